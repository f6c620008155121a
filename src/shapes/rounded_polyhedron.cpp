// Convex polyhedra with rounded edges. The body is the union of the core, of each face moved out by the rounding, and of a capsule along
// each edge; all are convex and so is the body: a line passes through it once.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "shapes/capsule.hpp"
#include "shapes/loops.hpp"
#include "shapes/polyhedron_faces.hpp"
#include "shapes/quadrature.hpp"
#include "shapes/rounded_body.hpp"
#include "shapes/rounded_mesh.hpp"

namespace porepack::shapes {
namespace {

class RoundedPolyhedron : public RoundedBody {
public:
    RoundedPolyhedron(std::vector<Vec3> corners, std::vector<Face> faces, std::vector<Edge> edges, const Vec3& centre, double rounding)
        : corners_(std::move(corners)), faces_(std::move(faces)), edges_(std::move(edges)), rounding_(rounding), centre_(centre) {
        for (const Vec3& corner : corners_) radius_ = std::max(radius_, (corner - centre_).norm());
        for (std::size_t e = 0; e < edges_.size(); ++e) {
            const Edge& edge = edges_[e];
            along_.push_back(at(edge.b) - at(edge.a));
            per_square_.push_back(1.0 / along_.back().squaredNorm());
            for (const std::size_t f : edge.faces) {
                Face& face = faces_[f];
                face.edges.resize(face.corners.size());
                for (std::size_t i = 0; i < face.corners.size(); ++i)
                    if (const int from = face.corners[i], to = face.corners[(i + 1) % face.corners.size()];
                        (from == edge.a && to == edge.b) || (from == edge.b && to == edge.a))
                        face.edges[i] = e;
            }
        }
        depth_ = 1e300;
        for (const Face& face : faces_) depth_ = std::min(depth_, face.height - face.normal.dot(centre_));
    }

    [[nodiscard]] Json to_json() const override {
        Json json = {{"kind", "polyhedron"}, {"corners_m", Json::array()}, {"faces", Json::array()}, {"rounding_m", rounding_}};
        for (const Vec3& x : corners_) json["corners_m"].push_back({x.x(), x.y(), x.z()});
        for (const Face& face : faces_) json["faces"].push_back(face.corners);
        return json;
    }

    [[nodiscard]] double distance(const Vec3& point, Vec3* outward) const override {
        const auto above = [&](std::size_t f) { return faces_[f].normal.dot(point) - faces_[f].height; };
        std::size_t over = 0;
        double height = above(0);
        for (std::size_t f = 1; f < faces_.size(); ++f)
            if (const double own = above(f); own > height) {
                height = own;
                over = f;
            }
        // Often the nearest point lies on the highest face, or within one of its edges; otherwise, on an edge of any face that is seen from
        // the point.
        const Face& highest = faces_[over];
        if (outward != nullptr) *outward = highest.normal;
        if (height <= 0.0) return height - rounding_;
        bool within = true;
        for (std::size_t i = 0; i < highest.corners.size(); ++i) {
            const Vec3 from = point - corner(highest, i);
            if (highest.outwards[i].dot(from) <= 0.0) continue;
            within = false;
            const Edge& edge = edges_[highest.edges[i]];
            const Vec3 &along = along_[highest.edges[i]], from_a = point - at(edge.a);
            const double share = from_a.dot(along) * per_square_[highest.edges[i]];
            if (share <= 0.0 || share >= 1.0 || edge.out_a.dot(from) <= 0.0 || edge.out_b.dot(from) <= 0.0) continue;
            const Vec3 away = from_a - share * along;
            const double distance = away.norm();
            if (outward != nullptr) *outward = away / distance;
            return distance - rounding_;
        }
        if (within) return height - rounding_;
        double nearest2 = 1e300;
        Vec3 from_nearest = faces_[over].normal;
        for (std::size_t e = 0; e < edges_.size(); ++e) {
            const Edge& edge = edges_[e];
            if (above(edge.faces[0]) <= 0.0 && above(edge.faces[1]) <= 0.0) continue;
            const Vec3 from = point - at(edge.a), &along = along_[e];
            const Vec3 away = from - std::clamp(from.dot(along) * per_square_[e], 0.0, 1.0) * along;
            if (const double away2 = away.squaredNorm(); away2 < nearest2) {
                nearest2 = away2;
                from_nearest = away;
            }
        }
        const double nearest = std::sqrt(nearest2);
        if (outward != nullptr && nearest > 0.0) *outward = from_nearest / nearest;
        return nearest - rounding_;
    }

