#include "apps/benchmark.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/manifest.hpp"

namespace porepack {
namespace {

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
    static const std::vector<std::string> names = {"coverage", "cross-check", "foam",        "lbm",
                                                   "packing",  "shapes",      "speed-error", "tortuosity"};
    return names;
}

Json run_benchmark(const std::string& name, const std::vector<Path>& cases, const Path& folder, bool quick) {
    Json result;
    if (name == "coverage")
        result = coverage_benchmark({9, 10}, {0.02, 0.01, 0.005});
    else if (name == "cross-check")
        result = cross_check_benchmark(cases, folder);
    else if (name == "foam")
        result = foam_benchmark(folder);
    else if (name == "lbm")
        result = lbm_benchmark(folder);
    else if (name == "packing")
        result = packing_benchmark(quick, folder);
    else if (name == "speed-error")
        result = speed_error_benchmark(quick, folder);
    else if (name == "tortuosity")
        result = tortuosity_benchmark(quick, folder);
    else if (name == "shapes")
        result = shapes_benchmark();
    else
        throw UserError("no such benchmark: " + name, {.allowed = fmt::format("{}", fmt::join(benchmark_names(), ", "))});
    result["machine"] = processor_name();
    result["threads"] = thread_count();
    result["git_hash"] = git_hash();
    if (!folder.empty()) write_json(folder / (name + ".json"), result);
    return result;
}

}  // namespace porepack
