// Joins the meshes of grains at their contacts, each contact on its own; only for the sources of this folder that include CGAL.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "converters/contact_bridges.hpp"
#include "converters/single_precision.hpp"

namespace porepack::converters {

/// A contact between two bodies. A body is one grain, or several that are united already.
struct Joint {
    const GrainContact* contact;
    std::size_t first, second;  ///< bodies of the contact's first and second image
};

/// Joins the bodies at each joint with a bridge. Only facets near it change: those inside the bridge are removed, and its sides close the
/// gap. Each result is checked in single precision: closed, without crossings, also of other bodies. After a fault the bridge is turned and
/// widened. A contact inside the bridge of another one of the same bodies needs none. Returns the joints (by number) that did not succeed;
/// their bodies are unchanged there and need a Boolean union. `done(n)` reports n more joints.
[[nodiscard]] std::vector<std::size_t> join_bodies(std::vector<Facets>& bodies, const std::vector<Joint>& joints, double contact_gap,
                                                   double deviation, const std::function<void(std::size_t)>& done);

}  // namespace porepack::converters
