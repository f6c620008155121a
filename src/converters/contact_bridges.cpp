// Contacts and bridges. Two grains in point contact overlap in a lens far thinner than the deviation of their facets, so
// the meshes may miss each other, or cross in slivers that are lost in single precision. A small box through the contact turns this
// grazing intersection into a clean one at steep angles. Grains that are near but apart must not meet: their corners there are put on the
// exact surface, so that the facets lie inside it.
#include "converters/contact_bridges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include "converters/grain_mesh.hpp"
#include "shapes/segments.hpp"

namespace porepack::converters {
using namespace core;
using namespace shapes;
using namespace packing;
namespace {

// The segment of `p`'s axis that lies beside `q`'s, for parallel axes; else the nearest point twice.
std::pair<Vec3, Vec3> nearest_stretch(const Capsule& p, const Capsule& q) {
    const Vec3 along = p.b - p.a;
    const double length = along.norm();
    if (length > 0.0 && along.cross(q.b - q.a).norm() < 1e-3 * length * (q.b - q.a).norm()) {
        const Vec3 unit = along / length;
        const double at_a = (q.a - p.a).dot(unit), at_b = (q.b - p.a).dot(unit);
        const double low = std::clamp(std::min(at_a, at_b), 0.0, length), high = std::clamp(std::max(at_a, at_b), 0.0, length);
        return {p.a + low * unit, p.a + high * unit};
    }
    const Vec3 nearest = closest_points({p.a, along}, {q.a, q.b - q.a}).on_first;
    return {nearest, nearest};
}

bool on_one_line(const Capsule& p, const Capsule& q) {
    const Vec3 along = p.b - p.a;
    const double slack = 1e-6 * p.radius * along.norm();
    return along.norm() > 0.0 && along.cross(q.a - p.a).norm() < slack && along.cross(q.b - p.a).norm() < slack;
}

}  // namespace

std::vector<GrainContact> find_contacts(const std::vector<Grains::Image>& images, double reach) {
    std::vector<GrainContact> contacts;
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = i + 1; j < images.size(); ++j) {
            if (((images[i].bounds.high - images[j].bounds.low).array() < -reach).any() ||
                ((images[j].bounds.high - images[i].bounds.low).array() < -reach).any())
                continue;
            for (const auto& p : images[i].capsules)
                for (const auto& q : images[j].capsules) {
                    const double between = gap(p, q);
                    if (between >= reach) continue;
                    GrainContact contact{.first = i,
                                         .second = j,
                                         .first_capsule = p,
                                         .second_capsule = q,
                                         .from = {},
                                         .to = {},
                                         .normal = {},
                                         .gap = between};
                    std::tie(contact.from, contact.to) = nearest_stretch(p, q);
                    const Vec3 across = closest_on_axis(q, contact.from) - contact.from;
                    contact.normal = across.norm() > 0.0 ? Vec3(across.normalized()) : Vec3(Vec3::UnitZ());
                    // Arms share their end spheres: the same contact is found several times.
                    const auto same = [&](const GrainContact& other) {
                        const double slack = 1e-6 * p.radius;
                        return other.first == i && other.second == j && (other.from - contact.from).norm() < slack &&
                               (other.to - contact.to).norm() < slack && (other.normal - contact.normal).norm() < 1e-6;
                    };
                    const auto recent = contacts.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(contacts.size(), 64));
                    if (std::none_of(recent, contacts.end(), same)) contacts.push_back(contact);
                }
        }
    return contacts;
}

Mesh bridge_mesh(const GrainContact& contact, double contact_gap, double deviation, int variant) {
    const double r = std::min(contact.first_capsule.radius, contact.second_capsule.radius);
    const double lens = std::max(contact_gap, -contact.gap) + std::min(variant, 2) * deviation;
    const double half_width = std::min(0.4 * r, (1.0 + 0.1 * variant) * std::sqrt(r * lens));
    const double depth = std::min(0.8 * r, 3.0 * deviation + half_width);
    const Vec3 along = contact.to - contact.from;
    // Rotated slightly: no face lies in a plane of the grains' meshes.
    const Vec3 across = along.norm() > 0.0 ? Vec3(along.normalized()) : contact.normal.unitOrthogonal();
    const Eigen::AngleAxisd turn(0.0137 + 0.083 * variant, contact.normal);
    const Vec3 t = turn * across, w = contact.normal.cross(t);
    const double half_length = 0.5 * along.norm() + half_width;
    const Vec3 middle = 0.5 * (contact.from + contact.to);
    const double bottom = contact.first_capsule.radius - depth;
    const double top = contact.first_capsule.radius + contact.gap + depth;
    Mesh mesh;
    std::array<Mesh::Vertex_index, 8> corner;
    for (std::size_t c = 0; c < 8; ++c)
        corner[c] =
            mesh.add_vertex(to_point(middle + ((c & 1U) != 0 ? half_length : -half_length) * t +
                                     ((c & 2U) != 0 ? half_width : -half_width) * w + ((c & 4U) != 0 ? top : bottom) * contact.normal));
    constexpr std::array<std::array<std::size_t, 4>, 6> quads = {
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& q : quads) {
        mesh.add_face(corner[q[0]], corner[q[1]], corner[q[2]]);
        mesh.add_face(corner[q[0]], corner[q[2]], corner[q[3]]);
    }
    return mesh;
}

void keep_apart(Mesh& mesh, const Capsule& own, const GrainContact& contact, double deviation, int variant) {
    // Beyond this distance from the contact the exact surfaces are farther apart than the deviation of any facet.
    const double reach = 2.0 * std::sqrt(8.0 * own.radius * deviation) * (1.0 + 0.5 * variant);
    const Vec3 to_contact = contact.first_capsule.radius * contact.normal;
    const Capsule zone{contact.from + to_contact, contact.to + to_contact, 0.0};
    for (const auto v : mesh.vertices()) {
        const Vec3 x(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
        if (signed_distance(zone, x) > reach) continue;
        const Vec3 foot = closest_on_axis(own, x);
        const double distance = (x - foot).norm();
        if (distance > own.radius && distance < own.radius + 2.0 * deviation)
            mesh.point(v) = to_point(foot + own.radius / distance * (x - foot));
    }
}

std::vector<int> thin_coaxial(std::size_t images, const std::vector<GrainContact>& contacts) {
    std::vector<int> thinned(images, 0);
    for (const auto& contact : contacts)
        if (on_one_line(contact.first_capsule, contact.second_capsule))
            thinned[contact.second] = std::max(thinned[contact.second], thinned[contact.first] + 1);
    return thinned;
}

std::vector<std::vector<std::size_t>> clusters_of(std::size_t images, const std::vector<GrainContact>& contacts, double contact_gap) {
    std::vector<std::size_t> parent(images);
    std::iota(parent.begin(), parent.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    for (const auto& contact : contacts)
        if (contact.gap < contact_gap) parent[root(contact.first)] = root(contact.second);
    std::map<std::size_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < images; ++i) groups[root(i)].push_back(i);
    std::vector<std::vector<std::size_t>> clusters;
    clusters.reserve(groups.size());
    for (auto& [r, members] : groups) clusters.push_back(std::move(members));
    return clusters;
}

}  // namespace porepack::converters
