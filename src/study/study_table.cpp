#include "study/study_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "analysis/shape.hpp"
#include "core/build.hpp"
#include "core/error.hpp"
#include "core/file_lock.hpp"
#include "core/json.hpp"
#include "core/table.hpp"
#include "record/digest.hpp"
#include "results/quantities.hpp"
#include "stages/stages.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

// A value is empty where the stage has not run, or has no such number.
struct Column {
    const char* name;
    std::string (*value)(const results::CaseResults&);
};

std::string text_of(std::optional<double> value) {
    return value && std::isfinite(*value) ? fmt::format("{:.9g}", *value) : std::string();
}
template <typename Interval>
std::string low_of(const Interval& interval) {
    return interval ? text_of(interval->low) : std::string();
}
template <typename Interval>
std::string high_of(const Interval& interval) {
    return interval ? text_of(interval->high) : std::string();
}

using Results = results::CaseResults;

constexpr Column grain_columns[] = {
    {"sphericity", [](const Results& r) { return r.shape ? text_of(r.shape->sphericity) : std::string(); }},
    {"convexity", [](const Results& r) { return r.shape ? text_of(r.shape->convexity) : std::string(); }},
    {"volume_m3", [](const Results& r) { return r.shape ? text_of(r.shape->volume_m3) : std::string(); }},
    {"equal_volume_diameter_m", [](const Results& r) { return r.shape ? text_of(r.shape->equal_volume_diameter_m) : std::string(); }},
    {"capsule_diameter_m", [](const Results& r) { return r.shape ? text_of(r.shape->diameter_m) : std::string(); }},
    {"capsule_length_m", [](const Results& r) { return r.shape ? text_of(r.shape->length_m) : std::string(); }},
    {"grains", [](const Results& r) { return r.pack ? std::to_string(r.pack->grains) : std::string(); }},
    {"bed_height_m", [](const Results& r) { return r.pack ? text_of(r.pack->bed.bed_height_m) : std::string(); }},
    {"porosity_bed", [](const Results& r) { return r.pack ? text_of(r.pack->bed.porosity_bed) : std::string(); }},
    {"coordination_number",
     [](const Results& r) { return r.pack && r.pack->pour ? text_of(r.pack->pour->coordination_number) : std::string(); }}};

template <double permeability::BedNumbers::*number>
std::string bed_number(const Results& r) {
    return r.descriptors ? text_of(r.descriptors->numbers.*number) : std::string();
}

constexpr Column other_columns[] = {
    {"permeability_over_equivalent_diameter2", bed_number<&permeability::BedNumbers::permeability_over_equivalent_diameter2>},
    {"surface_per_bed_per_m", bed_number<&permeability::BedNumbers::surface_per_bed_per_m>},
    {"kozeny_constant", bed_number<&permeability::BedNumbers::kozeny_constant>},
    {"permeability_core_m2",
     [](const Results& r) { return r.descriptors && r.descriptors->wall ? text_of(r.descriptors->wall->permeability_core_m2) : ""; }},
    {"openfoam_permeability_m2", [](const Results& r) { return r.foam ? text_of(r.foam->permeability.m2) : std::string(); }},
    {"openfoam_permeability_low_m2", [](const Results& r) { return r.foam ? low_of(r.foam->permeability.interval_m2) : std::string(); }},
    {"openfoam_permeability_high_m2", [](const Results& r) { return r.foam ? high_of(r.foam->permeability.interval_m2) : std::string(); }},
    {"voxel_size_m", [](const Results& r) { return r.lbm ? text_of(r.lbm->fine.voxel_size_m) : std::string(); }}};

