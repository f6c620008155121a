#include "lbm/paper_scheme.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "lbm/permeability.hpp"
#include "lbm/uses.hpp"
#include "packing/grains.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::lbm {
namespace {

// Spheres in body-centred order in a periodic cube of side 1.
PoreSpace body_centred_spheres(double solid_fraction) {
    const double r = std::cbrt(3.0 * solid_fraction / (8.0 * std::numbers::pi));
    const Packing packing{.container = vessels::make_box(Vec3::Ones(), {true, true, true}),
                          .shapes = {{.id = "grain", .capsules = {{Vec3::Zero(), Vec3::Zero(), r}}}},
                          .bodies = {{.shape = 0, .position_m = Vec3::Constant(0.25)}, {.shape = 0, .position_m = Vec3::Constant(0.75)}}};
    return pore_space_of(std::make_shared<const Grains>(packing), packing.container, {0.0, 1.0}, 2.0 * r);
}

}  // namespace

double paper_scheme_ratio(double capsule_diameter_m, double solid_fraction) {
    const PoreSpace space = body_centred_spheres(std::min(solid_fraction, 0.67));
    const double voxel = space.grain_size_m * paper_voxel_m / capsule_diameter_m;
    const LbmConfig paper{
        .walls = Walls::bounce_back, .collision = Collision::bgk, .relaxation_time = 0.59, .iteration_tolerance = 2e-3, .grids = 1};
    const LbmConfig ours{.iteration_tolerance = 1e-3, .grids = 1};
    return lbm_permeability(space, voxel, paper).permeability_m2 / lbm_permeability(space, voxel, ours).permeability_m2;
}

}  // namespace porepack::lbm
