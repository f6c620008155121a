#include "apps/pipeline.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <set>

#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "openfoam/foam.hpp"
#include "packing/liggghts.hpp"
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

std::string expect_text(const Expectation& expected) {
    return fmt::format("{}; memory about {}, time about {}", expected.text, human_bytes(expected.memory_bytes),
                       human_time(expected.wall_time_s));
}

Json tortuosity_of_case(const Case& c) {
    Json json;
    const auto& config = c.settings.tortuosity;
    if (!from_stl(c)) json["geometric_paper_exact"] = geometric_paper_stage(scene_of(c), config);
    json["geometric_paper_pixels"] = geometric_paper_slices_stage(folder_of(c, "slices"), config);
    json["hydraulic"] = hydraulic_stage(folder_of(c, "lbm") / "flow.vti", {});
    return json;
}

Json falling_head_of_case(const Case& c, const Path& folder) {
    const Json lbm = read_json(folder_of(c, "lbm") / "result.json");
    const Json shape = read_json(folder_of(c, "shape") / "result.json");
    const double pores = read_json(folder_of(c, "voxelise") / "result.json").at("porosity").get<double>();
    double inertial = std::numeric_limits<double>::infinity();
    Json correlations = Json::object();
    if (shape.contains("sphericity")) {
        const double psi = shape["sphericity"].get<double>(), d = shape["equal_volume_diameter_m"].get<double>();
        inertial = ergun_inertial_m(psi, d, pores);
        correlations["carman_kozeny_150_m2"] = carman_kozeny_m2(psi, d, pores, 150.0);
        correlations["carman_kozeny_180_m2"] = carman_kozeny_m2(psi, d, pores, 180.0);
        if (std::abs(shape["volume_m3"].get<double>() / 7.33e-7 - 1.0) < 0.01) correlations["paper_fit_m2"] = paper_fit_m2(pores);
    }
    Json json = falling_head_stage(lbm.at("permeability_m2").get<double>(), inertial, c.settings.falling_head, &folder);
    json["permeability_from"] = "lbm";
    json["inertial_permeability_from"] = shape.contains("sphericity") ? "Ergun" : "none: Darcy's law alone";
    json["correlations"] = correlations;
    return json;
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

std::string shell_quoted(const std::string& text) {
    if (text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+./,:=") == std::string::npos) return text;
    std::string quoted = "'";
    for (const char ch : text) quoted += ch == '\'' ? std::string("'\\''") : std::string(1, ch);
    return quoted + "'";
}

std::map<std::string, std::string> digests_of(const Case& c, const Stage& stage) {
    std::map<std::string, std::string> digests;
    for (const auto& file : stage.files) digests[file.filename().string()] = sha256_of_file(file);
    for (const auto& need : stage.needs) {
        const Path manifest = folder_of(c, need) / "manifest.json";
        if (!fs::exists(manifest)) {
            digests[need] = "missing";
            continue;
        }
        // Cost is no input: result.json holds seconds, so the key of the stage stands for it.
        try {
            const Json content = read_json(manifest);
            Json outputs = content.at("outputs_sha256");
            outputs.erase("result.json");
            digests[need] = sha256(content.at("key").get<std::string>() + outputs.dump());
        } catch (const std::exception&) {
            digests[need] = "unreadable";
        }
    }
    return digests;
}

Manifest expected_manifest(const Case& c, const Stage& stage) {
    Manifest manifest{.stage = stage.name, .configuration = stage.configuration};
    manifest.inputs = digests_of(c, stage);
    manifest.seed = c.settings.packing.seed;
    manifest.processes = stage.name == "pack" ? c.settings.packing.processes : 1;
    return manifest;
}

StageState state_in(const Case& c, const Stage& stage, std::string* why) {
    for (const auto& need : stage.needs)
        if (!fs::exists(folder_of(c, need) / "manifest.json")) {
            if (why != nullptr) *why = "needs " + need;
            return fs::exists(folder_of(c, stage.name)) ? StageState::stale : StageState::missing;
        }
    const StageState state = state_of(folder_of(c, stage.name), expected_manifest(c, stage), why);
    if (state == StageState::done) return state;
    if (fs::exists(c.results() / (stage.name + ".failed"))) return StageState::failed;
    if (fs::exists(c.results() / ("." + stage.name + ".running"))) return StageState::running;
    return state;
}

std::vector<std::string> files_in(const Path& folder, const std::vector<std::string>& patterns) {
    std::vector<std::string> names = {"result.json"};
    for (const auto& pattern : patterns) {
        if (pattern.front() != '*') {
            names.push_back(pattern);
            continue;
        }
        for (const auto& entry : fs::directory_iterator(folder))
            if (entry.path().extension() == pattern.substr(1)) names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin() + 1, names.end());
    return names;
}

// In a catch block: ends the stage and throws on. A failed stage keeps its folder, and the message names files where they
// now are; an interrupted one leaves nothing.
[[noreturn]] void keep_what_is_left(const Path& running, const Path& failed) {
    std::error_code ignored;
    try {
        throw;
    } catch (const Error& error) {
        if (interrupted()) {
            fs::remove_all(running, ignored);
            throw;
        }
        fs::remove_all(failed, ignored);
        fs::rename(running, failed, ignored);
        std::string text = error.what();
        for (std::size_t at = 0; (at = text.find(running.string(), at)) != std::string::npos; at += failed.string().size())
            text.replace(at, running.string().size(), failed.string());
        throw Error(error.code(), text);
    } catch (...) {
        fs::remove_all(running, ignored);
        throw;
    }
}

// Removes the running folder whatever happens; keeps it as .failed when the stage failed (not when it was interrupted).
Json run_stage(const Case& c, const Stage& stage) {
    const Path running = c.results() / ("." + stage.name + ".running"), final = folder_of(c, stage.name),
               failed = c.results() / (stage.name + ".failed");
    fs::remove_all(running);
    fs::remove_all(failed);
    make_folder(running);
    log_info("{}: runs", stage.name);
    reset_peak_memory();
    (void)take_peak_program_memory_bytes();
    const Stopwatch watch;
    Manifest manifest = expected_manifest(c, stage);
    try {
        const Json result = stage.run(running);
        check_interrupt();
        Json whole = result;
        whole["wall_time_s"] = watch.seconds();
        write_json(running / "result.json", whole);
        for (const auto& name : files_in(running, stage.outputs)) manifest.outputs[name] = sha256_of_file(running / name);
        manifest.versions = engine_versions();
        manifest.wall_time_s = watch.seconds();
        manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
        write_json(running / "manifest.json", to_json(manifest));
        fs::remove_all(final);
        fs::rename(running, final);
        log_info("{}: done in {}", stage.name, human_time(manifest.wall_time_s));
        if (whole.contains("repeat_by_hand"))
            log_info("{}: by hand: cd {} && {}", stage.name, shell_quoted(fs::absolute(final).lexically_normal().string()),
                     whole["repeat_by_hand"].get<std::string>());
        return whole;
    } catch (...) {
        keep_what_is_left(running, failed);
    }
}

// One run at a time in a case.
class Lock {
public:
    explicit Lock(const Path& results) {
        require_writable(results);
        file_ = open((results / ".lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
        if (file_ < 0 || flock(file_, LOCK_EX | LOCK_NB) != 0)
            throw UserError("another porepack runs in this case", {.where = results.string(), .mend = "wait for it, or end it"});
    }
    ~Lock() {
        if (file_ >= 0) close(file_);
    }
    Lock(const Lock&) = delete;
    Lock& operator=(const Lock&) = delete;

private:
    int file_ = -1;
};

// The stages that `last` needs, in order; all when empty.
std::vector<Stage> stages_up_to(const Case& c, const std::string& last) {
    auto all = stages_of(c);
    if (last.empty()) return all;
    std::set<std::string> wanted = {last};
    for (auto stage = all.rbegin(); stage != all.rend(); ++stage)
        if (wanted.contains(stage->name)) wanted.insert(stage->needs.begin(), stage->needs.end());
    if (std::none_of(all.begin(), all.end(), [&](const Stage& stage) { return stage.name == last; }))
        throw UserError("this case has no stage " + last,
                        {.mend = "openfoam.enabled = false leaves foam out; a case from an STL file has no pack"});
    std::erase_if(all, [&](const Stage& stage) { return !wanted.contains(stage.name); });
    return all;
}

}  // namespace

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
        stages.push_back(
            {"pack",
             {},
             table_json(c, {"shape", "container", "packing"}),
             given,
             {"packing.json"},
             [c](const Path& folder) { return pack_stage(c, folder); },
             [c]() -> std::string {
                 if (c.settings.packing.engine == "none") return "seconds";
                 const PourPlan plan = plan_pour(make_shapes(c.settings.shape), make_container(c.settings.container), c.settings.packing);
                 return fmt::format("LIGGGHTS, up to {} grains of {} spheres, time step {:.2e} s; memory about {}, time about {}",
                                    plan.most_grains, plan.clump_spheres, plan.time_step_s, human_bytes(plan.expected_memory_bytes),
                                    human_time(plan.expected_wall_time_s));
             }});
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
    stages.push_back({"lbm",
                      {solid},
                      only(table_json(c, {"container", "geometry", "lbm"}), "geometry", with_section({"voxel_size_m", "reservoir_m"})),
                      {},
                      {"flow.vti", "history.csv"},
                      [c](const Path& folder) { return lbm_stage(scene_of(c), c.settings.geometry, c.settings.lbm, folder); },
                      [c]() -> std::string {
                          const Container container = make_container(c.settings.container);
                          const double d = finest_diameter(c),
                                       h = c.settings.geometry.voxel_size_m > 0.0 ? c.settings.geometry.voxel_size_m : d / 10.0;
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
             }});
    auto tortuosity_needs = std::vector<std::string>{"slices", "lbm"};
    if (!stl) tortuosity_needs.insert(tortuosity_needs.begin(), "pack");
    stages.push_back({"tortuosity",
                      tortuosity_needs,
                      only(table_json(c, {"tortuosity", "geometry"}), "geometry", section_keys),
                      {},
                      {},
                      [c](const Path&) { return tortuosity_of_case(c); },
                      quick});
    stages.push_back({"falling-head",
                      {"shape", "voxelise", "lbm"},
                      table_json(c, {"falling_head"}),
                      {},
                      {"falling_head.csv"},
                      [c](const Path& folder) { return falling_head_of_case(c, folder); },
                      quick});
    std::vector<std::string> everything;
    everything.reserve(stages.size());
    for (const auto& stage : stages) everything.push_back(stage.name);
    stages.push_back({"report",
                      everything,
                      table_json(c, {"report"}),
                      {},
                      {"report.html", "report.md"},
                      [c](const Path& folder) { return report_of_case(c, folder); },
                      quick});
    return stages;
}

std::vector<StageStatus> status_of(const Case& c) {
    std::vector<StageStatus> list;
    for (const auto& stage : stages_of(c)) {
        StageStatus status{.name = stage.name, .state = StageState::missing, .why = {}};
        status.state = state_in(c, stage, &status.why);
        if (status.state == StageState::done) {
            status.wall_time_s = read_json(folder_of(c, stage.name) / "manifest.json").value("wall_time_s", 0.0);
            for (const auto& need : stage.needs)
                for (const auto& other : list)
                    if (other.name == need && other.state != StageState::done) {
                        status.state = StageState::stale;
                        status.why = other.name + " is " + name_of(other.state);
                    }
        }
        list.push_back(status);
    }
    return list;
}

Json run_case(const Case& c, const std::string& last) {
    const Lock lock(c.results());
    Json result;
    for (const auto& stage : stages_up_to(c, last)) {
        check_interrupt();
        std::string why;
        const StageState state = state_in(c, stage, &why);
        if (state == StageState::done) {
            log_info("{}: already done", stage.name);
            result = read_json(folder_of(c, stage.name) / "result.json");
        } else {
            if (state == StageState::stale) log_info("{}: done before, but {}", stage.name, why);
            result = run_stage(c, stage);
        }
        if (stage.name == "report")
            for (const char* name : {"report.html", "report.md", "result.json"}) {
                // The report's pictures lie beside it in results/report; the page itself holds all of them.
                const Path source =
                    std::string(name) == "result.json" ? folder_of(c, "report") / "merged.json" : folder_of(c, "report") / name;
                const std::string text = read_text(source);
                if (!fs::exists(c.results() / name) || read_text(c.results() / name) != text) write_text(c.results() / name, text);
            }
    }
    return result;
}

Json plan_case(const Case& c, const std::string& last) {
    Json plan = {{"configuration", Json::object()}, {"stages", Json::array()}};
    Case copy = c;
    for (const auto& table : Settings::tables()) plan["configuration"][table] = to_json(copy.settings.describe_table(table));
    for (const auto& stage : stages_up_to(c, last)) {
        std::string why;
        const StageState state = state_in(c, stage, &why);
        plan["stages"].push_back({{"stage", stage.name},
                                  {"state", name_of(state)},
                                  {"would_run", state != StageState::done},
                                  {"expected", state == StageState::done ? "nothing" : stage.expect()}});
    }
    plan["memory_available"] = human_bytes(available_memory_bytes());
    return plan;
}

Json engine_versions() {
    static const Json versions = {{"liggghts", first_line_of("liggghts -log none -h")},
                                  {"openfoam", first_line_of("dpkg-query -W -f '${Version}' openfoam")},
                                  {"mpirun", first_line_of("mpirun --version")},
                                  {"gnuplot", first_line_of("gnuplot --version")}};
    return versions;
}

namespace {

// Tells a folder that a loose stage may replace from one of the user's own.
constexpr const char* owner_mark = ".porepack";

}  // namespace

Json run_loose(const std::string& stage, const Path& target, const Json& configuration, const std::vector<Path>& inputs,
               const std::function<Json(const Path&)>& work) {
    require_writable(target);
    const Path running = target / fmt::format(".{}.{}.running", stage, getpid());
    make_folder(running);
    const Stopwatch watch;
    try {
        Json result = work(running);
        check_interrupt();
        result["wall_time_s"] = watch.seconds();
        Manifest manifest{.stage = stage, .configuration = configuration};
        for (const auto& input : inputs)
            if (!fs::is_directory(input)) manifest.inputs[input.filename().string()] = sha256_of_file(input);
        manifest.versions = engine_versions();
        write_json(running / (stage + ".result.json"), result);
        for (const auto& entry : fs::directory_iterator(running))
            if (entry.is_regular_file())
                manifest.outputs[entry.path().filename().string()] = sha256_of_file(entry.path());
            else if (entry.is_directory())
                write_text(entry.path() / owner_mark, "This folder was written by porepack and is replaced as a whole.\n");
        manifest.wall_time_s = watch.seconds();
        manifest.peak_memory_bytes = std::max(peak_memory_bytes(), take_peak_program_memory_bytes());
        write_json(running / (stage + ".manifest.json"), to_json(manifest));
        for (const auto& entry : fs::directory_iterator(running)) {
            const Path there = target / entry.path().filename();
            for (const auto& input : inputs)
                if (std::error_code none; fs::equivalent(there, input, none))
                    throw UserError("the result would overwrite its own input " + there.string(),
                                    {.mend = "choose another folder with --output"});
            if (fs::is_directory(there)) {
                if (!fs::exists(there / owner_mark))
                    throw UserError("the folder " + there.string() + " is in the way and was not written by porepack",
                                    {.mend = "move it, or choose another folder with --output"});
                fs::remove_all(there);
            }
            fs::rename(entry.path(), there);
        }
        fs::remove_all(running);
        return result;
    } catch (const Error& error) {
        // An engine's logs are worth keeping.
        if (error.code() == ExitCode::engine) keep_what_is_left(running, target / (stage + ".failed"));
        std::error_code ignored;
        fs::remove_all(running, ignored);
        throw;
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(running, ignored);
        throw;
    }
}

}  // namespace porepack
