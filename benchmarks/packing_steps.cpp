// Cost of a step of either packing engine, and effect of the clumps' settings.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "benchmarks/packing.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {
namespace {

double seconds_a_step(CapsuleDem& dem, long steps) {
    const Stopwatch watch;
    dem.step(steps);
    return watch.seconds() / static_cast<double>(steps);
}

// A snapshot of a scene, for either engine.
Pour moment(const CapsuleDem& dem) {
    Pour pour{.batches = {{}}};
    for (std::size_t i = 0; i < dem.size(); ++i) {
        const Body body = dem.pose(i);
        pour.batches[0].push_back({body.shape, body.position_m, body.orientation, dem.velocity(i)});
        pour.top_m = std::max(pour.top_m, body.position_m.z() + 0.05);
    }
    return pour;
}

CapsuleDem scene_of(const Container& container, const std::vector<ShapeShare>& shape, const PackingConfig& config, const Pour& pour,
                    bool sleep = false) {
    const PourPlan plan = plan_pour(shape, container, config);
    CapsuleDem dem(container, {shape[0].shape}, config.density_kg_per_m3, contact_law(config),
                   {.time_step_s = plan.time_step_s, .sleep = sleep});
    for (const Newcomer& grain : pour.batches.front()) dem.add(grain.shape, grain.position_m, grain.orientation, grain.velocity_m_per_s);
    return dem;
}

}  // namespace

double PackingBench::liggghts_step_seconds() const {
    std::ifstream in(folder / "liggghts" / "log.liggghts.screen");
    for (std::string line; std::getline(in, line);) {
        double seconds = 0.0;
        long processes = 0, steps = 0;
        if (std::sscanf(line.c_str(), "Loop time of %lf on %ld procs for %ld steps", &seconds, &processes, &steps) == 3 && steps > 100)
            return seconds / static_cast<double>(steps);
    }
    throw EngineError("LIGGGHTS' log has no \"Loop time\"", {.where = (folder / "liggghts").string()});
}

Json step_costs(const PackingBench& bench) {
    const auto shape = paper_shape(ShapeKind::tetrapod, 0.53);
    const PackingConfig lattice{.fill = Fill::lattice, .grains = bench.grains};
    const PourPlan plan = plan_pour(shape, bench.container, lattice);
    CapsuleDem falling =
        scene_of(bench.container, shape, lattice, make_batches(shape, bench.container, lattice, plan.drop_height_m, bench.grains));
    falling.step(std::lround(0.15 / plan.time_step_s));  // half of the grains have landed
    const Pour pouring = moment(falling);
    Pour settled{.batches = {{}}};
    for (const Body& body : bench.by_capsules(shape, lattice).packing.bodies) {
        settled.batches[0].push_back({body.shape, body.position_m, body.orientation, Vec3::Zero()});
        settled.top_m = std::max(settled.top_m, body.position_m.z() + 0.05);
    }
    Json rows = Json::array();
    const double scale = 1e6 / static_cast<double>(bench.grains);
    const long window = std::lround(lattice.batch_interval_s / plan.time_step_s);
    std::array<double, 2> capsule{};
    for (const bool sleep : {false, true}) {
        CapsuleDem one = scene_of(bench.container, shape, lattice, pouring, sleep),
                   other = scene_of(bench.container, shape, lattice, settled, sleep);
        const double first = seconds_a_step(one, window), second = seconds_a_step(other, window);
        if (!sleep) capsule = {first, second};
        rows.push_back({{"engine", sleep ? "capsule, sleepers" : "capsule"},
                        {"us_per_grain_and_step_pouring", scale * first},
                        {"us_per_grain_and_step_settled", scale * second}});
    }
    for (const double tolerance : bench.quick ? std::vector<double>{0.1, 0.05} : std::vector<double>{0.1, 0.05, 0.02, 0.005}) {
        std::array<double, 2> seconds{};
        for (const std::size_t state : {0U, 1U}) {
            PackingConfig config = lattice;
            config.surface_tolerance = tolerance;
            config.settle_time_s = 1e-3;  // only the first steps are needed
            try {
                (void)bench.by_liggghts(shape, config, state == 0 ? pouring : settled);
            } catch (const NumericalError&) {
            }
            seconds[state] = bench.liggghts_step_seconds();
        }
        rows.push_back({{"engine", "liggghts"},
                        {"surface_tolerance", tolerance},
                        {"spheres_per_grain", sphere_clump(shape[0].shape, tolerance * smallest_diameter(shape[0].shape)).size()},
                        {"us_per_grain_and_step_pouring", scale * seconds[0]},
                        {"us_per_grain_and_step_settled", scale * seconds[1]},
                        {"times_the_capsules_pouring", seconds[0] / capsule[0]},
                        {"times_the_capsules_settled", seconds[1] / capsule[1]}});
        log_info("tolerance {:g}: a step takes {:.1f} (pouring) and {:.1f} (settled) times the capsules' time", tolerance,
                 seconds[0] / capsule[0], seconds[1] / capsule[1]);
    }
    return {{"window_steps", window}, {"rows", rows}};
}

