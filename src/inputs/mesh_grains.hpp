// Grains of kind "mesh", read from their files.
#pragma once

#include <vector>

#include "converters/grain_from_mesh.hpp"
#include "core/files.hpp"
#include "shapes/config.hpp"

namespace porepack::inputs {

/// A library as a mixture of its meshes, in the order of their names; other shapes as they are. Throws UserError where the folder is
/// missing or has no mesh, or a key does not belong to a library.
[[nodiscard]] shapes::ShapeConfig without_library(const shapes::ShapeConfig& config, const core::Path& folder);

/// The files that a shape, the components of a mixture, or a library name; relative to `folder`.
[[nodiscard]] std::vector<core::Path> mesh_files(const shapes::ShapeConfig& config, const core::Path& folder);

/// One mesh, simplified; kept for the next call of this process with the same file and keys. Throws UserError, with the file, where
/// grain_from_mesh() does, or the grain is not between 1 micrometre and 5 m wide.
[[nodiscard]] converters::MeshGrain read_mesh_grain(const shapes::ShapeConfig& config, const core::Path& folder);

/// The same shapes, each mesh with its grain.
[[nodiscard]] shapes::ShapeConfig with_mesh_grains(const shapes::ShapeConfig& config, const core::Path& folder);

}  // namespace porepack::inputs
