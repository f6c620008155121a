#include "apps/porepack/run.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "apps/porepack/uses.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "record/engine_versions.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::apps {
namespace {

// Of "packing.seed=5" and the like, by table.
std::map<std::string, Flags> keys_of(const std::vector<std::string>& set) {
    std::map<std::string, Flags> keys;
    for (const std::string& one : set) {
        const std::size_t dot = one.find('.'), equals = one.find('=');
        if (dot == std::string::npos || equals == std::string::npos || dot > equals)
            throw UserError(fmt::format("\"{}\" sets nothing", one), {.where = "--set", .allowed = "table.key=value (packing.seed=5)"});
        keys[one.substr(0, dot)][one.substr(dot + 1, equals - dot - 1)] = one.substr(equals + 1);
    }
    return keys;
}

void print_lines(const Json& json, const std::string& indent = "") {
    for (const auto& [key, value] : json.items()) {
        if (value.is_object()) {
            fmt::print("{}{}:\n", indent, key);
            print_lines(value, indent + "  ");
        } else if (value.is_array() && !value.empty() && value.front().is_object()) {
            for (const auto& entry : value) {
                fmt::print("{}{}:\n", indent, key);
                print_lines(entry, indent + "  ");
            }
        } else if (value.is_number_float()) {
            fmt::print("{}{}: {:.6g}\n", indent, key, value.get<double>());
        } else {
            fmt::print("{}{}: {}\n", indent, key, value.is_string() ? for_terminal(value.get<std::string>()) : value.dump());
        }
    }
}

// The main numbers of a stage's result; of other stages, everything.
void print_summary(const std::string& stage, const Json& result) {
    static const std::map<std::string, std::vector<const char*>> main_keys = {
        {"shape", {"volume_m3", "sphericity", "equal_volume_diameter_m", "convexity"}},
        {"pack", {"grains", "porosity_bed", "bed_height_m", "coordination_number", "at_rest"}},
        {"stl", {"triangles", "volume_m3", "volume_error", "closed", "self_intersecting"}},
        {"voxelise", {"cells", "voxel_size_m", "section_m", "porosity", "porosity_interval"}},
        {"slices", {"slices", "spacing_m", "pixel_m", "section_m"}},
        {"lbm",
         {"permeability_m2", "permeability_interval_m2", "interval_meaning", "section_m", "porosity", "/fine/voxel_size_m", "converged"}},
        {"falling-head-analysis",
         {"sample_length_m", "inertia_coefficient", "/packings/0/least_squares/permeability_m2",
          "/packings/0/least_squares/permeability_interval_m2", "/packings/0/least_squares/inertial_permeability_m", "verdict",
          "verdict_inertial"}},
        {"foam", {"permeability_m2", "permeability_interval_m2", "section_m", "converged", "cells"}},
        {"segment", {"grains", "container", "section_m", "porosity", "median_grain_volume_m3"}},
        {"fit", {"grains", "container", "section_m", "porosity", "end_uncertainty_m", "residual", "unexplained_solid", "doubts"}}};
    const auto found = main_keys.find(stage);
    if (found == main_keys.end() || (result.contains("packings") && result["packings"].size() > 1)) return print_lines(result);
    for (const std::string key : found->second) {
        const Json::json_pointer at(key.starts_with("/") ? key : "/" + key);
        if (!result.contains(at)) continue;
        const Json& value = result.at(at);
        std::string text;
        for (const Json& entry : value.is_array() ? value : Json::array({value}))
            text += (text.empty() ? "" : ", ") + (entry.is_number_float() ? fmt::format("{:.4g}", entry.get<double>())
                                                  : entry.is_null()       ? std::string("none")
                                                  : entry.is_string()     ? entry.get<std::string>()
                                                                          : entry.dump());
        fmt::print("{}: {}\n", at.back(), text.empty() ? "none" : text);
    }
}

}  // namespace

