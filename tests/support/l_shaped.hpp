// Something whose axes cannot be exchanged unseen.
#pragma once

#include "packing/packing.hpp"

namespace porepack::test {

/// A body without symmetry: a long arm along +x, a shorter one along +y, an arm along +z, in a corner of the box.
[[nodiscard]] inline packing::Packing l_shaped() {
    using shapes::Vec3;
    packing::Packing packing;
    packing.container = vessels::make_box(Vec3(0.06, 0.05, 0.04));
    packing.shapes.push_back(
        {.id = "L",
         .capsules = {
             {Vec3::Zero(), Vec3(0.03, 0, 0), 0.003}, {Vec3::Zero(), Vec3(0, 0.02, 0), 0.003}, {Vec3::Zero(), Vec3(0, 0, 0.012), 0.003}}});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.01, 0.012, 0.014)});
    return packing;
}

}  // namespace porepack::test
