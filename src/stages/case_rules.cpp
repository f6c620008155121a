#include "stages/case_rules.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "record/resolved_config.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

void require_known(Settings& settings, const std::map<std::string, Flags>& set) {
    for (const auto& [table, keys] : set) {
        const auto& tables = Settings::tables();
        if (std::find(tables.begin(), tables.end(), table) == tables.end())
            throw UserError(
                fmt::format("there is no table [{}]", table),
                {.where = "--set", .allowed = fmt::format("{}", fmt::join(tables, ", ")), .fix = perhaps(nearest(table, tables))});
        std::vector<std::string> known;
        for (const auto& row : key_rows(settings.describe_table(table))) known.push_back(row.key);
        for (const auto& [key, value] : keys)
            if (std::find(known.begin(), known.end(), key) == known.end())
                throw UserError(
                    fmt::format("unknown key `{}.{}`", table, key),
                    {.where = "--set", .allowed = fmt::format("{}", fmt::join(known, ", ")), .fix = perhaps(nearest(key, known))});
    }
}

// A key that another table has: the reader of one table cannot know.
void require_own_keys(Settings& settings, const TomlFile& toml) {
    std::map<std::string, std::vector<std::string>> tables_with;
    for (const auto& table : Settings::tables()) {
        const Describe describe = settings.describe_table(table);
        for (const auto& row : key_rows(describe)) tables_with[row.key].push_back(table);
        for (const auto& old : renamed_keys(describe)) tables_with[old.first].push_back(table);
    }
    for (const auto& table : Settings::tables())
        for (const auto& [key, where] : toml.keys_of(table)) {
            const auto found = tables_with.find(key);
            if (found == tables_with.end()) continue;
            const auto& tables = found->second;
            if (std::find(tables.begin(), tables.end(), table) == tables.end())
                throw UserError(fmt::format("unknown key `{}.{}`", table, key),
                                {.where = where, .fix = fmt::format("the key belongs to [{}]", fmt::join(tables, "] or ["))});
        }
}

