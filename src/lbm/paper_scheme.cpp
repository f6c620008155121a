#include "lbm/paper_scheme.hpp"

#include <algorithm>

#include "lbm/known.hpp"

namespace porepack::lbm {
using namespace pore_space;

double paper_scheme_ratio(double capsule_diameter_m, double solid_fraction) {
    const KnownFlow spheres = sphere_array(std::min(solid_fraction, 0.67), 1.0, body_centred());
    const double voxel = spheres.diameter_m * paper_voxel_m / capsule_diameter_m;
    const LbmConfig paper{
        .walls = Walls::bounce_back, .collision = Collision::bgk, .relaxation_time = 0.59, .iteration_tolerance = 2e-3, .grids = 1};
    const LbmConfig ours{.iteration_tolerance = 1e-3, .grids = 1};
    const PoreSpace space = spheres.space();
    return lbm_permeability(space, voxel, paper).permeability_m2 / lbm_permeability(space, voxel, ours).permeability_m2;
}

}  // namespace porepack::lbm
