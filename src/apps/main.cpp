// The command line. Thin: it reads flags, calls a stage or the pipeline, prints the result.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <unistd.h>

#include <cmath>

#include "apps/benchmark.hpp"
#include "apps/pipeline.hpp"
#include "apps/stages.hpp"
#include "apps/sweep.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/manifest.hpp"
#include "core/process.hpp"
#include "io/render.hpp"
#include "permeability/permeability.hpp"

namespace porepack {
namespace {

// What all commands share.
struct Common {
    bool json = false;
    bool dry_run = false;
    int threads = 0;
    std::string output;
    std::string container;
    double unit_m = 1.0;
    std::string input;
    Flags flags;  // keys of the configuration given as flags
};

void add_common(CLI::App& command, Common& common, const std::string& example) {
    command.add_flag("--json", common.json, "result as JSON on stdout, log on stderr");
    command.add_flag("--dry-run", common.dry_run, "print the resolved configuration, what would run, memory and time; run nothing");
    command.add_option("--threads", common.threads, "threads of parallel loops (default: all cores)")->check(CLI::Range(1, 1024));
    command.add_option("--output", common.output, "folder for the results (default: beside the input)");
    command.footer("Example:\n  " + example);
}

// Every key of a table is a flag: voxel_size_m is --voxel-size, in metres. The file's rules check the value.
void add_keys(CLI::App& command, Flags& flags, const Describe& describe, const std::vector<std::string>& leave_out = {}) {
    for (const auto& row : key_rows(describe)) {
        if (std::find(leave_out.begin(), leave_out.end(), row.key) != leave_out.end() || row.type == "array of tables") continue;
        const std::string unit = row.unit.empty() ? "" : " [" + row.unit + ", SI]";
        const std::string key = row.key;
        command.add_option_function<std::string>(
            flag_of(row.key), [&flags, key](const std::string& value) { flags[key] = value; },
            row.meaning + unit + "; default " + (row.standard.empty() ? "none" : row.standard));
    }
}

void print_lines(const Json& json, const std::string& indent = "") {
    for (const auto& [key, value] : json.items()) {
        if (value.is_object()) {
            fmt::print("{}{}:\n", indent, key);
            print_lines(value, indent + "  ");
        } else if (value.is_array() && !value.empty() && value.front().is_object()) {
            for (const auto& entry : value) {
                fmt::print("{}{}:\n", indent, key);
                print_lines(entry, indent + "  ");
            }
        } else if (value.is_number_float()) {
            fmt::print("{}{}: {:.6g}\n", indent, key, value.get<double>());
        } else {
            fmt::print("{}{}: {}\n", indent, key, value.is_string() ? value.get<std::string>() : value.dump());
        }
    }
}

void print_result(const Common& common, const Json& json) {
    if (common.json)
        fmt::print("{}\n", json.dump(2));
    else
        print_lines(json);
}

bool is_case(const Path& input) {
    return std::filesystem::is_directory(input) ? std::filesystem::exists(input / "case.toml") : input.extension() == ".toml";
}

std::optional<Container> container_of(const Common& common) {
    if (common.container.empty()) return std::nullopt;
    return parse_container(common.container);
}

// Reads flags into a table's struct by the rules of the file.
template <typename Config>
Config from_flags(const Flags& flags) {
    Config config;
    TomlFile().read(
        "", [&](ConfigVisitor& v) { describe(v, config); }, flags);
    return config;
}

// The keys of `flags` that belong to a table: a command may carry keys of two tables.
template <typename Config>
Flags flags_of(const Flags& flags) {
    Config config;
    Flags own;
    for (const auto& row : key_rows([&](ConfigVisitor& v) { describe(v, config); }))
        if (const auto found = flags.find(row.key); found != flags.end()) own.insert(*found);
    return own;
}

// The case with its results where --output says.
Case open_case(const Common& common, const std::string& table = {}, const Flags& flags = {}) {
    if (!common.container.empty() || common.unit_m != 1.0)
        throw UserError("a case says itself what its container and unit are", {.mend = "leave --container and --unit out; see case.toml"});
    Case the_case = read_case(common.input, table, flags);
    the_case.output = common.output;
    return the_case;
}

void run_in_case(const Common& common, const std::string& stage, const std::string& table) {
    const Case the_case = open_case(common, table, common.flags);
    if (common.dry_run) return print_result(common, plan_case(the_case, stage));
    print_result(common, run_case(the_case, stage));
}

// Where loose files go: --output, else beside the input.
Path target_folder(const Common& common) {
    const Path target = common.output.empty() ? Path(common.input).parent_path() : Path(common.output);
    return target.empty() ? Path(".") : target;
}

// A stage on loose files; `work` gets the scene and a folder.
void run_on_scene(const Common& common, const std::string& stage, const GeometryConfig& geometry, const Json& configuration,
                  const std::function<Json(const Scene&, const Path&)>& work, const std::function<std::string(const Scene&)>& expect = {},
                  bool with_section = true, bool goes_on = false) {
    const bool is_packing = Path(common.input).extension() == ".json" || Path(common.input).extension() == ".gz";
    if (is_packing && (!common.container.empty() || common.unit_m != 1.0))
        throw UserError("a packing brings its own container, in metres",
                        {.where = common.input, .mend = "leave --container and --unit out"});
    const Scene scene = with_section ? load_scene(common.input, container_of(common), geometry, common.unit_m)
                                     : load_bed(common.input, container_of(common), common.unit_m);
    if (common.dry_run)
        return print_result(common, {{"configuration", configuration},
                                     {"stage", stage},
                                     {"section_m", {scene.section.z0, scene.section.z1}},
                                     {"expected", expect ? expect(scene) : "seconds"},
                                     {"memory_available", human_bytes(available_memory_bytes())}});
    const Path target = target_folder(common);
    print_result(common,
                 run_loose(
                     stage, target, configuration, {common.input}, [&](const Path& folder) { return work(scene, folder); }, goes_on));
}

template <typename Config>
Json resolved(const Config& config) {
    Config copy = config;
    return to_json([&](ConfigVisitor& v) { describe(v, copy); });
}

void print_status(const Common& common) {
    const auto list = status_of(open_case(common));
    Json json = Json::array();
    for (const auto& entry : list) {
        json.push_back({{"stage", entry.name}, {"state", name_of(entry.state)}, {"why", entry.why}, {"wall_time_s", entry.wall_time_s}});
        if (!common.json)
            fmt::print("{:<13} {:<15} {}\n", entry.name, name_of(entry.state),
                       entry.state == StageState::done ? human_time(entry.wall_time_s) : entry.why);
    }
    if (common.json) fmt::print("{}\n", json.dump(2));
}

void print_main_numbers(const Common& common, const Case& the_case, const Json& report) {
    if (common.json) {
        fmt::print("{}\n", read_json(the_case.results() / "result.json").dump(2));
        return;
    }
    for (const auto& entry : report.at("main_numbers"))
        fmt::print("{:<28} {}\n", entry["label"].get<std::string>(), entry["text"].get<std::string>());
    fmt::print("report: {}\n", std::filesystem::absolute(the_case.results() / "report.html").lexically_normal().string());
}

std::string version_text() {
    std::string text = fmt::format("porepack {} ({})\n", program_version(), git_hash());
    const Json versions = engine_versions();
    for (const auto& [name, version] : versions.items())
        text += fmt::format("  {:<10} {}\n", name, version.get<std::string>().empty() ? "not found" : version.get<std::string>());
    text.pop_back();
    return text;
}

std::string key_reference() {
    Settings settings;
    std::string text;
    for (const auto& table : Settings::tables()) {
        text += "\n## [" + table + "]\n\n| key | type | default | allowed | meaning |\n|---|---|---|---|---|\n";
        for (const auto& row : key_rows(settings.describe_table(table)))
            text += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.key, row.type, row.standard.empty() ? "–" : row.standard,
                                row.allowed.empty() ? "–" : row.allowed, row.meaning);
    }
    return text;
}

// Without a display the command is run again under xvfb-run, which brings one.
void render_under_some_display(const std::vector<std::string>& arguments) {
    if (std::getenv("DISPLAY") != nullptr) return;
    require_program("xvfb-run", "xvfb xauth");
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    std::vector<const char*> words = {"xvfb-run", "-a", self.c_str()};
    for (const auto& argument : arguments) words.push_back(argument.c_str());
    words.push_back(nullptr);
    execvp(words[0], const_cast<char* const*>(words.data()));
    throw EngineError("cannot start xvfb-run");
}

// Builds the commands. Each callback runs after parsing, so a throw reaches main.
class CommandLine {
public:
    CommandLine() {
        app_.require_subcommand(0, 1);
        app_.set_version_flag("--version", version_text);
        app_.footer(
            "Exit codes: 0 done, 2 the input, 3 a numerical failure, 4 an engine is missing or failed, 5 interrupted or the "
            "machine.\nExample:\n  porepack run cases/quickstart");
        add_case_commands();
        add_shape();
        add_geometry_commands();
        add_flow_commands();
        add_tortuosity();
        add_falling_head();
        add_tools();
    }

