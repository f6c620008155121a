#include "inputs/mesh_vessel.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "converters/surface.hpp"
#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "inputs/uses.hpp"
#include "record/digest.hpp"

namespace porepack::inputs {
namespace {

constexpr std::size_t max_triangles = 200000;

std::shared_ptr<const TriangleMesh> read_vessel(const Path& file, double unit_m) {
    const TriangleSurface surface = converters::read_surface(file, unit_m);
    if (surface.triangles.size() > max_triangles)
        throw UserError(fmt::format("the vessel has {} triangles", surface.triangles.size()),
                        {.where = file.string(), .allowed = fmt::format("4 to {}", max_triangles), .fix = "export it more coarsely"});
    auto mesh = std::make_shared<TriangleMesh>();
    Bounds bounds;
    for (const auto& [x, y, z] : surface.points) {
        mesh->points_m.emplace_back(x, y, z);
        bounds.add(mesh->points_m.back(), 0.0);
    }
    mesh->triangles = surface.triangles;
    if (const double size = (bounds.high - bounds.low).maxCoeff(); !(size > 1e-5 && size < 100.0))
        throw UserError(
            fmt::format("the vessel is {:.3g} m large with unit_m = {:g}", size, unit_m),
            {.where = file.string(), .allowed = "1e-5 to 100 m", .fix = "unit_m = 0.001 where the file's unit is the millimetre"});
    for (Vec3& point : mesh->points_m) point.z() -= bounds.low.z();
    // In the words of a vessel, where that can be; then what only the checks of a surface find.
    (void)TriangleWall(*mesh, file.string());
    const SurfaceCheck check = check_surface(surface);
    if (!check.fault.empty())
        throw UserError("the vessel's surface: " + check.fault,
                        {.where = file.string(), .fix = check.fix.empty() ? "repair it in the program that made it" : check.fix});
    if (std::abs(bounds.low.z()) > 1e-9 * (bounds.high - bounds.low).norm())
        log_info("{}: moved by {:g} m along z, so that the vessel begins at z = 0", file.string(), -bounds.low.z());
    return mesh;
}

}  // namespace

std::vector<Path> vessel_files(const ContainerConfig& config, const Path& folder) {
    if (config.file.empty()) return {};
    return {Path(config.file).is_absolute() ? Path(config.file) : folder / config.file};
}

Container make_container(const ContainerConfig& config, const Path& folder) {
    if (config.kind != "mesh" || config.file.empty() || config.unit_m == 0.0) return vessels::make_container(config);
    const Path file = vessel_files(config, folder).front();
    // Each stage of a run asks for the same vessel.
    static std::mutex mutex;
    static std::map<std::string, std::shared_ptr<const TriangleMesh>> made;
    const std::string key = fmt::format("{} {} {:.17g}", file.string(), record::sha256_of_file(file), config.unit_m);
    const std::lock_guard lock(mutex);
    auto& mesh = made[key];
    if (mesh == nullptr) mesh = read_vessel(file, config.unit_m);
    ContainerConfig read = config;
    read.mesh = mesh;
    return vessels::make_container(read);
}

}  // namespace porepack::inputs
