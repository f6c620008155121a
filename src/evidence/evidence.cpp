#include "evidence/evidence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/error.hpp"
#include "core/table.hpp"
#include "evidence/uses.hpp"
#include "report/plot.hpp"

namespace porepack::evidence {
namespace {

// A table of which every column is named here; rows by the names of the columns.
using Fields = std::map<std::string, std::string>;
std::vector<Fields> rows_of(const Path& file, const std::vector<std::string>& columns) {
    const TextTable table = read_text_table(file);
    if (table.columns != columns)
        throw UserError("the columns are others", {.where = file.string(), .allowed = fmt::format("{}", fmt::join(columns, ","))});
    std::vector<Fields> rows;
    for (const auto& row : table.rows) {
        Fields& fields = rows.emplace_back();
        for (std::size_t i = 0; i < columns.size(); ++i) fields[columns[i]] = row[i];
    }
    return rows;
}

double number(const Fields& row, const char* column, const Path& file) {
    const std::string& text = row.at(column);
    std::size_t end = 0;
    double value = NAN;
    try {
        value = std::stod(text, &end);
    } catch (const std::exception&) {
        end = 0;
    }
    if (end == 0 || end != text.size() || !std::isfinite(value))
        throw UserError(fmt::format("`{}` of `{}` is not a number: \"{}\"", column, row.at("item"), text), {.where = file.string()});
    return value;
}

Ours ours_of(const Fields& row, const Path& file) {
    Ours ours{.item = row.at("item"),
              .value = number(row, "value", file),
              .interval = {number(row, "low", file), number(row, "high", file)},
              .command = row.at("command"),
              .date = row.at("date"),
              .version = row.at("version")};
    if (const auto change = row.find("change"); change != row.end()) ours.change = change->second;
    if (!(ours.interval.low <= ours.value && ours.value <= ours.interval.high))
        throw UserError(fmt::format("the interval of `{}` does not hold its value", ours.item), {.where = file.string()});
    return ours;
}

Published published_of(const Fields& row, const Path& file) {
    Published published{.item = row.at("item"), .value = number(row, "value", file), .unit = row.at("unit"), .source = row.at("source")};
    if (!row.at("standard_uncertainty").empty()) published.standard_uncertainty = number(row, "standard_uncertainty", file);
    if (published.value == 0.0 || published.standard_uncertainty.value_or(1.0) <= 0.0)
        throw UserError(fmt::format("`{}`: value and uncertainty are above 0", published.item), {.where = file.string()});
    return published;
}

std::string title_of(const Path& page) {
    const std::string text = read_text(page);
    if (!text.starts_with("# ")) throw UserError("the first line is not a title", {.where = page.string(), .allowed = "# Title"});
    return text.substr(2, text.find('\n') - 2);
}

Subject read_subject(const Path& folder) {
    Subject subject{.name = folder.filename().string(), .title = title_of(folder / "README.md"), .rows = {}, .controls = {}};
    const Path theirs = folder / "published.csv", own = folder / "ours.csv", wrong = folder / "control.csv";
    for (const Fields& row : rows_of(theirs, {"item", "value", "standard_uncertainty", "unit", "source"})) {
        subject.rows.push_back({published_of(row, theirs)});
        for (std::size_t i = 0; i + 1 < subject.rows.size(); ++i)
            if (subject.rows[i].published.item == subject.rows.back().published.item)
                throw UserError(fmt::format("`{}` stands twice", row.at("item")), {.where = theirs.string()});
    }
    const auto published = [&](const std::string& item, const Path& file) -> Row& {
        const auto found = std::ranges::find_if(subject.rows, [&](const Row& row) { return row.published.item == item; });
        if (found == subject.rows.end()) throw UserError(fmt::format("`{}` is not in published.csv", item), {.where = file.string()});
        return *found;
    };
    const std::vector<std::string> columns = {"item", "value", "low", "high", "command", "date", "version"};
    if (std::filesystem::exists(own))
        for (const Fields& row : rows_of(own, columns)) {
            Row& one = published(row.at("item"), own);
            if (one.ours) throw UserError(fmt::format("`{}` stands twice", row.at("item")), {.where = own.string()});
            one.ours = ours_of(row, own);
        }
    if (std::filesystem::exists(wrong)) {
        std::vector<std::string> with_change = columns;
        with_change.insert(with_change.begin(), "change");
        for (const Fields& row : rows_of(wrong, with_change)) {
            Row& one = published(row.at("item"), wrong);
            subject.controls.push_back({one.published, ours_of(row, wrong)});
            one.control_agrees |= subject.controls.back().verdict() != Verdict::disagrees;
        }
    }
    return subject;
}

std::string number_of(double value) {
    return fmt::format("{:.4g}", value);
}

std::string ours_text(const Row& row) {
    if (!row.ours) return "not computed";
    return fmt::format("{} ({} to {})", number_of(row.ours->value), number_of(row.ours->interval.low), number_of(row.ours->interval.high));
}

std::string theirs_text(const Published& published) {
    const std::string value = number_of(published.value) + (published.unit.empty() || published.unit == "1" ? "" : " " + published.unit);
    if (!published.standard_uncertainty) return value;
    return fmt::format("{} (u {:.2g} %)", value, 100.0 * *published.standard_uncertainty / std::abs(published.value));
}

}  // namespace

std::string_view word_of(Verdict verdict) {
    return verdict == Verdict::agrees ? "agrees" : verdict == Verdict::disagrees ? "disagrees" : "no verdict";
}

Verdict verdict_of(const Published& published, const std::optional<Ours>& ours) {
    constexpr double largest_uncertainty = 0.15;  // relative; beyond it a value is no evidence
    const auto& theirs = published.standard_uncertainty;
    if (!ours || !theirs || *theirs > largest_uncertainty * std::abs(published.value)) return Verdict::none;
    const double own = 0.25 * (ours->interval.high - ours->interval.low);
    return std::abs(ours->value - published.value) <= 2.0 * std::hypot(*theirs, own) ? Verdict::agrees : Verdict::disagrees;
}

Verdict Row::verdict() const {
    return control_agrees ? Verdict::none : verdict_of(published, ours);
}

std::optional<double> Row::difference() const {
    if (!ours) return std::nullopt;
    return ours->value / published.value - 1.0;
}

int Subject::count(Verdict verdict) const {
    return static_cast<int>(std::ranges::count_if(rows, [&](const Row& row) { return row.verdict() == verdict; }));
}

bool Subject::control_disagrees() const {
    return std::ranges::any_of(controls, [](const Row& row) { return row.verdict() == Verdict::disagrees; });
}

std::vector<Subject> read_evidence(const Path& folder) {
    if (!std::filesystem::is_directory(folder)) throw UserError("not a folder", {.where = folder.string()});
    std::vector<Subject> subjects;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (std::filesystem::exists(entry.path() / "published.csv")) subjects.push_back(read_subject(entry.path()));
    if (subjects.empty())
        throw UserError("there is no evidence", {.where = folder.string(), .allowed = "a folder of folders with published.csv"});
    std::ranges::sort(subjects, {}, &Subject::name);
    return subjects;
}

std::string table_of(const std::vector<Subject>& subjects) {
    std::string text;
    for (const Subject& subject : subjects) {
        text += fmt::format(
            "## [{}]({}/README.md)\n\n| quantity | published | ours (95 of 100) | difference | verdict |\n|---|---|---|---|---|\n",
            subject.title, subject.name);
        const auto add = [&](const Row& row, const std::string& name) {
            const auto difference = row.difference();
            text += fmt::format("| {} | {} | {} | {} | {} |\n", name, theirs_text(row.published), ours_text(row),
                                difference ? fmt::format("{:+.1f} %", 100.0 * *difference) : "", word_of(row.verdict()));
        };
        for (const Row& row : subject.rows) add(row, row.published.item);
        for (const Row& row : subject.controls) add(row, fmt::format("*control, {}*: {}", row.ours->change, row.published.item));
        text += '\n';
    }
    return text;
}

bool draw_evidence(const Path& picture, const std::vector<Subject>& subjects) {
    Path data = picture;
    data.replace_extension(".dat");
    std::string text = "# place, ours over published, low, high, low and high of the published value over itself, subject, quantity\n";
    int place = 0, subject_number = 0;
    for (const Subject& subject : subjects) {
        ++subject_number;
        bool any = false;
        for (const Row& row : subject.rows) {
            if (!row.ours) continue;
            const double value = row.published.value, u = 2.0 * row.published.standard_uncertainty.value_or(0.0) / std::abs(value);
            text += fmt::format("{} {:.5g} {:.5g} {:.5g} {:.5g} {:.5g} {} \"{}\"\n", ++place, row.ours->value / value,
                                row.ours->interval.low / value, row.ours->interval.high / value, 1.0 - u, 1.0 + u, subject_number,
                                row.published.item);
            any = true;
        }
        place += any ? 1 : 0;
    }
    if (place == 0) return false;
    write_text(data, text);
    return draw_plot(picture, "evidence", {{"data", data.filename().string()}, {"places", static_cast<double>(place)}},
                     {.width = 760, .height = 90 + 17 * place, .font = 11});
}

}  // namespace porepack::evidence