    int run(int argc, char** argv) {
        arguments_.assign(argv + 1, argv + argc);
        try {
            app_.parse(argc, argv);
            set_thread_count(common_.threads);
            if (app_.get_subcommands().empty()) fmt::print("{}", app_.help());
            if (action_) action_();
            if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
                throw MachineError("the result could not be written to the standard output",
                                   {.mend = "is the disk full, or the pipe closed?"});
        } catch (const CLI::ParseError& fault) {
            if (fault.get_exit_code() == 0) return app_.exit(fault);
            log_raw(fmt::format("error: {}\n  mend:    porepack {}--help shows what is allowed\n", fault.what(), command_path()));
            return static_cast<int>(ExitCode::user);
        }
        return 0;
    }

private:
    // "falling-head simulate ", as it was typed.
    [[nodiscard]] std::string command_path() const {
        std::string path;
        for (const CLI::App* at = &app_; !at->get_subcommands().empty(); path += at->get_name() + " ") at = at->get_subcommands().front();
        return path;
    }

    CLI::App& command(const std::string& name, const std::string& help, const std::string& example, std::function<void()> action) {
        CLI::App& sub = *app_.add_subcommand(name, help);
        add_common(sub, common_, example);
        sub.callback([this, action = std::move(action)] { action_ = action; });
        return sub;
    }

