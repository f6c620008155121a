// Facets of one grain. A grain with faces has its own. Each capsule is a stack of rings of corners around its axis, from pole to pole.
// Neighbouring rings are rotated by half a corner, and each arm of a grain by a different angle, so that no two facets are coplanar:
// coplanar facets make exact Booleans slow and, rounded to single precision, faulty. The corners lie slightly outside the exact surface,
// the facets' middles slightly inside, so that the mesh keeps the capsule's volume. CGAL then unites the arms.
#include "converters/grain_mesh.hpp"

#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "converters/mesh_intersections.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/parallel.hpp"
#include "io/iso_surface.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace sms = CGAL::Surface_mesh_simplification;
namespace {

// A capsule, ring by ring from pole to pole, its corners at distance `r` from the axis. `turn` differs from arm to arm so
// that no facets are coplanar.
Mesh ring_mesh(const Capsule& capsule, double r, int n, double turn) {
    const double length = (capsule.b - capsule.a).norm();
    const Vec3 axis = length > 0.0 ? Vec3((capsule.b - capsule.a) / length) : Vec3(Vec3::UnitZ());
    const Vec3 e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    Mesh mesh;
    std::vector<std::vector<Mesh::Vertex_index>> rings;
    const auto add_ring = [&](const Vec3& centre, double radius) {
        rings.emplace_back();
        const double phase = turn + std::numbers::pi / n * static_cast<double>(rings.size());
        for (int i = 0; i < n; ++i) {
            const double phi = phase + 2.0 * std::numbers::pi * i / n;
            rings.back().push_back(mesh.add_vertex(to_point(centre + radius * (std::cos(phi) * e1 + std::sin(phi) * e2))));
        }
    };
    const int bands = n / 4;
    const auto bottom = mesh.add_vertex(to_point(capsule.a - r * axis));
    for (int k = 1; k <= bands; ++k) {
        const double theta = 0.5 * std::numbers::pi * k / bands;
        add_ring(capsule.a - r * std::cos(theta) * axis, r * std::sin(theta));
    }
    // A straight side needs no rings in between, but very long triangles make intersections slow and inaccurate.
    const int pieces = static_cast<int>(std::ceil(length / (3.0 * capsule.radius)));
    for (int k = 1; k < pieces; ++k) add_ring(capsule.a + (capsule.b - capsule.a) * (static_cast<double>(k) / pieces), r);
    for (int k = bands; k >= 1; --k) {
        if (k == bands && length == 0.0) continue;
        const double theta = 0.5 * std::numbers::pi * k / bands;
        add_ring(capsule.b + r * std::cos(theta) * axis, r * std::sin(theta));
    }
    const auto top = mesh.add_vertex(to_point(capsule.b + r * axis));
    const auto corner = [&](std::size_t ring, int i) { return rings[ring][static_cast<std::size_t>(i % n)]; };
    for (int i = 0; i < n; ++i) {
        mesh.add_face(bottom, corner(0, i + 1), corner(0, i));
        for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
            mesh.add_face(corner(ring, i), corner(ring, i + 1), corner(ring + 1, i));
            mesh.add_face(corner(ring, i + 1), corner(ring + 1, i + 1), corner(ring + 1, i));
        }
        mesh.add_face(top, corner(rings.size() - 1, i), corner(rings.size() - 1, i + 1));
    }
    return mesh;
}

// Maximum distance of a facet's middle or corner from the capsule's surface.
double mesh_deviation(const Mesh& mesh, const Capsule& capsule) {
    double worst = 0.0;
    for (const auto face : mesh.faces()) {
        Vec3 middle = Vec3::Zero();
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) {
            const Vec3 corner = to_vector(mesh.point(v));
            worst = std::max(worst, std::abs(signed_distance(capsule, corner)));
            middle += corner / 3.0;
        }
        worst = std::max(worst, std::abs(signed_distance(capsule, middle)));
    }
    return worst;
}

