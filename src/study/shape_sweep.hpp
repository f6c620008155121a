// Figure 7 of the paper: convexity against sphericity of its three aggregates, with a picture of each grain.
#pragma once

#include "core/files.hpp"
#include "core/json_fwd.hpp"

namespace porepack::study {

/// Writes sweep.csv, convexity.svg, convexity.png and grains.png (if a picture can be rendered) into `folder`. `volume_m3` is every
/// grain's volume. Returns the maximum difference of convexity at equal sphericity and the number of rows.
[[nodiscard]] core::Json run_shape_sweep(double volume_m3, const core::Path& folder);

}  // namespace porepack::study
