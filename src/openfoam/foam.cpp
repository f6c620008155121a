#include "openfoam/foam.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <future>
#include <string>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "openfoam/foam_case.hpp"
#include "openfoam/foam_field.hpp"
#include "openfoam/uses.hpp"

namespace porepack::openfoam {
namespace fs = std::filesystem;
namespace {

// Length of the evaluated part / pressure drop over it, for the pressures 1 at the inlet and 0 at the outlet.
double evaluated_length_over_drop(const FoamScene& scene, const Path& folder, double cell_size_m) {
    const auto cells = read_foam_cells(folder);
    const auto pressure_at = [&](double z, double end, double end_pressure) {
        return std::abs(z - end) < 1e-6 * scene.section.length() ? end_pressure : plane_pressure(cells, z, 1.5 * cell_size_m);
    };
    const double drop =
        pressure_at(scene.evaluated->z0_m, scene.section.z0_m, 1.0) - pressure_at(scene.evaluated->z1_m, scene.section.z1_m, 0.0);
    return scene.evaluated->length() / drop;
}

// The cases have a viscosity of 1, and a pressure drop 1 between the ends or gradient 1 in a periodic box. By Darcy's law k is then the
// flow rate over the area, times the length for a drop. Where only a part is evaluated, the drop over this part is taken from the pressure
// field.
void judge_flow(const FoamScene& scene, const FoamConfig& config, const Path& folder, FoamMeshResult& result) {
    const Path log = folder / "log.simpleFoam";
    const Path post = folder / "postProcessing";
    const double length = scene.section.length(), area = scene.container.vessel().mean_area(scene.section.interval());
    std::vector<double> flow;
    if (scene.container.periodic()[2]) {
        flow = read_series(post / "meanVelocity", "volFieldValue.dat", 3);
        if (flow.empty()) reject_foam("no flow rate was written", log);
        for (double& q : flow) q /= length;  // volume integral of u_z / length: mean flow rate
        result.permeability_m2 = flow.back() / area;
    } else {
        flow = read_series(post / "outletFlow", "surfaceFieldValue.dat", 1);
        const auto inlet = read_series(post / "inletFlow", "surfaceFieldValue.dat", 1);
        if (flow.empty() || inlet.empty()) reject_foam("no flow rate was written", log);
        // Fluxes are positive outward: at the inlet negative.
        result.flow_imbalance = std::abs(inlet.back() + flow.back()) / std::abs(flow.back());
        result.permeability_m2 = flow.back() * length / area;
    }
    result.iterations = static_cast<long>(flow.size());
    if (result.iterations < 2)
        reject_foam("the solver stopped after one iteration: nothing flows in the meshed region", log, "check locationInMesh");
    result.flow_drift = flow.size() > 10 ? std::abs(flow.back() / flow[flow.size() - 11] - 1.0) : 1.0;
    // Either all residuals fell below their limit, or (if a velocity component is zero and its residual is noise) that of the
    // pressure did, and the flow rate is constant over 50 iterations and balances.
    const bool by_residual = last_number(log, "SIMPLE solution converged in ").has_value();
    const bool by_flow = flow.size() > 50 && std::abs(flow.back() / flow[flow.size() - 51] - 1.0) < config.residual &&
                         result.flow_imbalance < config.residual &&
                         last_number(log, "Solving for p, Initial residual = ").value_or(1.0) < config.residual;
    result.converged = by_residual || by_flow;
    if (!result.converged)
        throw NumericalError(
            "OpenFOAM did not converge; no permeability is given\n" + tail(log, 8),
            {.where = log.string(), .fix = "raise max_iterations; or lower relaxation_pressure to 3 (1 - relaxation_velocity)"});
    if (!(result.permeability_m2 > 0.0) || !std::isfinite(result.permeability_m2))
        reject_foam(fmt::format("the flow has the wrong direction or diverged: k = {:g} m2", result.permeability_m2), log);
    if (result.flow_imbalance > 1e-4)
        throw NumericalError(fmt::format("OpenFOAM's flow does not balance: in and out differ by {:.1e}", result.flow_imbalance),
                             {.where = log.string(), .fix = "tighten residual"});
    if (result.flow_drift > 1e-3)
        throw NumericalError(fmt::format("OpenFOAM's flow rate still changes: {:.1e} over the last 10 iterations", result.flow_drift),
                             {.where = log.string(), .fix = "tighten residual"});
    if (scene.evaluated) result.permeability_m2 = flow.back() / area * evaluated_length_over_drop(scene, folder, result.cell_size_m);
}

// Conditions on the sides of the block.
std::string side_parameters(const FoamScene& scene) {
    std::string text;
    for (const std::size_t axis : {0, 1}) {
        const char name = "XY"[axis];
        text += scene.container.periodic()[axis] ? fmt::format("sides{0} cyclic; velocity{0} cyclic; pressure{0} cyclic;\n", name)
                                                 : fmt::format("sides{0} wall; velocity{0} noSlip; pressure{0} zeroGradient;\n", name);
    }
    return text;
}

FoamMeshResult solve_on_mesh(const FoamScene& scene, const FoamConfig& config, double cell, const Path& cases, const Path& folder,
                             long processes, const char* label) {
    FoamMeshResult result{.cell_size_m = cell, .processes = processes};
    const bool periodic = scene.container.periodic()[2];
    prepare_foam_case(scene,
                      common_parameters(scene, config, cell, processes) +
                          "// The fields are those of water (1e-6 m2/s, 1000 kg/m3) at a pressure drop of 1 mPa (periodic: per metre): U "
                          "in m/s, p in mPa.\n"
                          "viscosity 1;\n" +
                          (periodic ? "gradient (0 0 1);\n" : "pressureDrop 1;\n" + wall_parameters(scene) + side_parameters(scene)),
                      cases / (periodic ? "stokes_periodic" : "stokes_packing"), folder);
    log_info("{}: background cells of {:.3g} m", label, cell);
    const auto state = [&] {
        return fs::exists(folder / "log.simpleFoam") ? solving_state(folder, config.residual)
                                                     : FoamState{std::nullopt, meshing_phase(folder)};
    };
    const ProgramEnd end = run_foam_case(folder, label, state, result);
    judge_foam_mesh(scene, config, folder, result);
    if (!fs::exists(folder / "log.simpleFoam.done"))
        reject_foam(fmt::format("the solver failed (exit code {})", end.exit_code), folder / "log.Allrun",
                    "lower relaxation_velocity and relaxation_pressure");
    judge_flow(scene, config, folder, result);
    return result;
}

}  // namespace

std::array<int, 3> background_cells(const Container& container, const Section& section, double cell_size_m) {
    return background_block(container, section, cell_size_m).cells;
}

Vec3 find_pore_point(const PhaseImage& image, const Container& container) {
    const Drive drive{.axis = 2, .periodic = container.periodic()};
    std::vector<std::uint8_t> reached(image.grid.size(), 0);
    const Percolation percolation = find_percolating_cells(image, drive);
    percolation.cells.for_each([&](std::size_t cell) { reached[cell] = 1; });
    // Distance in cells from all cells that flow does not reach, layer by layer.
    std::vector<std::size_t> front, next;
    std::vector<std::uint8_t> seen(image.grid.size(), 0);
    for (std::size_t cell = 0; cell < image.grid.size(); ++cell) {
        const auto at = image.grid.place(cell);
        bool edge = false;
        // The image's edge counts like a wall, so the point keeps away from the sides of the block.
        for (std::size_t a = 0; a < 3; ++a) edge = edge || at[a] == 0 || at[a] == image.grid.cells[a] - 1;
        if (reached[cell] == 1 && !edge) continue;
        seen[cell] = 1;
        front.push_back(cell);
    }
    std::size_t deepest =
        percolation.cells.cell(static_cast<std::size_t>(percolation.cells.size() - 1));  // for images with edge cells only
    while (!front.empty()) {
        next.clear();
        for (const std::size_t cell : front)
            for (int q = 0; q < 6; ++q) {
                auto at = image.grid.place(cell);
                at[static_cast<std::size_t>(q / 2)] += q % 2 == 0 ? 1 : -1;
                if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] >= image.grid.cells[0] || at[1] >= image.grid.cells[1] ||
                    at[2] >= image.grid.cells[2])
                    continue;
                const std::size_t other = image.grid.index(at[0], at[1], at[2]);
                if (seen[other] == 1) continue;
                seen[other] = 1;
                next.push_back(other);
                deepest = other;
            }
        front.swap(next);
    }
    const auto at = image.grid.place(deepest);
    const double h = image.grid.spacing_m[0];
    return {image.grid.centre(0, at[0]) + 0.0131 * h, image.grid.centre(1, at[1]) + 0.0173 * h, image.grid.centre(2, at[2]) + 0.0119 * h};
}

