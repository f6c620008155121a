// What commands do with their input: a stage of a case, or work on loose files; and how results are printed.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "apps/porepack/command_line.hpp"
#include "core/files.hpp"
#include "core/members_json.hpp"
#include "inputs/pore_space_input.hpp"
#include "pipeline/loose.hpp"
#include "record/toml_file.hpp"
#include "stages/stages.hpp"

namespace porepack::apps {

void print_result(const Common& common, const core::Json& json);
template <core::HasMembers Result>
void print_result(const Common& common, const Result& result) {
    print_result(common, core::json_of(result));
}
/// The main numbers of a stage's result, and the files that its manifest names.
void print_stage(const Common& common, const std::string& stage, const core::Json& result, const core::Path& manifest);
/// Runs the case's stage `stage`, or reports what would run; `table` is the table of the command's flags.
void run_in_case(const Common& common, const std::string& stage, const std::string& table);
[[nodiscard]] stages::Case open_case(const Common& common, const std::string& table = {}, const record::Flags& flags = {});
/// Times are multiplied by `slowness`.
[[nodiscard]] core::Json plan_case(const stages::Case& c, const std::string& last, double slowness);

/// The keys of `flags` that belong to a table: a command may have those of two tables.
template <typename Config>
[[nodiscard]] Config config_of(const record::Flags& flags) {
    Config config;
    record::Flags own;
    for (const auto& row : record::key_rows([&](record::ConfigVisitor& v) { describe(v, config); }))
        if (const auto found = flags.find(row.key); found != flags.end()) own.insert(*found);
    return record::config_from_flags<Config>(own);
}

/// A stage on a loose file.
struct LooseCommand {
    std::string stage;
    converters::GeometryConfig geometry = {};
    pore_space::SectionConfig section = {.ends = pore_space::Ends::planes};
    core::Json configuration = {};
    core::JsonFunction<pore_space::PoreSpace, const core::Path&> work;           ///< writes into the folder
    std::function<core::Expectation(const pore_space::PoreSpace&)> expect = {};  ///< for --dry-run; "seconds" when empty
    bool whole_bed = false;
    bool resumes = false;
};
[[nodiscard]] pore_space::PoreSpace load_input(const Common& common, const LooseCommand& command);
void run_on_input(const Common& common, const LooseCommand& command);
void run_on_files(const Common& common, pipeline::LooseRun run);
[[nodiscard]] std::optional<vessels::Container> container_of(const Common& common);
/// Folder for the files of a loose run: --output, else that of the input.
[[nodiscard]] core::Path target_folder(const Common& common);

}  // namespace porepack::apps
