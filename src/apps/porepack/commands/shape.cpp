// The command shape: measures of a grain, of an STL file; the sweep over sphericities.
#include <fmt/format.h>

#include <memory>
#include <string>

#include "analysis/shape.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "record/engine_versions.hpp"
#include "record/resolved_config.hpp"
#include "report/picture.hpp"
#include "study/shape_sweep.hpp"

namespace porepack::apps {
namespace {

struct ShapeOptions {
    std::string capsules_file;
    bool sweep = false;
    double density_kg_per_m3 = 1000.0;
};

void sweep(const Common& common) {
    const auto config = config_from_flags<ShapeConfig>(common.flags);
    const double volume = config.volume_m3 > 0.0 ? config.volume_m3 : 7.33e-7;
    if (common.dry_run) return print_result(common, {{"volume_m3", volume}, {"expected", "171 shapes, about ten seconds"}});
    const Path target = common.output.empty() ? Path("sweep") : Path(common.output);
    const Json result = run_loose({.stage = "sweep",
                                   .target = target,
                                   .configuration = {{"volume_m3", volume}},
                                   .work = [&](const Path& folder) { return run_shape_sweep(volume, folder); },
                                   .versions = engine_versions});
    if (!report::draw_picture(target / "grains.stl", target / "grains.png", {"--front"}))
        log_warning("no picture of the grains: see " + (target / "log.picture").string());
    print_result(common, result);
}

ShapeConfig read_shape(const Common& common, const ShapeOptions& options) {
    Flags flags = common.flags;
    ShapeConfig config;
    const auto describe_it = [&](ConfigVisitor& v) { describe(v, config); };
    if (!options.capsules_file.empty()) {
        const TomlFile file{Path(options.capsules_file)};
        flags["kind"] = "\"capsules\"";
        file.read(file.has("shape") ? "shape" : "", describe_it, flags);
        return config;
    }
    if (common.input.empty()) {
        std::string kinds;
        for (const auto& kind : choices_of(shapes::ShapeKind()))
            if (kind.value != shapes::ShapeKind::capsules && kind.value != shapes::ShapeKind::surface &&
                kind.value != shapes::ShapeKind::mesh && kind.value != shapes::ShapeKind::library &&
                kind.value != shapes::ShapeKind::mixture)
                kinds += fmt::format("{}, ", kind.name);
        throw UserError("which shape?", {.allowed = kinds + "an STL, PLY or OBJ file (with --faces: as a grain), or --capsules FILE"});
    }
    flags["kind"] = "\"" + common.input + "\"";
    TomlFile().read("", describe_it, flags);
    return config;
}

// The grain of few faces that a case pours.
void measure_mesh(const Common& common, const ShapeOptions& options) {
    ShapeConfig config = config_from_flags<ShapeConfig>(common.flags);
    config.kind = ShapeKind::mesh;
    config.file = common.input;
    config.unit_m = common.unit_m;
    const auto work = [&](const Path& folder) {
        if (!folder.empty()) write_mesh_grain(config, {}, folder);
        return measure_shape(config, options.density_kg_per_m3);
    };
    if (common.output.empty() && !common.dry_run) return print_result(common, work({}));
    run_on_files(
        common,
        {.stage = "shape", .target = common.output, .configuration = resolved_config(config), .inputs = {common.input}, .work = work});
}

void measure_one(const Common& common, const ShapeOptions& options) {
    if (options.capsules_file.empty() && is_surface(common.input)) {
        if (common.flags.empty())
            return print_result(common, measure_surface_shape(converters::read_surface(common.input, common.unit_m), common.input,
                                                              options.density_kg_per_m3));
        return measure_mesh(common, options);
    }
    const ShapeConfig config = read_shape(common, options);
    const auto work = [&](const Path&) { return measure_shape(config, options.density_kg_per_m3); };
    if (common.output.empty() && !common.dry_run) return print_result(common, work({}));
    run_on_files(common, {.stage = "shape", .target = common.output, .configuration = resolved_config(config), .work = work});
}

}  // namespace

void add_shape_command(CommandLine& line) {
    const auto options = std::make_shared<ShapeOptions>();
    const Common& common = line.common;
    auto shape =
        line.add("shape", "volume, surface, sphericity, inertia of a grain", "porepack shape tetrapod --sphericity 0.53 --volume 7.33e-7",
                 [&common, options] { options->sweep ? sweep(common) : measure_one(common, *options); });
    shape
        .add_option("kind", line.common.input,
                    "tetrapod, dolos, tetrahedron, star, sphere, rod, cylinder, ring, box, cube, lobed, prism, or an STL, PLY or OBJ file")
        .type_name("name or path");
    shape.add_flag("--sweep", options->sweep, "figure 7: convexity against sphericity of the paper's aggregates, as CSV, plot and picture");
    shape.add_option("--capsules", options->capsules_file, "TOML file with [[capsule]] tables (a_m, b_m, radius_m)").type_name("path");
    line.add_unit(shape);
    shape.add_option("--density", options->density_kg_per_m3, "density for mass and inertia; default 1000")
        .type_name("number [kg/m3]")
        .range(1.0, 1e5);
    line.add_keys(shape, "shape", {"kind", "file", "unit_m"});
}

}  // namespace porepack::apps
