// Enclosed voids of a union of capsules: the search. A grid of cells shows which voids are connected at that resolution. Voids between the
// cells' centres are found from the exposed surface, because each has a wall. Then every part is tested for a connection: along a straight
// line to the outside, through points of increasing clearance, through throats narrower than a cell. Parts without connection are enclosed.
#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <vector>

#include "shapes/clearance.hpp"
#include "shapes/meridian.hpp"
#include "shapes/passages.hpp"
#include "shapes/shape.hpp"
#include "shapes/void_grid.hpp"

namespace porepack::shapes {
namespace {

// Adds the voids that contain no cell centre to the grid's parts.
void find_small_voids(const std::vector<Capsule>& capsules, VoidGrid& grid) {
    // A void between the cells' centres has a wall: search from every exposed piece of the surface. The middle comes first: a
    // small cavity of a symmetric grain lies there.
    Vec3 middle = Vec3::Zero();
    for (const auto& capsule : capsules) middle += (capsule.a + capsule.b) / (2.0 * static_cast<double>(capsules.size()));
    if (signed_distance(capsules, middle) > 0.0) (void)grid.part_of(middle);
    const ExposedSurface surface(capsules);
    constexpr int meridians = 12;
    std::vector<ExposedPart> parts;
    for (std::size_t own = 0; own < surface.capsules().size(); ++own)
        for (int k = 0; k < meridians; ++k) {
            const double phi = 2.0 * std::numbers::pi * (k + 0.37) / meridians;
            surface.meridian(own, phi, parts);
            for (const auto& part : parts) {
                const SurfacePoint at = surface.point(own, phi, part.piece, 0.5 * (part.low + part.high));
                const Vec3 above = at.x + 1e-5 * surface.capsules()[own].radius * at.normal;
                if (signed_distance(capsules, above) > 0.0) (void)grid.part_of(above);
            }
        }
}

}  // namespace

void find_cavities(Shape& shape) {
    shape.cavity_points.clear();
    shape.cavity_bounds = {};
    shape.void_cells = {};
    if (shape.capsules.size() < 3) return;  // the complement of two convex bodies is connected
    VoidGrid grid(shape.capsules);
    find_small_voids(shape.capsules, grid);
    for (std::size_t part = 1; part < grid.parts(); ++part)
        if (ray_escapes(shape.capsules, grid.deepest(part), grid.far())) grid.join(0, part);
    for (std::size_t part = 1; part < grid.parts(); ++part)
        while (grid.root(part) == part) {
            const auto other = joined_part(grid, part);
            if (!other) break;
            grid.join(part, *other);
        }
    for (std::size_t part = 1; part < grid.parts(); ++part)
        if (grid.root(part) == part) grid.describe(part, shape);
    if (!shape.cavity_points.empty()) shape.void_cells = grid.labelled();
}

namespace {

// The label of one of the eight void cells around the point whose centre is visible from the point.
std::optional<int> label_near(const Shape& shape, const Vec3& point) {
    const VoidCells& grid = shape.void_cells;
    if (grid.label == nullptr) return std::nullopt;
    const Vec3 low = ((point - grid.origin) / grid.size - Vec3::Constant(0.5)).array().floor();
    for (int corner = 0; corner < 8; ++corner) {
        const std::array<int, 3> at = {static_cast<int>(low.x()) + corner % 2, static_cast<int>(low.y()) + corner / 2 % 2,
                                       static_cast<int>(low.z()) + corner / 4};
        if (std::any_of(at.begin(), at.end(), [](int i) { return i < 0 || i >= VoidCells::cells; })) continue;
        const auto cell = (static_cast<std::size_t>(at[2]) * VoidCells::cells + static_cast<std::size_t>(at[1])) * VoidCells::cells +
                          static_cast<std::size_t>(at[0]);
        const auto label = static_cast<int>((*grid.label)[cell]);  // NOLINT(bugprone-signed-char-misuse): -1 is solid
        if (label < 0) continue;
        const Vec3 centre = grid.origin + grid.size * Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
        if (!blocked(shape.capsules, point, centre)) return label;
    }
    return std::nullopt;
}

}  // namespace

bool in_cavity(const Shape& shape, Vec3 point) {
    // A point in a corner that no cavity point sees is moved to points of larger clearance.
    constexpr int maximum_steps = 60;
    for (int step = 0; step < maximum_steps; ++step) {
        if (((shape.cavity_bounds.low - point).array() > 0.0).any() || ((point - shape.cavity_bounds.high).array() > 0.0).any())
            return false;
        if (const auto label = label_near(shape, point)) return *label == 1;
        if (step == 0)
            for (const auto& seed : shape.cavity_points)  // a void that contains no cell centre has only these
                if (!blocked(shape.capsules, seed, point)) return true;
        const Vec3 next = wider_place(shape.capsules, point);
        if (next == point) return false;
        point = next;
    }
    return false;
}

void join_over_cavities(const Shape& shape, const Vec3& origin, const Vec3& direction, std::vector<core::Interval>& parts) {
    std::size_t last = 0;
    for (std::size_t i = 1; i < parts.size(); ++i) {
        // A gap between two parts of one grain lies either entirely inside or entirely outside an enclosed void.
        if (in_cavity(shape, origin + 0.5 * (parts[last].high + parts[i].low) * direction))
            parts[last].high = parts[i].high;
        else
            parts[++last] = parts[i];
    }
    if (!parts.empty()) parts.resize(last + 1);
}

}  // namespace porepack::shapes
