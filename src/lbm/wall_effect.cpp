#include "lbm/wall_effect.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lbm/permeability.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

// visit(radius, axial velocity) for each cell in the section and the tube.
template <typename Visit>
void for_cells(const FlowImage& flow, const Section& section, double diameter_m, const Visit& visit) {
    for (std::size_t cell = 0; cell < flow.grid.size(); ++cell) {
        const auto at = flow.grid.place(cell);
        const double r = std::hypot(flow.grid.centre(0, at[0]), flow.grid.centre(1, at[1])), z = flow.grid.centre(2, at[2]);
        if (r < 0.5 * diameter_m && z > section.z0_m && z < section.z1_m)
            visit(r, static_cast<double>(flow.velocity_m_per_s[3 * cell + 2]));
    }
}

}  // namespace

std::vector<Ring> radial_profile(const FlowImage& flow, const Section& section, double diameter_m, long rings) {
    std::vector<Ring> profile(static_cast<std::size_t>(rings));
    std::vector<double> cells(profile.size(), 0.0);
    const double width = 0.5 * diameter_m / static_cast<double>(rings);
    double sum = 0.0, all = 0.0;
    for_cells(flow, section, diameter_m, [&](double r, double velocity) {
        const auto ring = std::min(profile.size() - 1, static_cast<std::size_t>(r / width));
        cells[ring] += 1.0;
        profile[ring].porosity += velocity != 0.0 ? 1.0 : 0.0;
        profile[ring].relative_velocity += velocity;
        sum += velocity;
        all += 1.0;
    });
    for (std::size_t ring = 0; ring < profile.size(); ++ring) {
        profile[ring].r0_m = width * static_cast<double>(ring);
        profile[ring].r1_m = width * static_cast<double>(ring + 1);
        profile[ring].porosity /= cells[ring];
        profile[ring].relative_velocity *= all / (cells[ring] * sum);
    }
    return profile;
}

double core_over_tube(const FlowImage& flow, const Section& section, double diameter_m, double layer_m) {
    double all = 0.0, core = 0.0, all_cells = 0.0, core_cells = 0.0;
    for_cells(flow, section, diameter_m, [&](double r, double velocity) {
        all += velocity;
        all_cells += 1.0;
        if (r >= 0.5 * diameter_m - layer_m) return;
        core += velocity;
        core_cells += 1.0;
    });
    return core_cells > 0.0 ? core / core_cells / (all / all_cells) : std::numeric_limits<double>::quiet_NaN();
}

double core_over_tube_permeability(const PoreSpace& space, double layer_m) {
    PoreSpace pores = space;
    pores.reservoir_m = 0.0;
    const FlowImage flow =
        lbm_permeability(pores, pores.grain_size_m / 6.0, {.iteration_tolerance = 1e-3, .grids = 1}, {.with_flow = true}).flow.of_own();
    return core_over_tube(flow, {-1e300, 1e300}, *pores.container.tube_diameter(), layer_m);
}

}  // namespace porepack::lbm
