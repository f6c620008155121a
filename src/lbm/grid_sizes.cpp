#include "lbm/grid_sizes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "lbm/permeability.hpp"
#include "lbm/sequence.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

// Additional coarser grids are cheap, and the best viscosity is found on them at low cost; but with fewer than five nodes per diameter,
// walls in narrow pores leak, and the flow needs thousands of steps.
long count_grids(const PoreSpace& space, double voxel_size_m, const LbmConfig& config) {
    long grids = config.grids;
    constexpr double min_nodes = 5.0;
    const auto nodes = [&](long count) {
        return space.known_grain_diameter_m() / (voxel_size_m * std::pow(config.grid_ratio, static_cast<double>(count - 1)));
    };
    while (config.grids > 2 && std::isfinite(space.known_grain_diameter_m()) && nodes(grids) > first_nodes_per_grain &&
           nodes(grids + 1) > min_nodes)
        ++grids;
    return grids;
}

bool all_differ(const PoreSpace& space, const std::vector<double>& sizes) {
    for (std::size_t i = 1; i < sizes.size(); ++i)
        if (space.plan_at(sizes[i - 1]).voxel_size_m < same_size * space.plan_at(sizes[i]).voxel_size_m) return false;
    return true;
}

// The first grid, as the flow will have it.
Grid coarsest_grid(const PoreSpace& space, double voxel_size_m, const LbmConfig& config) {
    const double size = coarsest_size(space, voxel_size_m, config);
    if (config.tolerance > 0.0) return space.plan_at(size).grid;
    return with_different_grids(space, grid_sizes(space, voxel_size_m, config)).plan_at(size).grid;
}

}  // namespace

// With a time limit the first three grids are so coarse that they take about half of it; they are always finished, so that there is
// an interval. About 500 steps, and 2e7 nodes per second, on the coarsest; twice the nodes per diameter need 16 times the time.
double first_nodes(const PoreSpace& space, const LbmConfig& config) {
    const double diameter = space.known_grain_diameter_m();
    if (config.max_time_s <= 0.0 || !std::isfinite(diameter)) return first_nodes_per_grain;
    const Section part = space.container.periodic()[2] ? space.section : space.computed();
    const double cells =
        space.container.vessel().mean_area(part.interval()) * part.length() / std::pow(diameter / first_nodes_per_grain, 3.0);
    const double three_grids = 21.0 * cells * 0.5 * 500.0 / 2e7;
    return std::clamp(first_nodes_per_grain * std::pow(0.5 * config.max_time_s / three_grids, 0.25), 2.0, first_nodes_per_grain);
}

std::vector<double> grid_sizes(const PoreSpace& space, double voxel_size_m, const LbmConfig& config) {
    std::vector<double> sizes;
    for (long left = count_grids(space, voxel_size_m, config) - 1; left >= 0; --left) {
        const double size = voxel_size_m * std::pow(config.grid_ratio, static_cast<double>(left));
        if (left == 0 || !space.gray() || size <= space.grain_size_m) sizes.push_back(size);
    }
    return sizes;
}

PoreSpace with_different_grids(const PoreSpace& space, const std::vector<double>& sizes) {
    if (!space.container.any_periodic() || sizes.front() > std::min(space.grain_size_m, space.section.length())) return space;
    PoreSpace rounded = space;
    rounded.round_sides = true;
    bool refused = false;
    for (const PoreSpace& candidate : {space, rounded}) {
        try {
            if (all_differ(candidate, sizes)) return candidate;
        } catch (const UserError&) {
            refused = true;  // no such size
        }
    }
    if (!refused) return space;
    throw UserError(
        fmt::format("the periodic box has no {} different voxel sizes of about {:g} to {:g} m", sizes.size(), sizes.back(), sizes.front()),
        {.fix = "use smaller voxels, or grids = 1"});
}