    void line(const Vec3& origin, const Vec3& direction, double grown, std::vector<Interval>& parts) const override {
        parts.clear();
        const double r = rounding_ + grown;
        const Vec3 from_centre = origin - centre_;
        if ((from_centre - from_centre.dot(direction) * direction).squaredNorm() >= (radius_ + r) * (radius_ + r)) return;
        Interval whole{1e300, -1e300};
        const auto join = [&](const Interval& part) {
            if (part.low >= part.high) return;
            whole = {std::min(whole.low, part.low), std::max(whole.high, part.high)};
        };
        Interval core{-1e300, 1e300};
        for (const Face& face : faces_) clip(core, face.normal, face.height, origin, direction);
        join(core);
        if (r > 0.0) {
            for (const Face& face : faces_) {
                Interval part{-1e300, 1e300};
                clip(part, face.normal, face.height + r, origin, direction);
                clip(part, -face.normal, -face.height, origin, direction);
                for (std::size_t i = 0; i < face.corners.size() && part.low < part.high; ++i)
                    clip(part, face.outwards[i], face.outwards[i].dot(corner(face, i)), origin, direction);
                join(part);
            }
            for (const Edge& edge : edges_)
                if (const auto part = line_interval(Capsule{at(edge.a), at(edge.b), r}, origin, direction)) join(*part);
        }
        if (whole.low < whole.high) parts.push_back(whole);
    }

    [[nodiscard]] double support(const Vec3& direction) const override {
        double highest = -1e300;
        for (const Vec3& corner : corners_) highest = std::max(highest, corner.dot(direction));
        return highest + rounding_;
    }

    // Below the rounding the core keeps its size; then it shrinks about its centre, where each plane comes nearer by the same share of its
    // distance, which is `depth_` or more.
    [[nodiscard]] std::shared_ptr<const RoundedBody> thinned(double depth) const override {
        if (depth <= rounding_) return moved_and_scaled(1.0, rounding_ - depth);
        const double factor = 1.0 - (depth - rounding_) / depth_;
        return factor > 0.0 ? moved_and_scaled(factor, 0.0) : nullptr;
    }

    [[nodiscard]] std::shared_ptr<const RoundedBody> scaled(double factor) const override {
        std::vector<Vec3> corners = corners_;
        for (Vec3& corner : corners) corner *= factor;
        return changed(std::move(corners), factor * centre_, factor * rounding_);
    }

    void for_surface(const SurfacePoint& visit) const override {
        for (const Face& face : faces_)
            for (std::size_t i = 1; i + 1 < face.corners.size(); ++i)
                on_triangle(corner(face, 0), corner(face, i), corner(face, i + 1), face.normal, visit);
        if (rounding_ == 0.0) return;
        for (const Edge& edge : edges_) on_edge(edge, visit);
        for (std::size_t i = 0; i < corners_.size(); ++i) on_corner(static_cast<int>(i), visit);
    }

