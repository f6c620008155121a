#include "apps/porepack/command_line.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <system_error>
#include <utility>

#include "apps/porepack/uses.hpp"
#include "core/build.hpp"
#include "core/communicator.hpp"
#include "core/context.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "record/engine_versions.hpp"
#include "stages/stages.hpp"
#include "vessels/config.hpp"

namespace porepack::apps {
namespace {

void add_common(CLI::App& command, Common& common, const std::string& example) {
    command.add_flag("--json", common.json, "result as JSON on stdout, log on stderr");
    command.add_flag("--verbose", common.verbose, "print all of the result, not only its main numbers");
    command.add_flag("--dry-run", common.dry_run, "print the resolved configuration, what would run, memory and time; run nothing");
    command
        .add_option("--threads", common.threads,
                    "threads of parallel loops (default: OMP_NUM_THREADS, else the cores that this process may use)")
        ->type_name("1 to 1024")
        ->check(CLI::Validator(CLI::Range(1, 1024)).description(""));
    command.add_option("--output", common.output, "folder for the results (default: that of the input)")->type_name("path");
    command.footer("Example:\n  " + example);
}

std::string version_text() {
    std::string text = fmt::format("porepack {} ({})\n", program_version(), git_hash());
    const Json versions = record::engine_versions();
    for (const auto& [name, version] : versions.items())
        text += fmt::format("  {:<10} {}\n", name, version.get<std::string>().empty() ? "not found" : version.get<std::string>());
    text.pop_back();
    return text;
}

// "number [m]", "one of x, y, z", ...: what --help shows behind a flag.
std::string type_text(const KeyRow& row) {
    if (row.type == "choice") return "one of " + row.allowed;
    if (row.key == "file") return "path";
    std::string text = row.type;
    if (text.starts_with("list of ")) text = text.substr(8) + (text.ends_with("numbers") ? "" : " times true or false") + ", with commas";
    std::string unit = row.unit;
    if (const std::size_t per = unit.find("_per_"); per != std::string::npos) unit.replace(per, 5, "/");
    return unit.empty() ? text : text + " [" + unit + "]";
}

// "--pores true" is the same as "--pores=true" and "--pores".
std::vector<std::string> with_joined_booleans(const std::vector<std::string>& arguments) {
    std::vector<std::string> joined;
    for (const std::string& argument : arguments) {
        const bool value = argument == "true" || argument == "false";
        if (value && !joined.empty() && joined.back().starts_with("--") && joined.back().find('=') == std::string::npos)
            joined.back() += "=" + argument;
        else
            joined.push_back(argument);
    }
    return joined;
}

// CLI11's ranges let "nan" pass. Keys of tables are checked where they are read, with the range that is allowed.
void require_finite_numbers(const CLI::App& command, const std::set<const CLI::Option*>& of_tables) {
    for (const CLI::Option* option : command.get_options()) {
        if (option->get_type_name().find("number") == std::string::npos || of_tables.contains(option)) continue;
        for (const std::string& result : option->results()) {
            std::istringstream fields(result);
            for (std::string field; std::getline(fields, field, ',');) {
                char* end = nullptr;
                const double value = std::strtod(field.c_str(), &end);
                if (end != field.c_str() && *end == '\0' && !std::isfinite(value))
                    throw UserError(fmt::format("\"{}\" is not a finite number", field), {.where = option->get_name()});
            }
        }
    }
    for (const CLI::App* below : command.get_subcommands()) require_finite_numbers(*below, of_tables);
}

// The known flag or command that is nearest to the first unknown one.
std::string suggestion(const CLI::App& app, const std::vector<std::string>& arguments) {
    const CLI::App* command = &app;
    for (const std::string& argument : arguments) {
        std::vector<std::string> known;
        if (!argument.starts_with("-")) {
            const auto all = command->get_subcommands([](const CLI::App*) { return true; });
            for (const CLI::App* below : all) known.push_back(below->get_name());
            if (const auto next = std::find(known.begin(), known.end(), argument); next != known.end()) {
                command = all[static_cast<std::size_t>(next - known.begin())];
                continue;
            }
        } else if (argument.starts_with("--")) {
            for (const CLI::Option* option : command->get_options())
                for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
        }
        const std::string word = argument.substr(0, argument.find('='));
        if (known.empty() || std::find(known.begin(), known.end(), word) != known.end()) continue;
        if (const std::string near = nearest(word, known); !near.empty()) return near;
    }
    return {};
}

}  // namespace

Option Option::type_name(const std::string& text) {
    option_->type_name(text);
    return *this;
}
Option Option::required(bool is) {
    option_->required(is);
    return *this;
}
// CLI11 would describe a range in its own words.
Option Option::range(long low, long high) {
    option_->check(CLI::Validator(CLI::Range(low, high)).description(""));
    return *this;
}
Option Option::range(double low, double high) {
    option_->check(CLI::Validator(CLI::Range(low, high)).description(""));
    return *this;
}
Option Option::not_negative() {
    option_->check(CLI::Validator(CLI::NonNegativeNumber).description(""));
    return *this;
}
Option Option::one_of(const std::vector<std::string>& names) {
    option_->check(CLI::Validator(CLI::IsMember(names)).description(""));
    return *this;
}
Option Option::expected(int count) {
    option_->expected(count);
    return *this;
}
Option Option::delimiter(char between_values) {
    option_->delimiter(between_values);
    return *this;
}
Option Option::description(const std::string& text) {
    option_->description(text);
    return *this;
}

Option Option::hidden() {
    option_->group("");
    return *this;
}

Option Command::add_option(const std::string& name, std::string& value, const std::string& help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::add_option(const std::string& name, double& value, const std::string& help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::add_option(const std::string& name, long& value, const std::string& help) {
    return Option(app_->add_option(name, value, help));
}
Option Command::add_option(const std::string& name, std::vector<std::string>& values, const std::string& help) {
    return Option(app_->add_option(name, values, help));
}
Option Command::add_option(const std::string& name, std::vector<double>& values, const std::string& help) {
    return Option(app_->add_option(name, values, help));
}
void Command::add_flag(const std::string& name, bool& value, const std::string& help) {
    app_->add_flag(name, value, help);
}
Option Command::option(const std::string& name) {
    return Option(app_->get_option(name));
}

CommandLine::CommandLine()
    : app_(std::make_unique<CLI::App>("From a grain's shape to the porosity, tortuosity and permeability of its packing.", "porepack")) {
    CLI::App& app = *app_;
    app.require_subcommand(0, 1);
    app.set_version_flag("--version", version_text);
    app.add_flag("--only-parse", only_parse_, "end after the flags are understood: for checks of documents")->group("");
    app.footer(
        "Exit codes: 0 done, 2 the input, 3 a numerical failure, 4 an engine is missing or failed, 5 interrupted or the "
        "machine.\nExample:\n  porepack run cases/quickstart");
    for (const auto& add_commands : {add_new_command, add_case_commands, add_shape_command, add_geometry_commands, add_lbm_command,
                                     add_foam_command, add_forchheimer_command, add_tortuosity_command, add_falling_head_commands,
                                     add_study_commands, add_design_command, add_image_commands, add_pores_command,
                                     add_pressure_drop_command, add_evidence_command, add_view_command, add_docs_command, add_tools})
        add_commands(*this);
}

CommandLine::~CommandLine() = default;

int CommandLine::run(int argc, char** argv) {
    CLI::App& app = *app_;
    arguments.assign(argv + 1, argv + argc);
    try {
        std::vector<std::string> words = with_joined_booleans(arguments);
        std::reverse(words.begin(), words.end());  // CLI11 takes them from the back
        app.parse(std::move(words));
    } catch (const CLI::ParseError& fault) {
        if (fault.get_exit_code() == 0) return app.exit(fault);
        const std::string near = suggestion(app, arguments), help = fmt::format("porepack {}--help shows what is allowed", command_path());
        std::string message = fault.what();
        if (dynamic_cast<const CLI::ExtrasError*>(&fault) != nullptr)
            message = fmt::format("not expected here: {}", fmt::join(app.remaining(true), " "));
        throw UserError(message, {.fix = near.empty() ? help : fmt::format("{}; {}", perhaps(near), help)});
    }
    require_finite_numbers(app, of_tables_);
    if (only_parse_) return 0;
    set_thread_count(common.threads);
    if (ranks().parts() > 1 && command_path() != "lbm " && command_path() != "forchheimer ")
        throw UserError(
            fmt::format("porepack {}was started {} times by mpirun or srun", command_path(), ranks().parts()),
            {.allowed = "several ranks for porepack lbm", .fix = "start it once; porepack run, lbm and forchheimer have --ranks"});
    // All ranks but the first say nothing, but for errors.
    const Context silent{.log = [](auto, auto) {}, .progress = [](auto, auto, auto, auto) {}};
    std::optional<ContextScope> scope;
    if (ranks().part() > 0) scope.emplace(silent);
    try {
        if (app.get_subcommands().empty()) fmt::print("{}", app.help());
        if (action_) action_();
    } catch (const std::system_error& fault) {
        if (fault.code().value() != EPIPE) throw;
        return 0;
    }
    errno = 0;
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
        if (errno == EPIPE) return 0;  // the reader, such as head, has seen enough
        throw MachineError("the result could not be written to the standard output", {.fix = "is the disk full?"});
    }
    return 0;
}

// "falling-head simulate ", as it was typed.
std::string CommandLine::command_path() const {
    std::string path;
    for (const CLI::App* at = app_.get(); !at->get_subcommands().empty(); path += at->get_name() + " ") at = at->get_subcommands().front();
    return path;
}

Command CommandLine::add(const std::string& name, const std::string& help, const std::string& example, std::function<void()> action) {
    return add_below(Command(app_.get()), name, help, example, std::move(action));
}

Command CommandLine::add_below(Command parent, const std::string& name, const std::string& help, const std::string& example,
                               std::function<void()> action) {
    CLI::App& command = *parent.app_->add_subcommand(name, help);
    add_common(command, common, example);
    command.callback([this, action = std::move(action)] { action_ = action; });
    return Command(&command);
}

Command CommandLine::add_group(const std::string& name, const std::string& help) {
    CLI::App* const group = app_->add_subcommand(name, help);
    group->require_subcommand(1);
    return Command(group);
}

void CommandLine::add_plain(const std::string& name, const std::string& help, std::function<void()> action) {
    app_->add_subcommand(name, help)->callback([this, action = std::move(action)] { action_ = action; });
}

void CommandLine::add_forwarded(const std::string& name, const std::string& help, std::function<void()> action) {
    CLI::App* const command = app_->add_subcommand(name, help);
    command->prefix_command();
    command->set_help_flag();
    command->callback([this, action = std::move(action)] { action_ = action; });
}

void CommandLine::add_keys(Command command, const std::string& table, const std::vector<std::string>& leave_out) {
    add_keys(command, settings_.describe_table(table), leave_out);
}

void CommandLine::add_keys(Command command, const Describe& describe, const std::vector<std::string>& leave_out) {
    const auto left_out = [&](const std::string& key) { return std::find(leave_out.begin(), leave_out.end(), key) != leave_out.end(); };
    for (const auto& row : key_rows(describe)) {
        if (left_out(row.key) || row.type == "array of tables") continue;
        const std::string flag = flag_of(row.key), standard = row.standard.empty() ? "none" : row.standard;
        const auto set = [this, key = row.key](const std::string& value) { common.flags[key] = value; };
        add_key(command, row, flag, set)->description(row.meaning + "; default " + standard);
        for (const auto& [old_key, key] : renamed_keys(describe)) {
            if (key != row.key) continue;
            const std::string old_flag = flag_of(old_key);
            add_key(command, row, old_flag, [set, flag, old_flag](const std::string& value) {
                log_warning(fmt::format("{} is now called {}; the old name is read until version 0.4", old_flag, flag));
                set(value);
            })->group("");
        }
    }
}

CLI::Option* CommandLine::add_key(Command command, const KeyRow& row, const std::string& flag,
                                  const std::function<void(const std::string&)>& set) {
    if (row.type != "true or false") {
        CLI::Option* const option = command.app_->add_option_function<std::string>(flag, set)->type_name(type_text(row));
        of_tables_.insert(option);
        return option;
    }
    const auto set_flag = [set](std::int64_t count) { set(count > 0 ? "true" : "false"); };
    const auto refuse_others = [](const std::string& value) {
        return value == "true" || value == "false" ? std::string() : "\"" + value + "\" is neither true nor false";
    };
    return command.app_->add_flag_function(flag + (row.standard == "true" ? ",!--no-" + flag.substr(2) : ""), set_flag)
        ->check(CLI::Validator(refuse_others, ""));
}

void CommandLine::add_alias(Command command, const std::string& flag, const std::string& key) {
    const std::string same = flag_of(key);
    of_tables_.insert(command.app_
                          ->add_option_function<std::string>(
                              flag, [this, key](const std::string& value) { common.flags[key] = value; }, "the same as " + same)
                          ->type_name(command.app_->get_option(same)->get_type_name()));
}

void CommandLine::add_case(Command command) {
    command.add_option("case", common.input, "folder with case.toml").type_name("path").required();
    command.app_->add_option("--set", common.set, "another value for a key of case.toml (repeatable; needs --output)")
        ->type_name("table.key=value")
        ->allow_extra_args(false);
}

void CommandLine::add_input(Command command, const char* what) {
    command.add_option("input", common.input, what).type_name("path").required();
    command.add_option("--container", common.container, "container of an STL file: " + vessels::container_frames())
        .type_name(vessels::container_forms() + " [m]");
    add_unit(command);
    add_image_keys(command);
}

void CommandLine::add_ranks(Command command, const std::string& help) {
    command.add_option("--ranks", common.ranks, help).type_name("1 to 10000").range(1L, 10000L);
}

void CommandLine::add_image_keys(Command command, const std::vector<std::string>& leave_out) {
    const auto describe_image = [](ConfigVisitor& v) {
        static imaging::ImageConfig config;
        describe(v, config);
    };
    for (const auto& row : key_rows(describe_image)) {
        if (row.key == "file" || row.key == "fit" || std::find(leave_out.begin(), leave_out.end(), row.key) != leave_out.end()) continue;
        add_key(command, row, "--image-" + flag_of(row.key).substr(2),
                [this, key = row.key](const std::string& value) { common.image_flags[key] = value; })
            ->description(row.meaning + "; default " + (row.standard.empty() ? "none" : row.standard))
            ->group("Images");
    }
}

void CommandLine::add_unit(Command command) {
    command.app_->add_option("--unit", common.unit_m, "length of the STL file's unit in metres (0.001: millimetres); default 1")
        ->type_name("number [m]")
        ->check(CLI::Validator(CLI::PositiveNumber).description(""));
}

}  // namespace porepack::apps
