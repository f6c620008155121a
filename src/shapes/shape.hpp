// A grain's shape in its own frame, a union of capsules or a body with faces, and its measures.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/interval.hpp"
#include "shapes/capsule.hpp"
#include "shapes/rounded_body.hpp"

namespace porepack::shapes {

/// A void that the grain encloses on all sides counts as solid ("filled": no fluid reaches it) or as void ("open").
enum class Cavity { filled, open };
constexpr std::array<core::Choice<Cavity>, 2> choices_of(Cavity) {
    return {{{Cavity::filled, "filled"}, {Cavity::open, "open"}}};
}

/// The presets of capsules (the paper's three, star, sphere, rod) and with faces, a grain from a user's surface, a list of capsules, a
/// whole bed as a user's surface, and a mixture of shapes.
enum class ShapeKind {
    tetrapod,
    dolos,
    tetrahedron,
    star,
    sphere,
    rod,
    cylinder,
    ring,
    box,
    cube,
    lobed,
    prism,
    mesh,
    library,
    capsules,
    surface,
    mixture
};
constexpr std::array<core::Choice<ShapeKind>, 17> choices_of(ShapeKind) {
    return {{{ShapeKind::tetrapod, "tetrapod"},
             {ShapeKind::dolos, "dolos"},
             {ShapeKind::tetrahedron, "tetrahedron"},
             {ShapeKind::star, "star"},
             {ShapeKind::sphere, "sphere"},
             {ShapeKind::rod, "rod"},
             {ShapeKind::cylinder, "cylinder"},
             {ShapeKind::ring, "ring"},
             {ShapeKind::box, "box"},
             {ShapeKind::cube, "cube"},
             {ShapeKind::lobed, "lobed"},
             {ShapeKind::prism, "prism"},
             {ShapeKind::mesh, "mesh"},
             {ShapeKind::library, "library"},
             {ShapeKind::capsules, "capsules"},
             {ShapeKind::surface, "surface"},
             {ShapeKind::mixture, "mixture"}}};
}

/// Cubic cells over a shape, 48 per side: 0 open void, 1 enclosed void, -1 solid (by the cells' centres).
struct VoidCells {
    static constexpr int cells = 48;
    Vec3 origin = Vec3::Zero();
    double size = 0.0;
    std::shared_ptr<const std::vector<signed char>> label = nullptr;
};

struct Shape {
    std::string id;
    std::vector<Capsule> capsules = {};                 ///< empty with a body
    std::shared_ptr<const RoundedBody> body = nullptr;  ///< a grain with faces
    Cavity cavity = Cavity::filled;
    bool may_be_disconnected = false;
    /// Points from which every point of the enclosed voids is visible; filled by find_cavities, empty when there are no voids.
    std::vector<Vec3> cavity_points = {};
    Bounds cavity_bounds = {};  ///< contains all enclosed voids
    VoidCells void_cells = {};  ///< filled with them, so that in_cavity() is fast
};

/// The presets: those of the paper (2.1.1), sphere, rod, and a star of `arms` evenly distributed arms (Thomson's problem).
/// `diameter` of the capsules, `length` of their axes. Throws UserError on sizes <= 0.
/// The frame's origin is the centre of symmetry (tetrapod, tetrahedron, star, sphere, rod), of the middle capsule (dolos).
[[nodiscard]] Shape make_preset(ShapeKind kind, double diameter, double length, long arms = 6);

/// Throws UserError where a shape has faces: `what` takes unions of capsules only.
void require_capsules(const Shape& shape, const std::string& what);

/// Throws UserError unless there is a body, or a capsule, all radii are positive, all numbers finite, and the union is connected (if
/// required).
void validate(const Shape& shape);

/// Finds the voids that the union encloses and sets `cavity_points` and `cavity_bounds`. Voids are searched from every
/// exposed piece of the surface; a grid of 48 cells per side gives the connected parts, and throats narrower than a cell are
/// searched one by one, down to 1e-9 of a cell (tested to 1e-6 of the radius on both sides of closing).
void find_cavities(Shape& shape);
/// True when `point`, known to lie outside all capsules, lies in an enclosed void.
[[nodiscard]] bool in_cavity(const Shape& shape, Vec3 point);
/// True when enclosed voids were found that count as solid.
[[nodiscard]] inline bool has_filled_cavity(const Shape& shape) {
    return shape.cavity == Cavity::filled && !shape.cavity_points.empty();
}
/// Joins the parts of a line inside the capsules (sorted, disjoint) over enclosed voids between them. The line is origin + t direction, in
/// the shape's frame.
void join_over_cavities(const Shape& shape, const Vec3& origin, const Vec3& direction, std::vector<core::Interval>& parts);

struct ShapeMeasures {
    double volume_m3 = 0.0;
    double surface_area_m2 = 0.0;
    double cavity_volume_m3 = 0.0;  ///< of the enclosed voids, counted in volume_m3 only when filled
    double cavity_area_m2 = 0.0;    ///< of their walls, counted in surface_area_m2 only when open
    double sphericity = 0.0;        ///< area of the equal-volume sphere / area
    Vec3 centre_of_mass_m = Vec3::Zero();
    Eigen::Matrix3d inertia_per_density_m5 = Eigen::Matrix3d::Zero();  ///< about the centre of mass, for density 1
    double bounding_radius_m = 0.0;                                    ///< about the centre of mass
    double maximum_feret_diameter_m = 0.0;                             ///< largest distance between two points of the surface
    double relative_error = 0.0;                                       ///< estimated, of volume, area and second moments
    long meridians = 0;                                                ///< number of meridians used
};

/// `twice` checks the estimate by a second integration on other meridians; `once` is for shapes known to be smooth.
enum class Effort { once, twice };

/// Integrates over the exposed surface (divergence theorem) until the estimated relative error is below `tolerance` (at least
/// 1e-6 for more than six capsules), or a million meridians are used. Deterministic; throws nothing.
[[nodiscard]] ShapeMeasures measure(const Shape& shape, double tolerance = 1e-8, Effort effort = Effort::twice);

struct Dimensions {
    double diameter_m = 0.0;
    double length_m = 0.0;
};
/// The capsule's diameter and length at which preset `kind` has this sphericity and volume. Throws UserError when there is
/// none: sphericity outside (0, 1], below the value at L/d = 50, or in the gap where a cavity closes. Accurate to 1e-8.
[[nodiscard]] Dimensions dimensions_for(ShapeKind kind, double sphericity, double volume_m3, Cavity cavity, long arms = 6);

/// Smallest capsule diameter, or the thickness of a body.
[[nodiscard]] double smallest_diameter(const Shape& shape);
/// Maximum Feret diameter: exact.
[[nodiscard]] double maximum_feret_diameter(const Shape& shape);

/// The convex hull, of capsules that of their end spheres: exact to about 1e-9.
[[nodiscard]] SurfaceSizes hull(const Shape& shape);

}  // namespace porepack::shapes
