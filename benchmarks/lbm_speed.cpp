#include "benchmarks/lbm_speed.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/json.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "lbm/domain.hpp"
#include "lbm/flow.hpp"
#include "packing/grains.hpp"
#include "packing/packing.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/walls.hpp"
#include "support/whole_library.hpp"
#include "vessels/config.hpp"

namespace porepack::benchmarks {
namespace {

template <typename Run>
double median_seconds(const Run& run) {
    std::vector<double> seconds(5);
    for (double& one : seconds) {
        const Stopwatch watch;
        run();
        one = watch.seconds();
    }
    return median(std::move(seconds));
}

// Bytes per second of a[i] *= s: populations are read and written in place like this.
double stream_bytes_per_second() {
    static std::vector<double> a(100'000'000, 1.0);
    const double seconds = median_seconds([] {
#pragma omp parallel for simd schedule(static)
        for (std::size_t i = 0; i < a.size(); ++i) a[i] *= 1.0000001;
    });
    return 16.0 * static_cast<double>(a.size()) / seconds;
}

// Updates per second.
double rate_of(Flow& flow, std::size_t nodes) {
    const int pairs = static_cast<int>(std::max(5.0, 5e7 / static_cast<double>(nodes)));
    flow.advance_two_steps();
    return 2.0 * pairs * static_cast<double>(nodes) / median_seconds([&] {
               for (int i = 0; i < pairs; ++i) flow.advance_two_steps();
           });
}

struct Bed {
    Domain domain;
    double seconds = 0.0;  // of its set-up
};
Bed bed_of(double porosity, double nodes) {
    const int cells = static_cast<int>(std::lround(std::cbrt(nodes / porosity)));
    const Packing packing = overlapping_spheres("box:1,1,1:periodic", porosity, 20.0 / cells);
    const Grains grains(packing);
    const Section section{0.0, 1.0};
    const FlowWalls walls{grains, packing.container, section};
    const Stopwatch watch;
    Bed bed;
    bed.domain =
        build_domain(voxelise(grains, packing.container, section, plan_voxels(packing.container, section, 1.0 / cells, {}, 1.0).grid),
                     choose_drive(packing.container, Axis::z), &walls);
    bed.seconds = watch.seconds();
    return bed;
}

constexpr double nodes_in_cache = 1e5;  // 10 MB in single precision: in the last cache of two or more cores

}  // namespace

Packing overlapping_spheres(const std::string& container, double porosity, double radius) {
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

Json lbm_speed_rows(double porosity, double nodes) {
    const Bed bed = bed_of(porosity, nodes), small = bed_of(porosity, nodes_in_cache);
    const auto count = static_cast<double>(bed.domain.nodes());
    Json rows = Json::array();
    for (const Walls kind : {Walls::bounce_back, Walls::interpolated})
        for (const Kernel kernel : {Kernel::cpu_double, Kernel::cpu_single}) {
            const Scheme scheme{.walls = kind, .force = {0, 0, 1e-3}};
            const Stopwatch watch;
            const auto flow = make_flow(kernel, bed.domain, scheme), cached = make_flow(kernel, small.domain, scheme);
            const double set_up = watch.seconds(), populations = 19.0 * (kernel == Kernel::cpu_double ? 8.0 : 4.0);
            // Two steps read and write the populations once, and read the addresses and walls once.
            const double bytes = flow->bytes() / count, bytes_an_update = 0.5 * (populations + bytes);
            const double before = stream_bytes_per_second(), rate = rate_of(*flow, bed.domain.nodes()),
                         in_cache = rate_of(*cached, small.domain.nodes()), after = stream_bytes_per_second();
            const double stream = std::max(before, after), by_memory = stream / bytes_an_update;
            rows.push_back({{"porosity", porosity},
                            {"walls", kind == Walls::interpolated ? "interpolated" : "bounce_back"},
                            {"precision", kernel == Kernel::cpu_double ? "double" : "single"},
                            {"fluid_nodes", bed.domain.nodes()},
                            {"wall_links_per_node", static_cast<double>(bed.domain.walls.size()) / count},
                            {"wall_links_per_node_in_cache",
                             static_cast<double>(small.domain.walls.size()) / static_cast<double>(small.domain.nodes())},
                            {"updates_per_second", rate},
                            {"stream_bytes_per_second", stream},
                            {"bytes_an_update", bytes_an_update},
                            {"limit_of_memory", by_memory},
                            {"limit_in_cache", in_cache},
                            {"ratio_to_smaller_limit", rate / std::min(by_memory, in_cache)},
                            {"bytes_per_node", bytes},
                            {"set_up_seconds", bed.seconds + set_up}});
        }
    return rows;
}

}  // namespace porepack::benchmarks
