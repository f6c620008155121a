#include "apps/case.hpp"

#include "core/error.hpp"

namespace porepack {

const std::vector<std::string>& Settings::tables() {
    static const std::vector<std::string> names = {"shape",    "container",  "packing",     "geometry",     "stl",   "lbm",
                                                   "openfoam", "tortuosity", "forchheimer", "falling_head", "report"};
    return names;
}

Describe Settings::describe_table(const std::string& table) {
    if (table == "shape") return [this](ConfigVisitor& v) { describe(v, shape); };
    if (table == "container") return [this](ConfigVisitor& v) { describe(v, container); };
    if (table == "packing") return [this](ConfigVisitor& v) { describe(v, packing); };
    if (table == "geometry") return [this](ConfigVisitor& v) { describe(v, geometry); };
    if (table == "stl") return [this](ConfigVisitor& v) { describe(v, stl); };
    if (table == "lbm") return [this](ConfigVisitor& v) { describe(v, lbm); };
    if (table == "openfoam") return [this](ConfigVisitor& v) { describe(v, openfoam); };
    if (table == "tortuosity") return [this](ConfigVisitor& v) { describe(v, tortuosity); };
    if (table == "forchheimer") return [this](ConfigVisitor& v) { describe(v, forchheimer); };
    if (table == "falling_head") return [this](ConfigVisitor& v) { describe(v, falling_head); };
    if (table == "report") return [this](ConfigVisitor& v) { describe(v, report); };
    throw std::logic_error("no such table: " + table);
}

Case read_case(const Path& path, const std::string& flag_table, const Flags& flags) {
    const Path file = std::filesystem::is_directory(path) ? path / "case.toml" : path;
    if (!std::filesystem::exists(file))
        throw UserError("no such case: " + file.string(), {.mend = "a case is a folder with a file case.toml in it"});
    const TomlFile toml(file);
    toml.require_known_tables(Settings::tables());
    Case the_case;
    the_case.folder = file.parent_path().empty() ? Path(".") : file.parent_path();
    for (const char* table : {"shape", "container"})
        if (!toml.has(table))
            throw UserError(std::string("the table [") + table + "] is missing",
                            {.where = file.string(), .allowed = "[shape] and [container] are required, all else has defaults"});
    // A flag belongs to the table of its command, or to [geometry], which all of them share.
    for (const auto& table : Settings::tables())
        toml.read(table, the_case.settings.describe_table(table), table == flag_table || table == "geometry" ? flags : Flags{});
    return the_case;
}

}  // namespace porepack
