#include "apps/benchmark.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/manifest.hpp"
#include "lbm/known.hpp"
#include "packing/grains.hpp"

namespace porepack {
namespace {

// Bytes a second of a[i] *= s: what populations that are moved in place could reach at best. Best of five.
double in_place_bytes_per_second() {
    const std::size_t n = 100'000'000;
    std::vector<double> a(n, 1.0);
    double best = 1e300;
    for (int round = 0; round < 5; ++round) {
        const Stopwatch watch;
#pragma omp parallel for simd schedule(static)
        for (std::size_t i = 0; i < n; ++i) a[i] *= 1.0000001;
        best = std::min(best, watch.seconds());
    }
    return 16.0 * static_cast<double>(n) / best;
}

// Error of k against the exact drag of simple cubic spheres: our walls, bounce-back, and the paper's scheme (BGK, viscosity 0.03,
// bounce-back).
Json accuracy_rows() {
    const KnownFlow known = sphere_array(0.343, 15.39949, simple_cubic);
    struct Kind {
        const char *name, *walls, *collision;
    };
    Json rows = Json::array();
    for (const Kind& kind :
         {Kind{"interpolated", "interpolated", "trt"}, {"bounce-back", "bounce_back", "trt"}, {"paper", "bounce_back", "bgk"}})
        for (const int cells : {12, 23, 46, 92}) {
            const Stopwatch watch;
            const LbmResult result =
                lbm_permeability(known.scene(), 1.0 / cells,
                                 {.walls = kind.walls, .collision = kind.collision, .iteration_tolerance = 1e-4, .grids = 1}, false);
            rows.push_back({{"scheme", kind.name},
                            {"nodes_a_diameter", known.diameter_m * cells},
                            {"error", result.permeability_m2 / known.permeability_m2 - 1.0},
                            {"seconds", watch.seconds()},
                            {"steps", result.fine().run.steps}});
        }
    return rows;
}

// Speed on spheres of 40 nodes that overlap at random in a periodic box, against the memory's limit.
Json speed_rows(double porosity, int cells, double limit_bytes_per_second) {
    const double r = 20.0 / cells;
    Packing packing{.container = parse_container("box:1,1,1:periodic"),
                    .shapes = {{.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), r}}}},
                    .bodies = {}};
    std::mt19937 random(1);
    const double volume = 4.0 * std::numbers::pi * r * r * r / 3.0;
    for (long i = std::lround(-std::log(porosity) / volume); i > 0; --i) {
        const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
        const double x = unit(), y = unit(), z = unit();
        packing.bodies.push_back({.shape = 0, .position_m = {x, y, z}});
    }
    const Grains grains(packing);
    const Section section{0.0, 1.0};
    const FlowWalls walls{grains, packing.container, section};
    Stopwatch watch;
    const Domain domain =
        build_domain(voxelise(grains, packing.container, section, plan_voxels(packing.container, section, 1.0 / cells, 0.0, 1.0)),
                     choose_drive(packing.container, "z"), &walls);
    const double domain_seconds = watch.seconds();
    Json rows = Json::array();
    for (const Walls kind : {Walls::bounce_back, Walls::interpolated})
        for (const Kernel kernel : {Kernel::fast_double, Kernel::fast_single}) {
            const Scheme scheme{.walls = kind, .force = {0, 0, 1e-3}};
            watch = {};
            const auto flow = make_flow(kernel, domain, scheme);
            const double set_up = watch.seconds();
            double best = 1e300;
            constexpr int pairs = 10;
            for (int round = 0; round < 4; ++round) {
                watch = {};
                for (int i = 0; i < pairs; ++i) flow->advance_two_steps();
                best = std::min(best, watch.seconds());
            }
            const double nodes = static_cast<double>(domain.nodes()), rate = 2.0 * pairs * nodes / best;
            const double bytes_an_update = 2.0 * 19.0 * (kernel == Kernel::fast_double ? 8.0 : 4.0);
            rows.push_back({{"porosity", porosity},
                            {"walls", kind == Walls::interpolated ? "interpolated" : "bounce_back"},
                            {"precision", kernel == Kernel::fast_double ? "double" : "single"},
                            {"fluid_nodes", domain.nodes()},
                            {"updates_per_second", rate},
                            {"ratio_to_memory_limit", rate * bytes_an_update / limit_bytes_per_second},
                            {"bytes_per_node", flow->bytes() / nodes},
                            {"set_up_seconds", domain_seconds + set_up}});
        }
    return rows;
}

