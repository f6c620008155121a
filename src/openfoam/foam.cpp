#include "openfoam/foam.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>
#include <map>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"

namespace porepack {
namespace fs = std::filesystem;
namespace {

struct Block {
    Vec3 low, high;
    std::array<int, 3> cells;
};

// A cylinder's background block is wider than the cylinder by one cell.
Block background_block(const Container& container, const Section& section, double cell) {
    Block block{container.low(), container.high(), {}};
    block.low.z() = section.z0;
    block.high.z() = section.z1;
    for (int axis = 0; axis < 3; ++axis) {
        const double extent = block.high[axis] - block.low[axis];
        int count = std::max(1, static_cast<int>(std::lround(extent / cell)));
        if (container.kind == Container::Kind::cylinder && axis < 2) {
            count = 2 * static_cast<int>(std::ceil(extent / (2.0 * cell))) + 2;
            block.low[axis] = -0.5 * count * cell;
            block.high[axis] = 0.5 * count * cell;
        }
        block.cells[static_cast<std::size_t>(axis)] = count;
    }
    return block;
}

// A box's sides are those of the background block: its wall is a cylinder wider than the block.
std::string parameters(const FoamScene& scene, const FoamConfig& config, double cell, long processes) {
    const Block block = background_block(scene.container, scene.section, cell);
    const Vec3& p = scene.pore_point;
    std::string text = "// Written by porepack; metres, seconds.\n";
    text += fmt::format("xMin {:.12g}; xMax {:.12g}; yMin {:.12g}; yMax {:.12g}; zMin {:.12g}; zMax {:.12g};\n", block.low.x(),
                        block.high.x(), block.low.y(), block.high.y(), block.low.z(), block.high.z());
    text += fmt::format("nx {}; ny {}; nz {};\nsurfaceLevel {};\n", block.cells[0], block.cells[1], block.cells[2], config.surface_level);
    text += fmt::format("locationInMesh ({:.12g} {:.12g} {:.12g});\nviscosity 1;\n", p.x(), p.y(), p.z());
    if (scene.container.any_periodic())
        text += "gradient (0 0 1);\n";
    else
        text += fmt::format("pressureDrop 1;\nwallRadius {:.12g};\n", scene.container.kind == Container::Kind::cylinder
                                                                          ? scene.container.diameter_m / 2.0
                                                                          : 2.0 * block.high.norm() + 2.0 * block.low.norm());
    text += fmt::format("relaxationU {:g}; relaxationP {:g};\nresidual {:g};\nmaxIterations {};\nprocesses {};\n",
                        config.relaxation_velocity, config.relaxation_pressure, config.residual, config.max_iterations, processes);
    return text;
}

// What is the same keeps its time: the case's Allrun starts over when an input is newer than its first step.
void write_if_different(const Path& file, const std::string& text) {
    if (!fs::exists(file) || read_text(file) != text) write_text(file, text);
}

void copy_if_different(const Path& from, const Path& to) {
    make_folder(to.parent_path());
    if (!fs::exists(to) || read_text(to) != read_text(from)) fs::copy_file(from, to, fs::copy_options::overwrite_existing);
}

void prepare(const FoamScene& scene, const FoamConfig& config, double cell, long processes, const Path& cases, const Path& folder) {
    // The case alone, not what an earlier run by hand left in its folder.
    const Path source = cases / (scene.container.any_periodic() ? "stokes_periodic" : "stokes_packing");
    make_folder(folder / "constant" / "triSurface");
    for (const char* part :
         {"Allrun", "Allclean", "README.md", "0.orig/U", "0.orig/p", "constant/transportProperties", "constant/turbulenceProperties"})
        copy_if_different(source / part, folder / part);
    for (const auto& entry : fs::directory_iterator(source / "system"))
        if (entry.path().filename() != "caseParameters") copy_if_different(entry.path(), folder / "system" / entry.path().filename());
    write_if_different(folder / "system" / "caseParameters", parameters(scene, config, cell, processes));
    const Path surface = folder / "constant" / "triSurface" / "solid.stl", fresh = folder / "solid.stl";
    write_stl(fresh, scene.surface, "porepack; unit: metre");
    if (fs::exists(surface) && sha256_of_file(surface) == sha256_of_file(fresh))
        fs::remove(fresh);
    else
        fs::rename(fresh, surface);
}

// The number behind `label` in the last line of a log that has it.
std::optional<double> last_number(const Path& log, const std::string& label) {
    std::ifstream in(log);
    std::optional<double> value;
    for (std::string line; std::getline(in, line);)
        if (const auto at = line.find(label); at != std::string::npos) {
            std::istringstream rest(line.substr(at + label.size()));
            double number = 0.0;
            if (rest >> number) value = number;
        }
    return value;
}

// The series of numbers that a function object wrote: one row an iteration, `column` behind the time. A run that was stopped and went on
// has a folder for each start; what a later one computed again counts.
std::vector<double> read_series(const Path& object, const char* file, int column) {
    std::map<double, Path> starts;
    if (fs::exists(object))
        for (const auto& entry : fs::directory_iterator(object)) starts[std::atof(entry.path().filename().c_str())] = entry.path() / file;
    std::map<double, double> by_time;
    for (const auto& [start, path] : starts) {
        by_time.erase(by_time.upper_bound(start), by_time.end());
        std::ifstream in(path);
        for (std::string line; std::getline(in, line);) {
            if (line.empty() || line.front() == '#') continue;
            for (char& ch : line)
                if (ch == '(' || ch == ')') ch = ' ';
            std::istringstream numbers(line);
            double time = 0.0, value = 0.0;
            bool good = static_cast<bool>(numbers >> time);
            for (int i = 0; i < column; ++i) good = good && static_cast<bool>(numbers >> value);
            if (good) by_time[time] = value;
        }
    }
    std::vector<double> values;
    values.reserve(by_time.size());
    for (const auto& [time, value] : by_time) values.push_back(value);
    return values;
}

[[noreturn]] void reject(const std::string& what, const Path& log, const std::string& mend = {}) {
    throw EngineError("OpenFOAM: " + what + "\n" + tail(log, 12), {.where = log.string(), .mend = mend});
}

void judge_mesh(const FoamScene& scene, const FoamConfig& config, const Path& folder, FoamMeshResult& result) {
    const Path log = folder / "log.checkMesh";
    // The case's own Allrun judges checkMesh (runFunctions), and goes no further when the mesh is unfit.
    if (!fs::exists(folder / "log.simpleFoam")) reject("the mesh fails checkMesh", log, "change cell_size_m a little");
    if (last_number(log, "***Max skewness = ")) result.skew_faces = std::lround(last_number(log, "<<Writing ").value_or(0.0));
    const auto cells = last_number(log, "    cells:"), volume = last_number(log, "Total volume = "),
               slant = last_number(log, "Mesh non-orthogonality Max:"), regions = last_number(log, "*Number of regions:");
    if (!cells || !volume || *cells < 1.0) reject("the mesh has no cells", log, "check locationInMesh and the surface");
    if (regions && *regions > 1.0) reject("the mesh has more than one region", log, "check the surface");
    result.cells = std::lround(*cells);
    result.max_non_orthogonality = slant.value_or(0.0);
    result.mesh_volume_ratio = *volume / scene.pore_volume_m3;
    // A mesh may cut corners, and leave out gaps between grains that are narrower than two of its cells.
    const double coarse = result.cell_size_m / scene.grain_size_m;
    result.narrow_pores = scene.narrow_pores ? scene.narrow_pores(result.cell_size_m / std::exp2(config.surface_level)) : 0.0;
    const double allowed = 0.015 + 0.3 * coarse * coarse + result.narrow_pores;
    if (std::abs(result.mesh_volume_ratio - 1.0) > allowed)
        reject(
            fmt::format("the mesh lost or invented pore space: its volume is {:.4f} of the exact one, {:.4f} is allowed at this cell size",
                        result.mesh_volume_ratio, allowed),
            log, "take smaller cells, or check that the surface is closed and lies where it should");
}

void judge_flow(const FoamScene& scene, const FoamConfig& config, const Path& folder, FoamMeshResult& result) {
    const Path log = folder / "log.simpleFoam";
    const Path post = folder / "postProcessing";
    const double length = scene.section.length(), area = scene.container.inner_area_m2();
    std::vector<double> flow;
    if (scene.container.any_periodic()) {
        flow = read_series(post / "meanVelocity", "volFieldValue.dat", 3);
        if (flow.empty()) reject("no flow rate was written", log);
        for (double& q : flow) q /= length;  // volume integral of u_z / length: mean flow rate
        result.permeability_m2 = flow.back() / area;
    } else {
        flow = read_series(post / "outletFlow", "surfaceFieldValue.dat", 1);
        const auto inlet = read_series(post / "inletFlow", "surfaceFieldValue.dat", 1);
        if (flow.empty() || inlet.empty()) reject("no flow rate was written", log);
        result.flow_imbalance = std::abs(inlet.back() + flow.back()) / std::abs(flow.back());
        result.permeability_m2 = flow.back() * length / area;
    }
    result.iterations = static_cast<long>(flow.size());
    if (result.iterations < 2)
        reject("the solver stopped after one iteration: nothing flows in the meshed region", log, "check locationInMesh");
    result.flow_drift = flow.size() > 10 ? std::abs(flow.back() / flow[flow.size() - 11] - 1.0) : 1.0;
    // Either all residuals fell below their limit, or (where a component of the velocity is zero and its residual is noise) that of the
    // pressure did, and the flow rate stands still for 50 iterations and balances.
    const bool by_residual = last_number(log, "SIMPLE solution converged in ").has_value();
    const bool by_flow = flow.size() > 50 && std::abs(flow.back() / flow[flow.size() - 51] - 1.0) < config.residual &&
                         result.flow_imbalance < config.residual &&
                         last_number(log, "Solving for p, Initial residual = ").value_or(1.0) < config.residual;
    if (!by_residual && !by_flow)
        throw NumericalError(
            "OpenFOAM did not converge; no permeability is given\n" + tail(log, 8),
            {.where = log.string(), .mend = "raise max_iterations; or lower relaxation_pressure to 3 (1 - relaxation_velocity)"});
    if (!(result.permeability_m2 > 0.0) || !std::isfinite(result.permeability_m2))
        reject(fmt::format("the flow goes the wrong way or diverged: k = {:g} m2", result.permeability_m2), log);
    if (result.flow_imbalance > 1e-4)
        throw NumericalError(fmt::format("OpenFOAM's flow does not balance: in and out differ by {:.1e}", result.flow_imbalance),
                             {.where = log.string(), .mend = "tighten residual"});
    if (result.flow_drift > 1e-3)
        throw NumericalError(fmt::format("OpenFOAM's flow still drifts: {:.1e} over the last 10 iterations", result.flow_drift),
                             {.where = log.string(), .mend = "tighten residual"});
}

FoamMeshResult solve_on_mesh(const FoamScene& scene, const FoamConfig& config, double cell, const Path& cases, const Path& folder,
                             long processes, const char* label) {
    FoamMeshResult result{.cell_size_m = cell, .processes = processes};
    prepare(scene, config, cell, processes, cases, folder);
    log_info("{}: background cells of {:.3g} m", label, cell);
    Progress progress(label);
    const char* steps[] = {"log.blockMesh", "log.snappyHexMesh", "log.checkMesh", "log.simpleFoam"};
    const ProgramEnd end = run_program({.command = {"bash", "./Allrun"},
                                        .folder = folder,
                                        .log = folder / "log.Allrun",
                                        .environment = {{"WM_PROJECT_DIR", "/usr/share/openfoam"}},
                                        .while_running = [&] {
                                            double done = 0.0;
                                            for (const char* step : steps)
                                                done += fs::exists(folder / (std::string(step) + ".done")) ? 0.25 : 0.0;
                                            progress.update(done, fs::exists(folder / "log.simpleFoam") ? "solving" : "meshing");
                                        }});
    {
        std::ifstream notes(folder / "log.Allrun");
        for (std::string line; std::getline(notes, line);) {
            if (line.rfind("note: ", 0) == 0) log_warning("OpenFOAM: " + line.substr(6));
            if (line.rfind("simpleFoam goes on", 0) == 0) log_info("{}", line);
            if (line.rfind("note: mpirun", 0) == 0) result.processes = 1;
        }
    }
    result.wall_time_s = end.wall_time_s;
    result.peak_memory_bytes = end.peak_memory_bytes;
    const bool solver_ran = fs::exists(folder / "log.simpleFoam.done");
    if (!fs::exists(folder / "log.surfaceCheck.done"))
        throw UserError("OpenFOAM cannot use the surface: " + tail(folder / "log.Allrun", 1),
                        {.where = (folder / "log.surfaceCheck").string()});
    if (!fs::exists(folder / "log.checkMesh")) reject(fmt::format("meshing failed (exit code {})", end.exit_code), folder / "log.Allrun");
    judge_mesh(scene, config, folder, result);
    if (!solver_ran)
        reject(fmt::format("the solver failed (exit code {})", end.exit_code), folder / "log.Allrun",
               "lower relaxation_velocity and relaxation_pressure");
    judge_flow(scene, config, folder, result);
    return result;
}

}  // namespace

std::array<int, 3> background_cells(const Container& container, const Section& section, double cell_size_m) {
    return background_block(container, section, cell_size_m).cells;
}

Vec3 find_pore_point(const PhaseImage& image, const Container& container) {
    const Drive drive{.axis = 2, .periodic = container.periodic};
    std::vector<std::uint8_t> reached(image.grid.size(), 0);
    const Percolation percolation = find_percolating_cells(image, drive);
    for (const std::int32_t cell : percolation.cells) reached[static_cast<std::size_t>(cell)] = 1;
    // Distance in steps from everything that is not reached by flow, layer by layer.
    std::vector<std::size_t> front, next;
    std::vector<std::uint8_t> seen(image.grid.size(), 0);
    for (std::size_t cell = 0; cell < image.grid.size(); ++cell) {
        const auto at = place_in_grid(image.grid, cell);
        bool edge = false;
        for (std::size_t a = 0; a < 3; ++a) edge = edge || at[a] == 0 || at[a] == image.grid.cells[a] - 1;
        if (reached[cell] == 1 && !edge) continue;
        seen[cell] = 1;
        front.push_back(cell);
    }
    auto deepest = static_cast<std::size_t>(percolation.cells.back());  // for images that are all edge
    while (!front.empty()) {
        next.clear();
        for (const std::size_t cell : front)
            for (int q = 0; q < 6; ++q) {
                auto at = place_in_grid(image.grid, cell);
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
    const auto at = place_in_grid(image.grid, deepest);
    const double h = image.grid.spacing_m[0];
    return {image.grid.centre(0, at[0]) + 0.0131 * h, image.grid.centre(1, at[1]) + 0.0173 * h, image.grid.centre(2, at[2]) + 0.0119 * h};
}

FoamResult foam_permeability(const FoamScene& scene, const FoamConfig& config, double cell_size_m, const Path& cases, const Path& folder) {
    for (const char* program : {"blockMesh", "snappyHexMesh", "checkMesh", "simpleFoam", "surfaceCheck"})
        require_program(program, "openfoam");
    const auto& periodic = scene.container.periodic;
    if (scene.container.any_periodic() && !(periodic[0] && periodic[1] && periodic[2]))
        throw UserError("OpenFOAM runs take a box that is periodic in all directions or in none",
                        {.mend = "use the lattice Boltzmann solver: porepack lbm"});
    FoamResult result;
    make_folder(folder);
    fs::copy_file(cases / "runFunctions", folder / "runFunctions", fs::copy_options::overwrite_existing);
    // The coarser meshes beside the finest: each keeps one core busy.
    auto coarser = std::async(config.meshes > 1 ? std::launch::async : std::launch::deferred, [&] {
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
        std::vector<double> cells, values;
        for (const FoamMeshResult& mesh : result.meshes) {
            cells.push_back(static_cast<double>(mesh.cells));
            values.push_back(mesh.permeability_m2);
        }
        result.extrapolation = extrapolate_meshes(cells, values);
        result.permeability_m2 = result.extrapolation->value;
    }
    return result;
}

FoamExtrapolation extrapolate_meshes(std::span<const double> cells, std::span<const double> values) {
    const std::size_t n = cells.size();
    const double k = values[n - 1], change = k - values[n - 2], ratio = std::cbrt(cells[n - 1] / cells[n - 2]);
    const auto with_order = [&](double order) { return k + change / (std::pow(ratio, order) - 1.0); };
    const auto between_orders = [&](double low, double high) {
        return Interval{std::min(with_order(low), with_order(high)), std::max(with_order(low), with_order(high))};
    };
    if (n == 2) return {with_order(1.5), between_orders(1.0, 2.0), std::nullopt, std::nullopt};
    const double before = values[1] - values[0];
    if (!(before * change > 0.0)) {
        const double half = 3.0 * std::max(std::abs(before), std::abs(change));
        return {k, {k - half, k + half}, std::nullopt, half / k};
    }
    // (k2 - k1)/(k3 - k2) = (s1^p - s2^p)/(s2^p - s3^p) grows with p.
    const double coarser = std::cbrt(cells[1] / cells[0]);
    const auto changes = [&](double p) { return (std::pow(coarser, p) - 1.0) / (1.0 - std::pow(ratio, -p)); };
    double low = 0.05, high = 8.0;
    while (high - low > 1e-9) (changes(0.5 * (low + high)) < before / change ? low : high) = 0.5 * (low + high);
    // The scheme is of second order; meshes that are too coarse for the asymptotic range show others, and tell little more than the
    // direction.
    const bool plausible = low >= 1.5 && low <= 2.5;
    const double order = plausible ? low : 2.0, spread = plausible ? 0.5 : 1.0;
    FoamExtrapolation found{with_order(order), between_orders(order - spread, order + spread), low, std::nullopt};
    found.grid_convergence_index = (plausible ? 1.25 : 3.0) * std::abs(found.value / k - 1.0);
    found.interval.low = std::min(found.interval.low, 0.995 * found.value);
    found.interval.high = std::max(found.interval.high, 1.005 * found.value);
    return found;
}

}  // namespace porepack
