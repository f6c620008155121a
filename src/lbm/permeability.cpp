#include "lbm/permeability.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack {
namespace {

constexpr double water_viscosity_Pa_s = 1e-3;

FlowSection flow_section(const PhaseImage& image, const Container& container, const Section& section, const Drive& drive) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[axis];
    FlowSection flow{.last_layer = grid.cells[axis] - 1};
    if (drive.axis == 2) {
        flow.area_cells = container.inner_area_m2() / (h * h);
        flow.first_layer = std::max(0, static_cast<int>(std::lround((section.z0 - grid.origin_m[2]) / h)));
        flow.last_layer = std::min(flow.last_layer, static_cast<int>(std::lround((section.z1 - grid.origin_m[2]) / h)) - 1);
    } else {
        flow.area_cells = container.size_m[1 - drive.axis] * container.size_m.z() / (h * h);
    }
    return flow;
}

// Scales to water at the superficial velocity asked for. In Stokes flow everything is proportional.
FlowImage flow_image(const PhaseImage& image, const Domain& domain, const StokesSolver& solver, const LbmGridResult& result,
                     double superficial_velocity) {
    FlowImage flow{.grid = image.grid,
                   .velocity_m_per_s = std::vector<float>(3 * image.grid.size(), 0.0F),
                   .pressure_Pa = std::vector<float>(image.grid.size(), 0.0F),
                   .phase = image.phase,
                   .notes = image.notes};
    const double speed = superficial_velocity / result.run.superficial_velocity_lu;
    const double gradient = water_viscosity_Pa_s * superficial_velocity / result.permeability_m2;
    const double pressure = gradient * result.voxel_size_m / (3.0 * result.run.gradient_lu);
#pragma omp parallel for schedule(static)
    for (std::size_t node = 0; node < domain.nodes(); ++node) {
        const auto here = solver.moments(node);
        const auto cell = static_cast<std::size_t>(domain.cell[node]);
        for (std::size_t a = 0; a < 3; ++a) flow.velocity_m_per_s[3 * cell + a] = static_cast<float>(speed * here.velocity[a]);
        flow.pressure_Pa[cell] = static_cast<float>(pressure * here.density);
    }
    flow.notes["state"] =
        fmt::format("water (1e-3 Pa s) at a superficial velocity of {:g} m/s along {}", superficial_velocity, "xyz"[domain.drive.axis]);
    flow.notes["direction"] = std::string(1, "xyz"[domain.drive.axis]);
    return flow;
}

LbmGridResult solve_on(const PhaseImage& image, const Container& container, const Section& section, const LbmConfig& config,
                       FlowImage* flow) {
    const Drive drive = choose_drive(container, config.direction);
    const Domain domain = build_domain(image, drive);
    const Relaxation relaxation{.tau = config.relaxation_time, .magic = config.magic_number};
    StokesSolver solver(domain, relaxation);
    LbmGridResult result{.voxel_size_m = image.grid.spacing_m[2],
                         .cells = image.grid.cells,
                         .nodes = domain.nodes(),
                         .isolated_cells = domain.isolated_cells,
                         .bytes_per_node = solver.bytes_per_node(),
                         .by_pressure = drive.by_pressure()};
    log_info("lattice Boltzmann: {} x {} x {} voxels of {:.4g} m, {} fluid nodes ({} isolated), {}", image.grid.cells[0],
             image.grid.cells[1], image.grid.cells[2], result.voxel_size_m, result.nodes, result.isolated_cells,
             human_bytes(result.bytes_per_node * static_cast<double>(result.nodes)));
    result.run = run_to_steady(solver, domain, relaxation, flow_section(image, container, section, drive),
                               {.tolerance = config.tolerance, .max_steps = config.max_steps});
    if (!result.run.converged)
        throw NumericalError(fmt::format("the flow is not steady after {} steps: iteration error {:.1e}, flow imbalance {:.1e}, gate "
                                         "{:.1e}; no permeability is given",
                                         result.run.steps, result.run.iteration_error, result.run.flow_imbalance, config.tolerance),
                             {.mend = "raise max_steps, or loosen the tolerance"});
    const double h2 = result.voxel_size_m * result.voxel_size_m;
    result.permeability_m2 = result.run.permeability_lu * h2;
    result.permeability_volume_m2 = result.run.permeability_volume_lu * h2;
    if (flow != nullptr) *flow = flow_image(image, domain, solver, result, config.superficial_velocity_m_per_s);
    return result;
}

}  // namespace

LbmResult lbm_permeability(const Voxeliser& voxeliser, double voxel_size_m, const Container& container, const Section& section,
                           const LbmConfig& config, bool with_flow) {
    LbmResult result;
    if (config.grids == 2) result.coarse = solve_on(voxeliser(config.grid_ratio * voxel_size_m), container, section, config, nullptr);
    result.fine = solve_on(voxeliser(voxel_size_m), container, section, config, with_flow ? &result.flow : nullptr);
    if (result.coarse) {
        // Bounce-back on voxels is of first order at best and not regular: the half width is Richardson's for first order.
        const double ratio = result.coarse->voxel_size_m / result.fine.voxel_size_m;
        // On spheres with a known answer its error scatters by some 4 % without a sign that one pair of grids could show.
        constexpr double scatter = 0.04;
        if (ratio < 1.02)
            throw UserError("both grids have the same voxel size: the section is too short for this grid_ratio",
                            {.mend = "take smaller voxels, a longer section, a larger grid_ratio, or grids = 1"});
        const double half = std::max(std::abs(result.fine.permeability_m2 - result.coarse->permeability_m2) / (ratio - 1.0),
                                     scatter * result.fine.permeability_m2);
        result.interval_m2 = Interval{std::max(0.0, result.fine.permeability_m2 - half), result.fine.permeability_m2 + half};
    }
    return result;
}

}  // namespace porepack
