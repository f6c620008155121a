#include "apps/porepack/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <system_error>

#include "core/build.hpp"
#include "core/escape.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::apps {
using namespace core;
using namespace record;
using namespace packing;
using namespace pore_space;
using namespace pipeline;
using namespace stages;
using namespace study;
namespace {

void add_common(CLI::App& command, Common& common, const std::string& example) {
    command.add_flag("--json", common.json, "result as JSON on stdout, log on stderr");
    command.add_flag("--verbose", common.verbose, "print all of the result, not only its main numbers");
    command.add_flag("--dry-run", common.dry_run, "print the resolved configuration, what would run, memory and time; run nothing");
    command
        .add_option("--threads", common.threads,
                    "threads of parallel loops (default: OMP_NUM_THREADS, else the cores that this process may use)")
        ->type_name("1 to 1024")
        ->check(CLI::Validator(CLI::Range(1, 1024)).description(""));
    command.add_option("--output", common.output, "folder for the results (default: that of the input)")->type_name("path");
    command.footer("Example:\n  " + example);
}

std::string version_text() {
    std::string text = fmt::format("porepack {} ({})\n", program_version(), git_hash());
    const Json versions = engine_versions();
    for (const auto& [name, version] : versions.items())
        text += fmt::format("  {:<10} {}\n", name, version.get<std::string>().empty() ? "not found" : version.get<std::string>());
    text.pop_back();
    return text;
}

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

// "number [m]", "one of x, y, z", ...: what --help shows behind a flag.
std::string type_text(const KeyRow& row) {
    if (row.type == "choice") return "one of " + row.allowed;
    if (row.key == "file") return "path";
    std::string text = row.type;
    if (text.starts_with("list of ")) text = text.substr(8) + (text.ends_with("numbers") ? "" : " times true or false") + ", with commas";
    std::string unit = row.unit;
    if (const std::size_t per = unit.find("_per_"); per != std::string::npos) unit.replace(per, 5, "/");
    return unit.empty() ? text : text + " [" + unit + "]";
}

// "--pores true" is the same as "--pores=true" and "--pores".
std::vector<std::string> with_joined_booleans(const std::vector<std::string>& arguments) {
    std::vector<std::string> joined;
    for (const std::string& argument : arguments) {
        const bool value = argument == "true" || argument == "false";
        if (value && !joined.empty() && joined.back().starts_with("--") && joined.back().find('=') == std::string::npos)
            joined.back() += "=" + argument;
        else
            joined.push_back(argument);
    }
    return joined;
}

// CLI11's ranges let "nan" pass. Keys of tables are checked where they are read, with the range that is allowed.
void require_finite_numbers(const CLI::App& command, const std::set<const CLI::Option*>& of_tables) {
    for (const CLI::Option* option : command.get_options()) {
        if (option->get_type_name().find("number") == std::string::npos || of_tables.contains(option)) continue;
        for (const std::string& result : option->results()) {
            std::istringstream fields(result);
            for (std::string field; std::getline(fields, field, ',');) {
                char* end = nullptr;
                const double value = std::strtod(field.c_str(), &end);
                if (end != field.c_str() && *end == '\0' && !std::isfinite(value))
                    throw UserError(fmt::format("\"{}\" is not a finite number", field), {.where = option->get_name()});
            }
        }
    }
    for (const CLI::App* below : command.get_subcommands()) require_finite_numbers(*below, of_tables);
}

// The known flag or command that is nearest to the first unknown one.
std::string suggestion(const CLI::App& app, const std::vector<std::string>& arguments) {
    const CLI::App* command = &app;
    for (const std::string& argument : arguments) {
        std::vector<std::string> known;
        if (!argument.starts_with("-")) {
            const auto all = command->get_subcommands([](const CLI::App*) { return true; });
            for (const CLI::App* below : all) known.push_back(below->get_name());
            if (const auto next = std::find(known.begin(), known.end(), argument); next != known.end()) {
                command = all[static_cast<std::size_t>(next - known.begin())];
                continue;
            }
        } else if (argument.starts_with("--")) {
            for (const CLI::Option* option : command->get_options())
                for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
        }
        const std::string word = argument.substr(0, argument.find('='));
        if (known.empty() || std::find(known.begin(), known.end(), word) != known.end()) continue;
        if (const std::string near = nearest(word, known); !near.empty()) return near;
    }
    return {};
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
    constexpr std::size_t most_files = 6;
    const Json written = read_json(manifest);
    const Json& files = written.at("outputs_sha256");
    if (files.size() > most_files)
        fmt::print("written: {} files in {}\n", files.size(), for_terminal(manifest.parent_path().lexically_normal().string()));
    else
        for (const auto& [file, digest] : files.items())
            fmt::print("written: {}\n", for_terminal((manifest.parent_path() / file).lexically_normal().string()));
}

CommandLine::CommandLine() {
    app.require_subcommand(0, 1);
    app.set_version_flag("--version", version_text);
    app.footer(
        "Exit codes: 0 done, 2 the input, 3 a numerical failure, 4 an engine is missing or failed, 5 interrupted or the "
        "machine.\nExample:\n  porepack run cases/quickstart");
    for (const auto& add_commands : {add_new_command, add_case_commands, add_shape_command, add_geometry_commands, add_lbm_command,
                                     add_foam_command, add_forchheimer_command, add_tortuosity_command, add_falling_head_commands,
                                     add_study_commands, add_design_command, add_image_commands, add_pores_command, add_tools})
        add_commands(*this);
}

int CommandLine::run(int argc, char** argv) {
    arguments.assign(argv + 1, argv + argc);
    try {
        std::vector<std::string> words = with_joined_booleans(arguments);
        std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
        app.parse(std::move(words));
    } catch (const CLI::ParseError& fault) {
        if (fault.get_exit_code() == 0) return app.exit(fault);
        const std::string near = suggestion(app, arguments), help = fmt::format("porepack {}--help shows what is allowed", command_path());
        std::string message = fault.what();
        if (dynamic_cast<const CLI::ExtrasError*>(&fault) != nullptr)
            message = fmt::format("not expected here: {}", fmt::join(app.remaining(true), " "));
        throw UserError(message, {.fix = near.empty() ? help : fmt::format("{}; {}", perhaps(near), help)});
    }
    require_finite_numbers(app, of_tables_);
    set_thread_count(common.threads);
    try {
        if (app.get_subcommands().empty()) fmt::print("{}", app.help());
        if (action_) action_();
    } catch (const std::system_error& fault) {
        if (fault.code().value() != EPIPE) throw;
        return 0;
    }
    errno = 0;
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        if (errno == EPIPE) return 0;  // the reader, such as head, has seen enough
        throw MachineError("the result could not be written to the standard output", {.fix = "is the disk full?"});
    }
    return 0;
}

