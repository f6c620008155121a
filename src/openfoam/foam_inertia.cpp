#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "openfoam/foam_case.hpp"
#include "openfoam/foam_field.hpp"
#include "openfoam/uses.hpp"

namespace porepack::openfoam {
namespace fs = std::filesystem;
namespace {

// Drop of the flux-weighted total pressure over the evaluated part, per length.
double total_pressure_gradient(const FoamScene& scene, const Path& run, const Path& fields, double cell_size_m) {
    std::vector<FoamCell> cells = read_foam_cells(run, fields);
    for (FoamCell& cell : cells) cell.pressure += 0.5 * cell.velocity.squaredNorm();
    const double reach = 1.5 * cell_size_m;
    return (plane_pressure(cells, scene.evaluated->z0_m, reach) - plane_pressure(cells, scene.evaluated->z1_m, reach)) /
           scene.evaluated->length();
}

}  // namespace

FoamInertialSeries foam_inertial_flows(const FoamScene& scene, const FoamConfig& config, double cell_size_m, std::span<const double> drops,
                                       const Path& cases, const Path& folder) {
    require_foam();
    if (scene.container.any_periodic())
        throw UserError("flows with inertia need a container without periodic faces",
                        {.fix = "disable OpenFOAM: the lattice Boltzmann solver accepts periodic boxes"});
    make_folder(folder);
    fs::copy_file(cases / "runFunctions", folder / "runFunctions", fs::copy_options::overwrite_existing);
    const Path run = folder / "inertial";
    std::string parameters = common_parameters(scene, config, cell_size_m, config.processes) +
                             fmt::format("viscosity {:g};\n{}pressureDrops (", water_viscosity_m2_per_s, wall_parameters(scene));
    for (const double drop : drops) parameters += fmt::format("{:.6g} ", drop);
    prepare_foam_case(scene, parameters + ");\n", cases / "inertial_packing", run);
    FoamInertialSeries series{.mesh = {.cell_size_m = cell_size_m, .processes = config.processes}, .flows = {}, .stopped_by = {}};
    log_info("OpenFOAM, flows with inertia: background cells of {:.3g} m", cell_size_m);
    const auto count_lines = [&] {
        std::ifstream in(run / "flow_rates.dat");
        long lines = 0;
        for (std::string line; std::getline(in, line);) lines += line.empty() || line.front() == '#' ? 0 : 1;
        return lines;
    };
    Stopwatch solving;
    const auto state = [&]() -> FoamState {
        if (!fs::exists(run / "log.checkMesh.done")) {
            solving = {};
            return {std::nullopt, meshing_phase(run)};
        }
        // Each flow starts from the one before and takes about the same time.
        const double done = static_cast<double>(count_lines()), all = static_cast<double>(drops.size());
        return {done > 0.0 ? std::optional(solving.seconds() * (all / done - 1.0)) : std::nullopt,
                fmt::format("pressure drop {:.0f} of {:.0f}", std::min(done + 1.0, all), all)};
    };
    const ProgramEnd end = run_foam_case(run, "OpenFOAM, flows with inertia", state, series.mesh);
    judge_foam_mesh(scene, config, run, series.mesh);
    const double area = scene.container.vessel().mean_area(scene.section.interval()), length = scene.section.length(),
                 nu = water_viscosity_m2_per_s;
    std::ifstream rates(run / "flow_rates.dat");
    for (std::string line; std::getline(rates, line);) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream numbers(line);
        double drop = 0.0, flow = 0.0, iterations = 0.0, gained = 0.0;
        if (!(numbers >> drop >> flow >> iterations >> gained) || !(flow > 0.0) || !std::isfinite(gained))
            reject_foam("a line of flow_rates.dat is not a result: " + line, run / "flow_rates.dat");
        // The drag on the grains is the pressure drop minus the momentum that the water gains between the planes.
        const double speed = flow / area, drag = drop - gained / area,
                     gradient = scene.evaluated
                                    ? total_pressure_gradient(scene, run, run / "drops" / line.substr(0, line.find(' ')), cell_size_m)
                                    : drag / length;
        series.flows.push_back({.pressure_drop_m2_per_s2 = drop,
                                .superficial_velocity_m_per_s = speed,
                                .momentum_share = gained / area / drop,
                                .permeability_m2 = nu * speed / gradient,
                                .iterations = std::lround(iterations)});
    }
    if (series.flows.size() < drops.size())
        series.stopped_by = fmt::format("no steady flow at a pressure drop of {:.4g} m2/s2 (exit code {}): {}", drops[series.flows.size()],
                                        end.exit_code, tail(run / "log.Allrun", 1));
    return series;
}

}  // namespace porepack::openfoam