void require_foam() {
    for (const char* program : {"blockMesh", "snappyHexMesh", "checkMesh", "simpleFoam", "surfaceCheck"})
        require_program(program, "openfoam");
}

FoamResult foam_permeability(const FoamScene& scene, const FoamConfig& config, double cell_size_m, const Path& cases, const Path& folder) {
    require_foam();
    const auto& periodic = scene.container.periodic();
    if (periodic[2] && !(periodic[0] && periodic[1]))
        throw UserError("OpenFOAM runs need a box that is not periodic along z, or periodic in all directions",
                        {.fix = "use the lattice Boltzmann solver: porepack lbm"});
    FoamResult result;
    make_folder(folder);
    fs::copy_file(cases / "runFunctions", folder / "runFunctions", fs::copy_options::overwrite_existing);
    // The coarser meshes at the same time as the finest: each uses one core.
    auto coarser = std::async(config.meshes > 1 ? std::launch::async : std::launch::deferred, [&, &run = context()] {
        const ContextScope here(run);
        std::vector<FoamMeshResult> meshes;
        if (config.meshes > 2)
            meshes.push_back(solve_on_mesh(scene, config, config.mesh_ratio * config.mesh_ratio * cell_size_m, cases,
                                           folder / "mesh_coarsest", 1, "OpenFOAM, coarsest mesh"));
        if (config.meshes > 1)
            meshes.push_back(
                solve_on_mesh(scene, config, config.mesh_ratio * cell_size_m, cases, folder / "mesh_coarse", 1, "OpenFOAM, coarser mesh"));
        return meshes;
    });
    const FoamMeshResult fine =
        solve_on_mesh(scene, config, cell_size_m, cases, folder / "mesh_fine", config.processes, "OpenFOAM, finest mesh");
    result.meshes = coarser.get();
    result.meshes.push_back(fine);
    result.permeability_m2 = fine.permeability_m2;
    if (config.meshes > 1) {
        std::vector<double> cells, values, volumes;
        for (const FoamMeshResult& mesh : result.meshes) {
            cells.push_back(static_cast<double>(mesh.cells));
            values.push_back(mesh.permeability_m2);
            volumes.push_back(mesh.mesh_volume_ratio);
        }
        result.extrapolation = without_lost_pores(extrapolate_meshes(cells, values), values, volumes);
        if (result.extrapolation->lost_pores)
            log_warning(
                fmt::format("OpenFOAM: the coarser mesh lacks {:.0f} % of the pores, and k grows with refinement: it is not "
                            "extrapolated; use smaller cells (now {:.3g} m)",
                            100.0 * (1.0 - volumes[volumes.size() - 2]), cell_size_m));
        result.permeability_m2 = result.extrapolation->value;
    }
    return result;
}

