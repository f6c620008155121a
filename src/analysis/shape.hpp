// The grain itself: volume, surface, sphericity, inertia.
#pragma once

#include <string>

#include "io/stl.hpp"
#include "results/shape.hpp"
#include "shapes/config.hpp"

namespace porepack::analysis {

/// Of a mixture: means over the grains, by number, and the measures of each component. Throws UserError as make_shape().
/// Files of meshes are relative to `folder`.
[[nodiscard]] results::Shape measure_shape(const shapes::ShapeConfig& config, double density_kg_per_m3, const core::Path& folder = {});
/// Of a mesh, into `output`: the grain as a closed surface, grain.stl; and beside it, on the left, the surface of its file, in
/// before_and_after.stl with the picture before_and_after.png.
void write_mesh_grain(const shapes::ShapeConfig& config, const core::Path& folder, const core::Path& output);
/// Of a closed surface; `name` for messages. Throws UserError where it is not sound.
[[nodiscard]] results::Shape measure_surface_shape(const geometry::TriangleSurface& surface, const std::string& name,
                                                   double density_kg_per_m3);

}  // namespace porepack::analysis
