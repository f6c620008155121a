// Both packing engines on the same task: seconds, porosity, and the effect of the clumps' roughness.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/packing.hpp"
#include "core/data_file.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "pore_space/voxels.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "report/plot.hpp"
#include "stages/stages.hpp"

namespace porepack::benchmarks {

std::vector<ShapeShare> paper_shape(ShapeKind kind, double sphericity) {
    const Dimensions size = dimensions_for(kind, sphericity, 7.33e-7, Cavity::filled);
    return {{.shape = make_preset(kind, size.diameter_m, size.length_m), .number_fraction = 1.0}};
}

PourResult PackingBench::by_capsules(const std::vector<ShapeShare>& shape, const PackingConfig& config) const {
    return pour_with_capsules(shape, container, config, folder / "capsule");
}

PourResult PackingBench::by_liggghts(const std::vector<ShapeShare>& shape, PackingConfig config, const std::optional<Pour>& given) const {
    config.engine = Engine::liggghts;
    config.processes = std::min(2, thread_count());
    return pour_with_liggghts(shape, container, config, data_file("liggghts_templates"), folder / "liggghts", given);
}

Bed measure_bed(const Packing& packing, double seconds) {
    const Grains grains(packing);
    const Container& container = packing.container;
    const double top = grains.bounds().high.z(), d = finest_diameter(packing);
    const Section central{0.015, top - 0.02};
    const Overlaps overlaps = find_overlaps(packing);
    Bed bed{.porosity_bed = porosity(grains, container, {0.0, top}, 20000).value,
            .porosity_central = porosity(grains, container, central, 20000).value,
            .coordination = 2.0 * static_cast<double>(overlaps.contacts) / static_cast<double>(packing.bodies.size()),
            .overlap = overlaps.mean_between_grains_m / d,
            .largest_overlap = overlaps.largest_between_grains_m / d,
            .seconds = seconds};
    const PhaseImage image = voxelise(grains, container, central, plan_voxels(container, central, d / 8.0, {}, 1.0).grid);
    std::array<double, Bed::rings> pores{}, all{};
    for (int k = 0; k < image.grid.cells[2]; ++k)
        for (int j = 0; j < image.grid.cells[1]; ++j)
            for (int i = 0; i < image.grid.cells[0]; ++i) {
                const double r = std::hypot(image.grid.centre(0, i), image.grid.centre(1, j)) / (0.5 * *container.tube_diameter());
                if (r >= 1.0) continue;
                const auto ring = static_cast<std::size_t>(r * r * Bed::rings);
                all[ring] += 1.0;
                pores[ring] += image.phase[image.grid.index(i, j, k)] == Phase::pore ? 1.0 : 0.0;
            }
    for (std::size_t r = 0; r < Bed::rings; ++r) bed.by_radius[r] = pores[r] / all[r];
    for (std::size_t s = 0; s < Bed::slabs; ++s) {
        const double z = 0.005 * static_cast<double>(s);
        bed.by_height[s] = porosity(grains, container, {z, z + 0.005}, 4000).value;
    }
    return bed;
}

namespace {

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
                 {"seconds_per_pour", row([](const Bed& bed) { return bed.seconds; })},
                 {"porosity_by_radius", Json::array()},
                 {"porosity_by_height", Json::array()}};
    for (std::size_t r = 0; r < Bed::rings; ++r)
        json["porosity_by_radius"].push_back(row([r](const Bed& bed) { return bed.by_radius[r]; }));
    for (std::size_t s = 0; s < Bed::slabs; ++s)
        json["porosity_by_height"].push_back(row([s](const Bed& bed) { return bed.by_height[s]; }));
    return json;
}

// Columns: position, capsule, error, LIGGGHTS, error.
std::string profile_data(const Json& shape, const char* profile, double first, double width) {
    std::string text;
    for (std::size_t i = 0; i < shape["capsule"][profile].size(); ++i) {
        text += fmt::format("{:.4g}", first + width * static_cast<double>(i));
        for (const char* engine : {"capsule", "liggghts"})
            text += fmt::format(" {:.5f} {:.5f}", shape[engine][profile][i][0].get<double>(), shape[engine][profile][i][1].get<double>());
        text += "\n";
    }
    return text;
}

void draw_engines(const Path& folder, const Json& shapes, const Json& tolerances, const Json& lattice, const Json& costs) {
    std::string porosity = "# surface tolerance, central porosity, error, mean overlap of the exact capsules\n",
                seconds = "# surface tolerance, us per grain and step pouring, settled\n";
    for (const Json& row : tolerances)
        porosity +=
            fmt::format("{:g} {:.5f} {:.5f} {:.5f}\n", row["surface_tolerance"].get<double>(), row["porosity_central"][0].get<double>(),
                        row["porosity_central"][1].get<double>(), row["mean_overlap_over_diameter"][0].get<double>());
    for (const Json& row : costs["rows"])
        if (row.contains("surface_tolerance"))
            seconds += fmt::format("{:g} {:.4g} {:.4g}\n", row["surface_tolerance"].get<double>(),
                                   row["us_per_grain_and_step_pouring"].get<double>(), row["us_per_grain_and_step_settled"].get<double>());
    write_text(folder / "porosity.dat", porosity);
    write_text(folder / "seconds.dat", seconds);
    write_text(folder / "by_radius.dat", profile_data(shapes[0], "porosity_by_radius", 0.5 / Bed::rings, 1.0 / Bed::rings));
    write_text(folder / "by_height.dat", profile_data(shapes[0], "porosity_by_height", 2.5, 5.0));
    const Json& capsule = costs["rows"][0];
    const Json& exact = lattice["porosity_central"];
    draw_plot(folder / "packing_engines.svg", "packing_engines",
              {{"pouring_us", capsule["us_per_grain_and_step_pouring"].get<double>()},
               {"settled_us", capsule["us_per_grain_and_step_settled"].get<double>()},
               {"porosity", exact[0].get<double>()},
               {"porosity_error", exact[1].get<double>()}},
              {.width = 900, .height = 700});
}

