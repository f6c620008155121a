// Boxes and prisms as polyhedra.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "shapes/rounded_body.hpp"

namespace porepack::shapes {
namespace {

// A prism over a polygon in the plane z = 0, counter-clockwise seen from above.
PolyhedronSize prism_over(const std::vector<Eigen::Vector2d>& polygon, double half_height, double rounding_m) {
    const auto n = static_cast<int>(polygon.size());
    PolyhedronSize prism{.corners_m = {}, .faces = {}, .rounding_m = rounding_m};
    for (const double z : {-half_height, half_height})
        for (const auto& corner : polygon) prism.corners_m.emplace_back(corner.x(), corner.y(), z);
    std::vector<int> bottom, top;
    for (int i = 0; i < n; ++i) {
        bottom.push_back(n - 1 - i);
        top.push_back(n + i);
        prism.faces.push_back({i, (i + 1) % n, n + (i + 1) % n, n + i});
    }
    prism.faces.push_back(bottom);
    prism.faces.push_back(top);
    return prism;
}

void require_sizes(const char* name, std::initializer_list<double> sizes, double rounding_m, double smallest) {
    for (const double size : sizes)
        if (!(size > 0.0) || !std::isfinite(size))
            throw UserError(fmt::format("a size of the {} is {:g} m", name, size), {.allowed = "above 0"});
    if (!(rounding_m >= 0.0) || rounding_m >= 0.5 * smallest)
        throw UserError(fmt::format("the rounding of the {} is {:g} m", name, rounding_m),
                        {.allowed = fmt::format("0 to below {:.6g} m, half of its smallest width", 0.5 * smallest)});
}

}  // namespace

PolyhedronSize box_size(const Vec3& size_m, double rounding_m) {
    require_sizes("box", {size_m.x(), size_m.y(), size_m.z()}, rounding_m, size_m.minCoeff());
    const Vec3 half = 0.5 * size_m - Vec3::Constant(rounding_m);
    return prism_over({{-half.x(), -half.y()}, {half.x(), -half.y()}, {half.x(), half.y()}, {-half.x(), half.y()}}, half.z(), rounding_m);
}

PolyhedronSize prism_size(long sides, double diameter_m, double height_m, double rounding_m) {
    if (sides < 3 || sides > 64) throw UserError(fmt::format("a prism of {} sides", sides), {.allowed = "3 to 64"});
    const double angle = std::numbers::pi / static_cast<double>(sides), inscribed = diameter_m * std::cos(angle);
    require_sizes("prism", {diameter_m, height_m}, rounding_m, std::min(inscribed, height_m));
    const double radius = 0.5 * diameter_m - rounding_m / std::cos(angle);
    std::vector<Eigen::Vector2d> polygon;
    for (long i = 0; i < sides; ++i)
        polygon.emplace_back(radius * std::cos(2.0 * angle * static_cast<double>(i)),
                             radius * std::sin(2.0 * angle * static_cast<double>(i)));
    return prism_over(polygon, 0.5 * height_m - rounding_m, rounding_m);
}

}  // namespace porepack::shapes
