// A grain's shape: a union of capsules in the shape's own frame, and what is known about it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "shapes/capsule.hpp"

namespace porepack::shapes {

/// Does a void that the grain encloses on all sides count as solid ("filled": no fluid reaches it) or as void ("open")?
enum class Cavity { filled, open };
constexpr std::array<core::Choice<Cavity>, 2> choices_of(Cavity) {
    return {{{Cavity::filled, "filled"}, {Cavity::open, "open"}}};
}

/// The presets (the paper's three, star, sphere, rod), a list of capsules, a user's surface, and a mixture of shapes.
enum class ShapeKind { tetrapod, dolos, tetrahedron, star, sphere, rod, capsules, stl, mixture };
constexpr std::array<core::Choice<ShapeKind>, 9> choices_of(ShapeKind) {
    return {{{ShapeKind::tetrapod, "tetrapod"},
             {ShapeKind::dolos, "dolos"},
             {ShapeKind::tetrahedron, "tetrahedron"},
             {ShapeKind::star, "star"},
             {ShapeKind::sphere, "sphere"},
             {ShapeKind::rod, "rod"},
             {ShapeKind::capsules, "capsules"},
             {ShapeKind::stl, "stl"},
             {ShapeKind::mixture, "mixture"}}};
}

/// Cubic cells over a shape, 48 a side: 0 open void, 1 enclosed void, -1 solid (by the cells' centres).
struct VoidCells {
    static constexpr int cells = 48;
    Vec3 origin = Vec3::Zero();
    double size = 0.0;
    std::shared_ptr<const std::vector<signed char>> label = nullptr;
};

struct Shape {
    std::string id;
    std::vector<Capsule> capsules;
    Cavity cavity = Cavity::filled;
    bool may_be_disconnected = false;
    /// Points from which every point of the enclosed voids is seen; filled by find_cavities, empty when there are none.
    std::vector<Vec3> cavity_points = {};
    Bounds cavity_bounds = {};  ///< holds all enclosed voids
    VoidCells void_cells = {};  ///< filled with them, so that in_cavity() is quick
};

/// The presets: those of the paper (2.1.1), sphere, rod, and a star of `arms` arms spread evenly (Thomson's problem).
/// `diameter` of the capsules, `length` of their axes. Throws UserError on sizes <= 0.
/// The frame's origin is the centre of symmetry (tetrapod, tetrahedron, star, sphere, rod), of the middle capsule (dolos).
[[nodiscard]] Shape make_preset(ShapeKind kind, double diameter, double length, long arms = 6);

/// Throws UserError unless there is at least one capsule, all radii are positive and all is finite and connected (if it must be).
void validate(const Shape& shape);

/// Finds the voids that the union encloses and sets `cavity_points` and `cavity_bounds`. Voids are looked for from every
/// exposed piece of the surface; a grid of 48 cells a side tells what hangs together, and throats narrower than a cell are
/// searched one by one, down to 1e-9 of a cell (tested to 1e-6 of the radius on both sides of closing).
void find_cavities(Shape& shape);
/// True when `point`, known to lie outside all capsules, lies in an enclosed void.
[[nodiscard]] bool in_cavity(const Shape& shape, Vec3 point);

struct ShapeMeasures {
    double volume_m3 = 0.0;
    double surface_area_m2 = 0.0;
    double cavity_volume_m3 = 0.0;  ///< of the enclosed voids, counted in volume_m3 only when filled
    double cavity_area_m2 = 0.0;    ///< of their walls, counted in surface_area_m2 only when open
    double sphericity = 0.0;        ///< area of the equal-volume sphere / area
    Vec3 centre_of_mass_m = Vec3::Zero();
    Eigen::Matrix3d inertia_per_density_m5 = Eigen::Matrix3d::Zero();  ///< about the centre of mass, for density 1
    double bounding_radius_m = 0.0;                                    ///< about the centre of mass
    double span_m = 0.0;                                               ///< largest Feret length
    double relative_error = 0.0;                                       ///< estimated, of volume, area and second moments
    long meridians = 0;                                                ///< what it cost
};

/// `twice` checks the estimate by a second integration on other meridians; `once` is for shapes known to be smooth.
enum class Effort { once, twice };

/// Integrates over the exposed surface (divergence theorem) until the estimated relative error is below `tolerance` (1e-6 at
/// the least for more than six capsules), or a million meridians are spent. Deterministic; throws nothing.
[[nodiscard]] ShapeMeasures measure(const Shape& shape, double tolerance = 1e-8, Effort effort = Effort::twice);

struct Dimensions {
    double diameter_m = 0.0;
    double length_m = 0.0;
};
/// The capsule's diameter and length at which preset `kind` has this sphericity and volume. Throws UserError when there is
/// none: sphericity out of (0, 1], below what L/d = 50 reaches, or in the gap where a cavity closes. To 1e-8.
[[nodiscard]] Dimensions dimensions_for(ShapeKind kind, double sphericity, double volume_m3, Cavity cavity, long arms = 6);

/// Spheres along the axes whose union stays within `tolerance` below the capsules' surface: spacing
/// 2 sqrt(r^2 - (r - tolerance)^2). Each is a capsule with a = b.
[[nodiscard]] std::vector<Capsule> sphere_clump(const Shape& shape, double tolerance);

/// Smallest capsule diameter.
[[nodiscard]] double smallest_diameter(const Shape& shape);
/// Largest Feret length: exact for unions of capsules.
[[nodiscard]] double span(const Shape& shape);

struct HullMeasures {
    double volume_m3 = 0.0;
    double surface_area_m2 = 0.0;
};
/// The convex hull, which is that of the end spheres: exact to about 1e-9.
[[nodiscard]] HullMeasures hull(const std::vector<Capsule>& capsules);

}  // namespace porepack::shapes