    [[nodiscard]] SurfaceSizes hull() const override { return surface_measures(*this); }
    [[nodiscard]] bool convex() const override { return true; }
    [[nodiscard]] std::vector<Facet> facets(double deviation, double) const override {
        std::vector<Facet> facets;
        const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& outward) {
            if (a == b || b == c || c == a) return;
            facets.push_back((b - a).cross(c - a).dot(outward) > 0.0 ? Facet{a, b, c} : Facet{a, c, b});
        };
        for (const Face& face : faces_) {
            const Vec3 out = rounding_ * face.normal;
            for (std::size_t i = 1; i + 1 < face.corners.size(); ++i)
                add(corner(face, 0) + out, corner(face, i) + out, corner(face, i + 1) + out, face.normal);
        }
        double widest = 0.0;
        for (const Edge& edge : edges_) widest = std::max(widest, angle_between(edge.normal_a, edge.normal_b));
        const int parts = divided_arc(rounding_, widest, 0.5 * deviation).parts;
        // From a corner of the core to that of a facet on the arc between two faces.
        const auto on_arc = [&](const Vec3& a, const Vec3& b, int k) -> Vec3 {
            const double factor = k == 0 || k == parts ? 1.0 : arc_factor(angle_between(a, b), parts);
            return factor * rounding_ * between(a, b, k, parts);
        };
        for (const Edge& edge : edges_)
            for (int k = 0; k < parts; ++k) {
                const Vec3 one = on_arc(edge.normal_a, edge.normal_b, k), other = on_arc(edge.normal_a, edge.normal_b, k + 1);
                add(at(edge.a) + one, at(edge.b) + one, at(edge.b) + other, one + other);
                add(at(edge.a) + one, at(edge.b) + other, at(edge.a) + other, one + other);
            }
        const double inner = arc_factor(widest, parts);
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            const std::vector<Vec3> normals = normals_around(static_cast<int>(i));
            const Vec3 middle = middle_of(normals);
            for (std::size_t n = 0; n < normals.size(); ++n) {
                const Vec3 &a = normals[n], &b = normals[(n + 1) % normals.size()];
                // The triangle from `middle` to the arc between two faces, in rows that grow by one facet.
                const auto place = [&](int row, int k) -> Vec3 {
                    if (row == parts) return corners_[i] + on_arc(a, b, k);
                    return corners_[i] + inner * rounding_ * between(middle, row == 0 ? a : between(a, b, k, row), row, parts);
                };
                for (int row = 0; row < parts; ++row)
                    for (int k = 0; k <= row; ++k) {
                        const Vec3 out = place(row + 1, k) - corners_[i];
                        add(place(row, k), place(row + 1, k), place(row + 1, k + 1), out);
                        if (k < row) add(place(row, k), place(row + 1, k + 1), place(row, k + 1), out);
                    }
            }
        }
        return facets;
    }

    [[nodiscard]] std::vector<ContactCurve> contact_curves() const override {
        std::vector<ContactCurve> curves;
        for (const Vec3& corner : corners_) curves.push_back({.kind = ContactCurve::Kind::corner, .a = corner, .radius = rounding_});
        for (const Edge& edge : edges_)
            curves.push_back({.kind = ContactCurve::Kind::edge, .a = at(edge.a), .b = at(edge.b), .radius = rounding_});
        return curves;
    }

    [[nodiscard]] double rounding() const override { return rounding_; }
    [[nodiscard]] double thickness() const override { return 2.0 * (rounding_ + depth_); }
    [[nodiscard]] double reach_from(const Vec3& point) const override {
        double farthest = 0.0;
        for (const Vec3& corner : corners_) farthest = std::max(farthest, (corner - point).norm());
        return farthest + rounding_;
    }
    [[nodiscard]] double maximum_feret_diameter() const override {
        double farthest = 0.0;
        for (const Vec3& a : corners_)
            for (const Vec3& b : corners_) farthest = std::max(farthest, (a - b).norm());
        return farthest + 2.0 * rounding_;
    }

private:
    [[nodiscard]] const Vec3& at(int i) const { return corners_[static_cast<std::size_t>(i)]; }
    [[nodiscard]] const Vec3& corner(const Face& face, std::size_t i) const { return at(face.corners[i % face.corners.size()]); }

    // The unit vector k / parts of the way along the arc from a to b, the same to the last bit from b to a.
    static Vec3 between(const Vec3& a, const Vec3& b, int k, int parts) {
        if (k == 0) return a;
        if (k == parts) return b;
        if (std::lexicographical_compare(b.begin(), b.end(), a.begin(), a.end())) return between(b, a, parts - k, parts);
        const double angle = angle_between(a, b), share = static_cast<double>(k) / parts;
        if (angle < 1e-12) return a;  // two faces in one plane
        return (std::sin((1.0 - share) * angle) * a + std::sin(share * angle) * b) / std::sin(angle);
    }

