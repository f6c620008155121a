// The tortuosity factor on grids of several voxel sizes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/machine.hpp"
#include "pore_space/percolation.hpp"
#include "tortuosity/tortuosity.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {

DiffusiveLimit diffusive_limit(const std::array<double, 3>& sizes, const std::array<double, 3>& values) {
    const auto limit_of = [&](std::size_t coarse) {
        return values[0] + (values[0] - values[coarse]) / (std::pow(sizes[coarse] / sizes[0], 2) - 1.0);
    };
    // The interval was calibrated on 55 arrays and judged on 72 others (docs/tortuosity.md). Its last part is that of the porosity.
    constexpr double of_correction = 0.7, of_value = 2e-4;
    const double value = limit_of(2), correction = value - values[0];
    return {.value = std::max(1.0, value),
            .half_width = std::max(of_correction * std::abs(correction), std::abs(limit_of(1) - value)) + of_value * value};
}

std::optional<Interval> DiffusiveEstimate::interval() const {
    if (!limit) return std::nullopt;
    return Interval{std::max(1.0, limit->value - limit->half_width), limit->value + limit->half_width};
}

DiffusiveEstimate diffusive_tortuosity(const PoreSpace& space, double voxel_size_m, Axis axis, const DiffusiveOptions& asked) {
    PoreSpace section = space.ends == Ends::in_situ && axis == Axis::z ? space : space.section_only();
    section.reservoir_m = 0.0;
    DiffusiveOptions options = asked;
    DiffusiveEstimate estimate;
    if (section.own_grid()) estimate.no_limit_because = "an image has one resolution";
    if (options.one_grid) estimate.no_limit_because = "one grid was asked for";
    for (const double coarser : {1.0, 1.5, 2.0}) {
        const bool finest = estimate.grids.empty();
        if (!finest && !estimate.no_limit_because.empty()) break;
        const double size = coarser * voxel_size_m;
        if (!finest && (size > section.grain_size_m || size > 0.5 * section.section.length())) {
            estimate.no_limit_because = "the voxels are too coarse for three grids";
            break;
        }
        const VoxelPlan plan = section.plan_at(size);
        require_memory(diffusive_memory_bytes(static_cast<double>(plan.grid.size())), "diffusion on the voxels",
                       "use a larger voxel size or a shorter section");
        try {
            DiffusiveResult result = diffusive_on_grid(section, size, axis, options);
            if (section.has_exact_walls()) options.porosity = result.porosity;
            estimate.grids.push_back({plan.voxel_size_m, result.value});
            if (finest) estimate.finest = std::move(result);
        } catch (const DoesNotPercolate&) {
            if (finest) throw;
            estimate.no_limit_because = fmt::format("on voxels of {:.3g} m the pores do not percolate", plan.voxel_size_m);
        }
    }
    const auto& grids = estimate.grids;
    if (!estimate.no_limit_because.empty()) return estimate;
    constexpr double few = 0.02;
    if (estimate.finest.thin_solid > few)
        estimate.no_limit_because = fmt::format("in {:.0f} % of the cells at walls the solid is thinner than a cell: choose smaller voxels",
                                                100.0 * estimate.finest.thin_solid);
    else if (grids[1].voxel_size_m > grids[0].voxel_size_m && grids[2].voxel_size_m > grids[1].voxel_size_m)
        estimate.limit = diffusive_limit({grids[0].voxel_size_m, grids[1].voxel_size_m, grids[2].voxel_size_m},
                                         {grids[0].value, grids[1].value, grids[2].value});
    else
        estimate.no_limit_because = "two of the three grids have the same voxel size in this periodic box: choose smaller voxels";
    return estimate;
}

}  // namespace porepack::tortuosity
