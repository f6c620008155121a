// The commands and their flags. CLI11 parses them; its header is in command_line.cpp alone, because it takes seconds to compile.
#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "record/config.hpp"
#include "stages/case.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace porepack::apps {

/// A flag or a positional argument. --help shows its type, which also says what is allowed.
class Option {
public:
    explicit Option(CLI::Option* option) : option_(option) {}
    /// A text with "number" in it makes the command line refuse what is not a finite number.
    Option type_name(const std::string& text);
    Option required(bool is = true);
    Option range(long low, long high);
    Option range(double low, double high);
    Option not_negative();
    Option one_of(const std::vector<std::string>& names);
    Option expected(int count);  ///< of values
    Option delimiter(char between_values);
    Option description(const std::string& text);
    Option hidden();  ///< from --help and the manual

private:
    CLI::Option* option_;
};

/// A command, to which flags are added. `value` is set when the command line is parsed.
class Command {
public:
    explicit Command(CLI::App* app) : app_(app) {}
    Option add_option(const std::string& name, std::string& value, const std::string& help);
    Option add_option(const std::string& name, double& value, const std::string& help);
    Option add_option(const std::string& name, long& value, const std::string& help);
    Option add_option(const std::string& name, std::vector<std::string>& values, const std::string& help);
    Option add_option(const std::string& name, std::vector<double>& values, const std::string& help);
    void add_flag(const std::string& name, bool& value, const std::string& help);
    /// A flag that the command has.
    [[nodiscard]] Option option(const std::string& name);

private:
    friend class CommandLine;
    CLI::App* app_;
};

/// Options shared by all commands.
struct Common {
    bool json = false;
    bool dry_run = false;
    bool verbose = false;
    int threads = 0;
    long ranks = 0;    ///< processes of MPI that compute one flow; 0: those that a launcher has started, those of a case, or one
    std::string into;  ///< folder of the stage for which this process is a rank
    std::string output;
    std::string container;
    double unit_m = 1.0;
    std::string input;
    record::Flags flags;           ///< keys of the configuration given as flags
    record::Flags image_flags;     ///< --image-...: keys of [image]
    std::vector<std::string> set;  ///< "table.key=value", in commands on cases
};

class CommandLine {
public:
    CommandLine();
    ~CommandLine();
    /// The exit code. Throws what the command throws.
    int run(int argc, char** argv);
    /// man/man1/porepack.1, one page per command, and bash-completion/completions/porepack, below `folder`. The files.
    [[nodiscard]] std::vector<core::Path> write_manual(const core::Path& folder) const;

    /// A command; its action runs after parsing, so that its exceptions reach main.
    Command add(const std::string& name, const std::string& help, const std::string& example, std::function<void()> action);
    Command add_below(Command parent, const std::string& name, const std::string& help, const std::string& example,
                      std::function<void()> action);
    /// A command that has only others below it.
    Command add_group(const std::string& name, const std::string& help);
    /// A command without flags.
    void add_plain(const std::string& name, const std::string& help, std::function<void()> action);
    /// A command whose arguments another program parses.
    void add_forwarded(const std::string& name, const std::string& help, std::function<void()> action);
    /// Every key of a table is a flag: voxel_size_m is --voxel-size, in metres. The rules of the file check the value. A key's name in an
    /// earlier version is a hidden flag that warns.
    void add_keys(Command command, const std::string& table, const std::vector<std::string>& leave_out = {});
    void add_keys(Command command, const record::Describe& describe, const std::vector<std::string>& leave_out = {});
    /// Another name for the flag of `key`, which the command has.
    void add_alias(Command command, const std::string& flag, const std::string& key);
    void add_case(Command command);
    void add_input(Command command, const char* what);
    void add_ranks(Command command, const std::string& help);
    void add_unit(Command command);
    /// --image-dims and so on: how an image is read. `leave_out`: keys.
    void add_image_keys(Command command, const std::vector<std::string>& leave_out = {"fitted_sizes", "fit_memory_bytes"});

    Common common;
    std::vector<std::string> arguments;  ///< as they were typed

private:
    [[nodiscard]] std::string command_path() const;
    CLI::Option* add_key(Command command, const record::KeyRow& row, const std::string& flag,
                         const std::function<void(const std::string&)>& set);

    std::unique_ptr<CLI::App> app_;
    stages::Settings settings_;               // only its lists of keys
    std::set<const CLI::Option*> of_tables_;  ///< options that are keys of a table
    std::function<void()> action_;
    bool only_parse_ = false;
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
void add_evidence_command(CommandLine& line);
void add_view_command(CommandLine& line);
void add_docs_command(CommandLine& line);
void add_pressure_drop_command(CommandLine& line);
void add_tools(CommandLine& line);

}  // namespace porepack::apps
