#include "lbm/domain.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/machine.hpp"
#include "lbm/lattice.hpp"

namespace porepack {
double lbm_memory_bytes(double cells, double fluid) {
    const double populations = 2.0 * 19.0 * 8.0, links = 19.0 * 4.0, own = 4.0;
    return cells * (1.0 + 4.0 + 1.0) + fluid * (populations + links + own) + fluid * 8.0;
}

Domain build_domain(const PhaseImage& image, const Drive& drive) {
    Domain domain{.grid = image.grid, .drive = drive, .cell = {}, .pull = {}, .open_links = {}};
    const Percolation percolation = find_percolating_cells(image, drive);
    const auto& keep = percolation.keep;
    domain.isolated_cells = percolation.isolated_cells;
    std::vector<std::int32_t> node_of(image.grid.size(), -1);
    for (std::size_t cell = 0; cell < keep.size(); ++cell)
        if (keep[cell] == 1) {
            node_of[cell] = static_cast<std::int32_t>(domain.cell.size());
            domain.cell.push_back(static_cast<std::int32_t>(cell));
        }
    const std::size_t n = domain.nodes();
    if (static_cast<double>(n) * 19.0 > 4.2e9)
        throw UserError(fmt::format("{} fluid nodes are more than this solver can number", n),
                        {.allowed = "220 million", .mend = "take a larger voxel size"});
    require_memory(lbm_memory_bytes(0.0, static_cast<double>(n)), fmt::format("the flow on {} fluid nodes", n),
                   "take a larger voxel size or a shorter section");

    domain.pull.resize(domain.populations());
    for (std::size_t slot = 0; slot < domain.pull.size(); ++slot) domain.pull[slot] = static_cast<std::uint32_t>(slot);
    const auto axis = static_cast<std::size_t>(drive.axis);
    for (std::size_t node = 0; node < n; ++node) {
        const auto here = place_in_grid(image.grid, static_cast<std::size_t>(domain.cell[node]));
        for (int q = 0; q < d3q19::directions; ++q) {
            // Population q comes from the neighbour against c_q.
            const auto& c = d3q19::c[static_cast<std::size_t>(d3q19::opposite(q))];
            auto from = here;
            int turns = 0;
            auto& slot = domain.pull[Domain::slot(static_cast<std::size_t>(q), node)];
            const auto bounced = static_cast<std::uint32_t>(Domain::slot(static_cast<std::size_t>(d3q19::opposite(q)), node));
            if (step_in_grid(image.grid, drive, from, c, turns)) {
                const std::int32_t other = node_of[image.grid.index(from[0], from[1], from[2])];
                slot = other >= 0 ? static_cast<std::uint32_t>(Domain::slot(static_cast<std::size_t>(q), static_cast<std::size_t>(other)))
                                  : bounced;
                continue;
            }
            slot = bounced;
            if (!drive.by_pressure()) continue;
            const int beyond = here[axis] + c[axis];
            if (beyond >= 0 && beyond < image.grid.cells[axis]) continue;  // a side wall
            // Through an open end, unless the way there is barred by a grain or a wall. Beyond the plane lies the mirror image
            // with pressure and tangential velocity reversed: constant pressure and normal flow hold exactly on the plane.
            auto aside = here;
            auto lateral = c;
            lateral[axis] = 0;
            if (!step_in_grid(image.grid, drive, aside, lateral, turns)) continue;
            const std::int32_t other = node_of[image.grid.index(aside[0], aside[1], aside[2])];
            if (other < 0) continue;
            slot = static_cast<std::uint32_t>(domain.populations() + domain.open_links.size());
            const auto mirrored = Domain::slot(static_cast<std::size_t>(d3q19::mirrored(q, drive.axis)), static_cast<std::size_t>(other));
            domain.open_links.push_back({static_cast<std::uint32_t>(mirrored), d3q19::w(q), beyond < 0});
        }
    }
    return domain;
}

}  // namespace porepack
