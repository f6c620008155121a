// Lattice Boltzmann: speed, steps, error against seconds.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

#include "benchmarks/benchmarks.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "lbm/known.hpp"
#include "report/plot.hpp"

namespace porepack::benchmarks {
using namespace core;
using namespace shapes;
using namespace packing;
using namespace converters;
using namespace lbm;
using namespace report;
namespace {

// Bytes per second of a[i] *= s: upper limit for populations that are streamed in place. Best of four.
double in_place_bytes_per_second() {
    static std::vector<double> a(100'000'000, 1.0);
    double best = 1e300;
    for (int round = 0; round < 4; ++round) {
        const Stopwatch watch;
#pragma omp parallel for simd schedule(static)
        for (std::size_t i = 0; i < a.size(); ++i) a[i] *= 1.0000001;
        best = std::min(best, watch.seconds());
    }
    return 16.0 * static_cast<double>(a.size()) / best;
}

// Spheres that overlap at random.
Packing random_spheres(const std::string& container, double porosity, double radius) {
    Packing packing{.container = parse_container(container),
                    .shapes = {{.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), radius}}}},
                    .bodies = {}};
    std::mt19937 random(1);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
    const Vec3 low = packing.container.low(), size = packing.container.high() - low;
    const double volume = 4.0 * std::numbers::pi * radius * radius * radius / 3.0;
    for (long i = std::lround(-std::log(porosity) / volume * size.prod()); i > 0; --i) {
        const double x = unit(), y = unit(), z = unit();
        packing.bodies.push_back({.shape = 0, .position_m = low + Vec3(x, y, z).cwiseProduct(size)});
    }
    return packing;
}

double best_rate(Flow& flow, std::size_t nodes) {
    double best = 1e300;
    constexpr int pairs = 10;
    for (int round = 0; round < 4; ++round) {
        const Stopwatch watch;
        for (int i = 0; i < pairs; ++i) flow.advance_two_steps();
        best = std::min(best, watch.seconds());
    }
    return 2.0 * pairs * static_cast<double>(nodes) / best;
}

// Speed on spheres of 40 nodes in a periodic box, against the memory bandwidth limit measured in the same run.
Json speed_rows(double porosity, int cells, bool scaling) {
    const Packing packing = random_spheres("box:1,1,1:periodic", porosity, 20.0 / cells);
    const Grains grains(packing);
    const Section section{0.0, 1.0};
    const FlowWalls walls{grains, packing.container, section};
    Stopwatch watch;
    const Domain domain =
        build_domain(voxelise(grains, packing.container, section, plan_voxels(packing.container, section, 1.0 / cells, {}, 1.0)),
                     choose_drive(packing.container, Axis::z), &walls);
    const double domain_seconds = watch.seconds();
    const int threads = thread_count();
    Json rows = Json::array();
    for (const Walls kind : {Walls::bounce_back, Walls::interpolated})
        for (const Kernel kernel : {Kernel::cpu_double, Kernel::cpu_single}) {
            const Scheme scheme{.walls = kind, .force = {0, 0, 1e-3}};
            watch = {};
            const auto flow = make_flow(kernel, domain, scheme);
            const double set_up = watch.seconds(), bytes_an_update = 2.0 * 19.0 * (kernel == Kernel::cpu_double ? 8.0 : 4.0);
            const double before = in_place_bytes_per_second(), rate = best_rate(*flow, domain.nodes());
            const double limit = std::max(before, in_place_bytes_per_second());
            rows.push_back({{"porosity", porosity},
                            {"walls", kind == Walls::interpolated ? "interpolated" : "bounce_back"},
                            {"precision", kernel == Kernel::cpu_double ? "double" : "single"},
                            {"fluid_nodes", domain.nodes()},
                            {"updates_per_second", rate},
                            {"in_place_bytes_per_second", limit},
                            {"ratio_to_memory_limit", rate * bytes_an_update / limit},
                            {"bytes_per_node", flow->bytes() / static_cast<double>(domain.nodes())},
                            {"set_up_seconds", domain_seconds + set_up}});
            if (!scaling || threads < 2) continue;
            set_thread_count(1);
            const double alone = best_rate(*flow, domain.nodes()), stream_alone = in_place_bytes_per_second();
            set_thread_count(threads);
            rows.back()["speed_up_by_threads"] = rate / alone;
            rows.back()["speed_up_of_stream"] = limit / stream_alone;
        }
    return rows;
}

struct Kind {
    const char* name;
    Walls walls;
    Collision collision;
    long grids;
    double relaxation_time;
};

// Steps and seconds to the same iteration error on a bed in a cylinder between pressure planes.
Json convergence_rows() {
    const PoreSpace bed = pore_space_of(random_spheres("cylinder:1,1", 0.5, 0.08)).with_section({0.0, 1.0});
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
                lbm_permeability(known.pore_space(), 1.0 / cells,
                                 {.walls = kind.walls, .collision = kind.collision, .iteration_tolerance = 1e-4, .grids = kind.grids});
            add(kind.name, known.diameter_m * cells, result, watch.seconds());
        }
    for (const double tolerance : {0.05, 0.02, 0.01, 0.005, 0.0025}) {
        const Stopwatch watch;
        const LbmResult result = lbm_permeability(known.pore_space(), 0.1, {.tolerance = tolerance});
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

Json lbm_benchmark(const Path& folder) {
    Json speed = speed_rows(0.4, 292, true);
    for (const Json& row : speed_rows(0.7, 242, false)) speed.push_back(row);
    const Json accuracy = accuracy_rows();
    if (!folder.empty()) draw_error_against_seconds(accuracy, folder);
    return {{"speed", speed}, {"convergence", convergence_rows()}, {"accuracy", accuracy}};
}

}  // namespace porepack::benchmarks
