#include "inputs/mesh_grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "inputs/uses.hpp"
#include "record/digest.hpp"

namespace porepack::inputs {
namespace {

Path file_of(const ShapeConfig& config, const Path& folder) {
    return Path(config.file).is_absolute() ? Path(config.file) : folder / config.file;
}

std::vector<Path> files_of_library(const ShapeConfig& config, const Path& folder) {
    require_library_keys(config);
    const Path place = Path(config.folder).is_absolute() ? Path(config.folder) : folder / config.folder;
    std::vector<Path> files;
    std::error_code missing;
    for (const auto& entry : std::filesystem::directory_iterator(place, missing))
        if (converters::is_surface_file(entry.path())) files.push_back(entry.path());
    constexpr std::size_t max_meshes = 1000;
    if (missing || files.empty() || files.size() > max_meshes)
        throw UserError(missing ? "the folder cannot be read: " + place.string() : fmt::format("the library has {} meshes", files.size()),
                        {.where = "[shape] folder = \"" + config.folder + "\"",
                         .allowed = fmt::format("a folder with 1 to {} STL, PLY or OBJ files", max_meshes),
                         .fix = "`porepack image segment scan.nrrd --library` writes one: segmented/library"});
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

ShapeConfig without_library(const ShapeConfig& config, const Path& folder) {
    if (config.kind != ShapeKind::library) return config;
    ShapeConfig mixture{.kind = ShapeKind::mixture};
    for (const Path& file : files_of_library(config, folder)) {
        ShapeConfig& mesh = mixture.component.emplace_back(config);
        mesh.kind = ShapeKind::mesh;
        mesh.file = std::filesystem::absolute(file).string();
        mesh.folder.clear();
        mesh.library_by = LibraryBy::number;
    }
    std::vector<double> part(mixture.component.size(), 1.0);
    if (config.library_by == LibraryBy::volume)
        parallel_for(part.size(), [&](std::size_t i) { part[i] = 1.0 / read_mesh_grain(mixture.component[i], {}).volume_m3; });
    double sum = 0.0;
    for (const double one : part) sum += one;
    for (std::size_t i = 0; i < part.size(); ++i) mixture.component[i].number_fraction = part[i] / sum;
    return mixture.component.size() == 1 ? mixture.component.front() : mixture;
}

std::vector<Path> mesh_files(const ShapeConfig& config, const Path& folder) {
    std::vector<Path> files;
    if (config.kind == ShapeKind::library) return files_of_library(config, folder);
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

ShapeConfig with_mesh_grains(const ShapeConfig& given, const Path& folder) {
    ShapeConfig config = without_library(given, folder);
    if (config.kind == ShapeKind::mesh) config.from_file = read_mesh_grain(config, folder).body;
    parallel_for(config.component.size(), [&](std::size_t i) { config.component[i] = with_mesh_grains(config.component[i], folder); });
    return config;
}

}  // namespace porepack::inputs
