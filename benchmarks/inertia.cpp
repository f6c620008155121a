// Flows with inertia that are not steady: which collision is stable at which Reynolds number, and the friction of arrays of spheres.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "lbm/inertia.hpp"
#include "lbm/mean_flow.hpp"
#include "lbm/sequence.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"
#include "support/known_flows.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Array {
    const char* name;
    KnownFlow flow;
};
// The drag is not used.
std::vector<Array> arrays() {
    return {{"simple cubic, touching", sphere_array(std::numbers::pi / 6.0, 42.1005, simple_cubic())},
            {"face-centred cubic, touching", sphere_array(std::numbers::pi / (3.0 * std::numbers::sqrt2), 1.0, face_centred())}};
}

struct Collision {
    const char* name;
    Model model;
    double magic;  ///< 0: one relaxation time
};
constexpr Collision collisions[] = {{"one relaxation time", Model::navier_stokes, 0.0},
                                    {"two relaxation times, Lambda 1/12", Model::navier_stokes, 1.0 / 12.0},
                                    {"two relaxation times, Lambda 1/4", Model::navier_stokes, 0.25},
                                    {"regularised", Model::regularised, 0.0},
                                    {"recursive regularised", Model::recursive, 0.0}};

// Forty turnovers from creeping flow, at about this Reynolds number by the diameter and the superficial velocity.
void try_collisions(const Array& array, double nodes_per_diameter, const std::vector<double>& reynolds, Table& table) {
    const PoreSpace space = array.flow.space();
    const PhaseImage image = space.voxelise_at(array.flow.diameter_m / nodes_per_diameter);
    const Drive drive = choose_drive(space.container, Axis::z);
    const std::optional<FlowWalls> walls = space.walls();
    const Domain domain = build_domain(image, drive, &*walls);
    const double area = static_cast<double>(image.grid.cells[0]) * image.grid.cells[1], layers = image.grid.cells[2],
                 porosity = static_cast<double>(domain.nodes()) / (area * layers);
    for (const Collision& collision : collisions)
        for (const double wanted : reynolds) {
            // Ergun's equation gives the force; the superficial velocity is a fortieth of the speed of sound.
            constexpr double speed = 0.577 / 40.0;
            const double d = array.flow.diameter_m / image.grid.spacing_m[0], viscosity = speed * d / wanted, solid = 1.0 - porosity;
            Scheme scheme{.tau = 0.5 + 3.0 * viscosity, .model = collision.model};
            scheme.magic = collision.magic > 0.0 ? collision.magic : std::pow(scheme.tau - 0.5, 2.0);
            scheme.force[2] = (150.0 * viscosity * solid / (d * d) + 1.75 * speed / d) * speed * solid / std::pow(porosity, 3.0);
            const auto flow = make_flow(Kernel::cpu_double, domain, scheme);
            std::string end = "stable";
            MeanFlow mean;
            try {
                mean = average_in_time(*flow, domain, area,
                                       {.tolerance = 0.05, .turnover_steps = d * porosity / speed, .max_turnovers = 50.0});
            } catch (const FlowDiverged&) {
                end = "diverged";
            }
            table.add(array.name, nodes_per_diameter, collision.name, wanted,
                      end == "stable" ? mean.superficial_velocity_lu * d / viscosity : 0.0, scheme.tau, end,
                      end == "stable" ? mean.fluctuation : 0.0, mean.fastest_lu);
            log_info("{}, {} nodes per diameter, {}: Re {:g} {}", array.name, nodes_per_diameter, collision.name, wanted, end);
        }
}

}  // namespace

Json inertia_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("inertia_study") : output;
    make_folder(folder);
    Table stability({"array", "nodes_per_diameter", "collision", "reynolds_wanted", "reynolds", "relaxation_time", "end", "fluctuation",
                     "fastest_lattice_velocity"});
    Table friction({"array", "nodes_per_diameter", "reynolds", "permeability_m2", "creeping_permeability_m2", "half_width", "steady",
                    "fluctuation", "turnovers", "kinetic_energy_factor", "seconds"});
    for (const Array& array : arrays()) {
        for (const double nodes : quick ? std::vector<double>{24} : std::vector<double>{24, 40})
            try_collisions(array, nodes, {25, 50, 100, 200, 400, 800}, stability);
        stability.write(folder / "stability.csv");
        for (const double nodes : quick ? std::vector<double>{16, 24} : std::vector<double>{24, 36, 54}) {
            const std::vector<double> reynolds = {5, 10, 20, 35, 50, 75, 100, 150, 200, 300, 400, 500};
            const InertialSeries series =
                lbm_inertial_flows(array.flow.space(), array.flow.diameter_m / nodes, reynolds, array.flow.diameter_m,
                                   {.in_time = InertialCriterion::InTime{.tolerance = 0.01, .max_turnovers = quick ? 100.0 : 800.0}});
            for (const InertialFlow& flow : series.flows)
                friction.add(array.name, nodes, flow.reynolds, flow.permeability_m2, series.creeping_permeability_m2,
                             flow.in_time->half_width, flow.in_time->steady ? 1 : 0, flow.in_time->fluctuation, flow.in_time->turnovers,
                             flow.in_time->kinetic_energy_factor, flow.seconds);
            friction.write(folder / "friction.csv");
            if (series.stopped_by) log_info("{}", *series.stopped_by);
        }
    }
    return {{"stability", (folder / "stability.csv").string()}, {"friction", (folder / "friction.csv").string()}};
}

}  // namespace porepack::benchmarks
