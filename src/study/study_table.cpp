#include "study/study_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/build.hpp"
#include "core/error.hpp"
#include "core/file_lock.hpp"
#include "core/table.hpp"
#include "record/digest.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"
#include "uncertainty/quantities.hpp"

namespace porepack::study {
using namespace core;
using namespace record;
using namespace permeability;
using namespace uncertainty;
using namespace stages;
namespace fs = std::filesystem;
namespace {

struct Column {
    const char *name, *value;  // place in {"stage": result}
};

constexpr Column grain_columns[] = {{"sphericity", "/shape/sphericity"},
                                    {"convexity", "/shape/convexity"},
                                    {"volume_m3", "/shape/volume_m3"},
                                    {"equal_volume_diameter_m", "/shape/equal_volume_diameter_m"},
                                    {"capsule_diameter_m", "/shape/diameter_m"},
                                    {"capsule_length_m", "/shape/length_m"},
                                    {"grains", "/pack/grains"},
                                    {"bed_height_m", "/pack/bed_height_m"},
                                    {"porosity_bed", "/pack/porosity_bed"},
                                    {"coordination_number", "/pack/coordination_number"}};

constexpr Column other_columns[] = {
    {"permeability_over_equivalent_diameter2", "/descriptors/numbers/permeability_over_equivalent_diameter2"},
    {"surface_per_bed_per_m", "/descriptors/numbers/surface_per_bed_per_m"},
    {"kozeny_constant", "/descriptors/numbers/kozeny_constant"},
    {"permeability_core_m2", "/descriptors/wall/permeability_core_m2"},
    {"openfoam_permeability_m2", "/foam/permeability_m2"},
    {"openfoam_permeability_low_m2", "/foam/permeability_interval_m2/0"},
    {"openfoam_permeability_high_m2", "/foam/permeability_interval_m2/1"},
    {"voxel_size_m", "/lbm/fine/voxel_size_m"}};

// The order of the columns: first those that name the point.
std::vector<std::string> columns_of(const Study& study) {
    std::vector<std::string> columns = {"point", "current"};
    columns.insert(columns.end(), study.keys.begin(), study.keys.end());
    columns.insert(columns.end(), {"shape", "seed", "packings"});
    for (const Column& column : grain_columns) columns.emplace_back(column.name);
    for (const Quantity& quantity : reported_quantities) {
        columns.emplace_back(quantity.name);
        for (const char* suffix : {"low", "high"}) columns.push_back(with_suffix(quantity.name, suffix));
    }
    columns.emplace_back("permeability_standard_deviation_m2");
    for (const Column& column : other_columns) columns.emplace_back(column.name);
    columns.insert(columns.end(),
                   {"seconds", "peak_memory_bytes", "program_version", "git_hash", "result_versions", "packing_sha256", "digest"});
    return columns;
}

std::string text_of(const Json& value) {
    if (value.is_string()) return value.get<std::string>();
    return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.is_null() ? std::string() : value.dump();
}

// The mean of several packings with its interval, else the value of the only one.
void add_quantities(StudyRow& row, const Json& results) {
    for (const Quantity& quantity : reported_quantities) {
        const std::string name = quantity.name, statement = "/uncertainty/statements/" + name;
        Json value = nullptr, interval = nullptr;
        const auto take = [&](const std::string& at, const std::string& between) {
            if (!value.is_null() || !number_at(results, at)) return;
            value = results.at(Json::json_pointer(at));
            if (const Json::json_pointer place(between); !between.empty() && results.contains(place)) interval = results.at(place);
        };
        if (results.contains("seeds")) {
            take(statement + "/mean_of_such_packings/value", statement + "/mean_of_such_packings/interval");
            take("/seeds/quantities/" + name + "/mean", "/seeds/quantities/" + name + "/interval_of_mean");
        }
        take(statement + "/this_packing/value", statement + "/this_packing/interval");
        take(quantity.value, quantity.interval);
        row[name] = text_of(value);
        if (!interval.is_array()) continue;
        row[with_suffix(name, "low")] = text_of(interval[0]);
        row[with_suffix(name, "high")] = text_of(interval[1]);
    }
    if (results.contains("seeds"))
        row["permeability_standard_deviation_m2"] = text_of(results["seeds"]["standard_deviation_between_packings_m2"]);
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

StudyRow row_of(const Point& point, const Case& made) {
    Json results = {{"shape", made.from_stl() || made.from_image()
                                  ? Json::object()
                                  : measure_shape(made.settings.shape, made.settings.packing.density_kg_per_m3)}};
    std::vector<std::string> versions;
    double seconds = 0.0, memory = 0.0;
    for (const Json& stage : point.identity) {
        const auto name = stage["stage"].get<std::string>();
        const Json manifest = read_json(made.stage_folder(name) / "manifest.json");
        if (name != "shape") results[name] = made.result_of(name);
        versions.push_back(fmt::format("{} {}", name, stage["result_version"].get<long>()));
        seconds += manifest.value("wall_time_s", 0.0);
        memory = std::max(memory, manifest.value("peak_memory_bytes", 0.0));
    }
    StudyRow row = {{"point", point.name},
                    {"current", "yes"},
                    {"shape", std::string(name_of(made.settings.shape.kind))},
                    {"seed", std::to_string(made.settings.packing.seed)},
                    {"packings", results.contains("seeds") ? results["seeds"]["packings"].dump() : "1"},
                    {"seconds", fmt::format("{:.4g}", seconds)},
                    {"peak_memory_bytes", fmt::format("{:.4g}", memory)},
                    {"program_version", program_version()},
                    {"git_hash", git_hash()},
                    {"result_versions", fmt::format("{}", fmt::join(versions, "; "))},
                    {"digest", point.digest}};
    for (const auto& [key, value] : point.values) row[key] = text_of(value);
    for (const auto& columns : {std::span<const Column>(grain_columns), std::span<const Column>(other_columns)})
        for (const Column& column : columns)
            if (const Json::json_pointer at(column.value); results.contains(at)) row[column.name] = text_of(results.at(at));
    add_quantities(row, results);
    if (const Path packing = made.stage_folder("pack") / "packing.json"; fs::exists(packing))
        row["packing_sha256"] = sha256_of_file(packing);
    return row;
}

void add_row(const Study& study, const StudyRow& row) {
    const FileLock lock = FileLock::wait_for(study.folder / ".study.lock");
    std::vector<StudyRow> rows = read_rows(study);
    std::erase_if(rows, [&](const StudyRow& old) { return old.at("point") == row.at("point") && old.at("digest") == row.at("digest"); });
    rows.push_back(row);
    std::map<std::string, std::pair<std::size_t, std::string>> wanted;  // name -> place and digest
    for (std::size_t i = 0; i < study.points.size(); ++i) wanted[study.points[i].name] = {i, study.points[i].digest};
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