// The coarsest mesh of a capsule within the deviation. Its corners lie outside, its facets inside, so that it has the
// capsule's volume.
Mesh capsule_mesh(const Capsule& capsule, double deviation, double turn) {
    const double r = capsule.radius;
    const double volume = std::numbers::pi * r * r * ((capsule.b - capsule.a).norm() + 4.0 / 3.0 * r);
    // Facets of n corners deviate by r (1 - cos(pi/n)); half of it lies outside.
    const double fewest = 0.6 * std::numbers::pi / std::acos(1.0 - std::min(1.0, deviation / r));
    for (int n = std::max(8, 4 * static_cast<int>(std::min(fewest, 512.0) / 4.0)); n <= 512; n += 4) {
        check_interrupt();
        double radius = r;
        Mesh mesh;
        for (int round = 0; round < 4; ++round) {
            mesh = ring_mesh(capsule, radius, n, turn);
            // dV/dr is the surface area, except for the small error of the facets.
            const double surface = 2.0 * std::numbers::pi * r * ((capsule.b - capsule.a).norm() + 2.0 * r);
            radius += (volume - pmp::volume(mesh)) / surface;
        }
        if (mesh_deviation(mesh, capsule) <= deviation) return mesh;
    }
    throw UserError(fmt::format("a surface deviation of {:g} m needs more than 512 corners around a capsule", deviation),
                    {.fix = "choose a larger surface_deviation_m"});
}

// Moves the corners onto the body's surface, or `outside` of it.
void project(Mesh& mesh, const RoundedBody& body, double outside = 0.0) {
    for (const auto v : mesh.vertices()) {
        Vec3 x = to_vector(mesh.point(v)), outward;
        for (int step = 0; step < 4; ++step) {
            const double away = body.distance(x, &outward) - outside;
            x -= away * outward;
        }
        mesh.point(v) = to_point(x);
    }
}

// Of the middles of facets and sides from the surface: the largest one, and the one that 97 % of them do not exceed.
struct Deviation {
    double largest, usual;
};
Deviation mesh_deviation(const Mesh& mesh, const RoundedBody& body) {
    std::vector<double> away;
    for (const auto face : mesh.faces()) {
        Vec3 middle = Vec3::Zero();
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) middle += to_vector(mesh.point(v)) / 3.0;
        away.push_back(std::abs(body.distance(middle)));
    }
    for (const auto edge : mesh.edges())
        away.push_back(
            std::abs(body.distance(0.5 * (to_vector(mesh.point(mesh.vertex(edge, 0))) + to_vector(mesh.point(mesh.vertex(edge, 1)))))));
    const auto usual = away.begin() + static_cast<std::ptrdiff_t>(97 * away.size() / 100);
    std::nth_element(away.begin(), usual, away.end());
    return {*std::max_element(usual, away.end()), *usual};
}

// A body without facets of its own: the zero level of its distance on a grid that is finer than the rounding, then as few facets as keep
// the deviation. `shift`, below 1, moves the grid by so much of its spacing.
Mesh level_mesh(const RoundedBody& body, double deviation, double shift) {
    Vec3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
        low[axis] = -body.support(-Vec3::Unit(axis));
        high[axis] = body.support(Vec3::Unit(axis));
    }
    constexpr double max_cells = 250.0;
    // Facets with sides h of a rounding r deviate by h^2 / 8r.
    const double of_edges = 0.7 * std::sqrt(8.0 * body.rounding() * deviation);
    const double h = std::max(std::min(std::max(1.5 * deviation, of_edges), 0.5 * body.thickness()), (high - low).maxCoeff() / max_cells);
    geometry::GrayImage image;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        image.grid.cells[axis] = static_cast<int>(std::ceil((high[a] - low[a]) / h)) + 4;
        image.grid.spacing_m[axis] = h;
        image.grid.origin_m[axis] = low[a] - (2.0 + shift) * h;
    }
    image.packed.resize(image.grid.size());
    parallel_for(static_cast<std::size_t>(image.grid.cells[2]), [&](std::size_t slice) {
        const int k = static_cast<int>(slice);
        for (int j = 0; j < image.grid.cells[1]; ++j)
            for (int i = 0; i < image.grid.cells[0]; ++i) {
                const Vec3 x(image.grid.centre(0, i), image.grid.centre(1, j), image.grid.centre(2, k));
                image.packed[image.grid.index(i, j, k)] = geometry::GrayImage::pack(0.5 - 0.2 * body.distance(x) / h);
            }
    });
    auto fine = mesh_of(io::iso_surface(image));
    if (!fine) throw NumericalError("the surface of a grain is not manifold", {.fix = "change surface_deviation_m slightly"});
    project(*fine, body);
    constexpr double share_inside = 0.7;
    // At inner edges, which have no rounding, facets deviate by more than elsewhere, and the more, the larger they are.
    const double at_edges = std::max(share_inside * deviation, 1.5 * mesh_deviation(*fine, body).largest);
    Mesh kept = *fine;
    constexpr double fewest_edges = 100.0, step = 1.4;
    for (double edges = static_cast<double>(kept.number_of_edges()) / step; edges > fewest_edges; edges /= step) {
        check_interrupt();
        Mesh mesh = kept;
        const sms::Count_stop_predicate<Mesh> stop(static_cast<std::size_t>(edges));
        sms::edge_collapse(mesh, stop, CGAL::parameters::filter(sms::Bounded_normal_change_filter<>()));
        mesh.collect_garbage();
        project(mesh, body);
        const Deviation found = mesh_deviation(mesh, body);
        if (found.usual > share_inside * deviation || found.largest > at_edges) break;
        kept = std::move(mesh);
    }
    // Corners outside, as many facets inside: the volume is that of the body.
    const double volume = surface_measures(body).volume_m3;
    double outside = 0.0;
    for (int round = 0; round < 3; ++round) {
        outside += (volume - pmp::volume(kept)) / pmp::area(kept);
        project(kept, body, std::clamp(outside, -share_inside * deviation, share_inside * deviation));
    }
    if (std::abs(pmp::volume(kept) / volume - 1.0) > 0.02)
        throw NumericalError(fmt::format("the surface of a grain has {:.3g} of its volume: parts of it are thinner than {:.3g} m",
                                         pmp::volume(kept) / volume, h),
                             {.fix = "use a smaller surface_deviation_m"});
    return kept;
}

