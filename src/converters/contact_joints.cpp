// A union of two grains in contact changes only a few facets, those that the bridge crosses. The facets around the bridge are cut out of
// both bodies as open patches and intersected with the bridge:
//
//      second    ----+    +----       the bridge's ends lie inside the grains and are removed; its sides stay
//                    |    |
//      first     ----+    +----       the facets inside the bridge are removed
//
// The result is taken when it is a closed surface in single precision: its open edges are those of the two patches, and no new triangle
// crosses another one or a facet of a third body nearby. So a contact costs what its few facets cost, and a fault is found and fixed where
// it is.
#include "converters/contact_joints.hpp"

#include <CGAL/Polygon_mesh_processing/connected_components.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "converters/grain_mesh.hpp"
#include "converters/mesh_intersections.hpp"
#include "converters/uses.hpp"
#include "core/parallel.hpp"
#include "shapes/bins.hpp"

namespace porepack::converters {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

using Corner = std::array<float, 3>;
using Edge = std::pair<Corner, Corner>;

void include(Bounds& box, const Facet& facet) {
    for (const Corner& c : facet) {
        box.low = box.low.cwiseMin(Vec3(c[0], c[1], c[2]));
        box.high = box.high.cwiseMax(Vec3(c[0], c[1], c[2]));
    }
}

Bounds bounds_of(const Facet& facet) {
    Bounds box;
    include(box, facet);
    return box;
}

bool meet(const Bounds& p, const Bounds& q) {
    return (p.low.array() <= q.high.array()).all() && (q.low.array() <= p.high.array()).all();
}

// Edges with a facet on one side only; nothing when two facets have the same directed edge.
std::optional<std::vector<Edge>> open_edges(const Facets& facets) {
    std::vector<Edge> edges;
    for (const Facet& facet : facets)
        for (std::size_t c = 0; c < 3; ++c) edges.emplace_back(facet[c], facet[(c + 1) % 3]);
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return std::nullopt;
    std::vector<Edge> open;
    for (const Edge& edge : edges)
        if (!std::binary_search(edges.begin(), edges.end(), Edge(edge.second, edge.first))) open.push_back(edge);
    return open;
}

// Facets of a body around a place. Where they would meet in a single corner only, the facets around this corner are added, so that a patch
// is a manifold with boundary.
struct Patch {
    Facets facets;
    std::vector<std::size_t> numbers;  // in the body
};
Patch patch_of(const Facets& body, const Bounds& place) {
    std::vector<bool> taken(body.size(), false);
    for (std::size_t i = 0; i < body.size(); ++i) taken[i] = meet(bounds_of(body[i]), place);
    while (true) {
        Patch patch;
        for (std::size_t i = 0; i < body.size(); ++i) {
            if (!taken[i]) continue;
            patch.facets.push_back(body[i]);
            patch.numbers.push_back(i);
        }
        std::map<Corner, int> leaving;  // open edges
        const auto open = open_edges(patch.facets);
        if (!open) return patch;  // not manifold; the meshes below cannot be made
        for (const Edge& edge : *open) ++leaving[edge.first];
        bool complete = true;
        for (std::size_t i = 0; i < body.size(); ++i) {
            if (taken[i]) continue;
            taken[i] = std::any_of(body[i].begin(), body[i].end(), [&](const Corner& c) {
                const auto found = leaving.find(c);
                return found != leaving.end() && found->second > 1;
            });
            complete = complete && !taken[i];
        }
        if (complete) return patch;
    }
}

void append_outside(Facets& facets, const Mesh& patch, const Bridge& bridge) {
    for (const auto face : patch.faces()) {
        Vec3 middle = Vec3::Zero();
        for (const auto v : vertices_around_face(patch.halfedge(face), patch)) middle += to_vector(patch.point(v)) / 3.0;
        if (bridge.contains(middle)) continue;
        if (const auto facet = facet_of(patch, face)) facets.push_back(*facet);
    }
}

// The parts of the bridge between the curves along which it was cut, without its two ends.
void append_sides(Facets& facets, Mesh& box, const Mesh::Property_map<Mesh::Edge_index, bool>& cut) {
    auto part = box.add_property_map<Mesh::Face_index, std::size_t>("f:part").first;
    pmp::connected_components(box, part, CGAL::parameters::edge_is_constrained_map(cut));
    std::set<std::size_t> ends;
    for (unsigned c = 0; c < 8; ++c)
        for (const auto face : faces_around_target(box.halfedge(Mesh::Vertex_index(c)), box)) ends.insert(part[face]);
    for (const auto face : box.faces())
        if (!ends.contains(part[face]))
            if (const auto facet = facet_of(box, face)) facets.push_back(*facet);
}

// A crossing that was not there before: others nearby may wait for their own joint.
bool new_crossing(const Facets& facets, Facets before) {
    const auto mesh = mesh_of(surface_of(facets));
    if (!mesh) return true;
    std::sort(before.begin(), before.end());
    const auto old = [&](Mesh::Face_index face) {
        const auto facet = facet_of(*mesh, face);
        return facet && std::binary_search(before.begin(), before.end(), *facet);
    };
    const auto crossings = self_intersections(*mesh);
    return std::any_of(crossings.begin(), crossings.end(), [&](const auto& pair) { return !old(pair.first) || !old(pair.second); });
}

struct Joined {
    Facets first, second;  // what replaces the patches; the bridge belongs to the first
};

std::optional<Joined> joined(const Facets& first, const Facets& second, const Facets& others, const Bridge& bridge) {
    auto p = mesh_of(surface_of(first)), q = mesh_of(surface_of(second));
    if (!p || !q) return std::nullopt;
    Mesh box = bridge_mesh(bridge);
    auto cut = box.add_property_map<Mesh::Edge_index, bool>("e:cut", false).first;
    for (Mesh* patch : {&*p, &*q}) cut_along_intersection(*patch, box, cut);
    Joined result;
    append_outside(result.first, *p, bridge);
    append_outside(result.second, *q, bridge);
    append_sides(result.first, box, cut);

    Facets all = result.first, before = first;
    all.insert(all.end(), result.second.begin(), result.second.end());
    before.insert(before.end(), second.begin(), second.end());
    const auto open = open_edges(all), open_before = open_edges(before);
    if (!open || !open_before || *open != *open_before) return std::nullopt;
    all.insert(all.end(), others.begin(), others.end());
    before.insert(before.end(), others.begin(), others.end());
    if (new_crossing(all, std::move(before))) return std::nullopt;
    return result;
}

void replace(Facets& body, const Patch& patch, const Facets& by) {
    std::vector<bool> removed(body.size(), false);
    for (const std::size_t i : patch.numbers) removed[i] = true;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < body.size(); ++i)
        if (!removed[i]) body[kept++] = body[i];
    body.resize(kept);
    body.insert(body.end(), by.begin(), by.end());
}