// The grains of the paper by both engines.
Json both_engines(const PackingBench& bench) {
    const bool quick = bench.quick;
    // Costs first, before other work heats the processor or fills the memory.
    const Json costs = step_costs(bench);
    const Json grains = cost_by_grains(bench), rods = lying_rods(bench), steps = time_step_table(bench);

    // Several packings by both engines.
    Json shapes = Json::array();
    for (const auto& [kind, sphericity] : quick ? std::vector<std::pair<ShapeKind, double>>{{ShapeKind::tetrapod, 0.53}}
                                                : std::vector<std::pair<ShapeKind, double>>{
                                                      {ShapeKind::tetrapod, 0.53}, {ShapeKind::tetrapod, 0.81}, {ShapeKind::sphere, 1.0}}) {
        const auto shape = paper_shape(kind, sphericity);
        std::vector<Bed> exact, clumps;
        for (long seed = 1; seed <= (quick ? 2 : 5); ++seed) {
            const PourResult pour = bench.by_capsules(shape, {.seed = seed, .grains = bench.grains});
            exact.push_back(measure_bed(pour.packing, pour.wall_time_s));
        }
        for (long seed = 1; seed <= (quick ? 2 : 3); ++seed) {
            const PourResult pour = bench.by_liggghts(shape, {.seed = seed, .grains = bench.grains});
            clumps.push_back(measure_bed(pour.packing, pour.wall_time_s));
        }
        const auto central = [](const Bed& bed) { return bed.porosity_central; };
        const Mean a = mean_of(exact, central), b = mean_of(clumps, central);
        shapes.push_back({{"shape", fmt::format("{} {:g}", name_of(kind), sphericity)},
                          {"capsule", bed_json(exact)},
                          {"liggghts", bed_json(clumps)},
                          {"difference_of_central_porosity", b.value - a.value},
                          {"standard_error_of_difference", std::hypot(a.error, b.error)}});
        log_info("{} {:g}: central porosity {:.4f} +- {:.4f} (capsule), {:.4f} +- {:.4f} (LIGGGHTS)", name_of(kind), sphericity, a.value,
                 a.error, b.value, b.error);
    }

    // Effect of the clumps' roughness.
    Json tolerances = Json::array();
    for (const double tolerance : quick ? std::vector<double>{0.1, 0.05} : std::vector<double>{0.1, 0.05, 0.02, 0.005}) {
        std::vector<Bed> beds;
        for (long seed = 1; seed <= (quick ? 1 : tolerance < 0.01 ? 2 : 3); ++seed) {
            const PourResult pour =
                bench.by_liggghts(paper_shape(ShapeKind::tetrapod, 0.53),
                                  {.fill = Fill::lattice, .seed = seed, .grains = bench.grains, .surface_tolerance = tolerance});
            beds.push_back(measure_bed(pour.packing, pour.wall_time_s));
        }
        Json row = bed_json(beds);
        row["surface_tolerance"] = tolerance;
        tolerances.push_back(row);
    }
    std::vector<Bed> beds;
    for (long seed = 1; seed <= (quick ? 1 : 5); ++seed) {
        const PourResult pour =
            bench.by_capsules(paper_shape(ShapeKind::tetrapod, 0.53), {.fill = Fill::lattice, .seed = seed, .grains = bench.grains});
        beds.push_back(measure_bed(pour.packing, pour.wall_time_s));
    }
    const Json lattice = bed_json(beds);
    draw_engines(bench.folder, shapes, tolerances, lattice, costs);
    return {{"grains", bench.grains}, {"step_costs", costs}, {"cost_by_grains", grains}, {"lying_rod", rods},
            {"time_steps", steps},    {"shapes", shapes},    {"tolerances", tolerances}, {"capsules_from_a_lattice", lattice}};
}

}  // namespace

Json packing_benchmark(const std::vector<std::string>& parts, bool quick, const Path& output) {
    const PackingBench bench{.folder = output.empty() ? Path("packing_engines") : output,
                             .container = parse_container("cylinder:0.04,0.45"),
                             .grains = quick ? 60 : 100,
                             .quick = quick};
    constexpr std::pair<const char*, Json (*)(const PackingBench&)> all[] = {
        {"engines", both_engines}, {"grains_with_faces", grains_with_faces}, {"spheres_of_320_faces", spheres_of_faces}};
    for (const std::string& part : parts)
        if (std::none_of(std::begin(all), std::end(all), [&](const auto& one) { return part == one.first; }))
            throw UserError(fmt::format("no such part of the packing benchmark: {}", part),
                            {.allowed = "engines, grains_with_faces, spheres_of_320_faces"});
    const auto is_asked = [&](const char* part) { return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end(); };
    if (is_asked("engines")) require_program("liggghts", "liggghts");
    make_folder(bench.folder);
    Json result;
    for (const auto& [name, run] : all)
        if (is_asked(name)) result[name] = run(bench);
    return result;
}

}  // namespace porepack::benchmarks
