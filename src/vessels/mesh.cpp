#include "vessels/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::vessels {

Json MeshVessel::to_json() const {
    Json points = Json::array(), triangles = Json::array();
    for (const Vec3& point : wall_->mesh().points_m) points.push_back({point.x(), point.y(), point.z()});
    for (const auto& triangle : wall_->mesh().triangles) triangles.push_back(triangle);
    return {{"kind", "mesh"}, {"points_m", std::move(points)}, {"triangles", std::move(triangles)}};
}

double MeshVessel::mean_area(const Interval& heights) const {
    return wall_->volume_between(heights.low, heights.high) / (heights.high - heights.low);
}

double MeshVessel::side_per_volume() const {
    return wall_->side_area() / wall_->volume_between(bounds().low.z(), bounds().high.z());
}

TriangleMesh mesh_from_json(const Json& json, const std::string& where) {
    const auto refuse = [&](const std::string& what) { throw UserError(what, {.where = where}); };
    const Json points = json.value("points_m", Json()), triangles = json.value("triangles", Json());
    if (!points.is_array() || !triangles.is_array()) refuse("a vessel of kind \"mesh\" needs `points_m` and `triangles`");
    const auto is_row = [](const Json& row, auto&& good) {
        return row.is_array() && row.size() == 3 && std::all_of(row.begin(), row.end(), good);
    };
    TriangleMesh mesh;
    for (const Json& point : points) {
        if (!is_row(point, [](const Json& x) { return x.is_number() && std::abs(x.get<double>()) <= 1e6; }))
            refuse(fmt::format("`points_m` {} must be three numbers up to 1e6 (metres)", mesh.points_m.size()));
        mesh.points_m.emplace_back(point[0].get<double>(), point[1].get<double>(), point[2].get<double>());
    }
    const auto count = static_cast<std::int64_t>(mesh.points_m.size());
    for (const Json& triangle : triangles) {
        if (!is_row(triangle,
                    [&](const Json& i) { return i.is_number_integer() && i.get<std::int64_t>() >= 0 && i.get<std::int64_t>() < count; }))
            refuse(fmt::format("`triangles` {} must be three numbers of points, from 0 to {}", mesh.triangles.size(), count - 1));
        mesh.triangles.push_back({triangle[0].get<int>(), triangle[1].get<int>(), triangle[2].get<int>()});
    }
    return mesh;
}

}  // namespace porepack::vessels
