// The cells of an OpenFOAM run with their velocity.
#pragma once

#include <vector>

#include "converters/surface.hpp"

namespace porepack {

struct FoamCell {
    Vec3 centre_m, velocity;  ///< velocity for viscosity 1 and the case's pressure drop or gradient
    double volume_m3;
};
/// Asks postProcess for the cells' centres and volumes at the last time in the case `folder`, reads them and removes them again.
/// Throws EngineError when that fails.
[[nodiscard]] std::vector<FoamCell> read_foam_cells(const Path& folder);

}  // namespace porepack
