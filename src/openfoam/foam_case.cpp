#include "openfoam/foam_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"
#include "geometry/triangle_wall.hpp"
#include "openfoam/uses.hpp"
#include "record/digest.hpp"

namespace porepack::openfoam {
namespace fs = std::filesystem;
namespace {

void write_if_different(const Path& file, const std::string& text) {
    if (!fs::exists(file) || read_text(file) != text) write_text(file, text);
}

void copy_if_different(const Path& from, const Path& to) {
    make_folder(to.parent_path());
    if (!fs::exists(to) || read_text(to) != read_text(from)) fs::copy_file(from, to, fs::copy_options::overwrite_existing);
}

}  // namespace

FoamBlock background_block(const Container& container, const Section& section, double cell) {
    FoamBlock block{container.low(), container.high(), {}};
    block.low.z() = section.z0_m;
    block.high.z() = section.z1_m;
    for (int axis = 0; axis < 3; ++axis) {
        const double extent = block.high[axis] - block.low[axis];
        int count = std::max(1, static_cast<int>(std::lround(extent / cell)));
        if (!container.vessel().fills_bounds() && axis < 2) {
            // An even number of cells about the axis: the mesh of a cylinder is symmetric, with at least one cell beyond the wall on each
            // side.
            count = 2 * static_cast<int>(std::ceil(extent / (2.0 * cell))) + 2;
            const double middle = 0.5 * (block.low[axis] + block.high[axis]);
            block.low[axis] = middle - 0.5 * count * cell;
            block.high[axis] = middle + 0.5 * count * cell;
        }
        block.cells[static_cast<std::size_t>(axis)] = count;
    }
    return block;
}

std::string common_parameters(const FoamScene& scene, const FoamConfig& config, double cell, long processes) {
    const FoamBlock block = background_block(scene.container, scene.section, cell);
    const Vec3& p = scene.pore_point;
    std::string text = "// Written by porepack; metres, seconds.\n";
    text += fmt::format("xMin {:.12g}; xMax {:.12g}; yMin {:.12g}; yMax {:.12g}; zMin {:.12g}; zMax {:.12g};\n", block.low.x(),
                        block.high.x(), block.low.y(), block.high.y(), block.low.z(), block.high.z());
    text += fmt::format("nx {}; ny {}; nz {};\nsurfaceLevel {};\n", block.cells[0], block.cells[1], block.cells[2], config.surface_level);
    text += fmt::format("locationInMesh ({:.12g} {:.12g} {:.12g});\n", p.x(), p.y(), p.z());
    text += fmt::format("relaxationU {:g}; relaxationP {:g};\nresidual {:g};\nmaxIterations {};\nprocesses {};\n",
                        config.relaxation_velocity, config.relaxation_pressure, config.residual, config.max_iterations, processes);
    return text;
}

std::string wall_parameters(const FoamScene& scene) {
    const Container& container = scene.container;
    const double length = scene.section.length(), low = scene.section.z0_m - length, high = scene.section.z1_m + length;
    std::string walls, levels;
    const auto add = [&](const char* name, const std::string& surface) {
        walls += fmt::format("    {} {{ {} }}\n", name, surface);
        levels += fmt::format("    {} {{ level ($surfaceLevel $surfaceLevel); patchInfo {{ type wall; }} }}\n", name);
    };
    const auto cylinder = [](double radius) {
        return fmt::format("type searchableCylinder; point1 (0 0 -1e3); point2 (0 0 1e3); radius {:.12g};", radius);
    };
    const auto around = container.vessel().walls();
    if (container.vessel().fills_bounds() || !around)
        add("wall", cylinder(2.0 * container.low().norm() + 2.0 * container.high().norm()));  // wider than the block
    else if (around->mesh != nullptr)
        add("wall", "type triSurfaceMesh; file \"vessel.stl\";");
    else
        for (const auto& wall : around->round) {
            const char* name = wall.inside ? "core" : "wall";
            if (wall.slope == 0.0) {
                add(name, cylinder(wall.radius_m));
                continue;
            }
            // Its tip, if it lies within reach, is no end of the surface.
            const double tip = -wall.radius_m / wall.slope, gap = 0.01 * length, z0 = wall.slope > 0.0 ? std::max(low, tip + gap) : low,
                         z1 = wall.slope < 0.0 ? std::min(high, tip - gap) : high;
            add(name, fmt::format("type searchableCone; point1 (0 0 {:.12g}); radius1 {:.12g}; innerRadius1 0; point2 (0 0 {:.12g}); "
                                  "radius2 {:.12g}; innerRadius2 0;",
                                  z0, wall.radius_m + wall.slope * z0, z1, wall.radius_m + wall.slope * z1));
        }
    return "walls\n{\n" + walls + "}\nwallLevels\n{\n" + levels + "}\n";
}

void prepare_foam_case(const FoamScene& scene, const std::string& parameters, const Path& source, const Path& folder) {
    // Only the case, not files that an earlier run by hand left in its folder.
    make_folder(folder / "constant" / "triSurface");
    for (const char* part :
         {"Allrun", "Allclean", "README.md", "0.orig/U", "0.orig/p", "constant/transportProperties", "constant/turbulenceProperties"})
        copy_if_different(source / part, folder / part);
    for (const auto& entry : fs::directory_iterator(source / "system"))
        if (entry.path().filename() != "caseParameters") copy_if_different(entry.path(), folder / "system" / entry.path().filename());
    write_if_different(folder / "system" / "caseParameters", parameters);
    const auto write_surface = [&](const char* name, const TriangleSurface& triangles) {
        const Path surface = folder / "constant" / "triSurface" / name, fresh = folder / name;
        write_stl(fresh, triangles, "porepack; unit: metre");
        if (fs::exists(surface) && sha256_of_file(surface) == sha256_of_file(fresh))
            fs::remove(fresh);
        else
            fs::rename(fresh, surface);
    };
    write_surface("solid.stl", scene.surface);
    const auto walls = scene.container.vessel().walls();
    if (!walls || walls->mesh == nullptr) return;
    const double length = scene.section.length();
    const TriangleMesh sides = walls->mesh->sides(scene.section.z0_m - length, scene.section.z1_m + length);
    TriangleSurface triangles{.points = {}, .triangles = sides.triangles};
    for (const Vec3& point : sides.points_m) triangles.points.push_back({point.x(), point.y(), point.z()});
    write_surface("vessel.stl", triangles);
}

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

std::vector<double> read_series(const Path& object, const char* file, int column) {
    std::map<double, Path> starts;
    if (fs::exists(object))
        for (const auto& entry : fs::directory_iterator(object)) starts[std::atof(entry.path().filename().c_str())] = entry.path() / file;
    std::map<double, double> by_time;
    for (const auto& [start, path] : starts) {
        // A resumed run begins at an earlier time than the last one that was written: what follows is computed again.
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

void reject_foam(const std::string& what, const Path& log, const std::string& fix) {
    throw EngineError("OpenFOAM: " + what + "\n" + tail(log, 12), {.where = log.string(), .fix = fix});
}

void judge_foam_mesh(const FoamScene& scene, const FoamConfig& config, const Path& folder, FoamMeshResult& result) {
    const Path log = folder / "log.checkMesh";
    // The case's own Allrun evaluates checkMesh (runFunctions), and stops when the mesh is unfit.
    if (!fs::exists(folder / "log.simpleFoam") && !fs::exists(folder / "drops"))
        reject_foam("the mesh fails checkMesh", log, "change cell_size_m slightly");
    if (last_number(log, "***Max skewness = ")) result.skew_faces = std::lround(last_number(log, "<<Writing ").value_or(0.0));
    const auto cells = last_number(log, "    cells:"), volume = last_number(log, "Total volume = "),
               slant = last_number(log, "Mesh non-orthogonality Max:"), regions = last_number(log, "*Number of regions:");
    if (!cells || !volume || *cells < 1.0) reject_foam("the mesh has no cells", log, "check locationInMesh and the surface");
    if (regions && *regions > 1.0) reject_foam("the mesh has more than one region", log, "check the surface");
    result.cells = std::lround(*cells);
    result.max_non_orthogonality = slant.value_or(0.0);
    result.mesh_volume_ratio = *volume / scene.pore_volume_m3;
    // A mesh may cut corners, and omit gaps between grains that are narrower than two of its cells.
    const double coarse = result.cell_size_m / scene.grain_size_m;
    result.narrow_pores = scene.pores ? narrow_pores(*scene.pores, result.cell_size_m / std::exp2(config.surface_level)) : 0.0;
    const double allowed = 0.015 + 0.3 * coarse * coarse + result.narrow_pores;
    if (std::abs(result.mesh_volume_ratio - 1.0) > allowed)
        reject_foam(
            fmt::format("the mesh lost or invented pore space: its volume is {:.4f} of the exact one, {:.4f} is allowed at this cell size",
                        result.mesh_volume_ratio, allowed),
            log, "use smaller cells, or check that the surface is closed and at the right position");
}

std::string meshing_phase(const Path& folder) {
    const Path log = folder / "log.snappyHexMesh";
    if (!fs::exists(log)) return "meshing";
    std::string phase = "meshing: surface";
    std::ifstream in(log);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("Refinement phase")) phase = "meshing: refinement";
        if (line.starts_with("Morphing phase")) phase = "meshing: snapping to the surface";
        if (line.starts_with("Checking final mesh")) phase = "meshing: check";
        if (const auto cells = line.find(" : cells:"); cells != std::string::npos && line.starts_with("After refinement"))
            phase = "meshing: refinement, " + line.substr(cells + 9, line.find(' ', cells + 9) - cells - 9) + " cells";
    }
    return phase;
}

FoamState solving_state(const Path& folder, double residual) {
    std::vector<double> logs, seconds;
    std::ifstream in(folder / "log.simpleFoam");
    constexpr std::string_view of_p = "Solving for p, Initial residual = ", of_time = "ExecutionTime = ";
    for (std::string line; std::getline(in, line);) {
        if (const auto at = line.find(of_p); at != std::string::npos) logs.push_back(std::log(std::atof(line.c_str() + at + of_p.size())));
        if (line.starts_with(of_time)) seconds.push_back(std::atof(line.c_str() + of_time.size()));
    }
    FoamState state{std::nullopt, fmt::format("solving, iteration {}", seconds.size())};
    const std::size_t n = std::min(logs.size(), seconds.size()), half = n / 2;
    if (n < 10) return state;
    // The second half of the iterations alone: at first the residual does not fall steadily.
    const double fall = (logs[half] - logs[n - 1]) / static_cast<double>(n - 1 - half);
    if (fall <= 0.0) return state;
    const double iterations = std::max(0.0, (logs[n - 1] - std::log(residual)) / fall);
    state.seconds_left = iterations * (seconds[n - 1] - seconds[0]) / static_cast<double>(n - 1);
    return state;
}

ProgramEnd run_foam_case(const Path& folder, const char* label, const std::function<FoamState()>& state, FoamMeshResult& result) {
    Progress progress(label);
    Stopwatch since;  // the logs are long: they are read every two seconds
    ProgramEnd end = run_program({.command = {"bash", "./Allrun"},
                                  .folder = folder,
                                  .log = folder / "log.Allrun",
                                  .environment = {{"WM_PROJECT_DIR", "/usr/share/openfoam"}},
                                  .while_running = [&] {
                                      if (since.seconds() < 2.0) return;
                                      since = {};
                                      const auto [left, text] = state();
                                      progress.update_left(left, text);
                                  }});
    std::ifstream notes(folder / "log.Allrun");
    for (std::string line; std::getline(notes, line);) {
        if (line.rfind("note: ", 0) == 0) log_warning("OpenFOAM: " + line.substr(6));
        if (line.rfind("simpleFoam resumes", 0) == 0) log_info("{}", line);
        if (line.rfind("note: mpirun", 0) == 0) result.processes = 1;
    }
    result.wall_time_s = end.wall_time_s;
    result.peak_memory_bytes = end.peak_memory_bytes;
    if (!fs::exists(folder / "log.surfaceCheck.done"))
        reject_foam("it cannot use the surface: " + tail(folder / "log.Allrun", 1), folder / "log.surfaceCheck",
                    "change surface_deviation_m slightly, or repair the surface of the STL file");
    if (!fs::exists(folder / "log.checkMesh"))
        reject_foam(fmt::format("meshing failed (exit code {})", end.exit_code), folder / "log.Allrun");
    return end;
}

}  // namespace porepack::openfoam