// A grain with faces, in its own frame.
Mesh body_mesh(const RoundedBody& body, double deviation, double turn) {
    std::vector<Point> points;
    std::vector<std::array<std::size_t, 3>> triangles;
    const std::vector<shapes::Facet> facets = body.facets(deviation, turn);
    if (facets.empty()) return level_mesh(body, deviation, turn - std::floor(turn));
    for (const shapes::Facet& facet : facets) {
        triangles.push_back({points.size(), points.size() + 1, points.size() + 2});
        for (const Vec3& corner : facet) points.push_back(to_point(corner));
    }
    pmp::merge_duplicate_points_in_polygon_soup(points, triangles);
    Mesh mesh;
    pmp::polygon_soup_to_polygon_mesh(points, triangles, mesh);
    return mesh;
}

// Inner shells (enclosed voids) have negative volume.
void drop_cavities(Mesh& mesh) {
    auto shell = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:shell").first;
    const std::size_t count = pmp::connected_components(mesh, shell);
    std::vector<std::size_t> keep;
    for (std::size_t s = 0; s < count; ++s) {
        double volume = 0.0;
        for (const auto face : mesh.faces()) {
            if (shell[face] != s) continue;
            auto h = mesh.halfedge(face);
            volume +=
                CGAL::volume(Point(0, 0, 0), mesh.point(mesh.source(h)), mesh.point(mesh.target(h)), mesh.point(mesh.target(mesh.next(h))));
        }
        if (volume > 0.0) keep.push_back(s);
    }
    if (keep.size() < count) pmp::keep_connected_components(mesh, keep, shell);
    mesh.collect_garbage();
    mesh.remove_property_map(shell);
}

}  // namespace

void unite_into(Mesh& all, Mesh& part) {
    auto united = boolean_of(Boolean::unite, all, part);
    if (!united) throw NumericalError("CGAL cannot unite two bodies", {.fix = "change surface_deviation_m slightly"});
    all = std::move(*united);
}

Mesh grain_mesh(const Shape& shape, double deviation, double thinner, int variant) {
    if (shape.body != nullptr) {
        const auto thinned = thinner > 0.0 ? shape.body->thinned(thinner) : shape.body;
        return body_mesh(thinned != nullptr ? *thinned : *shape.body, deviation, 0.37 + 0.291 * variant);
    }
    Mesh mesh;
    for (std::size_t i = 0; i < shape.capsules.size(); ++i) {
        Capsule capsule = shape.capsules[i];
        capsule.radius -= thinner;
        Mesh part = capsule_mesh(capsule, deviation, 0.37 + 1.117 * static_cast<double>(i) + 0.291 * variant);
        if (i == 0)
            mesh = std::move(part);
        else
            unite_into(mesh, part);
    }
    if (shape.cavity == Cavity::filled && !shape.cavity_points.empty()) drop_cavities(mesh);
    return mesh;
}

Mesh moved_mesh(const Mesh& mesh, const Vec3& position, const Quaternion& orientation) {
    Mesh copy = mesh;
    for (const auto v : copy.vertices()) copy.point(v) = to_point(position + orientation * to_vector(copy.point(v)));
    return copy;
}

}  // namespace porepack::converters
