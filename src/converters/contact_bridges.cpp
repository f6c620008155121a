// Contacts and bridges. Two grains in point contact overlap in a lens far thinner than the deviation of their facets, so
// the meshes may miss each other, or cross in slivers that are lost in single precision. A small box through the contact turns this
// grazing intersection into a clean one at steep angles. Grains that are near but apart must not meet: their corners there are put on the
// exact surface, so that the facets lie inside it.
#include "converters/contact_bridges.hpp"

#include <CGAL/Polygon_mesh_processing/measure.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "converters/grain_mesh.hpp"
#include "converters/uses.hpp"
#include "core/joined_sets.hpp"
#include "shapes/distance.hpp"
#include "shapes/segments.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

// The part of the first axis where the gap is larger than at the contact by `wider` at most. The gap is convex along the axis, so that
// bisection finds both ends.
std::pair<Vec3, Vec3> stretch_of(const GrainContact& contact, double wider) {
    const Capsule& p = contact.first_capsule;
    const double largest = contact.gap + p.radius + contact.second_capsule.radius + wider;
    const auto distance = [&](const Vec3& x) { return (closest_on_axis(contact.second_capsule, x) - x).norm(); };
    const auto end_towards = [&](Vec3 outside) {
        if (distance(outside) <= largest) return outside;
        Vec3 inside = contact.nearest;
        for (int halving = 0; halving < 30; ++halving) {
            const Vec3 middle = 0.5 * (inside + outside);
            (distance(middle) <= largest ? inside : outside) = middle;
        }
        return inside;
    };
    return {end_towards(p.a), end_towards(p.b)};
}

// Zero for a sphere.
Vec3 direction_of(const Capsule& capsule) {
    const Vec3 along = capsule.b - capsule.a;
    return along.norm() > 0.0 ? Vec3(along.normalized()) : Vec3(Vec3::Zero());
}

Vec3 direction_from(const Vec3& x, const Capsule& to) {
    const Vec3 across = closest_on_axis(to, x) - x;
    return across.norm() > 0.0 ? Vec3(across.normalized()) : Vec3(Vec3::UnitZ());
}

bool on_one_line(const Capsule& p, const Capsule& q) {
    const Vec3 along = p.b - p.a;
    const double slack = 1e-6 * p.radius * along.norm();
    return along.norm() > 0.0 && along.cross(q.a - p.a).norm() < slack && along.cross(q.b - p.a).norm() < slack;
}

}  // namespace

namespace {

// A ball in the grain that touches its surface at `place` from inside; `inward` is a unit vector. The smallest has the rounding's radius.
Capsule ball_at(const PlacedShape& grain, const Vec3& place, const Vec3& inward) {
    const double smallest = grain.shape.body != nullptr ? grain.shape.body->rounding() : 0.0;
    double radius = 0.5 * smallest_diameter(grain.shape);
    while (radius > smallest && signed_distance(grain, place + radius * inward) > -0.99 * radius) radius = std::max(smallest, 0.7 * radius);
    const Vec3 centre = place + radius * inward;
    return {centre, centre, radius};
}

void add_capsule_contacts(const Grains& grains, std::size_t i, std::size_t j, double reach, std::vector<GrainContact>& contacts) {
    const auto& images = grains.images();
    for (const auto& p : images[i].capsules)
        for (const auto& q : images[j].capsules) {
            const double between = gap(p, q);
            if (between >= reach) continue;
            const Vec3 nearest = closest_points({p.a, p.b - p.a}, {q.a, q.b - q.a}).on_first;
            const GrainContact contact{.first = i,
                                       .second = j,
                                       .first_capsule = p,
                                       .second_capsule = q,
                                       .nearest = nearest,
                                       .normal = direction_from(nearest, q),
                                       .gap = between};
            // Arms share their end spheres: the same contact is found several times.
            const auto same = [&](const GrainContact& other) {
                const double slack = 1e-6 * p.radius;
                return other.first == i && other.second == j && (other.nearest - contact.nearest).norm() < slack &&
                       (other.normal - contact.normal).norm() < 1e-6;
            };
            const auto recent = contacts.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(contacts.size(), 64));
            if (std::none_of(recent, contacts.end(), same)) contacts.push_back(contact);
        }
}

void add_nearest_place(const Grains& grains, std::size_t i, std::size_t j, double reach, std::vector<GrainContact>& contacts) {
    const PlacedShape first = grains.placed(grains.images()[i]), second = grains.placed(grains.images()[j]);
    const Nearest found = nearest(first, second, reach);
    if (found.gap_m >= reach) return;
    const Vec3 half = 0.5 * found.gap_m * found.normal;
    const Capsule ball = ball_at(first, found.point - half, -found.normal);
    contacts.push_back({.first = i,
                        .second = j,
                        .first_capsule = ball,
                        .second_capsule = ball_at(second, found.point + half, found.normal),
                        .nearest = ball.a,
                        .normal = found.normal,
                        .gap = found.gap_m,
                        .with_faces = true});
}

}  // namespace

