// Both packing engines on one question: seconds, porosity, and what the clumps' roughness changes.
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "apps/benchmark.hpp"
#include "apps/stages.hpp"
#include "converters/voxels.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "packing/batches.hpp"
#include "packing/capsule_pour.hpp"
#include "packing/liggghts.hpp"
#include "report/report.hpp"

namespace porepack {
namespace {

constexpr const char* container_text = "cylinder:0.04,0.45";
constexpr int rings = 5;

struct Bed {
    double porosity_bed = 0.0, porosity_central = 0.0, coordination = 0.0, overlap = 0.0, seconds = 0.0;
    std::array<double, rings> by_radius{};  // of equal area, in the central section
};

// Touching grains a grain, by the exact capsules.
double coordination_number(const Packing& packing, double slack) {
    const Grains grains(packing);
    std::vector<std::vector<Capsule>> bodies;
    for (const Body& body : packing.bodies) bodies.push_back(world_capsules(packing, body));
    long touching = 0;
    for (std::size_t i = 0; i < bodies.size(); ++i)
        for (std::size_t j = i + 1; j < bodies.size(); ++j) {
            bool touch = false;
            for (const Capsule& p : bodies[i])
                for (const Capsule& q : bodies[j]) touch = touch || gap(p, q) < slack;
            touching += touch ? 1 : 0;
        }
    return 2.0 * static_cast<double>(touching) / static_cast<double>(bodies.size());
}

Bed measure_bed(const Packing& packing, double seconds) {
    const Grains grains(packing);
    const Container& container = packing.container;
    const double top = grains.bounds().high.z(), d = finest_diameter(packing);
    const Section central{0.015, top - 0.02};
    Bed bed{.porosity_bed = porosity(grains, container, {0.0, top}, 20000).value,
            .porosity_central = porosity(grains, container, central, 20000).value,
            .coordination = coordination_number(packing, 0.002 * d),
            .overlap = find_overlaps(packing).mean_between_grains_m / d,
            .seconds = seconds};
    const PhaseImage image = voxelise(grains, container, central, plan_voxels(container, central, d / 8.0, 0.0, 1.0));
    std::array<double, rings> pores{}, all{};
    for (int k = 0; k < image.grid.cells[2]; ++k)
        for (int j = 0; j < image.grid.cells[1]; ++j)
            for (int i = 0; i < image.grid.cells[0]; ++i) {
                const double r = std::hypot(image.grid.centre(0, i), image.grid.centre(1, j)) / (0.5 * container.diameter_m);
                if (r >= 1.0) continue;
                const auto ring = static_cast<std::size_t>(r * r * rings);
                all[ring] += 1.0;
                pores[ring] += image.phase[image.grid.index(i, j, k)] == pore ? 1.0 : 0.0;
            }
    for (std::size_t r = 0; r < rings; ++r) bed.by_radius[r] = pores[r] / all[r];
    return bed;
}

struct Mean {
    double value = 0.0, error = 0.0;
};
template <typename Value>
Mean mean_of(const std::vector<Bed>& beds, const Value& value) {
    const auto n = static_cast<double>(beds.size());
    Mean mean;
    double squares = 0.0;
    for (const Bed& bed : beds) mean.value += value(bed) / n;
    for (const Bed& bed : beds) squares += std::pow(value(bed) - mean.value, 2);
    mean.error = beds.size() > 1 ? std::sqrt(squares / (n - 1.0) / n) : 0.0;
    return mean;
}

Json bed_json(const std::vector<Bed>& beds) {
    const auto row = [&](const auto& value) -> Json {
        const Mean mean = mean_of(beds, value);
        return {mean.value, mean.error};
    };
    Json json = {{"packings", beds.size()},
                 {"porosity_bed", row([](const Bed& bed) { return bed.porosity_bed; })},
                 {"porosity_central", row([](const Bed& bed) { return bed.porosity_central; })},
                 {"coordination_number", row([](const Bed& bed) { return bed.coordination; })},
                 {"mean_overlap_over_diameter", row([](const Bed& bed) { return bed.overlap; })},
                 {"seconds_a_pour", row([](const Bed& bed) { return bed.seconds; })},
                 {"porosity_by_radius", Json::array()}};
    for (std::size_t r = 0; r < rings; ++r) json["porosity_by_radius"].push_back(row([r](const Bed& bed) { return bed.by_radius[r]; }));
    return json;
}

// Seconds a step of the first run and of the last settling run of a pour, from LIGGGHTS' own "Loop time".
std::pair<double, double> liggghts_step_seconds(const Path& log) {
    std::ifstream in(log);
    std::vector<double> all;
    for (std::string line; std::getline(in, line);) {
        double seconds = 0.0;
        long processes = 0, steps = 0;
        if (std::sscanf(line.c_str(), "Loop time of %lf on %ld procs for %ld steps", &seconds, &processes, &steps) == 3 && steps > 1000)
            all.push_back(seconds / static_cast<double>(steps));
    }
    if (all.empty()) throw EngineError("LIGGGHTS' log has no \"Loop time\"", {.where = log.string()});
    return {all.front(), all.back()};
}

double capsule_step_seconds(CapsuleDem& dem, long steps) {
    const Stopwatch watch;
    dem.step(steps);
    return watch.seconds() / static_cast<double>(steps);
}

}  // namespace

Json packing_benchmark(bool quick, const Path& output) {
    require_program("liggghts", "liggghts");
    const Path folder = output.empty() ? Path("packing_engines") : output;
    make_folder(folder);
    const Container container = parse_container(container_text);
    const long grains = quick ? 60 : 100;
    const long processes = std::min(2, thread_count());
    const auto shape_of = [](const char* kind, double sphericity) -> std::vector<ShapeShare> {
        const Dimensions size = dimensions_for(kind, sphericity, 7.33e-7, Cavity::filled);
        return {{.shape = make_preset(kind, size.diameter_m, size.length_m), .number_fraction = 1.0}};
    };
    const auto by_liggghts = [&](const std::vector<ShapeShare>& shape, PackingConfig config, const Path& where) {
        config.engine = "liggghts";
        config.processes = processes;
        return pour_with_liggghts(shape, container, config, home_folder() / "liggghts_templates", where);
    };
    Json shapes = Json::array(), tolerances = Json::array();

    // Both engines, several packings each.
    const std::vector<std::pair<const char*, double>> list =
        quick ? std::vector<std::pair<const char*, double>>{{"tetrapod", 0.81}}
              : std::vector<std::pair<const char*, double>>{{"tetrapod", 0.53}, {"tetrapod", 0.81}, {"sphere", 1.0}};
    for (const auto& [kind, sphericity] : list) {
        const auto shape = shape_of(kind, sphericity);
        std::vector<Bed> exact, clumps;
        for (long seed = 1; seed <= (quick ? 2 : 5); ++seed) {
            const PourResult pour =
                pour_with_capsules(shape, container, {.engine = "capsule", .seed = seed, .grains = grains}, folder / "capsule");
            exact.push_back(measure_bed(pour.packing, pour.wall_time_s));
        }
        for (long seed = 1; seed <= (quick ? 2 : 3); ++seed) {
            const PourResult pour = by_liggghts(shape, {.seed = seed, .grains = grains}, folder / "liggghts");
            clumps.push_back(measure_bed(pour.packing, pour.wall_time_s));
        }
        const auto central = [](const Bed& bed) { return bed.porosity_central; };
        const Mean a = mean_of(exact, central), b = mean_of(clumps, central);
        shapes.push_back({{"shape", fmt::format("{} {:g}", kind, sphericity)},
                          {"capsule", bed_json(exact)},
                          {"liggghts", bed_json(clumps)},
                          {"difference_of_central_porosity", b.value - a.value},
                          {"standard_error_of_difference", std::hypot(a.error, b.error)}});
        log_info("{} {:g}: central porosity {:.4f} +- {:.4f} (capsule), {:.4f} +- {:.4f} (LIGGGHTS)", kind, sphericity, a.value, a.error,
                 b.value, b.error);
    }

    // Seconds and porosity against the clumps' surface tolerance; the same fall and the same settled bed for both engines.
    const auto tetrapod = shape_of("tetrapod", 0.53);
    std::string data =
        "# surface tolerance, seconds a pour, central porosity, mean overlap of the exact capsules, us a grain and step falling, settled\n";
    const PackingConfig lattice{.fill = "lattice", .seed = 1, .grains = grains};
    const auto add = [&](const char* engine, double tolerance, const Bed& bed, double falling, double settled, long spheres) {
        const double scale = 1e6 / static_cast<double>(grains);
        tolerances.push_back({{"engine", engine},
                              {"surface_tolerance", tolerance},
                              {"spheres_a_grain", spheres},
                              {"seconds_a_pour", bed.seconds},
                              {"porosity_central", bed.porosity_central},
                              {"mean_overlap_over_diameter", bed.overlap},
                              {"us_a_grain_and_step_falling", scale * falling},
                              {"us_a_grain_and_step_settled", scale * settled}});
        data += fmt::format("{:g} {:.4g} {:.5f} {:.5f} {:.4g} {:.4g}\n", tolerance, bed.seconds, bed.porosity_central, bed.overlap,
                            scale * falling, scale * settled);
    };
    const PourResult exact = pour_with_capsules(tetrapod, container, lattice, folder / "capsule");
    const PourPlan plan = plan_pour(tetrapod, container, lattice);
    const DemOptions options{.time_step_s = plan.time_step_s};
    CapsuleDem falling(container, {tetrapod[0].shape}, lattice.density_kg_per_m3, contact_law(lattice), options);
    const Pour start = make_batches(tetrapod, container, lattice, plan.drop_height_m, grains);
    for (const Newcomer& grain : start.batches.front())
        falling.add(grain.shape, grain.position_m, grain.orientation, grain.velocity_m_per_s);
    CapsuleDem settled(container, {tetrapod[0].shape}, lattice.density_kg_per_m3, contact_law(lattice), options);
    for (const Body& body : exact.packing.bodies) settled.add(body.shape, body.position_m, body.orientation);
    const double falling_step = capsule_step_seconds(falling, std::lround(lattice.batch_interval_s / plan.time_step_s)),
                 settled_step = capsule_step_seconds(settled, 5000);
    add("capsule", 0.0, measure_bed(exact.packing, exact.wall_time_s), falling_step, settled_step, 0);
    for (const double tolerance : quick ? std::vector<double>{0.1, 0.05} : std::vector<double>{0.1, 0.05, 0.02, 0.005}) {
        PackingConfig config = lattice;
        config.surface_tolerance = tolerance;
        const PourResult pour = by_liggghts(tetrapod, config, folder / "liggghts");
        const auto [first, last] = liggghts_step_seconds(folder / "liggghts" / "log.liggghts.screen");
        const auto spheres = static_cast<long>(sphere_clump(tetrapod[0].shape, tolerance * smallest_diameter(tetrapod[0].shape)).size());
        add("liggghts", tolerance, measure_bed(pour.packing, pour.wall_time_s), first, last, spheres);
        log_info("tolerance {:g}: {:.0f} s, falling {:.1f} and settled {:.1f} times the capsules' time a step", tolerance, pour.wall_time_s,
                 first / falling_step, last / settled_step);
    }
    write_text(folder / "packing_engines.dat", data);
    const double scale = 1e6 / static_cast<double>(grains);
    draw_plot(
        folder / "packing_engines.svg",
        fmt::format(
            "set terminal svg size 900,380 font 'DejaVu Sans,12' background 'white'\nset output 'packing_engines.svg'\n"
            "set multiplot layout 1,2\nset grid\nset logscale x\nset xlabel 'surface tolerance of the clumps / d'\nset xrange [0.003:0.2]\n"
            "set logscale y\nset yrange [0.1:*]\nset ylabel 'us a grain and step'\n"
            "plot 'packing_engines.dat' every ::1 using 1:5 with linespoints pt 7 title 'LIGGGHTS, falling', '' every ::1 using 1:6 with "
            "linespoints pt 5 title 'LIGGGHTS, settled', {} with lines dt 2 title 'capsules, falling', {} with lines dt 3 title 'capsules, "
            "settled'\nunset logscale y\nset yrange [*:*]\nset ylabel 'central porosity'\n"
            "plot 'packing_engines.dat' every ::1 using 1:3 with linespoints pt 7 title 'LIGGGHTS', {} with lines dt 2 title "
            "'capsules'\nunset multiplot\n",
            scale * falling_step, scale * settled_step, measure_bed(exact.packing, 0.0).porosity_central));
    return {{"shapes", shapes}, {"tolerances", tolerances}, {"grains", grains}, {"cores", processes}};
}

}  // namespace porepack
