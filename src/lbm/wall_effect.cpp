#include "lbm/wall_effect.hpp"

#include <cmath>

#include "lbm/permeability.hpp"

namespace porepack::lbm {
using namespace core;
using namespace converters;

double core_over_tube_permeability(const PoreSpace& space, double layer_m) {
    PoreSpace pores = space;
    pores.reservoir_m = 0.0;
    const FlowImage flow =
        lbm_permeability(pores, pores.grain_size_m / 6.0, {.iteration_tolerance = 1e-3, .grids = 1}, {.with_flow = true}).flow;
    double all = 0.0, core = 0.0, all_cells = 0.0, core_cells = 0.0;
    const double radius = 0.5 * pores.container.diameter_m;
    for (std::size_t cell = 0; cell < flow.grid.size(); ++cell) {
        const auto at = place_in_grid(flow.grid, cell);
        const double r = std::hypot(flow.grid.centre(0, at[0]), flow.grid.centre(1, at[1]));
        if (r > radius) continue;
        const double speed = flow.velocity_m_per_s[3 * cell + 2];
        all += speed;
        all_cells += 1.0;
        if (r < radius - layer_m) {
            core += speed;
            core_cells += 1.0;
        }
    }
    return core / core_cells / (all / all_cells);
}

}  // namespace porepack::lbm
