#include "inputs/mesh_grains.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "inputs/uses.hpp"
#include "io/stl.hpp"

namespace porepack::inputs {
namespace {

Path file_of(const ShapeConfig& config, const Path& folder) {
    return Path(config.file).is_absolute() ? Path(config.file) : folder / config.file;
}

}  // namespace

std::vector<Path> mesh_files(const ShapeConfig& config, const Path& folder) {
    std::vector<Path> files;
    if (config.kind == ShapeKind::mesh && !config.file.empty()) files.push_back(file_of(config, folder));
    for (const ShapeConfig& part : config.component)
        for (const Path& file : mesh_files(part, folder)) files.push_back(file);
    return files;
}

MeshGrain read_mesh_grain(const ShapeConfig& config, const Path& folder) {
    require_mesh_keys(config);
    const Path file = file_of(config, folder);
    MeshGrainOptions options{.deviation_m = config.deviation_m, .rounding_m = config.rounding_m};
    if (config.faces > 0) options.faces = config.faces;
    MeshGrain grain = grain_from_mesh(io::read_stl(file, config.unit_m), options, file.string());
    const double diameter = std::cbrt(6.0 * grain.volume_m3 / std::numbers::pi);
    if (!(diameter > 1e-6 && diameter < 5.0))
        throw UserError(
            fmt::format("the grain is {:.3g} m wide with unit_m = {:g}", diameter, config.unit_m),
            {.where = file.string(), .allowed = "1e-6 to 5 m", .fix = "unit_m = 0.001 where the file's unit is the millimetre"});
    return grain;
}

ShapeConfig with_mesh_grains(ShapeConfig config, const Path& folder) {
    if (config.kind == ShapeKind::mesh) config.from_file = read_mesh_grain(config, folder).body;
    for (ShapeConfig& part : config.component) part = with_mesh_grains(std::move(part), folder);
    return config;
}

}  // namespace porepack::inputs