    void add_case_commands() {
        auto& run = command("run", "run all stages of a case that are not done", "porepack run cases/quickstart", [this] {
            const Case the_case = open_case(common_);
            if (common_.dry_run) return print_result(common_, plan_case(the_case));
            const Json report = run_case(the_case);
            print_main_numbers(common_, the_case, report);
        });
        run.add_option("case", common_.input, "folder with case.toml")->required();
        auto& status = command("status", "what is done, stale, failed or missing in a case", "porepack status cases/quickstart",
                               [this] { print_status(common_); });
        status.add_option("case", common_.input, "folder with case.toml")->required();
        auto& pack = command("pack", "pour the grains of a case (exact capsules, or LIGGGHTS)", "porepack pack cases/quickstart --seed 7",
                             [this] { run_in_case(common_, "pack", "packing"); });
        pack.add_option("case", common_.input, "folder with case.toml")->required();
        add_keys(pack, common_.flags, settings_.describe_table("packing"));
        auto& report = command("report", "write the report of a case, running what it needs", "porepack report cases/quickstart",
                               [this] { run_in_case(common_, "report", "report"); });
        report.add_option("case", common_.input, "folder with case.toml")->required();
        add_keys(report, common_.flags, settings_.describe_table("report"));
    }

    void sweep() {
        const auto config = from_flags<ShapeConfig>(common_.flags);
        const double volume = config.volume_m3 > 0.0 ? config.volume_m3 : 7.33e-7;
        if (common_.dry_run) return print_result(common_, {{"volume_m3", volume}, {"expected", "171 shapes, about ten seconds"}});
        const Path target = common_.output.empty() ? Path("sweep") : Path(common_.output);
        const Json result =
            run_loose("sweep", target, {{"volume_m3", volume}}, {}, [&](const Path& folder) { return sweep_stage(volume, folder); });
        if (!draw_picture(target / "grains.stl", target / "grains.png", {"--front"}))
            log_warning("no picture of the grains: see " + (target / "log.picture").string());
        print_result(common_, result);
    }

