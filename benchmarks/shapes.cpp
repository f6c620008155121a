#include "benchmarks/benchmarks.hpp"

#include <fmt/format.h>

#include <cmath>

#include "converters/surface.hpp"
#include "core/build.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "vessels/config.hpp"

namespace porepack::benchmarks {
// Error and time of the measures against tolerance, of the inverse, and of CGAL's surfaces against their number of triangles.
Json shapes_benchmark() {
    Json measures = Json::array(), inverses = Json::array(), surfaces = Json::array();
    for (const ShapeKind kind : {ShapeKind::tetrapod, ShapeKind::dolos, ShapeKind::tetrahedron, ShapeKind::star})
        for (const double psi : {0.92, 0.81, 0.53}) {
            Stopwatch watch;
            const Dimensions size = dimensions_for(kind, psi, 7.33e-7, Cavity::open);
            const double inverse_seconds = watch.seconds();
            const Shape shape = make_preset(kind, size.diameter_m, size.length_m);
            const ShapeMeasures exact = measure(shape, 1e-11);
            inverses.push_back({{"kind", name_of(kind)},
                                {"sphericity", psi},
                                {"seconds", inverse_seconds},
                                {"sphericity_error", std::abs(exact.sphericity - psi)},
                                {"volume_error", std::abs(exact.volume_m3 / 7.33e-7 - 1.0)}});
            for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
                watch = {};
                const ShapeMeasures m = measure(shape, tolerance);
                measures.push_back({{"kind", name_of(kind)},
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
                surfaces.push_back({{"kind", name_of(kind)},
                                    {"deviation_relative_to_diameter", result.deviation_m / size.diameter_m},
                                    {"triangles", result.surface.triangles.size()},
                                    {"seconds", seconds},
                                    {"volume_error", m.volume_m3 / exact.volume_m3 - 1.0},
                                    {"area_error", m.area_m2 / exact.surface_area_m2 - 1.0}});
            }
        }
    return {{"measures", measures}, {"inverses", inverses}, {"surfaces", surfaces}};
}

}  // namespace porepack::benchmarks
