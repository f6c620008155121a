// Porosity of a section, by exact intervals on vertical lines.
#pragma once

#include "geometry/solid.hpp"
#include "packing/section.hpp"

namespace porepack::packing {

struct Porosity {
    double value = 0.0;
    double uncertainty = 0.0;  ///< half the difference between two shifted lattices of lines, or that of single precision
    double line_spacing_m = 0.0;
    long lines = 0;  ///< 0: the volume is exact
};
/// Pore volume / inner container volume of the section: exact for a closed surface inside its container, else from exact intervals on
/// about `lines` vertical lines.
[[nodiscard]] Porosity porosity(const geometry::Solid& solid, const vessels::Container& container, const Section& section,
                                long lines = 60000);

}  // namespace porepack::packing