    // Keeps the part of the line below the plane.
    static void clip(Interval& part, const Vec3& normal, double height, const Vec3& origin, const Vec3& direction) {
        const double rise = normal.dot(direction), below = height - normal.dot(origin);
        if (std::abs(rise) < 1e-14) {
            if (below <= 0.0) part = {1.0, -1.0};
        } else if (rise > 0.0) {
            part.high = std::min(part.high, below / rise);
        } else {
            part.low = std::max(part.low, below / rise);
        }
    }

    // About the centre.
    [[nodiscard]] std::shared_ptr<const RoundedBody> moved_and_scaled(double factor, double rounding) const {
        std::vector<Vec3> corners = corners_;
        for (Vec3& corner : corners) corner = centre_ + factor * (corner - centre_);
        return changed(std::move(corners), centre_, rounding);
    }
    // The same faces with other corners.
    [[nodiscard]] std::shared_ptr<const RoundedBody> changed(std::vector<Vec3> corners, const Vec3& centre, double rounding) const {
        std::vector<Face> faces = faces_;
        for (Face& face : faces) face.height = face.normal.dot(corners[static_cast<std::size_t>(face.corners[0])]);
        return std::make_shared<const RoundedPolyhedron>(std::move(corners), std::move(faces), edges_, centre, rounding);
    }

    // The triangle, as a square with one side drawn together.
    void on_triangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& normal, const SurfacePoint& visit) const {
        const double twice_area = (b - a).cross(c - a).norm();
        for_gauss_points<4>(0.0, 1.0, [&](double u, double weight_u) {
            for_gauss_points<4>(0.0, 1.0, [&](double v, double weight_v) {
                const Vec3 x = a + u * ((1.0 - v) * (b - a) + v * (c - a));
                visit(x + rounding_ * normal, normal, twice_area * u * weight_u * weight_v);
            });
        });
    }

    // A part of a cylinder about the edge, from the normal of one face to that of the other.
    void on_edge(const Edge& edge, const SurfacePoint& visit) const {
        const Vec3 along = at(edge.b) - at(edge.a);
        const Vec3 across = (edge.normal_b - edge.normal_b.dot(edge.normal_a) * edge.normal_a).normalized();
        const double turn = std::atan2(edge.normal_b.dot(across), edge.normal_b.dot(edge.normal_a));
        for_gauss_points<20>(0.0, turn, [&](double angle, double weight) {
            const Vec3 normal = std::cos(angle) * edge.normal_a + std::sin(angle) * across;
            for_gauss_points<4>(0.0, 1.0, [&](double share, double weight_along) {
                visit(at(edge.a) + share * along + rounding_ * normal, normal, rounding_ * weight * along.norm() * weight_along);
            });
        });
    }

    // A part of a sphere, between the normals of the faces around the corner.
    void on_corner(int index, const SurfacePoint& visit) const {
        const std::vector<Vec3> normals = normals_around(index);
        const Vec3 a = middle_of(normals);
        for (std::size_t i = 0; i < normals.size(); ++i) {
            const Vec3 &b = normals[i], &c = normals[(i + 1) % normals.size()];
            const Vec3 across = (b - a).cross(c - a);  // the flat triangle below that part; its area is half of this vector's length
            for_gauss_points<20>(0.0, 1.0, [&](double u, double weight_u) {
                for_gauss_points<20>(0.0, 1.0, [&](double v, double weight_v) {
                    const Vec3 x = a + u * ((1.0 - v) * (b - a) + v * (c - a));
                    const double away = x.norm(), solid_angle = std::abs(across.dot(x)) / (away * away * away) * u * weight_u * weight_v;
                    visit(at(index) + rounding_ / away * x, x / away, rounding_ * rounding_ * solid_angle);
                });
            });
        }
    }

    static Vec3 middle_of(const std::vector<Vec3>& directions) {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& direction : directions) sum += direction;
        return sum.normalized();
    }

    // In their order around the corner: the side before the corner in one face is the side after it in the next.
    [[nodiscard]] std::vector<Vec3> normals_around(int index) const {
        std::map<int, std::pair<int, const Face*>> by_next;  // corner after -> corner before, face
        for (const Face& face : faces_) {
            const auto found = std::find(face.corners.begin(), face.corners.end(), index);
            if (found == face.corners.end()) continue;
            const auto i = static_cast<std::size_t>(found - face.corners.begin());
            by_next[face.corners[(i + 1) % face.corners.size()]] = {face.corners[(i + face.corners.size() - 1) % face.corners.size()],
                                                                    &face};
        }
        std::vector<Vec3> normals;
        int next = by_next.begin()->first;
        for (std::size_t n = 0; n < by_next.size(); ++n) {
            normals.push_back(by_next.at(next).second->normal);
            next = by_next.at(next).first;
        }
        return normals;
    }

    std::vector<Vec3> corners_;
    std::vector<Face> faces_;
    std::vector<Edge> edges_;
    double rounding_;
    Vec3 centre_;
    double radius_ = 0.0;             // of the sphere about the centre through the farthest corner
    double depth_;                    // of the centre below the nearest face
    std::vector<Vec3> along_;         // of each edge
    std::vector<double> per_square_;  // 1 / its squared length
};

}  // namespace

