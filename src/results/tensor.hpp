// A symmetric tensor of a result, as of the permeability.
#pragma once

#include <array>

namespace porepack::results {

/// By rows.
using Tensor = std::array<std::array<double, 3>, 3>;

}  // namespace porepack::results