// Richardson's extrapolation: the error is proportional to s^p, with the cell size s from the number of cells, s ~ cells^(-1/3).
FoamExtrapolation extrapolate_meshes(std::span<const double> cells, std::span<const double> values) {
    const std::size_t n = cells.size();
    const double k = values[n - 1], change = k - values[n - 2], ratio = std::cbrt(cells[n - 1] / cells[n - 2]);
    const auto with_order = [&](double order) { return k + change / (std::pow(ratio, order) - 1.0); };
    const auto between_orders = [&](double low, double high) {
        return Interval{std::min(with_order(low), with_order(high)), std::max(with_order(low), with_order(high))};
    };
    if (n == 2) return {with_order(1.5), between_orders(1.0, 2.0), std::nullopt, std::nullopt};
    const double before = values[1] - values[0];
    // Changes of opposite signs, or none: no order explains them.
    if (!(before * change > 0.0)) {
        const double half = 3.0 * std::max(std::abs(before), std::abs(change));
        return {k, {k - half, k + half}, std::nullopt, half / k};
    }
    // (k2 - k1)/(k3 - k2) = (s1^p - s2^p)/(s2^p - s3^p) grows with p.
    const double coarser = std::cbrt(cells[1] / cells[0]);
    const auto changes = [&](double p) { return (std::pow(coarser, p) - 1.0) / (1.0 - std::pow(ratio, -p)); };
    const auto too_low = [&](double p) { return changes(p) < before / change ? -1.0 : 1.0; };
    const double low = too_low(0.05) * too_low(8.0) > 0.0
                           ? (too_low(0.05) > 0.0 ? 0.05 : 8.0)
                           : boost::math::tools::bisect(too_low, 0.05, 8.0, [](double a, double b) { return b - a <= 1e-9; }).first;
    // The scheme is of second order; meshes that are too coarse for the asymptotic range show others, and tell little more than the
    // direction.
    const bool plausible = low >= 1.5 && low <= 2.5;
    const double order = plausible ? low : 2.0, spread = plausible ? 0.5 : 1.0;
    FoamExtrapolation found{with_order(order), between_orders(order - spread, order + spread), low, std::nullopt};
    // Roache's safety factors: 1.25 with an observed order, 3 with an assumed one.
    found.grid_convergence_index = (plausible ? 1.25 : 3.0) * std::abs(found.value / k - 1.0);
    found.interval.low = std::min(found.interval.low, 0.995 * found.value);
    found.interval.high = std::max(found.interval.high, 1.005 * found.value);
    return found;
}

FoamExtrapolation without_lost_pores(FoamExtrapolation found, std::span<const double> values, std::span<const double> volume_ratios) {
    constexpr double min_volume_ratio = 0.97;
    const std::size_t n = values.size();
    if (volume_ratios[n - 2] >= min_volume_ratio || values[n - 1] <= values[n - 2]) return found;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return {.value = values[n - 1],
            .interval = {std::min({*low, found.value, found.interval.low}), std::max({*high, found.value, found.interval.high})},
            .observed_order = std::nullopt,
            .grid_convergence_index = std::nullopt,
            .lost_pores = true};
}

}  // namespace porepack::openfoam