// "falling-head simulate ", as it was typed.
std::string CommandLine::command_path() const {
    std::string path;
    for (const CLI::App* at = &app; !at->get_subcommands().empty(); path += at->get_name() + " ") at = at->get_subcommands().front();
    return path;
}

CLI::App& CommandLine::add(const std::string& name, const std::string& help, const std::string& example, std::function<void()> action) {
    return add_below(app, name, help, example, std::move(action));
}

CLI::App& CommandLine::add_below(CLI::App& parent, const std::string& name, const std::string& help, const std::string& example,
                                 std::function<void()> action) {
    CLI::App& command = *parent.add_subcommand(name, help);
    add_common(command, common, example);
    command.callback([this, action = std::move(action)] { action_ = action; });
    return command;
}

void CommandLine::add_keys(CLI::App& command, const std::string& table, const std::vector<std::string>& leave_out) {
    add_keys(command, settings_.describe_table(table), leave_out);
}

void CommandLine::add_keys(CLI::App& command, const Describe& describe, const std::vector<std::string>& leave_out) {
    const auto left_out = [&](const std::string& key) { return std::find(leave_out.begin(), leave_out.end(), key) != leave_out.end(); };
    for (const auto& row : key_rows(describe)) {
        if (left_out(row.key) || row.type == "array of tables") continue;
        const std::string flag = flag_of(row.key), standard = row.standard.empty() ? "none" : row.standard;
        const auto set = [this, key = row.key](const std::string& value) { common.flags[key] = value; };
        add_key(command, row, flag, set)->description(row.meaning + "; default " + standard);
        for (const auto& [old_key, key] : renamed_keys(describe)) {
            if (key != row.key) continue;
            const std::string old_flag = flag_of(old_key);
            add_key(command, row, old_flag, [set, flag, old_flag](const std::string& value) {
                log_warning(fmt::format("{} is now called {}; the old name is read until version 0.3", old_flag, flag));
                set(value);
            })->group("");
        }
    }
}

