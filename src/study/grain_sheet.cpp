#include "study/grain_sheet.hpp"

#include <Eigen/Geometry>

#include "converters/surface.hpp"
#include "packing/packing.hpp"
#include "shapes/distance.hpp"
#include "study/uses.hpp"

namespace porepack::study {

namespace {

// The origin of a user's shape may lie anywhere.
Vec3 middle_of(const Shape& shape) {
    const Bounds bounds = bounds_of(PlacedShape{shape});
    return 0.5 * (bounds.low + bounds.high);
}

}  // namespace

geometry::TriangleSurface grain_sheet(const std::vector<Shape>& grains, long columns, double pitch_m) {
    const Quaternion turned(Eigen::AngleAxisd(0.45, Vec3::UnitX()) * Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
    Packing sheet;
    sheet.shapes = grains;
    for (std::size_t i = 0; i < grains.size(); ++i) {
        const auto place = static_cast<long>(i);
        const auto column = static_cast<double>(place % columns), row = static_cast<double>(place / columns);
        const Vec3 middle((0.5 + column) * pitch_m, 0.5 * pitch_m, (0.5 + row) * pitch_m);
        sheet.bodies.push_back({.shape = i, .position_m = middle - turned * middle_of(grains[i]), .orientation = turned});
    }
    const auto rows = static_cast<double>((static_cast<long>(grains.size()) + columns - 1) / columns);
    sheet.container = vessels::make_box({static_cast<double>(columns) * pitch_m, pitch_m, rows * pitch_m});
    return converters::make_surface(sheet, {.deviation_m = 0.01 * smallest_diameter(grains.back())}).surface;
}

}  // namespace porepack::study
