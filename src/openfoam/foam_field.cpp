#include "openfoam/foam_field.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "core/process.hpp"
#include "openfoam/uses.hpp"

namespace porepack::openfoam {
namespace fs = std::filesystem;
namespace {

// The last time folder after `last`.
Path last_time(const Path& folder, double last) {
    Path found;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (!entry.is_directory() || name.find_first_not_of("0123456789.") != std::string::npos) continue;
        if (const double time = std::stod(name); time > last) {
            last = time;
            found = entry.path();
        }
    }
    if (found.empty()) throw EngineError("OpenFOAM has written no time folder", {.where = folder.string()});
    return found;
}

// The numbers of a field's interior, binary (64 bit) or as text.
std::vector<double> read_interior(const Path& file, const std::string& type, std::size_t components) {
    const std::string text = read_text(file);
    const std::string mark = "nonuniform List<" + type + ">";
    const auto at = text.find(mark), open = text.find('(', at);
    const bool as_text = text.find("ascii;") < at;
    if (at == std::string::npos || open == std::string::npos || (!as_text && text.find("scalar=64") == std::string::npos))
        throw EngineError("cannot read this OpenFOAM field",
                          {.where = file.string(), .fix = "writeFormat ascii or binary in system/controlDict"});
    const auto cells = static_cast<std::size_t>(std::stol(text.substr(at + mark.size())));
    std::vector<double> numbers(cells * components);
    if (as_text) {
        const char* place = text.c_str() + open + 1;
        for (double& number : numbers) {
            while (*place == '(' || *place == ')' || std::isspace(static_cast<unsigned char>(*place)) != 0) ++place;
            char* end = nullptr;
            number = std::strtod(place, &end);
            if (end == place) throw EngineError("an OpenFOAM field is truncated", {.where = file.string()});
            place = end;
        }
        return numbers;
    }
    if (open + 1 + numbers.size() * sizeof(double) > text.size())
        throw EngineError("an OpenFOAM field is truncated", {.where = file.string()});
    std::memcpy(numbers.data(), text.data() + open + 1, numbers.size() * sizeof(double));
    return numbers;
}

}  // namespace

std::vector<FoamCell> read_foam_cells(const Path& folder, const Path& fields) {
    const Path time = last_time(folder, fields.empty() ? 0.0 : -1.0), state = fields.empty() ? time : fields,
               log = folder / "log.postProcess";
    const ProgramEnd end = run_program({.command = {"bash", "-c",
                                                    ". ../runFunctions && avoid_odd_path && postProcess -latestTime -funcs "
                                                    "'(writeCellCentres writeCellVolumes)'"},
                                        .folder = folder,
                                        .log = log,
                                        .environment = {{"WM_PROJECT_DIR", "/usr/share/openfoam"}}});
    if (end.exit_code != 0 || !fs::exists(time / "C") || !fs::exists(time / "V"))
        throw EngineError("OpenFOAM: postProcess failed\n" + tail(log, 12), {.where = log.string()});
    const auto centres = read_interior(time / "C", "vector", 3), velocities = read_interior(state / "U", "vector", 3),
               pressures = read_interior(state / "p", "scalar", 1), volumes = read_interior(time / "V", "scalar", 1);
    for (const char* made : {"C", "Cx", "Cy", "Cz", "V"}) fs::remove(time / made);
    if (centres.size() != 3 * volumes.size() || velocities.size() != 3 * volumes.size() || pressures.size() != volumes.size())
        throw EngineError("OpenFOAM's fields differ in size", {.where = time.string()});
    std::vector<FoamCell> cells;
    cells.reserve(volumes.size());
    for (std::size_t i = 0; i < volumes.size(); ++i)
        cells.push_back({{centres[3 * i], centres[3 * i + 1], centres[3 * i + 2]},
                         {velocities[3 * i], velocities[3 * i + 1], velocities[3 * i + 2]},
                         pressures[i],
                         volumes[i]});
    return cells;
}

double plane_pressure(std::span<const FoamCell> cells, double z_m, double reach_m) {
    double weights = 0.0, z1 = 0.0, z2 = 0.0, p1 = 0.0, pz = 0.0;
    for (const FoamCell& cell : cells) {
        const double z = (cell.centre_m.z() - z_m) / reach_m;
        if (std::abs(z) > 1.0) continue;
        const double weight = cell.volume_m3 * cell.velocity.z();
        weights += weight;
        z1 += weight * z;
        z2 += weight * z * z;
        p1 += weight * cell.pressure;
        pz += weight * cell.pressure * z;
    }
    const double spread = weights * z2 - z1 * z1;
    if (!(spread > 0.0))
        throw NumericalError(fmt::format("no cells with flow at the plane z = {:g} m", z_m),
                             {.fix = "use smaller cells (foam.cell_size_m), or a section whose planes lie inside the meshed bed"});
    return (z2 * p1 - z1 * pz) / spread;
}

FoamTortuosity hydraulic_tortuosity(std::span<const FoamCell> cells, const Section& section) {
    double speed = 0.0;
    Vec3 mean = Vec3::Zero();
    for (const FoamCell& cell : cells) {
        if (cell.centre_m.z() < section.z0_m || cell.centre_m.z() > section.z1_m) continue;
        speed += cell.volume_m3 * cell.velocity.norm();
        mean += cell.volume_m3 * cell.velocity;
    }
    int axis = 2;
    const double along = mean.cwiseAbs().maxCoeff(&axis);
    if (!(along > 0.0))
        throw NumericalError("nothing flows in this OpenFOAM case",
                             {.fix = "check that the solver has run (log.simpleFoam) and that the section lies inside the mesh"});
    return {.axis = static_cast<Axis>(axis), .value = speed / along};
}

}  // namespace porepack::openfoam