CLI::Option* CommandLine::add_key(CLI::App& command, const KeyRow& row, const std::string& flag,
                                  const std::function<void(const std::string&)>& set) {
    if (row.type != "true or false") {
        CLI::Option* const option = command.add_option_function<std::string>(flag, set)->type_name(type_text(row));
        of_tables_.insert(option);
        return option;
    }
    const auto set_flag = [set](std::int64_t count) { set(count > 0 ? "true" : "false"); };
    const auto refuse_others = [](const std::string& value) {
        return value == "true" || value == "false" ? std::string() : "\"" + value + "\" is neither true nor false";
    };
    return command.add_flag_function(flag + (row.standard == "true" ? ",!--no-" + flag.substr(2) : ""), set_flag)
        ->check(CLI::Validator(refuse_others, ""));
}

void CommandLine::add_alias(CLI::App& command, const std::string& flag, const std::string& key) {
    const std::string same = flag_of(key);
    of_tables_.insert(command
                          .add_option_function<std::string>(
                              flag, [this, key](const std::string& value) { common.flags[key] = value; }, "the same as " + same)
                          ->type_name(command.get_option(same)->get_type_name()));
}

void CommandLine::add_case(CLI::App& command) {
    command.add_option("case", common.input, "folder with case.toml")->type_name("path")->required();
    command.add_option("--set", common.set, "another value for a key of case.toml (repeatable; needs --output)")
        ->type_name("table.key=value")
        ->allow_extra_args(false);
}

void CommandLine::add_input(CLI::App& command, const char* what) {
    command.add_option("input", common.input, what)->type_name("path")->required();
    command
        .add_option("--container", common.container,
                    "container of an STL file: a cylinder has its axis at x = y = 0, a box its corner at the origin; the floor is at z = 0")
        ->type_name("cylinder:D,H or box:X,Y,Z[:periodic] [m]");
    add_unit(command);
    add_image_keys(command);
}

void CommandLine::add_image_keys(CLI::App& command, const std::vector<std::string>& leave_out) {
    const auto describe_image = [](ConfigVisitor& v) {
        static imaging::ImageConfig config;
        describe(v, config);
    };
    for (const auto& row : key_rows(describe_image)) {
        if (row.key == "file" || row.key == "fit" || std::find(leave_out.begin(), leave_out.end(), row.key) != leave_out.end()) continue;
        add_key(command, row, "--image-" + flag_of(row.key).substr(2),
                [this, key = row.key](const std::string& value) { common.image_flags[key] = value; })
            ->description(row.meaning + "; default " + (row.standard.empty() ? "none" : row.standard))
            ->group("Images");
    }
}

void CommandLine::add_unit(CLI::App& command) {
    command.add_option("--unit", common.unit_m, "length of the STL file's unit in metres (0.001: millimetres); default 1")
        ->type_name("number [m]")
        ->check(CLI::Validator(CLI::PositiveNumber).description(""));
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
    run.versions = engine_versions;
    if (common.dry_run) return print_result(common, {{"configuration", run.configuration}, {"stage", run.stage}, {"expected", "seconds"}});
    print_stage(common, run.stage, run_loose(run), run.target / (run.stage + ".manifest.json"));
}

void run_on_input(const Common& common, const LooseCommand& command) {
    if (is_packing(common.input) && (!common.container.empty() || common.unit_m != 1.0))
        throw UserError("a packing brings its own container, in metres", {.where = common.input, .fix = "remove --container and --unit"});
    const PoreSpace space = load_pore_space(common.input, {.container = container_of(common),
                                                           .unit_m = common.unit_m,
                                                           .geometry = command.geometry,
                                                           .section = command.section,
                                                           .image = config_from_flags<imaging::ImageConfig>(common.image_flags),
                                                           .whole_bed = command.whole_bed});
    if (common.dry_run)
        return print_result(common, {{"configuration", command.configuration},
                                     {"stage", command.stage},
                                     {"section_m", section_json(space.section)},
                                     {"expected", command.expect ? text_of(command.expect(space), slowness()) : "seconds"},
                                     {"memory_available", human_bytes(available_memory_bytes())}});
    run_on_files(common, {.stage = command.stage,
                          .target = target_folder(common),
                          .configuration = command.configuration,
                          .inputs = {common.input},
                          .work = [&](const Path& folder) { return command.work(space, folder); },
                          .resumes = command.resumes});
}

}  // namespace porepack::apps
