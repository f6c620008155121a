#include "stages/case.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "record/toml_file.hpp"
#include "stages/case_rules.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

namespace {

Path case_file(const Path& path) {
    const Path file = std::filesystem::is_directory(path) ? path / "case.toml" : path;
    if (!std::filesystem::exists(file))
        throw UserError("no such case: " + file.string(), {.fix = "a case is a folder with a file case.toml in it"});
    return file;
}

Case case_of(const TomlFile& toml, const Path& file, const std::string& flag_table, const Flags& flags,
             const std::map<std::string, Flags>& set) {
    toml.require_known_tables(Settings::tables());
    Case the_case;
    the_case.folder = file.parent_path().empty() ? Path(".") : file.parent_path();
    for (const char* table : {"shape", "container"})
        if (!toml.has(table) && !toml.has("image"))
            throw UserError(
                std::string("the table [") + table + "] is missing",
                {.where = file.string(), .allowed = "[shape] and [container] are required, or [image]; all other tables have defaults"});
    require_known(the_case.settings, set);
    require_own_keys(the_case.settings, toml);
    // A flag belongs to the table of its command, or to [geometry] and [section], which the commands share.
    for (const auto& table : Settings::tables()) {
        const bool has_flags = table == flag_table || table == "geometry" || table == "section";
        const auto found = set.find(table);
        toml.read(table, the_case.settings.describe_table(table), has_flags ? flags : Flags{},
                  found == set.end() ? Flags{} : found->second);
    }
    require_consistent(the_case, toml, set, file.string());
    return the_case;
}

}  // namespace

Case read_case(const Path& path, const std::string& flag_table, const Flags& flags, const std::map<std::string, Flags>& set) {
    const Path file = case_file(path);
    return case_of(TomlFile(file), file, flag_table, flags, set);
}

Case read_changed_case(const Path& path, const std::map<std::string, Flags>& changes) {
    const Path file = case_file(path);
    return case_of(TomlFile(file).with(changes), file, {}, {}, {});
}

std::vector<std::string> set_arguments(const Case& c) {
    const Json in_file = read_case(c.folder).settings.resolved_tables(), wanted = c.settings.resolved_tables();
    std::vector<std::string> arguments;
    for (const auto& [table, keys] : wanted.items())
        for (const auto& [key, value] : keys.items())
            if (!in_file.at(table).contains(key) || in_file[table][key] != value)
                arguments.insert(arguments.end(), {"--set", fmt::format("{}.{}={}", table, key, record::toml_text(value))});
    return arguments;
}

}  // namespace porepack::stages
