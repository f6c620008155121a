// How sure the numbers are: the uncertainty budget of k, and for each quantity what is known of this packing, of the mean of such packings
// and of the next one (docs/uncertainty.md).
#pragma once

#include <optional>

#include "pore_space/pore_space.hpp"
#include "pouring/config.hpp"
#include "results/uncertainty.hpp"
#include "uncertainty/section_scatter.hpp"

namespace porepack::results {
struct CaseResults;
}

namespace porepack::analysis {

struct BedOfCase {
    std::optional<pore_space::PoreSpace> space = {};  ///< of a packing whose grains may not overlap
    pouring::PackingConfig packing = {};
    std::optional<uncertainty::SectionScatter> section = {};  ///< from the gradient along z
};
/// `results`: those that it uses, with that of lbm. Throws std::logic_error without it.
[[nodiscard]] results::Uncertainty state_uncertainty(const results::CaseResults& results, const BedOfCase& bed);

}  // namespace porepack::analysis
