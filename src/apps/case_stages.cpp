// What the stages of a case are: what each needs, what decides its result, what it runs and what that will cost.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "apps/pipeline.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "packing/pour.hpp"
#include "permeability/permeability.hpp"
#include "report/report.hpp"

namespace porepack {
namespace fs = std::filesystem;
namespace {

Path folder_of(const Case& c, const std::string& stage) {
    return c.results() / stage;
}

Json table_json(const Case& c, std::initializer_list<const char*> tables) {
    Settings copy = c.settings;
    Json json = Json::object();
    for (const char* table : tables) json[table] = to_json(copy.describe_table(table));
    return json;
}

// Only the keys that decide a stage's result: slices do not grow stale when the voxel size changes.
Json only(Json tables, const std::string& table, const std::set<std::string>& keys) {
    Json kept = Json::object();
    for (const auto& [key, value] : tables[table].items())
        if (keys.contains(key)) kept[key] = value;
    tables[table] = kept;
    return tables;
}

bool from_stl(const Case& c) {
    return c.settings.shape.kind == "stl";
}

// What the geometry and flow stages work on. The surface of the stl stage comes along when asked for.
Scene scene_of(const Case& c, bool with_surface = false) {
    const Container container = make_container(c.settings.container);
    if (from_stl(c)) return load_scene(folder_of(c, "stl") / "solid.stl", container, c.settings.geometry, 1.0);
    Scene scene = load_scene(folder_of(c, "pack") / "packing.json", container, c.settings.geometry, 1.0);
    if (with_surface) scene.surface = read_stl(folder_of(c, "stl") / "solid.stl");
    return scene;
}

double expected_porosity(const Case& c) {
    const Path file = folder_of(c, "pack") / "result.json";
    return fs::exists(file) ? read_json(file).value("porosity_bed", 0.6) : 0.6;
}

// The section before the packing is there: the height at which pouring stops, less one span at both ends.
Section expected_section(const Case& c, const Container& container) {
    const auto& geometry = c.settings.geometry;
    double top = container.height() / 2.0, extent = 0.0;
    if (!from_stl(c)) {
        const Path file = folder_of(c, "pack") / "packing.json";
        if (fs::exists(file)) return load_scene(file, container, geometry, 1.0).section;
        double volume = 0.0;
        for (const auto& [shape, share] : make_shapes(c.settings.shape)) {
            extent = std::max(extent, span(shape));
            volume += share * measure(shape, 1e-4).volume_m3;
        }
        if (c.settings.packing.fill_height_m > 0.0) top = c.settings.packing.fill_height_m;
        if (c.settings.packing.grains > 0)
            top = std::min(container.height(), static_cast<double>(c.settings.packing.grains) * volume / (0.4 * container.inner_area_m2()));
    }
    return choose_section(container, {.section_m = geometry.section_m, .trim_m = geometry.trim_m}, top, extent);
}

double finest_diameter(const Case& c) {
    double least = std::numeric_limits<double>::infinity();
    if (!from_stl(c))
        for (const auto& share : make_shapes(c.settings.shape)) least = std::min(least, smallest_diameter(share.shape));
    return least;
}

Json tortuosity_of_case(const Case& c, const Path& folder) {
    Json json;
    const auto& config = c.settings.tortuosity;
    const Scene scene = scene_of(c);
    if (!from_stl(c)) json["geometric_paper_exact"] = geometric_paper_stage(scene, config, folder);
    json["geometric_paper_pixels"] = geometric_paper_slices_stage(folder_of(c, "slices"), config, folder);
    if (config.shortest_path) json["shortest_path"] = shortest_path_stage(scene, c.settings.geometry, config, folder);
    if (config.diffusive) json["diffusive"] = diffusive_stage(scene, c.settings.geometry, config);
    if (c.settings.lbm.fields == "none") {
        const Json lbm = read_json(folder_of(c, "lbm") / "result.json");
        json["hydraulic"] = {{"kind", "hydraulic"},
                             {"uncertainty", nullptr},
                             {"tortuosity_hydraulic", lbm.at("hydraulic_tortuosity")},
                             {"direction", lbm.at("direction")}};
    } else {
        json["hydraulic"] = hydraulic_stage(folder_of(c, "lbm") / "flow.vti", {});
    }
    return json;
}

// By whatever stage knows it best.
std::pair<double, std::string> inertial_permeability(const Case& c, double pores) {
    if (c.settings.forchheimer.enabled)
        return {read_json(folder_of(c, "forchheimer") / "result.json").at("inertial_permeability_m").get<double>(),
                "the flows with inertia (lattice Boltzmann), extrapolated to the test's Reynolds numbers"};
    const Json shape = read_json(folder_of(c, "shape") / "result.json");
    if (!shape.contains("sphericity")) return {std::numeric_limits<double>::infinity(), "none: Darcy's law alone"};
    return {ergun_inertial_m(shape["sphericity"].get<double>(), shape["equal_volume_diameter_m"].get<double>(), pores), "Ergun"};
}

Json causes_of_case(const Case& c, const Path& folder) {
    const double k = read_json(folder_of(c, "lbm") / "result.json").at("permeability_m2").get<double>();
    const double pores = read_json(folder_of(c, "voxelise") / "result.json").at("porosity").get<double>();
    const auto [inertial, from] = inertial_permeability(c, pores);
    Json json = causes_stage(scene_of(c), k, inertial, apparatus_of_case(c), folder);
    json["inertial_permeability_from"] = from;
    return json;
}

Json falling_head_of_case(const Case& c, const Path& folder) {
    const Json lbm = read_json(folder_of(c, "lbm") / "result.json");
    const Json shape = read_json(folder_of(c, "shape") / "result.json");
    const double pores = read_json(folder_of(c, "voxelise") / "result.json").at("porosity").get<double>();
    const auto [inertial, from] = inertial_permeability(c, pores);
    Json correlations = Json::object();
    if (shape.contains("sphericity")) {
        const double psi = shape["sphericity"].get<double>(), d = shape["equal_volume_diameter_m"].get<double>();
        correlations["carman_kozeny_150_m2"] = carman_kozeny_m2(psi, d, pores, 150.0);
        correlations["carman_kozeny_180_m2"] = carman_kozeny_m2(psi, d, pores, 180.0);
        if (std::abs(shape["volume_m3"].get<double>() / 7.33e-7 - 1.0) < 0.01) correlations["paper_fit_m2"] = paper_fit_m2(pores);
    }
    Json json = falling_head_stage(lbm.at("permeability_m2").get<double>(), inertial, apparatus_of_case(c), &folder);
    json["permeability_from"] = "lbm";
    json["inertial_permeability_from"] = from;
    json["correlations"] = correlations;
    return json;
}

Json without(Json json, const char* table, const char* key) {
    json[table].erase(key);
    return json;
}

// The same case with the next seeds, as far as k. Each has its own folder of results, so that a stopped one goes on.
Json seeds_of_case(const Case& c, const Path& folder) {
    const long first = c.settings.packing.seed;
    std::vector<double> values, half_widths;
    std::string table = "seed,permeability_m2,half_width_m2\n";
    for (long seed = first; seed < first + c.settings.packing.seeds; ++seed) {
        Case one = c;
        one.settings.packing.seed = seed;
        one.settings.packing.seeds = 1;
        one.settings.lbm.fields = "none";
        one.output = c.results() / fmt::format("seed_{}", seed);
        if (seed != first) log_info("seed {}:", seed);
        const Json lbm = seed == first ? read_json(folder_of(c, "lbm") / "result.json") : run_case(one, "lbm");
        const Json& interval = lbm.at("permeability_interval_m2");
        values.push_back(lbm.at("permeability_m2").get<double>());
        half_widths.push_back(interval.is_array() ? 0.5 * (interval.at(1).get<double>() - interval.at(0).get<double>()) : 0.0);
        table += fmt::format("{},{:.9g},{:.9g}\n", seed, values.back(), half_widths.back());
    }
    write_text(folder / "seeds.csv", table);
    const auto n = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
    double squares = 0.0;
    for (const double k : values) squares += (k - mean) * (k - mean);
    const double deviation = std::sqrt(squares / (n - 1.0));
    return {{"packings", values.size()},
            {"permeability_mean_m2", mean},
            {"standard_deviation_between_packings_m2", deviation},
            {"standard_error_of_mean_m2", deviation / std::sqrt(n)},
            {"numerical_half_width_m2", *std::max_element(half_widths.begin(), half_widths.end())},
            {"meaning", "scatter between packings and numerical uncertainty of one (the largest) are apart"}};
}

Json report_of_case(const Case& c, const Path& folder) {
    ReportInput input{.title = c.settings.report.title.empty() ? fs::absolute(c.folder).lexically_normal().filename().string()
                                                               : c.settings.report.title};
    if (input.title.empty()) input.title = fs::absolute(c.folder).lexically_normal().parent_path().filename().string();
    Case copy = c;
    for (const auto& table : Settings::tables()) input.configuration[table] = to_json(copy.settings.describe_table(table));
    for (const auto& stage : stages_of(c)) {
        const Path at = folder_of(c, stage.name);
        if (stage.name == "report" || !fs::exists(at / "result.json")) continue;
        input.results[stage.name] = read_json(at / "result.json");
        input.manifests[stage.name] = read_json(at / "manifest.json");
    }
    input.versions = engine_versions();
    input.stage_folders = c.results();
    if (c.settings.report.pictures) {
        const Container container = make_container(c.settings.container);
        const Json& made = input.results.contains("pack") ? input.results["pack"] : input.results["stl"];
        const double shown =
            std::min(container.height(), 1.15 * made.value("bed_height_m", container.height()));  // the empty part is no news
        std::vector<std::string> more;
        if (container.kind == Container::Kind::cylinder)
            more = {"--container", fmt::format("cylinder:{:.9g},{:.9g}", container.diameter_m, shown)};
        if (!draw_picture(folder_of(c, "stl") / "solid.stl", folder / "packing.png", more))
            input.notes.push_back("No picture of the packing: rendering failed, see results/report/log.picture.");
    }
    return write_report(input, folder);
}

}  // namespace

FallingHeadConfig apparatus_of_case(const Case& c) {
    FallingHeadConfig config = c.settings.falling_head;
    const Path voxels = folder_of(c, "voxelise") / "result.json", tortuosity = folder_of(c, "tortuosity") / "result.json";
    if (config.sample_inertia == 0.0 && fs::exists(voxels)) {
        const double pores = read_json(voxels).at("porosity").get<double>();
        const Json ways = c.settings.tortuosity.diffusive && fs::exists(tortuosity) ? read_json(tortuosity) : Json::object();
        config.sample_inertia =
            ways.contains("diffusive") ? ways["diffusive"].at("tortuosity_diffusive").get<double>() / pores : std::pow(pores, -1.5);
    }
    return config;
}

std::vector<Stage> stages_of(const Case& c) {
    std::vector<Stage> stages;
    const Settings& s = c.settings;
    const bool stl = from_stl(c);
    const std::string solid = stl ? "stl" : "pack";
    const std::set<std::string> section_keys = {"section_m", "trim_m"};
    const auto with_section = [&](std::set<std::string> keys) {
        keys.insert(section_keys.begin(), section_keys.end());
        return keys;
    };
    const auto quick = [] { return std::string("seconds"); };
    const Path stl_file = stl ? c.resolve(s.shape.file) : Path();
    if (stl && s.shape.file.empty()) throw UserError("kind = \"stl\" needs a file", {.where = "[shape]", .mend = "file = \"grains.stl\""});

    stages.push_back({"shape",
                      {},
                      table_json(c, {"shape"}),
                      stl ? std::vector<Path>{stl_file} : std::vector<Path>{},
                      {},
                      [c, stl, stl_file](const Path&) {
                          return stl ? surface_shape_stage(stl_file, c.settings.shape.unit_m, c.settings.packing.density_kg_per_m3)
                                     : shape_stage(c.settings.shape, c.settings.packing.density_kg_per_m3);
                      },
                      quick});
    if (!stl) {
        std::vector<Path> given;
        if (s.packing.engine == "none" && !s.packing.file.empty()) given.push_back(c.resolve(s.packing.file));
        for (const auto& file : given) (void)sha256_of_file(file);
        stages.push_back({"pack",
                          {},
                          without(table_json(c, {"shape", "container", "packing"}), "packing", "seeds"),
                          given,
                          {"packing.json"},
                          [c](const Path& folder) { return pack_stage(c, folder); },
                          [c]() -> std::string {
                              if (c.settings.packing.engine == "none") return "seconds";
                              const PourPlan plan =
                                  plan_pour(make_shapes(c.settings.shape), make_container(c.settings.container), c.settings.packing);
                              const std::string engine =
                                  c.settings.packing.engine == "liggghts"
                                      ? fmt::format("LIGGGHTS, up to {} grains of {} spheres", plan.most_grains, plan.clump_spheres)
                                      : fmt::format("capsules, up to {} grains", plan.most_grains);
                              return fmt::format("{}, time step {:.2e} s; memory about {}, time about {}", engine, plan.time_step_s,
                                                 human_bytes(plan.expected_memory_bytes), human_time(plan.expected_wall_time_s));
                          },
                          c.settings.packing.engine != "none"});
    }
    const bool with_planes = s.stl.pores || s.stl.clip;
    const auto stl_needs = stl ? std::vector<std::string>{} : std::vector<std::string>{"pack"};
    stages.push_back({"stl",
                      stl_needs,
                      only(table_json(c, {"container", "shape", "geometry", "stl"}), "geometry",
                           with_planes ? with_section({"surface_deviation_m", "contact_gap_m"})
                                       : std::set<std::string>{"surface_deviation_m", "contact_gap_m"}),
                      stl ? std::vector<Path>{stl_file} : std::vector<Path>{},
                      {"solid.stl"},
                      [c, stl, stl_file, with_planes](const Path& folder) {
                          const Container container = make_container(c.settings.container);
                          const Path file = stl ? stl_file : folder_of(c, "pack") / "packing.json";
                          const double unit = stl ? c.settings.shape.unit_m : 1.0;
                          return stl_stage(
                              with_planes ? load_scene(file, container, c.settings.geometry, unit) : load_bed(file, container, unit),
                              c.settings.geometry, c.settings.stl, folder);
                      },
                      quick});
    stages.push_back({"voxelise",
                      {solid},
                      only(table_json(c, {"container", "geometry"}), "geometry", with_section({"voxel_size_m", "reservoir_m"})),
                      {},
                      {"pore.vti"},
                      [c](const Path& folder) { return voxelise_stage(scene_of(c), c.settings.geometry, folder); },
                      quick});
    stages.push_back({"slices",
                      {solid},
                      only(table_json(c, {"container", "geometry"}), "geometry", with_section({"slice_spacing_m", "slice_pixel_m"})),
                      {},
                      {"slices.json", "*.png"},
                      [c](const Path& folder) { return slices_stage(scene_of(c), c.settings.geometry, folder); },
                      quick});
    stages.push_back(
        {"lbm",
         {solid},
         only(table_json(c, {"container", "geometry", "lbm"}), "geometry", with_section({"voxel_size_m", "reservoir_m"})),
         {},
         s.lbm.fields == "none" ? std::vector<std::string>{"history.csv"} : std::vector<std::string>{"flow.vti", "history.csv"},
         [c](const Path& folder) {
             return lbm_stage(scene_of(c), c.settings.geometry, c.settings.lbm, folder, c.results() / "lbm.checkpoint");
         },
         [c]() -> std::string {
             const Container container = make_container(c.settings.container);
             const double d = finest_diameter(c), h = c.settings.geometry.voxel_size_m > 0.0 ? c.settings.geometry.voxel_size_m : d / 10.0;
             return expect_text(expect_lbm(container, expected_section(c, container), h, std::isfinite(d) ? d : 10.0 * h,
                                           expected_porosity(c), c.settings.geometry, c.settings.lbm));
         }});
    if (s.openfoam.enabled)
        stages.push_back(
            {"foam",
             stl ? std::vector<std::string>{"stl"} : std::vector<std::string>{"pack", "stl"},
             only(table_json(c, {"container", "geometry", "openfoam"}), "geometry", section_keys),
             {},
             {},
             [c](const Path& folder) { return foam_stage(scene_of(c, true), c.settings.geometry, c.settings.openfoam, folder); },
             [c]() -> std::string {
                 const Container container = make_container(c.settings.container);
                 const double d = finest_diameter(c),
                              cell = c.settings.openfoam.cell_size_m > 0.0 ? c.settings.openfoam.cell_size_m : d / 4.0;
                 return expect_text(
                     expect_foam(container, expected_section(c, container), cell, expected_porosity(c), c.settings.openfoam));
             },
             true});
    if (!stl && s.packing.seeds > 1 && s.packing.engine != "none")
        stages.push_back({"seeds",
                          {"lbm"},
                          {{"packing", {{"seeds", s.packing.seeds}}}},
                          {},
                          {"seeds.csv"},
                          [c](const Path& folder) { return seeds_of_case(c, folder); },
                          [s] { return fmt::format("{} more packings, each like pack and lbm", s.packing.seeds - 1); }});
    auto tortuosity_needs = std::vector<std::string>{"slices", "lbm"};
    if (!stl) tortuosity_needs.insert(tortuosity_needs.begin(), "pack");
    stages.push_back({"tortuosity",
                      tortuosity_needs,
                      only(table_json(c, {"container", "tortuosity", "geometry"}), "geometry", with_section({"voxel_size_m"})),
                      {},
                      {"*.vtp"},
                      [c](const Path& folder) { return tortuosity_of_case(c, folder); },
                      [c]() -> std::string {
                          const auto& settings = c.settings;
                          const Container container = make_container(settings.container);
                          const double d = finest_diameter(c),
                                       h = settings.geometry.voxel_size_m > 0.0 ? settings.geometry.voxel_size_m : d / 10.0;
                          const Vec3 inner = container.high() - container.low();
                          const double cells = inner.x() * inner.y() * expected_section(c, container).length() / (h * h * h);
                          Expectation expected = expect_tortuosity("geometric_paper", cells);
                          for (const auto& [wanted, kind] : {std::pair(settings.tortuosity.shortest_path, "shortest_path"),
                                                             std::pair(settings.tortuosity.diffusive, "diffusive")})
                              if (wanted) {
                                  const Expectation one = expect_tortuosity(kind, cells);
                                  expected.memory_bytes = std::max(expected.memory_bytes, one.memory_bytes);
                                  expected.wall_time_s += one.wall_time_s;
                                  expected.text = one.text;
                              }
                          return expect_text(expected);
                      }});
    if (s.forchheimer.enabled)
        stages.push_back(
            {"forchheimer",
             {solid},
             only(table_json(c, {"container", "geometry", "forchheimer"}), "geometry", section_keys),
             {},
             {"forchheimer.csv"},
             [c](const Path& folder) { return forchheimer_stage(scene_of(c), c.settings.geometry, c.settings.forchheimer, folder); },
             [c]() -> std::string {
                 if (!fs::exists(folder_of(c, "pack") / "packing.json") && !from_stl(c)) return "as soon as there is a packing";
                 return expect_text(expect_forchheimer(scene_of(c), c.settings.forchheimer));
             },
             true});
    auto head_needs = std::vector<std::string>{"shape", "voxelise", "lbm"};
    if (s.forchheimer.enabled) head_needs.emplace_back("forchheimer");
    if (s.tortuosity.diffusive) head_needs.emplace_back("tortuosity");  // for the inertia of the sample's water
    stages.push_back({"falling-head",
                      head_needs,
                      table_json(c, {"falling_head"}),
                      {},
                      {"falling_head.csv"},
                      [c](const Path& folder) { return falling_head_of_case(c, folder); },
                      quick});
    if (s.falling_head.causes)
        stages.push_back({"causes",
                          head_needs,
                          only(table_json(c, {"container", "geometry", "falling_head"}), "geometry", section_keys),
                          {},
                          {"causes.csv"},
                          [c](const Path& folder) { return causes_of_case(c, folder); },
                          [] { return std::string("some 900 simulated tests and three coarse flows; about a minute"); }});
    std::vector<std::string> everything;
    everything.reserve(stages.size());
    // The surface of a packing is made only for what shows or meshes it.
    const bool surface_wanted = stl || s.openfoam.enabled || s.report.pictures || with_planes;
    for (const auto& stage : stages)
        if (stage.name != "stl" || surface_wanted) everything.push_back(stage.name);
    stages.push_back({"report",
                      everything,
                      table_json(c, {"report"}),
                      {},
                      {"report.html", "report.md"},
                      [c](const Path& folder) { return report_of_case(c, folder); },
                      quick});
    return stages;
}

}  // namespace porepack