LbmConfig fitted_to(const PoreSpace& space, LbmConfig config) {
    if (space.own_grid()) {
        const auto& h = space.own_grid()->spacing_m;
        for (const double spacing : h)
            if (std::abs(spacing / h[0] - 1.0) > 1e-6)
                throw UserError(fmt::format("the voxels are not cubic: {:g} x {:g} x {:g} m", h[0], h[1], h[2]),
                                {.where = space.source, .fix = "resample the image"});
        if (config.tolerance > 0.0)
            throw UserError("an image has one resolution: no finer grid can reach a tolerance",
                            {.where = space.source, .fix = "omit the tolerance, or give packing.json or the STL file"});
        config.grids = 1;
    }
    if (config.tolerance > 0.0 && scheme_of(config, space.has_exact_walls(), {}).walls == Walls::bounce_back)
        throw UserError("a tolerance needs interpolated walls: bounce-back scatters by about 4 % on any grid",
                        {.fix = "walls = \"interpolated\" and an exact geometry, or no tolerance"});
    return config;
}

double coarsest_size(const PoreSpace& space, double voxel_size_m, const LbmConfig& config) {
    if (config.tolerance == 0.0) return grid_sizes(space, voxel_size_m, config).front();
    const double coarsest = space.known_grain_diameter_m() / first_nodes(space, config);
    return std::isfinite(coarsest) ? coarsest : 3.0 * voxel_size_m;
}

long max_parts(const PoreSpace& space, double voxel_size_m, const LbmConfig& given) {
    const LbmConfig config = fitted_to(space, given);
    return max_parts(coarsest_grid(space, voxel_size_m, config).cells[2]);
}

double largest_slab(const PoreSpace& space, double voxel_size_m, const LbmConfig& given, long parts, const Communicator& counted_by) {
    const LbmConfig config = fitted_to(space, given);
    const double layers = space.plan_at(voxel_size_m).grid.cells[2], shared = 2.0 / layers;
    if (!space.solid) return 1.0 / static_cast<double>(parts) + shared;
    double largest = 0.0;
    for (const SlabShare& slab : slab_shares(space, coarsest_grid(space, voxel_size_m, config), static_cast<int>(parts), counted_by))
        largest = std::max({largest, slab.height + shared, slab.pores * (1.0 + shared / slab.height)});
    return std::min(largest, 1.0);
}

SlabCuts slab_cuts(const PoreSpace& space, double voxel_size_m, const LbmConfig& given, const Communicator& parts) {
    const LbmConfig config = fitted_to(space, given);
    return {space, coarsest_grid(space, voxel_size_m, config), parts};
}

PoreSpace space_of_part(const PoreSpace& space, double voxel_size_m, const LbmConfig& given, const SlabCuts& cuts, double porosity,
                        const Communicator& parts) {
    const LbmConfig config = fitted_to(space, given);
    const bool periodic = choose_drive(space.container, config.direction).periodic[2];
    const Grid whole = coarsest_grid(space, voxel_size_m, config), slab = cuts.slab_of(whole, periodic, parts);
    if (!slab.is_slab()) return space;
    // The layers of a finer grid begin up to half a layer of this one elsewhere; links and interpolation reach one further.
    const double h = whole.spacing_m[2], bottom = whole.origin_m[2], top = bottom + whole.cells[2] * h, margin = 4.0 * h;
    std::vector<Interval> heights = {{bottom + slab.slab.first * h - margin, bottom + (slab.slab.first + slab.cells[2]) * h + margin}};
    // The relaxation time is searched on a piece of the first grid that percolates; percolating nodes may be a part of the pores.
    constexpr double wider = 4.0;
    const double nodes = porosity * static_cast<double>(whole.size());
    if (config.grids > 1 || config.tolerance > 0.0) {
        const double middle = 0.5 * (space.computed().z0_m + space.computed().z1_m),
                     half = 0.5 * std::min(wider * std::max(8.0 * h, (top - bottom) * nodes_of_search / nodes), top - bottom);
        heights.push_back({middle - half - margin, middle + half + margin});
    }
    return space.between(heights);
}

}  // namespace porepack::lbm
