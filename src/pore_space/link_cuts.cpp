#include "pore_space/link_cuts.hpp"

#include <algorithm>
#include <bit>

#include "pore_space/uses.hpp"

namespace porepack::pore_space {

LinkCuts::LinkCuts(const Grid& grid, std::vector<Cut> cuts) {
    if (cuts.empty()) return;
    std::sort(cuts.begin(), cuts.end(), [](const Cut& p, const Cut& q) { return p.cell < q.cell; });
    cells_ = CellSet(grid);
    std::size_t last = 0;
    for (const Cut& cut : cuts) {
        if (!links_.empty() && cut.cell == last) {
            links_.back() |= cut.links;
            continue;
        }
        cells_.insert_run(cut.cell, 0, 0);
        links_.push_back(cut.links);
        last = cut.cell;
    }
    cells_.finish();
}

std::int64_t LinkCuts::count() const {
    std::int64_t sum = 0;
    for (const std::uint32_t links : links_) sum += std::popcount(links);
    return sum;
}

}  // namespace porepack::pore_space