void print_stage(const Common& common, const std::string& stage, const Json& result, const Path& manifest) {
    if (common.json || common.verbose) return print_result(common, result);
    print_summary(stage, result);
    constexpr std::size_t max_files = 6;
    const Json written = read_json(manifest);
    const Json& files = written.at("outputs_sha256");
    if (files.size() > max_files)
        fmt::print("written: {} files in {}\n", files.size(), for_terminal(manifest.parent_path().lexically_normal().string()));
    else
        for (const auto& [file, digest] : files.items())
            fmt::print("written: {}\n", for_terminal((manifest.parent_path() / file).lexically_normal().string()));
}

void print_result(const Common& common, const Json& json) {
    if (common.json)
        fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
    else
        print_lines(json);
}

std::optional<Container> container_of(const Common& common) {
    if (common.container.empty()) return std::nullopt;
    return parse_container(common.container);
}

Case open_case(const Common& common, const std::string& table, const Flags& flags) {
    if (!common.container.empty() || common.unit_m != 1.0)
        throw UserError("a case defines its own container and unit", {.fix = "remove --container and --unit; see case.toml"});
    if (!common.image_flags.empty())
        throw UserError("--image-... have no effect on a case", {.where = common.input, .fix = "keys of [image] in case.toml"});
    Case the_case = read_case(common.input, table, flags, keys_of(common.set));
    if (!common.set.empty() && common.output.empty())
        throw UserError("--set changes keys of the case, and the results in its own folder are those of case.toml as it is",
                        {.fix = "name another folder with --output"});
    the_case.output = common.output;
    if (common.ranks > 0) the_case.settings.parallel.ranks = common.ranks;
    return the_case;
}

Json plan_case(const Case& c, const std::string& last, double slowness) {
    Json plan = {{"configuration", c.settings.resolved_tables()}};
    Settings settings = c.settings;
    for (auto& [table, values] : plan["configuration"].items())
        for (const KeyRow& row : key_rows(settings.describe_table(table)))
            if (row.standard == "auto") values[row.key] = "auto";
    plan.update(plan_pipeline(case_pipeline(c), last, slowness));
    return plan;
}

void run_in_case(const Common& common, const std::string& stage, const std::string& table) {
    const Case the_case = open_case(common, table, common.flags);
    if (common.dry_run) return print_result(common, plan_case(the_case, stage, slowness()));
    print_stage(common, stage, run_pipeline(case_pipeline(the_case), stage), the_case.stage_folder(stage) / "manifest.json");
}

Path target_folder(const Common& common) {
    const Path target = common.output.empty() ? Path(common.input).parent_path() : Path(common.output);
    return target.empty() ? Path(".") : target;
}

void run_on_files(const Common& common, LooseRun run) {
    run.versions = record::engine_versions;
    if (common.dry_run) return print_result(common, {{"configuration", run.configuration}, {"stage", run.stage}, {"expected", "seconds"}});
    print_stage(common, run.stage, run_loose(run), run.target / (run.stage + ".manifest.json"));
}

PoreSpace load_input(const Common& common, const LooseCommand& command) {
    if (is_packing(common.input) && (!common.container.empty() || common.unit_m != 1.0))
        throw UserError("a packing brings its own container, in metres", {.where = common.input, .fix = "remove --container and --unit"});
    return load_pore_space(common.input, {.container = container_of(common),
                                          .unit_m = common.unit_m,
                                          .geometry = command.geometry,
                                          .section = command.section,
                                          .image = config_from_flags<imaging::ImageConfig>(common.image_flags),
                                          .whole_bed = command.whole_bed});
}

void run_on_input(const Common& common, const LooseCommand& command) {
    PoreSpace space = load_input(common, command);
    if (ranks().part() > 0) {
        if (!common.dry_run) (void)command.work(std::move(space), target_folder(common));  // the first rank writes
        return;
    }
    if (common.dry_run)
        return print_result(common, {{"configuration", command.configuration},
                                     {"stage", command.stage},
                                     {"section_m", json_of(space.section.interval())},
                                     {"expected", command.expect ? text_of(command.expect(space), slowness()) : "seconds"},
                                     {"memory_available", human_bytes(available_memory_bytes())}});
    run_on_files(common, {.stage = command.stage,
                          .target = target_folder(common),
                          .configuration = command.configuration,
                          .inputs = {common.input},
                          .work = [&](const Path& folder) { return command.work(std::move(space), folder); },
                          .resumes = command.resumes});
}

}  // namespace porepack::apps
