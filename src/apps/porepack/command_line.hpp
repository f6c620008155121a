// The command line: flags in, a stage or a pipeline called, its result printed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "pipeline/loose.hpp"
#include "record/toml_file.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::apps {

/// Options shared by all commands.
struct Common {
    bool json = false;
    bool dry_run = false;
    bool verbose = false;
    int threads = 0;
    std::string output;
    std::string container;
    double unit_m = 1.0;
    std::string input;
    core::Flags flags;             ///< keys of the configuration given as flags
    core::Flags image_flags;       ///< --image-...: keys of [image]
    std::vector<std::string> set;  ///< "table.key=value", in commands on cases
};

class CommandLine {
public:
    CommandLine();
    /// The exit code. Throws what the command throws.
    int run(int argc, char** argv);

    /// A command; its action runs after parsing, so that its exceptions reach main.
    CLI::App& add(const std::string& name, const std::string& help, const std::string& example, std::function<void()> action);
    CLI::App& add_below(CLI::App& parent, const std::string& name, const std::string& help, const std::string& example,
                        std::function<void()> action);
    /// Every key of a table is a flag: voxel_size_m is --voxel-size, in metres. The rules of the file check the value. A key's name in an
    /// earlier version is a hidden flag that warns.
    void add_keys(CLI::App& command, const std::string& table, const std::vector<std::string>& leave_out = {});
    void add_keys(CLI::App& command, const core::Describe& describe, const std::vector<std::string>& leave_out = {});
    /// Another name for the flag of `key`, which the command has.
    void add_alias(CLI::App& command, const std::string& flag, const std::string& key);
    void add_case(CLI::App& command);
    void add_input(CLI::App& command, const char* what);
    void add_unit(CLI::App& command);
    /// --image-dims and so on: how an image is read. `leave_out`: keys.
    void add_image_keys(CLI::App& command, const std::vector<std::string>& leave_out = {"fitted_sizes", "fit_memory_bytes"});

    CLI::App app{"From a grain's shape to the porosity, tortuosity and permeability of its packing.", "porepack"};
    Common common;
    std::vector<std::string> arguments;  ///< as they were typed

private:
    [[nodiscard]] std::string command_path() const;
    CLI::Option* add_key(CLI::App& command, const core::KeyRow& row, const std::string& flag,
                         const std::function<void(const std::string&)>& set);

    stages::Settings settings_;               // only its lists of keys
    std::set<const CLI::Option*> of_tables_;  ///< options that are keys of a table
    std::function<void()> action_;
};

// Each function adds its commands (commands/*.cpp).
void add_case_commands(CommandLine& line);
void add_new_command(CommandLine& line);
/// Files that a case names outside of its folder, into the log; a warning where one does not exist.
void say_files_outside(const stages::Case& the_case);
void add_shape_command(CommandLine& line);
void add_geometry_commands(CommandLine& line);
void add_lbm_command(CommandLine& line);
void add_foam_command(CommandLine& line);
void add_forchheimer_command(CommandLine& line);
void add_tortuosity_command(CommandLine& line);
void add_falling_head_commands(CommandLine& line);
void add_study_commands(CommandLine& line);
void add_design_command(CommandLine& line);
void add_image_commands(CommandLine& line);
void add_pores_command(CommandLine& line);
void add_tools(CommandLine& line);

void print_result(const Common& common, const core::Json& json);
/// The main numbers of a stage's result, and the files that its manifest names.
void print_stage(const Common& common, const std::string& stage, const core::Json& result, const core::Path& manifest);
/// Runs the case's stage `stage`, or reports what would run; `table` is the table of the command's flags.
void run_in_case(const Common& common, const std::string& stage, const std::string& table);
[[nodiscard]] stages::Case open_case(const Common& common, const std::string& table = {}, const core::Flags& flags = {});
/// Times are multiplied by `slowness`.
[[nodiscard]] core::Json plan_case(const stages::Case& c, const std::string& last, double slowness);

/// The keys of `flags` that belong to a table: a command may have those of two tables.
template <typename Config>
[[nodiscard]] Config config_of(const core::Flags& flags) {
    Config config;
    core::Flags own;
    for (const auto& row : core::key_rows([&](core::ConfigVisitor& v) { describe(v, config); }))
        if (const auto found = flags.find(row.key); found != flags.end()) own.insert(*found);
    return record::config_from_flags<Config>(own);
}

/// A stage on a loose file.
struct LooseCommand {
    std::string stage;
    converters::GeometryConfig geometry = {};
    pore_space::SectionConfig section = {.ends = pore_space::Ends::planes};
    core::Json configuration = {};
    std::function<core::Json(const pore_space::PoreSpace&, const core::Path& folder)> work;
    std::function<pipeline::Expectation(const pore_space::PoreSpace&)> expect = {};  ///< for --dry-run; "seconds" when empty
    bool whole_bed = false;
    bool resumes = false;
};
void run_on_input(const Common& common, const LooseCommand& command);
void run_on_files(const Common& common, pipeline::LooseRun run);
[[nodiscard]] std::optional<packing::Container> container_of(const Common& common);
/// Folder for the files of a loose run: --output, else that of the input.
[[nodiscard]] core::Path target_folder(const Common& common);

}  // namespace porepack::apps
