#include "results/results.hpp"

namespace porepack::results {

std::optional<BedPorosity> bed_of(const CaseResults& results) {
    if (results.pack) return results.pack->bed;
    return results.stl ? results.stl->bed : std::nullopt;
}

}  // namespace porepack::results