Json cost_by_grains(const PackingBench& bench) {
    const auto shape = paper_shape(ShapeKind::tetrapod, 0.81);
    const Container tile = vessels::make_box({0.06, 0.06, 0.3}, {true, true, false});
    const PackingConfig lattice{.fill = Fill::lattice, .grains = 100};
    const Packing bed = pour_with_capsules(shape, tile, lattice, bench.folder / "capsule").packing;
    Json rows = Json::array();
    for (const long side : bench.quick ? std::vector<long>{1, 3} : std::vector<long>{1, 2, 3, 5, 7, 10}) {
        // Copies of a settled bed that is periodic, side by side: settled as well.
        const auto sides = static_cast<double>(side);
        const Container container = tile.resized({sides * tile.size().x(), sides * tile.size().y(), tile.height()});
        Pour pour{.batches = {{}}};
        for (long x = 0; x < side; ++x)
            for (long y = 0; y < side; ++y)
                for (const Body& body : bed.bodies)
                    pour.batches[0].push_back(
                        {0, body.position_m + Vec3(static_cast<double>(x) * tile.size().x(), static_cast<double>(y) * tile.size().y(), 0.0),
                         body.orientation, Vec3::Zero()});
        const auto grains = static_cast<double>(pour.batches[0].size());
        Json row = {{"grains", pour.batches[0].size()}};
        const int threads = thread_count();
        for (const int count : {1, threads}) {
            set_thread_count(count);
            CapsuleDem dem = scene_of(container, shape, lattice, pour);
            dem.step(20);
            row[fmt::format("us_per_grain_and_step_{}_threads", count)] =
                1e6 / grains * seconds_a_step(dem, std::max(50L, 400000 / std::lround(grains)));
        }
        set_thread_count(threads);
        rows.push_back(row);
    }
    return rows;
}

Json time_step_table(const PackingBench& bench) {
    const auto shape = paper_shape(ShapeKind::tetrapod, 0.53);
    PackingConfig config{.engine = Engine::liggghts, .fill = Fill::lattice, .grains = 60};
    const double contact = plan_pour(shape, bench.container, config).contact_time_s;
    Json rows = Json::array();
    for (const double tolerance : bench.quick ? std::vector<double>{0.1} : std::vector<double>{0.1, 0.05, 0.02})
        for (const double part : bench.quick ? std::vector<double>{45.0} : std::vector<double>{31.0, 45.0, 90.0}) {
            config.surface_tolerance = tolerance;
            config.time_step_s = contact / part;
            const PourResult pour = bench.by_liggghts(shape, config);
            const Bed bed = measure_bed(pour.packing, pour.wall_time_s);
            rows.push_back({{"surface_tolerance", tolerance},
                            {"steps_per_contact", part},
                            {"time_step_s", config.time_step_s},
                            {"porosity_central", bed.porosity_central},
                            {"largest_overlap_of_spheres_over_diameter", *pour.largest_clump_overlap_m / finest_diameter(shape)},
                            {"largest_overlap_of_capsules_over_diameter", bed.largest_overlap},
                            {"seconds", pour.wall_time_s}});
        }
    return rows;
}

Json lying_rods(const PackingBench& bench) {
    const std::vector<ShapeShare> rod = {{.shape = make_preset(ShapeKind::rod, 0.004, 0.012), .number_fraction = 1.0}};
    const auto stiffness = [&](const PourResult& pour, const PackingConfig& config) {
        const double weight = config.density_kg_per_m3 * measure(rod[0].shape, 1e-9).volume_m3 * config.gravity_m_per_s2;
        return weight / find_overlaps(pour.packing).largest_with_wall_m / (0.5 * config.normal_stiffness_N_per_m);
    };
    PackingConfig config{.grains = 1};
    Json rows = Json::array({{{"engine", "capsule"}, {"contacts", stiffness(bench.by_capsules(rod, config), config)}}});
    for (const double tolerance : {0.1, 0.05, 0.02, 0.005}) {
        config.surface_tolerance = tolerance;
        rows.push_back({{"engine", "liggghts"},
                        {"surface_tolerance", tolerance},
                        {"spheres", sphere_clump(rod[0].shape, tolerance * 0.004).size()},
                        {"contacts", stiffness(bench.by_liggghts(rod, config), config)}});
    }
    return rows;
}

}  // namespace porepack::benchmarks
