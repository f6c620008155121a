// The grains as one closed triangle surface, in files.
#pragma once

#include "converters/config.hpp"
#include "core/files.hpp"
#include "pore_space/pore_space.hpp"
#include "results/geometry.hpp"

namespace porepack::analysis {

/// Writes solid.stl of grains or of a user's surface, and the files requested by `extras`; what is reported is checked on the file as
/// written, in single precision. Throws UserError for an image, NumericalError where the surface is not sound.
[[nodiscard]] results::Stl write_surfaces(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                          const converters::StlConfig& extras, const core::Path& folder);

}  // namespace porepack::analysis
