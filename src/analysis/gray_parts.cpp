#include "analysis/gray_parts.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "analysis/uses.hpp"
#include "core/log.hpp"
#include "lbm/grid_sizes.hpp"
#include "pore_space/gray_solid.hpp"
#include "scans/ball_walls.hpp"
#include "scans/gray_input.hpp"

namespace porepack::analysis {

void add_gray_parts(lbm::LbmResult& result, const PoreSpace& space, const lbm::LbmConfig& config, const lbm::LbmRun& run,
                    std::optional<GrayVariants> given) {
    if (!space.gray() || !result.half_width || result.grids.size() < 2) return;
    const lbm::LbmGridResult& middle = result.grids[result.grids.size() - 2];
    lbm::LbmConfig one = config;
    one.grids = 1;
    one.tolerance = 0.0;
    one.fields = lbm::FieldFiles::none;
    one.relaxation_time = config.collision == lbm::Collision::trt ? middle.relaxation_time : config.relaxation_time;
    // Change of k with another solid, on the same grid; all of k where that does not percolate.
    const auto change = [&](std::shared_ptr<const GraySolid> other) {
        try {
            const PoreSpace varied = with_gray(space, std::move(other));
            return lbm_permeability(varied, middle.voxel_size_m, one, {.parts = run.parts, .cuts = run.cuts}).permeability_m2 /
                       middle.permeability_m2 -
                   1.0;
        } catch (const DoesNotPercolate&) {
            return -1.0;
        }
    };
    const bool of_balls = scans::has_walls_of_balls(*space.gray());
    log_info("{} on voxels of {:.4g} m",
             of_balls ? "places of the walls: one more run" : "gray levels, blur and resolution: three more runs", middle.voxel_size_m);
    GrayVariants variants = given ? std::move(*given) : gray_variants(*space.gray(), space.container);
    if (of_balls) variants.averaged = nullptr;  // means of its distances are no scan
    const double k = result.permeability_m2;
    if (variants.averaged) result.averaged_image_change = change(variants.averaged);
    if (variants.other_level) result.half_width->threshold_m2 = std::abs(change(variants.other_level)) * k;
    if (variants.blurred) {
        // Contacts that the blur has closed change no more, and their share is judged: on spheres in contact it is about this part of sigma
        // / d.
        constexpr double closed_contacts = 0.85;
        const double blur = variants.blur_voxels * space.image_voxel_size_m / space.grain_size_m;
        result.half_width->blur_m2 = std::max(GrayVariants::blur_part * std::abs(change(variants.blurred)) * k, closed_contacts * blur * k);
    }
}

void keep_own_part(PoreSpace& space, std::optional<GrayVariants>& variants, lbm::LbmRun& run, double voxel_size_m,
                   const lbm::LbmConfig& config, double porosity) {
    if (run.parts->parts() == 1) return;
    run.cuts = lbm::slab_cuts(space, voxel_size_m, config, *run.parts);
    const auto own = [&](const PoreSpace& whole) { return space_of_part(whole, voxel_size_m, config, *run.cuts, porosity, *run.parts); };
    if (space.gray() && !config.tensor && (config.grids > 1 || config.tolerance > 0.0)) {
        variants = gray_variants(*space.gray(), space.container);
        for (auto* variant : {&variants->averaged, &variants->other_level, &variants->blurred})
            if (*variant) *variant = std::dynamic_pointer_cast<const GraySolid>(own(with_gray(space, *variant)).solid);
    }
    space = own(space);
}

}  // namespace porepack::analysis
