#include "inputs/mesh_grains.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "inputs/uses.hpp"
#include "record/digest.hpp"

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
    // Each stage of a run asks for the same grain, which takes seconds to make.
    static std::mutex mutex;
    static std::map<std::string, MeshGrain> made;
    const std::string key = fmt::format("{} {} {:.17g} {} {:.17g} {:.17g}", file.string(), record::sha256_of_file(file), config.unit_m,
                                        config.faces, config.deviation_m, config.rounding_m);
    {
        const std::lock_guard lock(mutex);
        if (const auto known = made.find(key); known != made.end()) return known->second;
    }
    MeshGrainOptions options{.deviation_m = config.deviation_m, .rounding_m = config.rounding_m};
    if (config.faces > 0) options.faces = config.faces;
    MeshGrain grain = grain_from_mesh(read_surface(file, config.unit_m), options, file.string());
    const double diameter = std::cbrt(6.0 * grain.volume_m3 / std::numbers::pi);
    if (!(diameter > 1e-6 && diameter < 5.0))
        throw UserError(
            fmt::format("the grain is {:.3g} m wide with unit_m = {:g}", diameter, config.unit_m),
            {.where = file.string(), .allowed = "1e-6 to 5 m", .fix = "unit_m = 0.001 where the file's unit is the millimetre"});
    const std::lock_guard lock(mutex);
    return made.try_emplace(key, std::move(grain)).first->second;
}

ShapeConfig with_mesh_grains(ShapeConfig config, const Path& folder) {
    if (config.kind == ShapeKind::mesh) config.from_file = read_mesh_grain(config, folder).body;
    for (ShapeConfig& part : config.component) part = with_mesh_grains(std::move(part), folder);
    return config;
}

}  // namespace porepack::inputs