// Bridges between bodies, in turn; bodies change as they are joined.
class Joiner {
public:
    Joiner(std::vector<Facets>& bodies, const std::vector<Joint>& joints, double contact_gap, double deviation)
        : bodies_(bodies), joints_(joints), contact_gap_(contact_gap), deviation_(deviation), others_(joints.size()) {
        std::vector<Bounds> reach(bodies.size());
        for (std::size_t b = 0; b < bodies.size(); ++b)
            for (const Facet& facet : bodies[b]) include(reach[b], facet);
        const SpatialBins bins(reach);
        parallel_for(joints.size(), [&](std::size_t j) {
            const Bounds place = place_of(joints[j], variants - 1);
            std::vector<int> found;
            bins.near(0.5 * (place.low + place.high), 0.5 * (place.high - place.low).maxCoeff(), found);
            for (const int b : found)
                if (static_cast<std::size_t>(b) != joints[j].first && static_cast<std::size_t>(b) != joints[j].second)
                    others_[j].push_back(static_cast<std::size_t>(b));
            std::sort(others_[j].begin(), others_[j].end());
        });
        for (const Joint& joint : joints) bridges_.try_emplace(std::minmax(joint.first, joint.second));
    }

    // Joints without a common body are made at the same time, always in the same order. Returns those that did not succeed.
    std::vector<std::size_t> join_all(std::vector<std::size_t> left, const std::function<void(std::size_t)>& done) {
        std::vector<std::size_t> failed;
        while (!left.empty()) {
            std::vector<bool> used(bodies_.size(), false);
            std::vector<std::size_t> now, later;
            for (const std::size_t j : left) {
                auto all = others_[j];
                all.insert(all.end(), {joints_[j].first, joints_[j].second});
                const bool free = std::none_of(all.begin(), all.end(), [&](std::size_t b) { return used[b]; });
                for (const std::size_t b : all) used[b] = true;  // also of those that wait: the order is kept
                (free ? now : later).push_back(j);
            }
            std::vector<char> made(now.size(), 0);
            parallel_for(now.size(), [&](std::size_t i) { made[i] = join(now[i]) ? 1 : 0; });
            for (std::size_t i = 0; i < now.size(); ++i)
                if (made[i] == 0) failed.push_back(now[i]);
            done(now.size());
            left = std::move(later);
        }
        return failed;
    }

private:
    static constexpr int variants = 8;