std::vector<GrainContact> find_contacts(const Grains& grains, double reach) {
    std::vector<GrainContact> contacts;
    const auto& images = grains.images();
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = i + 1; j < images.size(); ++j) {
            if (((images[i].bounds.high - images[j].bounds.low).array() < -reach).any() ||
                ((images[j].bounds.high - images[i].bounds.low).array() < -reach).any())
                continue;
            const bool with_faces = grains.shape_of(images[i]).body != nullptr || grains.shape_of(images[j]).body != nullptr;
            (with_faces ? add_nearest_place : add_capsule_contacts)(grains, i, j, reach, contacts);
        }
    return contacts;
}

Bridge bridge_of(const GrainContact& contact, double contact_gap, double deviation, int variant) {
    const double r = std::min(contact.first_capsule.radius, contact.second_capsule.radius);
    const double lens = std::max(0.0, -contact.gap) + 2.0 * contact_gap + 0.25 * std::min(variant, 8) * deviation;
    // The gap grows with the square of the distance. For two cylinders with the angle theta between them, the part where it grows by `lens`
    // at most is an ellipse: its half width is sqrt(2 r lens), and along the first axis it reaches as far as the gap on this axis grows by
    // (1 + cos^2 theta) lens. For spheres and parallel cylinders it is narrower.
    const Vec3 axis = direction_of(contact.first_capsule);
    const double cosine = axis.dot(direction_of(contact.second_capsule));
    const double half_width = std::min(0.4 * r, std::sqrt((axis.isZero() ? 1.0 : 2.0) * r * lens));
    const double depth = std::min(0.8 * r, 3.0 * deviation + half_width);
    const auto [from, to] = stretch_of(contact, (1.0 + cosine * cosine) * lens);
    const Vec3 on_axis = 0.5 * (from + to), normal = direction_from(on_axis, contact.second_capsule);
    const Vec3 along = to - from - (to - from).dot(normal) * normal;
    const bool reaches_end = from == contact.first_capsule.a || to == contact.first_capsule.b;  // and goes around it
    const double half_length = std::max(half_width, 0.5 * along.norm() + (reaches_end ? std::sqrt(0.5) * half_width : 0.0));
    // Rotated slightly: no face lies in a plane of the grains' meshes.
    const Vec3 across = along.norm() > 1e-6 * r ? Vec3(along.normalized()) : normal.unitOrthogonal();
    const Vec3 t = Eigen::AngleAxisd((0.0137 + 0.083 * variant) * half_width / half_length, normal) * across;
    const double bottom = contact.first_capsule.radius - depth;
    const double top = (closest_on_axis(contact.second_capsule, on_axis) - on_axis).norm() - contact.second_capsule.radius + depth;
    Bridge bridge;
    bridge.axes << t, normal.cross(t), normal;
    bridge.half_size = Vec3(half_length, half_width, 0.5 * (top - bottom));
    bridge.middle = on_axis + 0.5 * (top + bottom) * normal;
    return bridge;
}

Mesh bridge_mesh(const Bridge& bridge) {
    Mesh mesh;
    std::array<Mesh::Vertex_index, 8> corner;
    for (std::size_t c = 0; c < 8; ++c) {
        const Vec3 side((c & 1U) != 0 ? 1.0 : -1.0, (c & 2U) != 0 ? 1.0 : -1.0, (c & 4U) != 0 ? 1.0 : -1.0);
        corner[c] = mesh.add_vertex(to_point(bridge.middle + bridge.axes * side.cwiseProduct(bridge.half_size)));
    }
    constexpr std::array<std::array<std::size_t, 4>, 6> quads = {
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& q : quads) {
        mesh.add_face(corner[q[0]], corner[q[1]], corner[q[2]]);
        mesh.add_face(corner[q[0]], corner[q[2]], corner[q[3]]);
    }
    return mesh;
}