namespace {

// An image has no grains unless they are found in it; then the other stages are those of a packing, and nothing is poured.
void require_tables_of_image(const Case& c, const TomlFile& toml, const std::map<std::string, Flags>& set, const std::string& file) {
    if (!toml.has("image")) return;
    const bool fit = c.settings.image.fit;
    for (const char* table : {"shape", "packing", "protocol", "packings", "stl", "forchheimer"})
        if ((toml.has(table) || set.contains(table)) &&
            (!fit || std::string(table).starts_with("packing") || std::string(table) == "protocol"))
            throw UserError(std::string("the table [") + table + "] has no effect on an image",
                            {.where = file,
                             .fix = std::string("remove it, or ") +
                                    (table == std::string("shape") ? "write fit = true in [image]" : "remove [image]")});
    if (c.settings.image.fit_memory_bytes != 0.0 && !fit)
        throw UserError("`fit_memory_bytes` has no effect without fit = true", {.where = file + ", [image]"});
    if (c.settings.image.fitted_sizes && !fit)
        throw UserError("`fitted_sizes` has no effect without fit = true", {.where = file + ", [image]"});
    if (fit && c.settings.image.file.empty())
        throw UserError("fit = true needs a scan", {.where = file + ", [image]", .fix = "file = \"scan.nrrd\""});
    if (fit && (!toml.has("shape") || c.from_surface()))
        throw UserError("fit = true needs the shape of the grains", {.where = file, .allowed = "[shape] with spherocylinders"});
}

// The grains of an STL file are not poured.
void require_pouring(const Case& c, const TomlFile& toml, const std::map<std::string, Flags>& set, const std::string& file) {
    for (const char* table : {"packing", "protocol", "packings"})
        if (c.from_surface() && (toml.has(table) || set.contains(table)))
            throw UserError(fmt::format("the table [{}] has no effect on the grains of an STL file: they stay where they are", table),
                            {.where = file,
                             .allowed = "an STL file with all grains of the bed in their places",
                             .fix = "remove the table; to pour many copies of one grain, kind = \"mesh\""});
    if (c.from_surface()) refuse_sizes(c.settings.shape, "file, unit_m");
    if (c.from_surface() && (!c.settings.shape.folder.empty() || c.settings.shape.library_by != shapes::LibraryBy::number))
        throw UserError("`folder` and `library_by` have no effect on the surface of all grains",
                        {.where = file + ", [shape]", .fix = "remove them, or choose kind = \"library\""});
    if (c.from_surface() && (c.settings.shape.faces > 0 || c.settings.shape.deviation_m > 0.0 || c.settings.shape.rounding_m > 0.0))
        throw UserError("`faces`, `deviation_m` and `rounding_m` have no effect on all grains of an STL file: they stay as they are",
                        {.where = file + ", [shape]", .fix = "remove them; to pour many copies of one grain, kind = \"mesh\""});
}

// What [packings] and friction_uncertainty need of each other.
void require_packings(const Settings& settings, const std::string& file) {
    const PackingsConfig& packings = settings.packings;
    const PackingConfig& packing = settings.packing;
    const bool enough = packings.until_sure > 0.0 || packings.seeds >= 5;
    const std::string where = file + ", [packings]", more = "seeds = 10 or more: the interval is narrower with more";
    if (!packings.measured_porosity.empty()) {
        const double value = packings.measured_porosity[0], u = packings.measured_porosity[1];
        if (!(value > 0.0 && value < 1.0 && u > 0.0 && u < 0.5))
            throw UserError(fmt::format("`measured_porosity` is [{:g}, {:g}]", value, u),
                            {.where = where,
                             .allowed = "[porosity, standard uncertainty], both above 0; a porosity below 1, an uncertainty below 0.5",
                             .fix = "state how well it was measured, as [0.742, 0.004]"});
        if (packing.engine == Engine::none)
            throw UserError("`measured_porosity` needs packings that are poured", {.where = where, .fix = "engine = \"capsule\""});
        if (!enough)
            throw UserError(
                fmt::format("`measured_porosity` needs 5 packings or more, not {}: their porosities must lie about it", packings.seeds),
                {.where = where, .fix = more});
    }
    const bool levels = !packings.measured_between_m.empty();
    if (levels != (packings.measured_part == MeasuredPart::between))
        throw UserError(levels ? "`measured_between_m` has no effect without measured_part = \"between\""
                               : "measured_part = \"between\" needs `measured_between_m`",
                        {.where = where, .fix = levels ? "measured_part = \"between\"" : "measured_between_m = [0.01, 0.06]"});
    if (levels && !(packings.measured_between_m[0] < packings.measured_between_m[1]))
        throw UserError("the levels of `measured_between_m` are not in order", {.where = where, .allowed = "[lower, upper]"});
    if (packings.measured_part != MeasuredPart::section && packings.measured_porosity.empty())
        throw UserError("`measured_part` has no effect without measured_porosity",
                        {.where = where, .fix = "measured_porosity = [0.742, 0.004]"});
    if (packing.friction_uncertainty > 0.0) {
        const std::string here = file + ", [packing]";
        if (packing.engine == Engine::none)
            throw UserError("`friction_uncertainty` needs packings that are poured", {.where = here, .fix = "engine = \"capsule\""});
        if (packings.until_sure > 0.0 || packings.seeds < 5)
            throw UserError("`friction_uncertainty` needs a fixed number of 5 packings or more, between which friction varies",
                            {.where = here, .fix = "[packings] seeds = 10, without until_sure"});
        if (std::sqrt(3.0) * packing.friction_uncertainty > packing.friction)
            throw UserError(
                fmt::format("a friction of {:g} with a standard uncertainty of {:g} would vary below 0", packing.friction,
                            packing.friction_uncertainty),
                {.where = here,
                 .allowed = fmt::format("friction_uncertainty up to {:.3g} (friction / sqrt(3))", packing.friction / std::sqrt(3.0))});
    }
}

// Menisci are part of the voxels alone.
void require_no_surface_with_menisci(const Case& c, const TomlFile& toml, const std::string& file) {
    if (c.settings.geometry.closing_radius_m == 0.0) return;
    if (toml.has("openfoam") && c.settings.openfoam.enabled)
        throw UserError("OpenFOAM's mesh is made from the grains, without menisci: [openfoam] has no effect with closing_radius_m",
                        {.where = file, .fix = "enabled = false in [openfoam]"});
    if (c.settings.forchheimer.enabled && c.settings.forchheimer.openfoam)
        throw UserError("OpenFOAM's mesh is made from the grains, without menisci",
                        {.where = file + ", [forchheimer]", .fix = "openfoam = false"});
    if (c.settings.falling_head.causes)
        throw UserError("the causes of a wrong k are computed for grains without menisci",
                        {.where = file + ", [falling_head]", .fix = "causes = false"});
    if (c.settings.stl.pores || c.settings.stl.clip)
        throw UserError("`pores` and `clip` are made from the grains, without menisci", {.where = file + ", [stl]", .fix = "remove them"});
}

}  // namespace

void require_consistent(const Case& c, const TomlFile& toml, const std::map<std::string, Flags>& set, const std::string& file) {
    require_tables_of_image(c, toml, set, file);
    if (toml.has("protocol") && c.settings.protocol.none())
        throw UserError("[protocol] has no steps",
                        {.where = file, .fix = "[[protocol.step]] kind = \"tap\", number = 100, height_m = 0.002"});
    if (c.settings.packing.engine == Engine::none && !c.settings.protocol.none())
        throw UserError("[protocol] has no effect on a given packing",
                        {.where = file, .fix = "remove it, or pour the bed: engine = \"capsule\""});
    if (const PackingConfig& packing = c.settings.packing; packing.engine != Engine::none && !packing.file.empty())
        throw UserError(fmt::format("`file` has no effect with engine = \"{}\"", name_of(packing.engine)),
                        {.where = file + ", [packing]", .fix = "remove it, or write engine = \"none\""});
    require_pouring(c, toml, set, file);
    require_packings(c.settings, file);
    require_no_surface_with_menisci(c, toml, file);
}

}  // namespace porepack::stages
