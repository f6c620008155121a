// The surface of a core with a ball swept over it, in patches.
#pragma once

#include "shapes/rounded_body.hpp"
#include "shapes/triangle_core.hpp"

namespace porepack::shapes {

/// Points of the surface with outward normals and areas. Where no crease is near, as exact as RoundedBody::for_surface(); patches that end
/// in a crease are divided until what is lost there is about 1e-6 of volume and area.
void for_mesh_surface(const TriangleCore& core, double rounding, const RoundedBody::SurfacePoint& visit);

}  // namespace porepack::shapes
