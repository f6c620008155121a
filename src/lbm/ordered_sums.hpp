// Sums over the nodes of a domain whose bits depend on nothing but the cells: not on threads, not on chunks of memory, and not on where a
// domain may be divided between planes normal to z.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "lbm/flow.hpp"

namespace porepack::lbm {

/// Cells of a plane normal to z are summed in blocks of this number, so that flat domains keep several threads busy.
inline constexpr std::size_t cells_per_sum = 16384;

/// Each block of cells is summed in the order of its cells by fill(sums, first node, end node); blocks are added in ascending order to the
/// sum of their plane, and planes in ascending order to the total; those of a slab after those of the slabs below. `Sums` has `add(Sums&)`,
/// `clear()`, and `numbers()`: all that was added, as a span. `nothing` is an empty one.
template <typename Sums, typename Fill>
[[nodiscard]] Sums sum_in_order(const Domain& domain, const Sums& nothing, const Fill& fill) {
    const auto& [nx, ny, nz] = domain.grid.cells;
    const std::size_t plane = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
    const std::size_t blocks = (plane + cells_per_sum - 1) / cells_per_sum, all = blocks * static_cast<std::size_t>(nz);
    const auto nodes_before = [&](std::size_t cell) {
        return cell < domain.grid.size() ? static_cast<std::size_t>(domain.cells.rank(cell)) : domain.nodes();
    };
    Sums total = nothing, of_plane = nothing;
    std::vector<Sums> planes;  // that wait for the slabs below
    const bool waits = domain.slabs->part() > 0;
#pragma omp parallel
    {
        Sums part = nothing;
#pragma omp for ordered schedule(static, 1)
        for (std::size_t n = 0; n < all; ++n) {
            const std::size_t first = n / blocks * plane + n % blocks * cells_per_sum,
                              end = std::min(first + cells_per_sum, (n / blocks + 1) * plane);
            part.clear();
            fill(part, nodes_before(first), nodes_before(end));
#pragma omp ordered
            {
                of_plane.add(part);
                if (n % blocks == blocks - 1) {
                    waits ? planes.push_back(of_plane) : total.add(of_plane);
                    of_plane.clear();
                }
            }
        }
    }
    if (domain.slabs->parts() > 1)
        domain.slabs->in_turn(total.numbers(), [&] {
            for (Sums& one : planes) total.add(one);
        });
    return total;
}

/// Calls visit(cell, value) for the nodes [begin, end) in ascending order; get(first, values) gives those of whole chunks.
template <typename Value, typename Get, typename Visit>
void visit_nodes(const Domain& domain, std::size_t begin, std::size_t end, const Get& get, const Visit& visit) {
    std::array<Value, Flow::chunk> values;
    std::array<std::size_t, Flow::chunk> cells;
    for (std::size_t first = begin / Flow::chunk * Flow::chunk; first < end; first += Flow::chunk) {
        const std::size_t count = std::min(Flow::chunk, domain.nodes() - first), from = std::max(begin, first) - first,
                          to = std::min(end - first, count);
        get(first, std::span(values).first(count));
        domain.cells.list(first + from, std::span(cells).subspan(from, to - from));
        for (std::size_t i = from; i < to; ++i) visit(cells[i], values[i]);
    }
}

/// Sums of what sums.visit(cell, moments) adds.
template <typename Sums>
[[nodiscard]] Sums sum_moments(const Flow& flow, const Domain& domain, const Sums& nothing) {
    return sum_in_order(domain, nothing, [&](Sums& sums, std::size_t begin, std::size_t end) {
        visit_nodes<Moments>(
            domain, begin, end, [&](std::size_t first, std::span<Moments> moments) { flow.moments(first, moments); },
            [&](std::size_t cell, const Moments& here) { sums.visit(cell, here); });
    });
}

}  // namespace porepack::lbm