    void add_shape() {
        auto& shape = command(
            "shape", "volume, surface, sphericity, inertia of a grain", "porepack shape tetrapod --sphericity 0.53 --volume 7.33e-7",
            [this] {
                if (sweep_) return sweep();
                Flags flags = common_.flags;
                ShapeConfig config;
                if (!capsules_file_.empty()) {
                    const TomlFile file{Path(capsules_file_)};
                    flags["kind"] = "\"capsules\"";
                    file.read(
                        file.has("shape") ? "shape" : "", [&](ConfigVisitor& v) { describe(v, config); }, flags);
                } else {
                    if (common_.input.ends_with(".stl") || common_.input.ends_with(".STL"))
                        return print_result(common_, surface_shape_stage(common_.input, common_.unit_m, density_));
                    if (common_.input.empty())
                        throw UserError("which shape?", {.allowed = "tetrapod, dolos, tetrahedron, star, sphere, rod, or --capsules FILE"});
                    flags["kind"] = "\"" + common_.input + "\"";
                    TomlFile().read(
                        "", [&](ConfigVisitor& v) { describe(v, config); }, flags);
                }
                if (common_.dry_run) return print_result(common_, {{"configuration", resolved(config)}, {"expected", "seconds"}});
                if (common_.output.empty()) return print_result(common_, shape_stage(config, density_));
                print_result(common_, run_loose("shape", common_.output, resolved(config), {},
                                                [&](const Path&) { return shape_stage(config, density_); }));
            });
        shape.add_option("kind", common_.input, "tetrapod, dolos, tetrahedron, star, sphere, rod, or an STL file");
        shape.add_flag("--sweep", sweep_, "figure 7: convexity against sphericity of the paper's aggregates, as CSV, plot and picture");
        shape.add_option("--capsules", capsules_file_, "TOML file with [[capsule]] tables (a_m, b_m, radius_m) in metres");
        shape.add_option("--unit", common_.unit_m, "metres a unit of the STL file (0.001: millimetres); default 1")
            ->check(CLI::PositiveNumber);
        shape.add_option("--density", density_, "density for mass and inertia [kg/m3]; default 1000")->check(CLI::Range(1.0, 1e5));
        add_keys(shape, common_.flags, settings_.describe_table("shape"), {"kind", "file", "unit_m"});
    }

    void add_scene_input(CLI::App& sub, const char* what) {
        sub.add_option("input", common_.input, what)->required();
        sub.add_option("--container", common_.container, "container of an STL file: cylinder:D,H or box:X,Y,Z[:periodic] [m]");
        sub.add_option("--unit", common_.unit_m, "metres a unit of the STL file (0.001: millimetres); default 1")
            ->check(CLI::PositiveNumber);
    }

    void geometry_command(const char* name, const char* help, const char* example,
                          Json (*stage)(const Scene&, const GeometryConfig&, const Path&)) {
        auto& sub = command(name, help, example, [this, name = std::string(name), stage] {
            if (is_case(common_.input)) return run_in_case(common_, name, "geometry");
            const auto geometry = from_flags<GeometryConfig>(common_.flags);
            run_on_scene(common_, name, geometry, resolved(geometry),
                         [&](const Scene& scene, const Path& folder) { return stage(scene, geometry, folder); });
        });
        add_scene_input(sub, "a case, packing.json[.gz] or an STL file");
        add_keys(sub, common_.flags, settings_.describe_table("geometry"));
        sub.get_option("--section")->description("z0,z1 of the section [m]; default: the bed less the trim");
    }

