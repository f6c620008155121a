#include "lbm/permeability.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack {
namespace {

constexpr double water_viscosity_Pa_s = 1e-3;
constexpr double body_force_lu = 1e-3;  // any: Stokes flow is linear, and populations are deviations from rest

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

// Scales to water at the superficial velocity asked for: in Stokes flow everything is proportional. The pressure is zero at the
// outlet; of a periodic cell it is what is left of it without the driving gradient.
FlowImage flow_image(const PhaseImage& image, const Domain& domain, const Flow& flow, const LbmGridResult& result,
                     double superficial_velocity) {
    FlowImage picture{.grid = image.grid,
                      .velocity_m_per_s = std::vector<float>(3 * image.grid.size(), 0.0F),
                      .pressure_Pa = std::vector<float>(image.grid.size(), 0.0F),
                      .phase = image.phase,
                      .notes = image.notes};
    const double speed = superficial_velocity / result.run.superficial_velocity_lu;
    const double gradient = water_viscosity_Pa_s * superficial_velocity / result.permeability_m2;
    const double pressure = gradient * result.voxel_size_m / result.run.gradient_lu;
    const double slope = domain.drive.by_pressure() ? body_force_lu : 0.0;
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
#pragma omp parallel for schedule(static)
    for (std::size_t first = 0; first < domain.nodes(); first += Flow::chunk) {
        std::array<Moments, Flow::chunk> moments;
        const std::size_t count = std::min(Flow::chunk, domain.nodes() - first);
        flow.moments(first, std::span(moments).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const auto cell = static_cast<std::size_t>(domain.cell[first + i]);
            for (std::size_t a = 0; a < 3; ++a) picture.velocity_m_per_s[3 * cell + a] = static_cast<float>(speed * moments[i].velocity[a]);
            const double to_outlet = domain.grid.cells[axis] - place_in_grid(domain.grid, cell)[axis] - 0.5;
            picture.pressure_Pa[cell] = static_cast<float>(pressure * (moments[i].density / 3.0 + slope * to_outlet));
        }
    }
    picture.notes["state"] =
        fmt::format("water (1e-3 Pa s) at a superficial velocity of {:g} m/s along {}", superficial_velocity, "xyz"[domain.drive.axis]);
    picture.notes["direction"] = std::string(1, "xyz"[domain.drive.axis]);
    return picture;
}

LbmGridResult solve_on(const LbmScene& scene, double voxel_size_m, const LbmConfig& config, FlowImage* picture) {
    const PhaseImage image = scene.voxels(voxel_size_m);
    const Drive drive = choose_drive(scene.container, config.direction);
    const Scheme scheme = scheme_of(config, scene.solid != nullptr, drive);
    const Stopwatch set_up;
    std::optional<FlowWalls> walls;
    if (scheme.walls == Walls::interpolated) walls.emplace(FlowWalls{*scene.solid, scene.container, scene.section});
    const Domain domain = build_domain(image, drive, walls ? &*walls : nullptr);
    const auto flow = make_flow(config.precision == "single" ? Kernel::fast_single : Kernel::fast_double, domain, scheme);
    LbmGridResult result{.voxel_size_m = image.grid.spacing_m[2],
                         .cells = image.grid.cells,
                         .nodes = domain.nodes(),
                         .isolated_cells = domain.isolated_cells,
                         .wall_links = domain.walls.size(),
                         .narrow_share = domain.narrow_share(),
                         .bytes_per_node = flow->bytes() / static_cast<double>(domain.nodes()),
                         .set_up_seconds = set_up.seconds(),
                         .by_pressure = drive.by_pressure()};
    log_info("lattice Boltzmann: {} x {} x {} voxels of {:.4g} m, {} fluid nodes ({} isolated), {}", image.grid.cells[0],
             image.grid.cells[1], image.grid.cells[2], result.voxel_size_m, result.nodes, result.isolated_cells,
             human_bytes(flow->bytes()));
    result.run = run_to_steady(*flow, domain, scheme, flow_section(image, scene.container, scene.section, drive),
                               {.tolerance = config.tolerance, .max_steps = config.max_steps});
    if (!result.run.converged)
        throw NumericalError(
            fmt::format("the flow is not steady after {} steps: iteration error {:.1e}, gate {:.1e}; no permeability is given",
                        result.run.steps, result.run.iteration_error, config.tolerance),
            {.mend = "raise max_steps, or loosen the tolerance"});
    const double h2 = result.voxel_size_m * result.voxel_size_m;
    result.permeability_m2 = result.run.permeability_lu * h2;
    result.permeability_volume_m2 = result.run.permeability_volume_lu * h2;
    if (picture != nullptr) *picture = flow_image(image, domain, *flow, result, config.superficial_velocity_m_per_s);
    return result;
}

}  // namespace

Scheme scheme_of(const LbmConfig& config, bool exact_walls, const Drive& drive) {
    Scheme scheme{.tau = config.relaxation_time,
                  .walls = exact_walls && config.walls == "interpolated" ? Walls::interpolated : Walls::bounce_back};
    scheme.magic = config.collision == "bgk"             ? (scheme.tau - 0.5) * (scheme.tau - 0.5)
                   : config.magic_number > 0.0           ? config.magic_number
                   : scheme.walls == Walls::interpolated ? 1.0 / 12.0
                                                         : 3.0 / 16.0;
    scheme.force[static_cast<std::size_t>(drive.axis)] = body_force_lu;
    return scheme;
}

LbmResult lbm_permeability(const LbmScene& scene, double voxel_size_m, const LbmConfig& config, bool with_flow) {
    LbmResult result;
    if (config.grids == 2) result.coarse = solve_on(scene, config.grid_ratio * voxel_size_m, config, nullptr);
    result.fine = solve_on(scene, voxel_size_m, config, with_flow ? &result.flow : nullptr);
    if (result.coarse) {
        // Bounce-back on voxels is of first order at best and not regular: the half width is Richardson's for first order, and on
        // spheres with a known answer its error scatters by some 4 % without a sign that one pair of grids could show.
        // Interpolated walls are of second order and regular; the factor and the floor cover what two grids do not show.
        const bool regular = scheme_of(config, scene.solid != nullptr, {}).walls == Walls::interpolated;
        const double ratio = result.coarse->voxel_size_m / result.fine.voxel_size_m;
        const double factor = regular ? 1.5 / (ratio * ratio - 1.0) : 1.0 / (ratio - 1.0), floor = regular ? 0.01 : 0.04;
        if (ratio < 1.02)
            throw UserError("both grids have the same voxel size: the section is too short for this grid_ratio",
                            {.mend = "take smaller voxels, a longer section, a larger grid_ratio, or grids = 1"});
        const double k = result.fine.permeability_m2;
        const double half = std::max(factor * std::abs(k - result.coarse->permeability_m2), floor * k);
        result.interval_m2 = Interval{std::max(0.0, k - half), k + half};
    }
    return result;
}

}  // namespace porepack