// The order of the columns: first those that name the point.
std::vector<std::string> columns_of(const Study& study) {
    std::vector<std::string> columns = {"point", "current"};
    columns.insert(columns.end(), study.keys.begin(), study.keys.end());
    columns.insert(columns.end(), {"shape", "seed", "packings"});
    for (const Column& column : grain_columns) columns.emplace_back(column.name);
    for (const results::Quantity& quantity : results::reported_quantities) {
        columns.emplace_back(quantity.name);
        for (const char* suffix : {"low", "high"}) columns.push_back(with_suffix(quantity.name, suffix));
    }
    columns.emplace_back("permeability_standard_deviation_m2");
    for (const Column& column : other_columns) columns.emplace_back(column.name);
    columns.insert(columns.end(),
                   {"seconds", "peak_memory_bytes", "program_version", "git_hash", "result_versions", "packing_sha256", "digest"});
    return columns;
}

// The mean of several packings with its interval, else the value of the only one.
std::pair<std::optional<double>, std::optional<Interval>> best_known(const Results& results, const results::Quantity& quantity) {
    const auto* sure = results.uncertainty ? find(results.uncertainty->statements, quantity.name) : nullptr;
    if (results.seeds) {
        if (sure != nullptr && sure->mean_of_such_packings.value)
            return {sure->mean_of_such_packings.value, sure->mean_of_such_packings.interval};
        if (const auto* seeds = find(results.seeds->quantities, quantity.name)) return {seeds->mean, seeds->interval_of_mean};
    }
    if (sure != nullptr && sure->this_packing.value) return {sure->this_packing.value, sure->this_packing.interval};
    return {quantity.value(results), quantity.interval(results)};
}

void add_quantities(StudyRow& row, const Results& results) {
    for (const results::Quantity& quantity : results::reported_quantities) {
        const auto [value, interval] = best_known(results, quantity);
        row[quantity.name] = text_of(value);
        if (!interval) continue;
        row[with_suffix(quantity.name, "low")] = low_of(interval);
        row[with_suffix(quantity.name, "high")] = high_of(interval);
    }
    if (results.seeds) row["permeability_standard_deviation_m2"] = text_of(results.seeds->standard_deviation_between_packings_m2);
}

void write_rows(const Study& study, const std::vector<StudyRow>& rows) {
    std::vector<std::string> columns = columns_of(study);
    for (const StudyRow& row : rows)  // of another version of the program, or of an axis that the study no longer has
        for (const auto& [name, value] : row)
            if (std::find(columns.begin(), columns.end(), name) == columns.end()) columns.push_back(name);
    Table table(columns);
    for (const StudyRow& row : rows) {
        std::vector<std::string> fields;
        for (const std::string& column : columns) {
            const auto found = row.find(column);
            fields.push_back(found == row.end() ? std::string() : table.field(found->second));
        }
        table.add_row(std::move(fields));
    }
    table.write(study.table());
}

}  // namespace

std::string with_suffix(const std::string& column, const std::string& suffix) {
    const auto [name, unit] = split_unit(column);
    return unit.empty() ? name + "_" + suffix : name + "_" + suffix + "_" + unit;
}

std::vector<StudyRow> read_rows(const Study& study) {
    if (!fs::exists(study.table())) return {};
    const TextTable table = read_text_table(study.table());
    for (const char* needed : {"point", "digest"})
        if (std::find(table.columns.begin(), table.columns.end(), needed) == table.columns.end())
            throw UserError(fmt::format("the column `{}` is missing", needed), {.where = study.table().string()});
    std::vector<StudyRow> rows;
    for (const auto& fields : table.rows) {
        StudyRow row;
        for (std::size_t i = 0; i < fields.size(); ++i) row[table.columns[i]] = fields[i];
        rows.push_back(std::move(row));
    }
    return rows;
}

bool is_current(const StudyRow& row, const Point& point) {
    return row.at("point") == point.name && row.at("digest") == point.digest;
}

bool has_current_row(const std::vector<StudyRow>& rows, const Point& point) {
    return std::any_of(rows.begin(), rows.end(), [&](const StudyRow& row) { return is_current(row, point); });
}

namespace {

std::string text_of_key(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.is_null() ? std::string() : value.dump();
}

}  // namespace

