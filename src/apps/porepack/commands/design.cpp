// The reverse question: a shape for a wanted permeability.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "design/design.hpp"
#include "vessels/config.hpp"

namespace porepack::apps {
using shapes::ShapeKind;
namespace {

struct DesignOptions {
    std::string permeability, porosity, shape = "any", volume, sphericity, convexity, mass, study;
    std::vector<std::string> free;
    DesignGoal goal;
};

// "X" or "LOW,HIGH".
Interval interval_of(const std::string& text, const char* flag) {
    Interval interval;
    int used = 0;
    const auto whole = [&] { return static_cast<std::size_t>(used) == text.size(); };
    const auto known = [&] { return whole() && std::isfinite(interval.low) && std::isfinite(interval.high); };
    if (std::sscanf(text.c_str(), "%lf,%lf%n", &interval.low, &interval.high, &used) == 2 && known()) return interval;
    interval.high = 0.0;
    if (std::sscanf(text.c_str(), "%lf%n", &interval.low, &used) == 1 && known()) return {interval.low, interval.low};
    throw UserError(fmt::format("\"{}\" is neither a number nor a range", text), {.where = flag, .allowed = "X, or LOW,HIGH"});
}

// Presets with one ratio at most; others have a file.
constexpr ShapeKind families[] = {ShapeKind::tetrapod, ShapeKind::dolos, ShapeKind::tetrahedron, ShapeKind::star,
                                  ShapeKind::sphere,   ShapeKind::rod,   ShapeKind::cylinder,    ShapeKind::cube};

// Names of presets, or a file with a shape.
void choose_shapes(DesignGoal& goal, const std::string& text) {
    std::istringstream words(text == "any" ? "tetrapod,dolos,tetrahedron" : text);
    for (std::string word; std::getline(words, word, ',');) {
        const auto kind = choice_named<ShapeKind>(word);
        if (kind && std::find(std::begin(families), std::end(families), *kind) != std::end(families))
            goal.kinds.push_back(*kind);
        else if (word.ends_with(".toml") && goal.own_shape.empty())
            goal.own_shape = word;
        else
            throw UserError(
                fmt::format("\"{}\" is no shape to choose", word),
                {.where = "--shape",
                 .allowed = "any; tetrapod, dolos, tetrahedron, star, sphere, rod, cylinder, cube; one TOML file with a shape; or a list"});
    }
}

double volume_of(const std::string& text) {
    if (text.empty() || text == "free") return 0.0;
    const Interval value = interval_of(text, "--volume");
    if (!(value.low > 0.0) || value.low != value.high)
        throw UserError("the volume is not positive", {.where = "--volume", .allowed = "m3, or free"});
    return value.low;
}

DesignGoal goal_of(const Common& common, const DesignOptions& options) {
    DesignGoal goal = options.goal;
    goal.permeability_m2 = interval_of(options.permeability, "--permeability");
    if (!options.porosity.empty()) goal.porosity = interval_of(options.porosity, "--porosity");
    goal.container = *container_of(common);
    goal.volume_m3 = volume_of(options.volume);
    choose_shapes(goal, options.shape);
    for (const std::string& text : options.free) goal.free.push_back(parse_free_parameter(text));
    if (!options.sphericity.empty()) goal.sphericity = interval_of(options.sphericity, "--sphericity");
    if (!options.convexity.empty()) goal.convexity = interval_of(options.convexity, "--convexity");
    if (!options.mass.empty()) goal.mass_kg = interval_of(options.mass, "--mass");
    goal.study = options.study.empty() ? data_file("cases/paper_study") : Path(options.study);
    return goal;
}

void design(const Common& common, const DesignOptions& options) {
    const DesignGoal goal = goal_of(common, options);
    if (common.dry_run) return print_result(common, plan_design(goal));
    const Path folder = common.output.empty() ? Path("design") : Path(common.output);
    const DesignResult result = run_design(goal, folder);
    if (common.json) return print_result(common, read_json(folder / "design.json"));
    fmt::print("{}\n", result.text);
    if (result.full)
        fmt::print("in the whole container: k = {:.3g} m2, porosity {:.3f}\n", result.full->permeability_m2, result.full->porosity);
    fmt::print("report: {}\n", for_terminal(std::filesystem::absolute(folder / "design.html").lexically_normal().string()));
}

}  // namespace

void add_design_command(CommandLine& line) {
    const auto options = std::make_shared<DesignOptions>();
    DesignGoal& goal = options->goal;
    Common& common = line.common;
    auto command = line.add("design", "find the shape that gives a wanted permeability: propose, pour, solve, learn",
                            "porepack design --permeability 2e-7 --porosity 0.4,0.6 --volume 7.33e-7 --container cylinder:0.1,0.4",
                            [&common, options] { design(common, *options); });
    command.add_option("--permeability", options->permeability, "wanted k in m2: a value, or LOW,HIGH")
        .type_name("number or range")
        .required();
    command.add_option("--porosity", options->porosity, "wanted porosity: a value, or LOW,HIGH; any if left out")
        .type_name("number or range");
    command.add_option("--container", common.container, "of the finished bed").type_name(vessels::container_forms() + " [m]").required();
    command.add_option("--volume", options->volume, "of a grain in m3, or \"free\" (default): then the size follows from k")
        .type_name("number or free");
    command
        .add_option("--shape", options->shape,
                    "shapes to choose from: any (tetrapod, dolos, tetrahedron), names, or a TOML file with a shape: [[capsule]] tables, or "
                    "a kind with faces and its sizes")
        .type_name("list");
    command
        .add_option("--free", options->free,
                    "parameter of the shape in the TOML file: capsule.2.radius_m=0.001,0.002 (also length_m; "
                    "radius_m of all); of grains with faces a size: inner_diameter_m=0.002,0.006")
        .type_name("name=low,high");
    command.add_option("--sphericity", options->sphericity, "limits for presets; default 0.43,0.99").type_name("range");
    command.add_option("--convexity", options->convexity, "limits").type_name("range");
    command.add_option("--thinnest", goal.thinnest_m, "smallest capsule diameter allowed, in m").type_name("number [m]").not_negative();
    command.add_option("--mass", options->mass, "limits of a grain's mass in kg").type_name("range");
    command.add_option("--packings", goal.packings, "packings per proposal; default 3").type_name("number, 2 to 100").range(2L, 100L);
    command.add_option("--seed", goal.seed, "seed of the first packing; default 101")
        .type_name("number, 0 to 2000000000")
        .range(0L, 2000000000L);
    command.add_option("--max-proposals", goal.max_proposals, "default 6").type_name("number, 1 to 100").range(1L, 100L);
    command.add_option("--within", goal.within, "largest relative half width of the interval of k that counts; default 0.2")
        .type_name("number, 0.01 to 1")
        .range(0.01, 1.0);
    command.add_option("--max-time", goal.max_time_s, "seconds after which no proposal begins, and none gets more packings")
        .type_name("number [s]")
        .not_negative();
    command.add_flag("--full", goal.full, "pour the answer in the whole container as well");
    command.add_option("--study", options->study, "study to learn from; default: the one that porepack brings").type_name("path");
}

}  // namespace porepack::apps
