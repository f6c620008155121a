// Grains with faces: a core with flat faces, straight edges or rims, together with a sphere of the rounding's radius swept over it.
// Distances and lines are those of this body itself; no facets are involved. Lengths in metres, in the shape's own frame.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/json_fwd.hpp"
#include "geometry/vector.hpp"
#include "shapes/point_row.hpp"

namespace porepack::shapes {

using geometry::Vec3;

/// A curve along which a body touches others from outside: each ball of `radius` about a point of a corner, an edge or a rim lies in the
/// body. About an axis, the discs normal to it do: it counts only where the other body is nearest at right angles to it, and farther away
/// than `hole_radius`.
struct ContactCurve {
    enum class Kind { corner, edge, rim, axis };
    Kind kind = Kind::corner;
    Vec3 a = Vec3::Zero();  ///< the corner; one end of an edge or an axis; the centre of a rim
    Vec3 b = Vec3::Zero();  ///< the other end; the unit normal of a rim
    double rim_radius = 0.0;
    double radius = 0.0;
    double hole_radius = 0.0;
};

struct SurfaceSizes {
    double volume_m3 = 0.0;
    double surface_area_m2 = 0.0;
};

/// A triangle; its corners are counter-clockwise seen from outside.
using Facet = std::array<Vec3, 3>;

class RoundedBody {
public:
    RoundedBody() = default;
    RoundedBody(const RoundedBody&) = delete;
    RoundedBody& operator=(const RoundedBody&) = delete;
    virtual ~RoundedBody() = default;

    /// As in packing.json: `kind`, and the dimensions of that kind.
    [[nodiscard]] virtual core::Json to_json() const = 0;
    /// From the surface: exact outside; negative inside, where the true depth may be larger.
    [[nodiscard]] double distance(const Vec3& point) const { return distance(point, nullptr); }
    /// The same; `outward` becomes the direction in which the distance grows (unit vector), if it is not null.
    [[nodiscard]] virtual double distance(const Vec3& point, Vec3* outward) const = 0;
    /// The same of several points.
    virtual void distances(const PointRow& points, DistanceRow& found) const;
    /// The parts of the line origin + t direction (unit vector) inside the body, sorted and disjoint; with `grown`, inside the body whose
    /// rounding is larger by that length. `parts` is overwritten.
    virtual void line(const Vec3& origin, const Vec3& direction, double grown, std::vector<core::Interval>& parts) const = 0;
    /// Largest coordinate along a direction (unit vector): the height of the tangent plane.
    [[nodiscard]] virtual double support(const Vec3& direction) const = 0;
    /// A body of which every point lies deeper than `depth` in this one; null where none is known. A negative depth: the body with all
    /// points that are as near to it, exactly; null where its hole closes.
    [[nodiscard]] virtual std::shared_ptr<const RoundedBody> thinned(double depth) const = 0;
    /// The same body in other units of length.
    [[nodiscard]] virtual std::shared_ptr<const RoundedBody> scaled(double factor) const = 0;
    /// Points of the surface with outward normals and areas, with which polynomials of degree 3 are integrated to about 1e-12 (1e-9 for
    /// lobes that hardly overlap, 1e-6 for polyhedra that are not convex).
    using SurfacePoint = std::function<void(const Vec3& point, const Vec3& normal, double area)>;
    virtual void for_surface(const SurfacePoint& visit) const = 0;
    /// Relative, of volume and area by these points.
    [[nodiscard]] virtual double surface_error() const { return 1e-9; }
    [[nodiscard]] virtual SurfaceSizes hull() const = 0;
    /// A closed surface within `deviation` of this one; neighbours have equal corners to the last bit. Flat faces are exact; corners of
    /// round sides lie a little outside, so that the volume is kept. `turn` (rad) divides round sides at other places. Empty where they are
    /// found from the distance.
    [[nodiscard]] virtual std::vector<Facet> facets(double deviation, double turn) const = 0;

    [[nodiscard]] virtual bool convex() const = 0;
    [[nodiscard]] virtual std::vector<ContactCurve> contact_curves() const = 0;
    [[nodiscard]] virtual double rounding() const = 0;
    /// Diameter of the largest ball in the thinnest part: a wall, a lobe, the whole of a convex body.
    [[nodiscard]] virtual double thickness() const = 0;
    /// Distance from `point` to the farthest point of the body.
    [[nodiscard]] virtual double reach_from(const Vec3& point) const = 0;
    [[nodiscard]] virtual double maximum_feret_diameter() const = 0;
};

/// Volume and area of the body itself.
[[nodiscard]] SurfaceSizes surface_measures(const RoundedBody& body);

/// A cylinder with flat ends, or with a hole a ring; the axis is z, the centre lies at the origin. Outer dimensions.
struct RingSize {
    double diameter_m = 0.0;
    double inner_diameter_m = 0.0;  ///< 0: no hole
    double height_m = 0.0;
    double rounding_m = 0.0;
};
/// Throws UserError where a size is not positive, or the rounding is larger than half a wall or half the height.
[[nodiscard]] std::shared_ptr<const RoundedBody> make_ring(const RingSize& size);

/// `lobes` upright cylinders, evenly about the axis z, that overlap, with all that lies between them.
struct LobedSize {
    long lobes = 3;
    double diameter_m = 0.0;  ///< of the circle around all lobes
    double lobe_diameter_m = 0.0;
    double height_m = 0.0;
    double rounding_m = 0.0;  ///< of the rims
};
/// Throws UserError where the lobes do not overlap by more than the rounding, or do not fit into the circle.
[[nodiscard]] std::shared_ptr<const RoundedBody> make_lobed(const LobedSize& size);

/// A polyhedron: the corners of the core, and its flat convex faces as corners counter-clockwise seen from outside.
struct PolyhedronSize {
    std::vector<Vec3> corners_m;
    std::vector<std::vector<int>> faces;
    double rounding_m = 0.0;
};
/// Throws UserError where it is not closed, or a face is not flat or not convex (1e-9 of its size). One that is not convex as a whole has
/// triangles for faces, and must be one part that does not cross itself.
[[nodiscard]] std::shared_ptr<const RoundedBody> make_polyhedron(const PolyhedronSize& size);
/// Outer dimensions; the corner of the core farther out along each axis lies at half of them, less the rounding.
[[nodiscard]] PolyhedronSize box_size(const Vec3& size_m, double rounding_m);
/// A prism of a regular polygon with `sides` corners, the axis z. `diameter_m`: of the circle through the corners of the prism without
/// rounding.
[[nodiscard]] PolyhedronSize prism_size(long sides, double diameter_m, double height_m, double rounding_m);

/// What to_json() writes. Throws UserError with `where`, the place in the file.
[[nodiscard]] std::shared_ptr<const RoundedBody> body_from_json(const core::Json& json, const std::string& where);

}  // namespace porepack::shapes