// Only stages of the point's identity count. A folder may hold results of later stages, from a run on its own; these are not covered by the
// digest and may belong to other settings.
StudyRow row_of(const Point& point, const Case& made) {
    std::vector<std::string> versions, stages;
    double seconds = 0.0, memory = 0.0;
    for (const Json& stage : point.identity) {
        const auto name = stage["stage"].get<std::string>();
        const Json manifest = read_json(made.stage_folder(name) / "manifest.json");
        stages.push_back(name);
        versions.push_back(fmt::format("{} {}", name, stage["result_version"].get<long>()));
        seconds += manifest.value("wall_time_s", 0.0);
        memory = std::max(memory, manifest.value("peak_memory_bytes", 0.0));
    }
    // The shape is measured here: its stage need not have run.
    Results results = results::read_results(made.results(), [&](const std::string& stage) {
        return stage != results::Shape::stage && std::find(stages.begin(), stages.end(), stage) != stages.end();
    });
    if (!made.from_surface() && !made.from_image())
        results.shape = analysis::measure_shape(made.settings.shape, made.settings.packing.density_kg_per_m3);
    StudyRow row = {{"point", point.name},
                    {"current", "yes"},
                    {"shape", std::string(name_of(made.settings.shape.kind))},
                    {"seed", std::to_string(made.settings.packing.seed)},
                    {"packings", results.seeds ? std::to_string(results.seeds->packings) : "1"},
                    {"seconds", fmt::format("{:.4g}", seconds)},
                    {"peak_memory_bytes", fmt::format("{:.4g}", memory)},
                    {"program_version", program_version()},
                    {"git_hash", git_hash()},
                    {"result_versions", fmt::format("{}", fmt::join(versions, "; "))},
                    {"digest", point.digest}};
    for (const auto& [key, value] : point.values) row[key] = text_of_key(value);
    for (const auto& columns : {std::span<const Column>(grain_columns), std::span<const Column>(other_columns)})
        for (const Column& column : columns)
            if (const std::string value = column.value(results); !value.empty()) row[column.name] = value;
    add_quantities(row, results);
    if (const Path packing = made.stage_folder("pack") / "packing.json"; fs::exists(packing))
        row["packing_sha256"] = sha256_of_file(packing);
    return row;
}

void add_row(const Study& study, const StudyRow& row) {
    // The rows are read under the lock: rows that another process adds meanwhile would be lost otherwise.
    const FileLock lock = FileLock::wait_for(study.folder / ".study.lock");
    std::vector<StudyRow> rows = read_rows(study);
    std::erase_if(rows, [&](const StudyRow& old) { return old.at("point") == row.at("point") && old.at("digest") == row.at("digest"); });
    rows.push_back(row);
    std::map<std::string, std::pair<std::size_t, std::string>> wanted;  // name -> place and digest
    for (std::size_t i = 0; i < study.points.size(); ++i) wanted[study.points[i].name] = {i, study.points[i].digest};
    // Current rows stand in the order of the points; rows of other points or settings follow, marked as not current.
    const auto place = [&](const StudyRow& one) {
        const auto found = wanted.find(one.at("point"));
        return found == wanted.end() || found->second.second != one.at("digest") ? wanted.size() : found->second.first;
    };
    for (StudyRow& one : rows) one["current"] = place(one) < wanted.size() ? "yes" : "no";
    std::stable_sort(rows.begin(), rows.end(), [&](const StudyRow& one, const StudyRow& other) { return place(one) < place(other); });
    write_rows(study, rows);
}

std::string column_named(const std::vector<StudyRow>& rows, const std::string& name) {
    std::set<std::string> columns;
    for (const StudyRow& row : rows)
        for (const auto& [column, value] : row) columns.insert(column);
    if (columns.contains(name)) return name;
    std::vector<std::string> near;
    for (const std::string& column : columns)
        if (column.ends_with("." + name) || split_unit(column).first == name) near.push_back(column);
    if (near.size() == 1) return near.front();
    throw UserError(fmt::format("study.csv has {} column `{}`", near.empty() ? "no" : "more than one", name),
                    {.allowed = fmt::format("{}", fmt::join(near.empty() ? std::vector(columns.begin(), columns.end()) : near, ", "))});
}

}  // namespace porepack::study