std::shared_ptr<const RoundedBody> make_polyhedron(const PolyhedronSize& size) {
    const auto count = static_cast<int>(size.corners_m.size());
    if (count < 4 || size.faces.size() < 4)
        throw UserError("a polyhedron needs four corners and four faces, or more", {.where = "corners_m, faces"});
    double extent = 0.0;
    for (const Vec3& corner : size.corners_m) extent = std::max(extent, (corner - size.corners_m.front()).norm());
    if (!(extent > 0.0) || !std::isfinite(extent))
        throw UserError("the corners of the polyhedron are not finite numbers, or all the same", {.where = "corners_m"});
    if (!(size.rounding_m >= 0.0) || !std::isfinite(size.rounding_m))
        throw UserError(fmt::format("the rounding of the polyhedron is {:g} m", size.rounding_m), {.allowed = "0 or more"});
    std::vector<Face> faces;
    for (const auto& list : size.faces) {
        for (const int i : list)
            if (i < 0 || i >= count)
                throw UserError(fmt::format("a face of the polyhedron names corner {}", i), {.allowed = fmt::format("0 to {}", count - 1)});
        faces.push_back(plane_face(size.corners_m, list, extent));
    }
    std::vector<Edge> edges = edges_of(faces);
    for (int i = 0; i < count; ++i)
        if (std::none_of(edges.begin(), edges.end(), [&](const Edge& edge) { return edge.a == i || edge.b == i; }))
            throw UserError(fmt::format("corner {} of the polyhedron belongs to no face", i), {.fix = "remove it"});
    const bool convex = std::all_of(faces.begin(), faces.end(), [&](const Face& face) {
        return std::all_of(size.corners_m.begin(), size.corners_m.end(),
                           [&](const Vec3& corner) { return face.normal.dot(corner) - face.height <= 1e-9 * extent; });
    });
    if (!convex) {
        std::vector<std::array<int, 3>> triangles;
        for (const Face& face : faces)
            for (std::size_t i = 1; i + 1 < face.corners.size(); ++i)
                triangles.push_back({face.corners[0], face.corners[i], face.corners[i + 1]});
        return make_rounded_mesh(std::make_shared<const TriangleCore>(size.corners_m, std::move(triangles)), size.rounding_m);
    }
    const Vec3 centre = middle_of_largest_ball(faces, size.corners_m);
    return std::make_shared<const RoundedPolyhedron>(size.corners_m, std::move(faces), std::move(edges), centre, size.rounding_m);
}

}  // namespace porepack::shapes
