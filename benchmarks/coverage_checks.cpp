// Checks of the references of the coverage on random packings: other walls, another grid position, OpenFOAM, and wider beds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/coverage_rows.hpp"
#include "benchmarks/random_beds.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "lbm/permeability.hpp"
#include "openfoam/foam.hpp"

namespace porepack::benchmarks {
namespace {

constexpr int lattice_beds[] = {0, 24, 1, 25, 2, 26, 3, 27};
constexpr int foam_beds[] = {1, 4, 26};  // open enough for cells of a sixth of a diameter
constexpr int wide_beds[] = {0, 1};
constexpr double wide_diameters = 12.0, wide_nodes = 2e7;

struct Check {
    std::string name;
    int bed = 0;
    double value_m2 = 0.0, half_width = 0.0;  ///< half width relative
    Reference reference;
    double seconds = 0.0;
};

const std::vector<std::string> columns = {"check",      "bed",    "permeability_m2", "half_width", "reference_m2", "reference_half_width",
                                          "difference", "seconds"};

void write_checks(const Path& file, const std::vector<Check>& checks) {
    Table table(columns);
    for (const Check& c : checks)
        table.add(c.name, c.bed, c.value_m2, c.half_width, c.reference.value_m2, c.reference.half_width,
                  c.value_m2 / c.reference.value_m2 - 1.0, c.seconds);
    table.write(file);
}

std::vector<Check> read_checks(const Path& file) {
    std::vector<Check> checks;
    if (!std::filesystem::exists(file)) return checks;
    for (const auto& f : read_text_table(file).rows)
        checks.push_back({.name = f.at(0),
                          .bed = std::stoi(f.at(1)),
                          .value_m2 = std::stod(f.at(2)),
                          .half_width = std::stod(f.at(3)),
                          .reference = {std::stod(f.at(4)), std::stod(f.at(5))},
                          .seconds = std::stod(f.at(7))});
    return checks;
}

Reference reference_of(const LbmResult& result, const PoreSpace& space) {
    CoverageRow row;
    last_grids(result, space, row.reference_nodes, row.references_m2);
    row.reference_other_half_width = other_half_width(result);
    return benchmarks::reference_of(row);
}

void set(Check& check, const Reference& found) {
    check.value_m2 = found.value_m2;
    check.half_width = found.half_width;
}

// Walls half-way between nodes converge with order 1 from many nodes on: the interval of the solver.
void bounce_back(Check& check, const RandomBed& bed) {
    const PoreSpace space = pore_space_of(bed, 0);
    const double pores = space.porosity(4000).value * space.container.inner_area_m2() *
                         (space.container.periodic()[2] ? space.section.length() : space.computed().length());
    const LbmResult found = lbm_permeability(space, std::cbrt(pores / reference_nodes),
                                             {.walls = Walls::bounce_back, .iteration_tolerance = 2e-4, .grids = 2, .grid_ratio = 1.35});
    set(check, {found.permeability_m2, found.half_width.value().sum() / found.permeability_m2});
}

void by_openfoam(Check& check, const RandomBed& bed, const Path& folder) {
    const PoreSpace space = pore_space_of(bed, 0);
    const double cell = space.grain_size_m / 6.0;
    const FoamScene scene = foam_scene(space, {.deviation_m = 0.005 * space.grain_size_m}, 2.0 * cell);
    const FoamResult found = foam_permeability(scene, {.meshes = 2}, cell, data_file("openfoam_cases"), folder);
    set(check, {found.permeability_m2,
                found.extrapolation ? 0.5 * (found.extrapolation->interval.high - found.extrapolation->interval.low) / found.permeability_m2
                                    : 0.0});
}

// A run with a tolerance, as a user would, against a reference of its own.
void wide(Check& check, int bed, const Path& folder) {
    const PoreSpace space = pore_space_of(random_bed(bed, folder, wide_diameters), 0);
    check.reference = reference_of(reference_run(space, wide_nodes), space);
    const LbmResult found = lbm_permeability(space, 0.0, {.tolerance = 0.02});
    set(check, {found.permeability_m2, found.half_width.value().sum() / found.permeability_m2});
}

}  // namespace

Json coverage_checks_benchmark(const Path& rows_file, const Path& file, const Path& given) {
    const Path folder = given.empty() ? Path("coverage_beds") : given;
    const std::vector<CoverageRow> rows = read_rows(rows_file);
    std::vector<Check> checks = read_checks(file);
    const auto compute = [&](const char* name, int bed, const auto& work) {
        if (std::any_of(checks.begin(), checks.end(), [&](const Check& c) { return c.name == name && c.bed == bed; })) return;
        Check check{.name = name, .bed = bed};
        const auto row = std::find_if(rows.begin(), rows.end(), [&](const CoverageRow& r) { return r.bed == bed; });
        if (row != rows.end()) check.reference = benchmarks::reference_of(*row);
        const Stopwatch watch;
        work(check);
        check.seconds = watch.seconds();
        checks.push_back(check);
        write_checks(file, checks);
        log_info("{} on bed {}: {:+.2f} % (half widths {:.2f} and {:.2f} %), {:.0f} s", name, bed,
                 100.0 * (check.value_m2 / check.reference.value_m2 - 1.0), 100.0 * check.half_width, 100.0 * check.reference.half_width,
                 check.seconds);
    };
    for (const int bed : lattice_beds) {
        compute("another grid position", bed, [&](Check& check) {
            const PoreSpace space = pore_space_of(random_bed(bed, folder), 1);
            set(check, reference_of(reference_run(space, reference_nodes), space));
        });
        compute("bounce-back", bed, [&](Check& check) { bounce_back(check, random_bed(bed, folder)); });
    }
    for (const int bed : wide_beds) compute("12 diameters wide", bed, [&](Check& check) { wide(check, bed, folder); });
    for (const int bed : foam_beds)
        compute("OpenFOAM", bed, [&](Check& check) { by_openfoam(check, random_bed(bed, folder), folder / fmt::format("foam_{}", bed)); });
    std::map<std::string, std::vector<double>> differences;
    for (const Check& check : checks) differences[check.name].push_back(check.value_m2 / check.reference.value_m2 - 1.0);
    return {{"differences", differences}};
}

}  // namespace porepack::benchmarks