namespace {

// Some point of the triangle lies within `reach` of the grain: from one point to another, the distance changes by no more than the way.
bool comes_within(const PlacedShape& grain, const std::array<Vec3, 3>& triangle, double reach) {
    const Vec3 middle = (triangle[0] + triangle[1] + triangle[2]) / 3.0;
    const double away = signed_distance(grain, middle);
    if (away <= reach) return true;
    double half_size = 0.0;
    std::size_t longest = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        half_size = std::max(half_size, (triangle[c] - middle).norm());
        if ((triangle[(c + 1) % 3] - triangle[c]).norm() > (triangle[(longest + 1) % 3] - triangle[longest]).norm()) longest = c;
    }
    if (away > reach + half_size) return false;
    if (half_size < 0.5 * reach) return true;
    const std::size_t next = (longest + 1) % 3;
    auto one = triangle, other = triangle;
    one[next] = other[longest] = 0.5 * (triangle[longest] + triangle[next]);
    return comes_within(grain, one, reach) || comes_within(grain, other, reach);
}

// Moves the other corners of round sides outward until the mesh has this volume again.
void keep_volume(Mesh& mesh, const PlacedShape& grain, const std::vector<bool>& moved, double volume, double deviation) {
    std::vector<Vec3> outward(mesh.num_vertices(), Vec3::Zero());
    const bool has_faces = grain.shape.body != nullptr;
    for (const auto v : mesh.vertices()) {
        if (moved[v.idx()]) continue;
        Vec3 out;
        if (signed_distance(grain, to_vector(mesh.point(v)), out) > 1e-3 * deviation || !has_faces) outward[v.idx()] = out;
    }
    double free_area = 0.0;
    for (const auto face : mesh.faces())
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh))
            if (!outward[v.idx()].isZero()) free_area += pmp::face_area(face, mesh) / 3.0;
    if (free_area <= 0.0) return;
    const double step = std::clamp((volume - pmp::volume(mesh)) / free_area, 0.0, 0.2 * deviation);
    for (const auto v : mesh.vertices()) mesh.point(v) = to_point(to_vector(mesh.point(v)) + step * outward[v.idx()]);
}

}  // namespace

void keep_apart(Mesh& mesh, const PlacedShape& grain, const std::vector<PlacedShape>& others, double deviation, int variant) {
    const double volume = pmp::volume(mesh);
    // Corners of both grains lie outside by half the deviation at most: where the exact surfaces are farther apart, facets cannot meet.
    const double reach = (1.2 + 0.5 * variant) * deviation;
    std::vector<bool> moved(mesh.num_vertices(), false);
    for (const auto face : mesh.faces()) {
        const auto h = mesh.halfedge(face);
        const std::array<Mesh::Vertex_index, 3> corners = {mesh.source(h), mesh.target(h), mesh.target(mesh.next(h))};
        const std::array<Vec3, 3> triangle = {to_vector(mesh.point(corners[0])), to_vector(mesh.point(corners[1])),
                                              to_vector(mesh.point(corners[2]))};
        if (std::any_of(others.begin(), others.end(), [&](const PlacedShape& other) { return comes_within(other, triangle, reach); }))
            for (const auto v : corners) moved[v.idx()] = true;
    }
    for (const auto v : mesh.vertices()) {
        if (!moved[v.idx()]) continue;
        const Vec3 x = to_vector(mesh.point(v));
        Vec3 outward;
        const double away = signed_distance(grain, x, outward);
        // In a crease between two capsules, facets are small and could be folded; it is tried only after a fault.
        const Vec3 own = grain.to_shape(x);
        const auto in_reach = std::count_if(grain.shape.capsules.begin(), grain.shape.capsules.end(),
                                            [&](const Capsule& capsule) { return signed_distance(capsule, own) < 2.0 * deviation; });
        if ((in_reach <= 1 || variant > 0) && away > 0.0 && away < 2.0 * deviation) mesh.point(v) = to_point(x - away * outward);
    }
    keep_volume(mesh, grain, moved, volume, deviation);
}

std::vector<int> thin_coincident(std::size_t images, const std::vector<GrainContact>& contacts, double contact_gap) {
    std::vector<int> thinned(images, 0);
    for (const auto& contact : contacts)
        if (contact.with_faces ? std::abs(contact.gap) < 0.1 * contact_gap : on_one_line(contact.first_capsule, contact.second_capsule))
            thinned[contact.second] = std::max(thinned[contact.second], thinned[contact.first] + 1);
    return thinned;
}

std::vector<std::vector<std::size_t>> clusters_of(std::size_t images, const std::vector<std::pair<std::size_t, std::size_t>>& joined) {
    JoinedSets sets(images);
    for (const auto& [first, second] : joined) sets.join(first, second);
    std::map<std::size_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < images; ++i) groups[sets.root(i)].push_back(i);
    std::vector<std::vector<std::size_t>> clusters;
    clusters.reserve(groups.size());
    for (auto& [r, members] : groups) clusters.push_back(std::move(members));
    return clusters;
}

}  // namespace porepack::converters
