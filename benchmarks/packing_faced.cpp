// Seconds and cost per step of pours of grains with faces.
#include "benchmarks/packing.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "pore_space/voxels.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "shapes/config.hpp"

namespace porepack::benchmarks {
using namespace core;
using namespace geometry;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;

Json grains_with_faces(const PackingBench& bench) {
    struct Task {
        const char* name;
        RingSize size;
        double tube_m, height_m;
        long grains;
    };
    const Task tasks[] = {
        {"cylinders, tube of 10 diameters",
         {.diameter_m = 0.008, .height_m = 0.008, .rounding_m = 0.00018},
         0.08,
         bench.quick ? 0.3 : 1.0,
         bench.quick ? 100 : 1000},
        {"rings, tube of 6 diameters",
         {.diameter_m = 0.01, .inner_diameter_m = 0.007, .height_m = 0.01, .rounding_m = 0.00018},
         0.06,
         bench.quick ? 0.3 : 1.0,
         bench.quick ? 30 : 300},
    };
    Json rows = Json::array();
    for (const Task& task : tasks)
        for (const Fill fill : {Fill::lattice, Fill::batches}) {
            const std::vector<ShapeShare> shape = {{.shape = {.id = task.name, .body = make_ring(task.size)}, .number_fraction = 1.0}};
            const Container tube = make_cylinder(task.tube_m, task.height_m);
            PackingConfig config{.fill = fill, .grains = task.grains};
            if (fill == Fill::batches) config.batch_grains = 50;
            const PourPlan plan = plan_pour(shape, tube, config);
            const PourResult pour = dem::pour_with_capsules(shape, tube, config, bench.folder / "faced");
            const Grains grains(pour.packing);
            const Overlaps overlaps = find_overlaps(pour.packing);
            const auto count = static_cast<double>(task.grains);
            rows.push_back({{"grains", task.grains},
                            {"shape", task.name},
                            {"fill", name_of(fill)},
                            {"steps", pour.steps},
                            {"seconds", pour.wall_time_s},
                            {"expected_seconds", plan.expected_wall_time_s},
                            {"us_per_grain_and_step", 1e6 * pour.wall_time_s / count / static_cast<double>(pour.steps)},
                            {"porosity_bed", porosity(grains, tube, {0.0, grains.bounds().high.z()}, 20000).value},
                            {"coordination_number", 2.0 * static_cast<double>(overlaps.contacts) / count},
                            {"largest_overlap_over_thickness", overlaps.largest_between_grains_m / finest_diameter(pour.packing)}});
            log_info("{} {}, {}: {:.0f} s, {} steps", task.grains, task.name, name_of(fill), pour.wall_time_s, pour.steps);
        }
    return rows;
}

}  // namespace porepack::benchmarks
