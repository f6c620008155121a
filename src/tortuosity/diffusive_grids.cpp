// The tortuosity factor on grids of several voxel sizes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "converters/percolation.hpp"
#include "core/machine.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack::tortuosity {
using namespace core;
using namespace converters;

std::optional<Interval> DiffusiveEstimate::interval() const {
    if (!limit) return std::nullopt;
    return Interval{std::max(1.0, limit->value - limit->half_width), limit->value + limit->half_width};
}

DiffusiveEstimate diffusive_tortuosity(const PoreSpace& space, double voxel_size_m, Axis axis, const DiffusiveOptions& options) {
    const PoreSpace section = space.section_only();
    DiffusiveEstimate estimate;
    if (section.image) estimate.no_limit_because = "an image has one resolution";
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
            const PhaseImage image = section.voxelise_at(size);
            const Drive drive{.axis = static_cast<int>(axis), .periodic = section.periodic_sides()};
            DiffusiveResult result = diffusive_tortuosity(image, drive.axis, drive.periodic, options, section.link_cuts(image, drive));
            estimate.grids.push_back({plan.voxel_size_m, result.value});
            if (finest) estimate.finest = std::move(result);
        } catch (const DoesNotPercolate&) {
            if (finest) throw;
            estimate.no_limit_because = fmt::format("on voxels of {:.3g} m the pores do not percolate", plan.voxel_size_m);
        }
    }
    const auto& grids = estimate.grids;
    if (!estimate.no_limit_because.empty()) return estimate;
    if (grids[1].voxel_size_m > grids[0].voxel_size_m && grids[2].voxel_size_m > grids[1].voxel_size_m)
        estimate.limit = diffusive_limit({grids[0].voxel_size_m, grids[1].voxel_size_m, grids[2].voxel_size_m},
                                         {grids[0].value, grids[1].value, grids[2].value});
    else
        estimate.no_limit_because = "the grids do not differ";
    return estimate;
}

}  // namespace porepack::tortuosity