    void add_geometry_commands() {
        auto& stl = command("stl", "one closed triangle surface of the grains (CGAL)", "porepack stl packing.json --pores true", [this] {
            if (is_case(common_.input)) return run_in_case(common_, "stl", "stl");
            const auto geometry = from_flags<GeometryConfig>(flags_of<GeometryConfig>(common_.flags));
            const auto extras = from_flags<StlConfig>(flags_of<StlConfig>(common_.flags));
            run_on_scene(
                common_, "stl", geometry, {{"geometry", resolved(geometry)}, {"stl", resolved(extras)}},
                [&](const Scene& scene, const Path& folder) { return stl_stage(scene, geometry, extras, folder); }, {},
                extras.pores || extras.clip);
        });
        add_scene_input(stl, "a case, packing.json[.gz] or an STL file");
        add_keys(stl, common_.flags, settings_.describe_table("geometry"),
                 {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
        add_keys(stl, common_.flags, settings_.describe_table("stl"));
        geometry_command("voxelise", "grains to voxels (pore.vti)", "porepack voxelise packing.json --voxel-size 2e-4", voxelise_stage);
        geometry_command("slices", "grains to a stack of pictures", "porepack slices packing.json --slice-spacing 2e-4", slices_stage);
        app_.get_subcommand("slices")->add_option_function<std::string>(
            "--spacing", [this](const std::string& value) { common_.flags["slice_spacing_m"] = value; }, "the same as --slice-spacing [m]");
        app_.get_subcommand("slices")->add_option_function<std::string>(
            "--pixel", [this](const std::string& value) { common_.flags["slice_pixel_m"] = value; }, "the same as --slice-pixel [m]");
    }

    void add_flow_commands() {
        auto& lbm =
            command("lbm", "permeability by lattice Boltzmann", "porepack lbm packing.json --voxel-size 2e-4 --direction z", [this] {
                if (is_case(common_.input)) return run_in_case(common_, "lbm", "lbm");
                const auto geometry = from_flags<GeometryConfig>(flags_of<GeometryConfig>(common_.flags));
                const auto config = from_flags<LbmConfig>(flags_of<LbmConfig>(common_.flags));
                const Json configuration = {{"geometry", resolved(geometry)}, {"lbm", resolved(config)}};
                if (Path(common_.input).extension() == ".vti") {
                    if (common_.dry_run)
                        return print_result(common_, {{"configuration", configuration}, {"expected", "one grid, as it is in the file"}});
                    return print_result(
                        common_, run_loose("lbm", target_folder(common_), configuration, {common_.input}, [&](const Path& folder) {
                            return lbm_image_stage(common_.input, container_of(common_), geometry.section_m, config, folder);
                        }));
                }
                run_on_scene(
                    common_, "lbm", geometry, configuration,
                    [&](const Scene& scene, const Path& folder) {
                        return lbm_stage(scene, geometry, config, folder, target_folder(common_) / "lbm.checkpoint");
                    },
                    [&](const Scene& scene) {
                        const Expectation e =
                            expect_lbm(scene.container, scene.section, scene.voxel_size(geometry), scene.grain_size_m,
                                       porosity(scene.solid(), scene.container, scene.section, 4000).value, geometry, config);
                        return fmt::format("{}; memory about {}, time about {}", e.text, human_bytes(e.memory_bytes),
                                           human_time(e.wall_time_s));
                    });
            });
        add_scene_input(lbm, "a case, packing.json[.gz], an STL file or pore.vti");
        add_keys(lbm, common_.flags, settings_.describe_table("geometry"),
                 {"surface_deviation_m", "contact_gap_m", "slice_spacing_m", "slice_pixel_m"});
        add_keys(lbm, common_.flags, settings_.describe_table("lbm"));

        auto& foam = command("foam", "permeability by OpenFOAM", "porepack foam packing.json --cell-size 5e-4", [this] {
            if (is_case(common_.input)) return run_in_case(common_, "foam", "openfoam");
            const auto geometry = from_flags<GeometryConfig>(flags_of<GeometryConfig>(common_.flags));
            const auto config = from_flags<FoamConfig>(flags_of<FoamConfig>(common_.flags));
            run_on_scene(
                common_, "foam", geometry, {{"geometry", resolved(geometry)}, {"openfoam", resolved(config)}},
                [&](const Scene& scene, const Path& folder) {
                    make_folder(folder / "foam");
                    Json result = foam_stage(scene, geometry, config, folder / "foam");
                    result["repeat_by_hand"] = "cd foam/" + result["repeat_by_hand"].get<std::string>().substr(3);
                    return result;
                },
                [&](const Scene& scene) {
                    const Expectation e = expect_foam(scene.container, scene.section,
                                                      config.cell_size_m > 0.0 ? config.cell_size_m : scene.grain_size_m / 4.0,
                                                      porosity(scene.solid(), scene.container, scene.section, 4000).value, config);
                    return fmt::format("{}; memory about {}, time about {}", e.text, human_bytes(e.memory_bytes),
                                       human_time(e.wall_time_s));
                },
                true, true);
        });
        add_scene_input(foam, "a case, packing.json[.gz] or an STL file");
        add_keys(foam, common_.flags, settings_.describe_table("geometry"),
                 {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
        add_keys(foam, common_.flags, settings_.describe_table("openfoam"), {"enabled"});
        foam.add_option_function<std::string>(
            "--levels", [this](const std::string& value) { common_.flags["meshes"] = value; }, "the same as --meshes");

        auto& inertia =
            command("forchheimer", "flows with inertia by both solvers: permeability against the Reynolds number",
                    "porepack forchheimer packing.json --reynolds 2,5,10,20,40", [this] {
                        if (is_case(common_.input)) return run_in_case(common_, "forchheimer", "forchheimer");
                        const auto geometry = from_flags<GeometryConfig>(flags_of<GeometryConfig>(common_.flags));
                        const auto config = from_flags<ForchheimerConfig>(flags_of<ForchheimerConfig>(common_.flags));
                        run_on_scene(
                            common_, "forchheimer", geometry, {{"geometry", resolved(geometry)}, {"forchheimer", resolved(config)}},
                            [&](const Scene& scene, const Path& folder) { return forchheimer_stage(scene, geometry, config, folder); },
                            [&](const Scene& scene) { return expect_text(expect_forchheimer(scene, config)); }, true, true);
                    });
        add_scene_input(inertia, "a case, packing.json[.gz] or an STL file");
        add_keys(inertia, common_.flags, settings_.describe_table("geometry"),
                 {"voxel_size_m", "slice_spacing_m", "slice_pixel_m", "reservoir_m"});
        add_keys(inertia, common_.flags, settings_.describe_table("forchheimer"), {"enabled"});
    }

    void add_tortuosity() {
        auto& sub = command("tortuosity", "tortuosity of a named kind", "porepack tortuosity hydraulic flow.vti", [this] {
            if (is_case(common_.input)) {
                log_warning("a case gets all kinds of tortuosity, not " + kind_ + " alone");
                return run_in_case(common_, "tortuosity", "tortuosity");
            }
            const auto geometry = from_flags<GeometryConfig>(flags_of<GeometryConfig>(common_.flags));
            const auto config = from_flags<TortuosityConfig>(flags_of<TortuosityConfig>(common_.flags));
            const bool image = std::filesystem::is_directory(common_.input) || Path(common_.input).extension() == ".vti";
            if (kind_ != "hydraulic" && !image)
                return run_on_scene(
                    common_, "tortuosity." + kind_, geometry, resolved(config),
                    [&](const Scene& scene, const Path& folder) {
                        return kind_ == "shortest_path" ? shortest_path_stage(scene, geometry, config, folder)
                               : kind_ == "diffusive"   ? diffusive_stage(scene, geometry, config)
                                                        : geometric_paper_stage(scene, config, folder);
                    },
                    [&](const Scene& scene) {
                        if (kind_ == "geometric_paper") return std::string("seconds");
                        const VoxelPlan plan =
                            plan_voxels(scene.container, scene.section, scene.voxel_size(geometry), 0.0, scene.grain_size_m);
                        const Expectation e = expect_tortuosity(kind_, static_cast<double>(plan.grid.size()));
                        return fmt::format("{}; memory about {}, time about {}", e.text, human_bytes(e.memory_bytes),
                                           human_time(e.wall_time_s));
                    });
            if (common_.dry_run) return print_result(common_, {{"configuration", resolved(config)}, {"expected", "seconds to minutes"}});
            const auto work = [&](const Path& folder) {
                if (kind_ == "hydraulic") return hydraulic_stage(common_.input, geometry.section_m);
                if (kind_ == "shortest_path")
                    return shortest_path_image_stage(common_.input, container_of(common_), geometry.section_m, config, folder);
                if (kind_ == "diffusive") return diffusive_image_stage(common_.input, container_of(common_), geometry.section_m, config);
                return geometric_paper_slices_stage(common_.input, config, folder);
            };
            print_result(common_, run_loose("tortuosity." + kind_, target_folder(common_), resolved(config), {common_.input}, work));
        });
        const std::set<std::string> kinds = {"geometric_paper", "shortest_path", "hydraulic", "diffusive"};
        sub.add_option("kind", kind_, "geometric_paper, shortest_path, hydraulic or diffusive")->required()->check(CLI::IsMember(kinds));
        add_scene_input(sub,
                        "packing.json[.gz], an STL file, a folder of slices, pore.vti; flow.vti or an OpenFOAM case that has run "
                        "(hydraulic); or a case");
        add_keys(sub, common_.flags, settings_.describe_table("tortuosity"));
        add_keys(sub, common_.flags, settings_.describe_table("geometry"),
                 {"slice_spacing_m", "slice_pixel_m", "surface_deviation_m", "contact_gap_m", "reservoir_m"});
    }

    void add_falling_head() {
        auto& head = *app_.add_subcommand("falling-head", "the falling-head test");
        head.require_subcommand(1);
        auto& simulate =
            *head.add_subcommand("simulate", "level over time: Eq. 18 in closed form, and with the water's inertia, meshes and noise");
        add_common(simulate, common_,
                   "porepack falling-head simulate --permeability 8.9e-7 --inertial-permeability 3.9e-3 --sample-length 0.12 --start-level "
                   "1.6 --levels 1.3,0.7,0.1");
        simulate.add_option("--permeability", permeability_m2_, "k [m2]")->required();
        simulate.add_option("--inertial-permeability", inertial_permeability_m_, "k_in [m]; default infinite (Darcy's law alone)");
        add_keys(simulate, common_.flags, settings_.describe_table("falling_head"),
                 {"causes", "computed_over_measured", "level_offset_uncertainty_m"});
        simulate.callback([this] {
            action_ = [this] {
                const auto config = from_flags<FallingHeadConfig>(common_.flags);
                if (common_.dry_run) return print_result(common_, {{"configuration", resolved(config)}, {"expected", "seconds"}});
                if (common_.output.empty())
                    return print_result(common_, falling_head_stage(permeability_m2_, inertial_permeability_m_, config, nullptr));
                Json configuration = resolved(config);
                configuration["permeability_m2"] = permeability_m2_;
                configuration["inertial_permeability_m"] = fmt::format("{:g}", inertial_permeability_m_);
                print_result(common_, run_loose("falling-head", common_.output, configuration, {}, [&](const Path& folder) {
                                 return falling_head_stage(permeability_m2_, inertial_permeability_m_, config, &folder);
                             }));
            };
        });
        auto& analyse = *head.add_subcommand("analyse", "k and k_in from measured levels: as in the paper, and by least squares");
        add_common(analyse, common_, "porepack falling-head analyse run1.csv run2.csv --case cases/falling_head/tetrapod_053");
        analyse.add_option("curves", files_, "CSV files: a header with time_s and level_m (or _ms, _mm, ...), then a line a picture")
            ->required();
        analyse.add_option("--case", common_.input, "case whose [falling_head] describes the apparatus; flags win over it");
        add_keys(analyse, common_.flags, settings_.describe_table("falling_head"),
                 {"start_level_m", "levels_m", "noise_m", "frames_per_s", "seed", "causes", "computed_over_measured"});
        analyse.callback([this] {
            action_ = [this] {
                FallingHeadConfig config;
                if (common_.input.empty())
                    config = from_flags<FallingHeadConfig>(common_.flags);
                else
                    config = apparatus_of_case(read_case(common_.input, "falling_head", common_.flags));
                if (common_.dry_run) return print_result(common_, {{"configuration", resolved(config)}, {"expected", "seconds"}});
                const std::vector<Path> curves(files_.begin(), files_.end());
                const Path target = common_.output.empty() ? Path(".") : Path(common_.output);
                print_result(common_, run_loose("falling-head-analysis", target, resolved(config), curves,
                                                [&](const Path& folder) { return analyse_stage(curves, config, folder); }));
            };
        });
        auto& of_case = *head.add_subcommand("case", "the falling-head stage of a case");
        add_common(of_case, common_, "porepack falling-head case cases/quickstart");
        of_case.add_option("case", common_.input, "folder with case.toml")->required();
        of_case.callback([this] { action_ = [this] { run_in_case(common_, "falling-head", "falling_head"); }; });
        auto& causes = *head.add_subcommand("causes", "how much each cause changes the k of the paper's evaluation");
        add_common(causes, common_, "porepack falling-head causes cases/falling_head/tetrapod_053");
        causes.add_option("case", common_.input, "folder with case.toml, with causes = true in [falling_head]")->required();
        causes.callback([this] { action_ = [this] { run_in_case(common_, "causes", "falling_head"); }; });
    }

    void add_tools() {
        auto& benchmark = command("benchmark", "measurements", "porepack benchmark lbm", [this] {
            if (common_.dry_run) return print_result(common_, {{"benchmark", common_.input}, {"expected", "minutes"}});
            if (!common_.output.empty()) require_writable(common_.output);
            print_result(common_, run_benchmark(common_.input, {cases_.begin(), cases_.end()}, common_.output, quick_));
        });
        benchmark.add_option("name", common_.input, fmt::format("{}", fmt::join(benchmark_names(), ", ")))->required();
        benchmark.add_option("cases", cases_, "of cross-check: folders with case.toml");
        benchmark.add_flag("--quick", quick_, "of speed-error: minutes instead of half an hour");
        auto& picture = command("picture", "render an STL file to a PNG", "porepack picture solid.stl --output solid.png", [this] {
            const Path target = common_.output.empty() ? Path(common_.input).replace_extension(".png") : Path(common_.output);
            if (common_.dry_run) return print_result(common_, {{"picture", target.string()}, {"expected", "seconds"}});
            if (Path(common_.input).extension() != ".stl" && Path(common_.input).extension() != ".STL")
                throw UserError("not an STL file: " + common_.input, {.mend = "make one: porepack stl packing.json"});
            render_under_some_display(arguments_);
            const TriangleSurface surface = read_stl(common_.input, common_.unit_m);
            PictureStyle style = style_for(surface);
            style.front = front_;
            if (const auto container = container_of(common_); container && container->kind == Container::Kind::cylinder)
                style = {.cylinder_diameter_m = container->diameter_m, .cylinder_height_m = container->height_m};
            render_surface(target, surface, style);
            print_result(common_, {{"picture", target.string()}});
        });
        add_scene_input(picture, "an STL file");
        picture.add_flag("--front", front_, "seen along y, without perspective");
        auto& keys = *app_.add_subcommand("keys", "all keys of case.toml, as a Markdown table");
        keys.callback([this] { action_ = [] { fmt::print("{}", key_reference()); }; });
    }

    CLI::App app_{"From a grain's shape to the porosity, tortuosity and permeability of its packing.", "porepack"};
    Settings settings_;
    Common common_;
    std::vector<std::string> cases_;  // of a benchmark
    std::vector<std::string> files_;  // measured curves
    bool quick_ = false;
    std::string capsules_file_, kind_;
    bool sweep_ = false, front_ = false;
    double density_ = 1000.0;
    double permeability_m2_ = 0.0;
    double inertial_permeability_m_ = std::numeric_limits<double>::infinity();
    std::function<void()> action_;
    std::vector<std::string> arguments_;
};

}  // namespace
}  // namespace porepack

int main(int argc, char** argv) {
    using namespace porepack;
    install_signal_handlers();
    try {
        return CommandLine().run(argc, argv);
    } catch (const Error& error) {
        log_raw(fmt::format("error: {}\n", error.what()));
        return static_cast<int>(error.code());
    } catch (const std::bad_alloc&) {
        log_raw("error: out of memory\n  mend:    take a larger voxel size or a shorter section\n");
    } catch (const std::exception& fault) {
        log_raw(fmt::format("error: {}\n", fault.what()));
    }
    return static_cast<int>(ExitCode::machine);
}
