// Lattice Boltzmann: steps, and error against seconds.
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "benchmarks/lbm_speed.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "pore_space/pore_space.hpp"
#include "report/plot.hpp"
#include "support/known_flows.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Kind {
    const char* name;
    Walls walls;
    Collision collision;
    long grids;
    double relaxation_time;
};

// Steps and seconds to the same iteration error on a bed in a cylinder between pressure planes.
Json convergence_rows() {
    const PoreSpace bed = pore_space_of(overlapping_spheres("cylinder:1,1", 0.5, 0.08)).with_section({0.0, 1.0});
    Json rows = Json::array();
    double reference = 0.0;
    for (const Kind& kind : {Kind{"the paper's: BGK, viscosity 0.03, from rest", Walls::bounce_back, Collision::bgk, 1, 0.0},
                             {"TRT, viscosity 0.03, from rest", Walls::interpolated, Collision::trt, 1, 0.59},
                             {"TRT, viscosity 0.23, from rest", Walls::interpolated, Collision::trt, 1, 1.2},
                             {"TRT, best viscosity, from coarser grids", Walls::interpolated, Collision::trt, 3, 0.0}}) {
        const LbmResult result = lbm_permeability(bed, 1.0 / 112,
                                                  {.walls = kind.walls,
                                                   .collision = kind.collision,
                                                   .relaxation_time = kind.relaxation_time,
                                                   .iteration_tolerance = 1e-4,
                                                   .grids = kind.grids});
        const auto steps = static_cast<double>(result.fine().run.steps);
        if (reference == 0.0) reference = steps;
        rows.push_back({{"scheme", kind.name},
                        {"fluid_nodes", result.fine().nodes},
                        {"steps", steps},
                        {"times_fewer", reference / steps},
                        {"seconds", result.fine().run.seconds},
                        {"relaxation_time", result.fine().relaxation_time}});
    }
    return rows;
}

// Error of k against the exact drag of simple cubic spheres, and the seconds needed.
Json accuracy_rows() {
    const KnownFlow known = sphere_array(0.343, 15.39949, simple_cubic(), Vec3(0.21, 0.37, 0.11));
    Json rows = Json::array();
    const auto add = [&](const std::string& name, double nodes, const LbmResult& result, double seconds) {
        rows.push_back({{"scheme", name},
                        {"nodes_per_diameter", nodes},
                        {"error", result.permeability_m2 / known.permeability_m2 - 1.0},
                        {"seconds", seconds},
                        {"steps", result.fine().run.steps}});
    };
    for (const Kind& kind : {Kind{"interpolated walls", Walls::interpolated, Collision::trt, 1, 0.0},
                             {"bounce-back", Walls::bounce_back, Collision::trt, 1, 0.0},
                             {"the paper's: BGK, viscosity 0.03", Walls::bounce_back, Collision::bgk, 1, 0.0}})
        for (const int cells : {12, 23, 46, 92}) {
            if (cells > 46 && kind.collision == Collision::bgk) continue;  // minutes
            const Stopwatch watch;
            const LbmResult result =
                lbm_permeability(known.space(), 1.0 / cells,
                                 {.walls = kind.walls, .collision = kind.collision, .iteration_tolerance = 1e-4, .grids = kind.grids});
            add(kind.name, known.diameter_m * cells, result, watch.seconds());
        }
    for (const double tolerance : {0.05, 0.02, 0.01, 0.005, 0.0025}) {
        const Stopwatch watch;
        const LbmResult result = lbm_permeability(known.space(), 0.1, {.tolerance = tolerance});
        add("a tolerance", known.diameter_m / result.fine().voxel_size_m, result, watch.seconds());
        rows.back()["tolerance"] = tolerance;
    }
    return rows;
}

void draw_error_against_seconds(const Json& rows, const Path& folder) {
    std::string data;
    std::vector<std::string> names;
    for (const Json& row : rows) {
        const auto name = row["scheme"].get<std::string>();
        if (names.empty() || names.back() != name) {
            data += fmt::format("{}\"{}\"\n", names.empty() ? "" : "\n\n", name);
            names.push_back(name);
        }
        data += fmt::format("{:.6g} {:.6g}\n", row["seconds"].get<double>(), std::abs(100.0 * row["error"].get<double>()));
    }
    write_text(folder / "error_against_seconds.dat", data);
    draw_plot(folder / "error_against_seconds.svg", "error_against_seconds", {{"schemes", static_cast<double>(names.size())}});
}

}  // namespace

Json lbm_benchmark(bool quick, const Path& folder) {
    Json speed = Json::array();
    for (const double porosity : {0.4, 0.7})
        for (const Json& row : lbm_speed_rows(porosity, quick ? 2e6 : 1e7)) speed.push_back(row);
    if (quick) return {{"speed", speed}};
    const Json accuracy = accuracy_rows();
    if (!folder.empty()) draw_error_against_seconds(accuracy, folder);
    return {{"speed", speed}, {"convergence", convergence_rows()}, {"accuracy", accuracy}};
}

}  // namespace porepack::benchmarks
