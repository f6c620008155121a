// A grain as a rigid body, used by both engines.
#pragma once

#include "shapes/shape.hpp"

namespace porepack::pouring {

/// Mass and principal moments of inertia of a shape. The body frame has its origin at the centre of mass and its axes along the
/// principal ones.
struct GrainBody {
    double mass_kg = 0.0;
    shapes::Vec3 inertia_kg_m2 = shapes::Vec3::Zero();
    shapes::Vec3 centre_m = shapes::Vec3::Zero();              ///< centre of mass in the shape's frame
    shapes::Quaternion turn = shapes::Quaternion::Identity();  ///< from the body frame to the shape's
};
/// Numbers rounded to seven digits: a pour is chaotic, and must not change with the last bits of an integral.
[[nodiscard]] GrainBody grain_body(const shapes::Shape& shape, double density_kg_per_m3);

}  // namespace porepack::pouring