Json lbm_benchmark() {
    const double limit = in_place_bytes_per_second();
    Json speed = speed_rows(0.4, 292, limit);
    for (const Json& row : speed_rows(0.7, 242, limit)) speed.push_back(row);
    return {{"case", "error: simple cubic spheres, solid fraction 0.343; speed: overlapping spheres of 40 nodes"},
            {"in_place_bytes_per_second", limit},
            {"speed", speed},
            {"accuracy", accuracy_rows()}};
}

// Error and time of the measures against tolerance, of the inverse, and of CGAL's surfaces against their number of triangles.
Json shapes_benchmark() {
    Json measures = Json::array(), inverses = Json::array(), surfaces = Json::array();
    for (const char* kind : {"tetrapod", "dolos", "tetrahedron", "star"})
        for (const double psi : {0.92, 0.81, 0.53}) {
            Stopwatch watch;
            const Dimensions size = dimensions_for(kind, psi, 7.33e-7, Cavity::open);
            const double inverse_seconds = watch.seconds();
            const Shape shape = make_preset(kind, size.diameter_m, size.length_m);
            const ShapeMeasures exact = measure(shape, 1e-11);
            inverses.push_back({{"kind", kind},
                                {"sphericity", psi},
                                {"seconds", inverse_seconds},
                                {"sphericity_error", std::abs(exact.sphericity - psi)},
                                {"volume_error", std::abs(exact.volume_m3 / 7.33e-7 - 1.0)}});
            for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
                watch = {};
                const ShapeMeasures m = measure(shape, tolerance);
                measures.push_back({{"kind", kind},
                                    {"sphericity", psi},
                                    {"tolerance", tolerance},
                                    {"seconds", watch.seconds()},
                                    {"meridians", m.meridians},
                                    {"volume_error", std::abs(m.volume_m3 / exact.volume_m3 - 1.0)},
                                    {"area_error", std::abs(m.surface_area_m2 / exact.surface_area_m2 - 1.0)}});
            }
            if (psi != 0.53) continue;
            Packing packing{.container = parse_container("box:1,1,1"), .shapes = {shape}, .bodies = {{.position_m = Vec3::Constant(0.5)}}};
            for (const double deviation : {0.08, 0.04, 0.02, 0.01, 0.005, 0.0025}) {
                watch = {};
                const SurfaceResult result = make_surface(packing, {.deviation_m = deviation * size.diameter_m});
                const double seconds = watch.seconds();
                const SurfaceMeasures m = measure_surface(result.surface);
                surfaces.push_back({{"kind", kind},
                                    {"deviation_relative_to_diameter", result.deviation_m / size.diameter_m},
                                    {"triangles", result.surface.triangles.size()},
                                    {"seconds", seconds},
                                    {"volume_error", m.volume_m3 / exact.volume_m3 - 1.0},
                                    {"area_error", m.area_m2 / exact.surface_area_m2 - 1.0}});
            }
        }
    return {{"measures", measures}, {"inverses", inverses}, {"surfaces", surfaces}};
}

}  // namespace

const std::vector<std::string>& benchmark_names() {
    static const std::vector<std::string> names = {"coverage", "lbm", "shapes"};
    return names;
}

Json run_benchmark(const std::string& name) {
    Json result;
    if (name == "coverage")
        result = coverage_benchmark({3, 4}, {0.02, 0.005});
    else if (name == "lbm")
        result = lbm_benchmark();
    else if (name == "shapes")
        result = shapes_benchmark();
    else
        throw UserError("no such benchmark: " + name, {.allowed = fmt::format("{}", fmt::join(benchmark_names(), ", "))});
    result["machine"] = processor_name();
    result["threads"] = thread_count();
    result["git_hash"] = git_hash();
    return result;
}

}  // namespace porepack
