// Grains of kind "mesh", read from their files.
#pragma once

#include "converters/grain_from_mesh.hpp"
#include "core/files.hpp"
#include "shapes/config.hpp"

namespace porepack::inputs {

/// The files that a shape, or the components of a mixture, name; relative to `folder`.
[[nodiscard]] std::vector<core::Path> mesh_files(const shapes::ShapeConfig& config, const core::Path& folder);

/// One mesh, simplified; kept for the next call of this process with the same file and keys. Throws UserError, with the file, where grain_from_mesh() does, or the grain is not between 1 micrometre and 5 m
/// wide.
[[nodiscard]] converters::MeshGrain read_mesh_grain(const shapes::ShapeConfig& config, const core::Path& folder);

/// The same shapes, each mesh with its grain.
[[nodiscard]] shapes::ShapeConfig with_mesh_grains(shapes::ShapeConfig config, const core::Path& folder);

}  // namespace porepack::inputs