    [[nodiscard]] Bounds place_of(const Joint& joint, int variant) const {
        const Bridge bridge = bridge_of(*joint.contact, contact_gap_, deviation_, variant);
        const Vec3 half = bridge.axes.cwiseAbs() * bridge.half_size + Vec3::Constant(deviation_);
        return Bounds{bridge.middle - half, bridge.middle + half};
    }

    bool join(std::size_t j) {
        const Joint& joint = joints_[j];
        auto& here = bridges_.at(std::minmax(joint.first, joint.second));
        const Vec3 place =
            joint.contact->nearest + (joint.contact->first_capsule.radius + 0.5 * joint.contact->gap) * joint.contact->normal;
        if (std::any_of(here.begin(), here.end(), [&](const Bridge& bridge) { return bridge.contains(place); })) return true;
        for (int variant = 0; variant < variants; ++variant) {
            const Bounds around = place_of(joint, variant);
            const Patch first = patch_of(bodies_[joint.first], around), second = patch_of(bodies_[joint.second], around);
            Facets near;
            for (const std::size_t other : others_[j]) {
                const Patch patch = patch_of(bodies_[other], around);
                near.insert(near.end(), patch.facets.begin(), patch.facets.end());
            }
            const Bridge bridge = bridge_of(*joint.contact, contact_gap_, deviation_, variant);
            const auto result = joined(first.facets, second.facets, near, bridge);
            if (!result) continue;
            replace(bodies_[joint.first], first, result->first);
            replace(bodies_[joint.second], second, result->second);
            here.push_back(bridge);
            return true;
        }
        return false;
    }

    std::vector<Facets>& bodies_;
    const std::vector<Joint>& joints_;
    const double contact_gap_, deviation_;
    std::vector<std::vector<std::size_t>> others_;                                // bodies that a bridge might reach
    std::map<std::pair<std::size_t, std::size_t>, std::vector<Bridge>> bridges_;  // of two bodies
};

}  // namespace

std::vector<std::size_t> join_bodies(std::vector<Facets>& bodies, const std::vector<Joint>& joints, double contact_gap, double deviation,
                                     const std::function<void(std::size_t)>& done) {
    Joiner joiner(bodies, joints, contact_gap, deviation);
    // The deepest overlaps first, so that their bridges contain the others. A joint does not succeed while another contact nearby is open,
    // so that those are tried again.
    std::vector<std::size_t> left(joints.size());
    std::iota(left.begin(), left.end(), std::size_t{0});
    std::stable_sort(left.begin(), left.end(),
                     [&](std::size_t p, std::size_t q) { return joints[p].contact->gap < joints[q].contact->gap; });
    while (true) {
        auto failed = joiner.join_all(left, done);
        if (failed.empty() || failed.size() == left.size()) return failed;
        left = std::move(failed);
    }
}

}  // namespace porepack::converters
