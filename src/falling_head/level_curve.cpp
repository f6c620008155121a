#include "falling_head/level_curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <sstream>

#include "core/error.hpp"
#include "core/median.hpp"

namespace porepack::falling_head {
namespace {

std::string trimmed(std::string text) {
    const auto blank = [](unsigned char c) { return std::isspace(c) != 0; };
    text.erase(text.begin(), std::find_if_not(text.begin(), text.end(), blank));
    text.erase(std::find_if_not(text.rbegin(), text.rend(), blank).base(), text.end());
    return text;
}

// The separator that the header uses: semicolon, tab, or else comma.
char separator_of(const std::string& header) {
    return header.find(';') != std::string::npos ? ';' : header.find('\t') != std::string::npos ? '\t' : ',';
}

std::vector<std::string> cells_of(const std::string& line, char separator) {
    std::vector<std::string> cells = {""};
    bool quoted = false;  // a separator there is part of the cell
    for (const char c : line)
        if (c == '"')
            quoted = !quoted;
        else if (c == separator && !quoted)
            cells.emplace_back();
        else
            cells.back() += c;
    for (std::string& cell : cells) cell = trimmed(cell);
    while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
    return cells;
}

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

// The part of a line that can be shown.
std::string excerpt(const std::string& line) {
    std::string shown;
    for (const char c : line.substr(0, 80)) shown += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
    return line.size() > 80 ? shown + " ..." : shown;
}

// The whole file, with Unix line ends.
std::string text_of(const Path& csv) {
    if (std::filesystem::is_directory(csv)) throw UserError(csv.string() + " is a folder", {.fix = "name the CSV files in it"});
    // Spreadsheets write UTF-16, a byte order mark, or carriage returns: the first is refused, the others are removed.
    std::string text = read_text(csv, 100e6);
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
        throw UserError("the file is UTF-16", {.where = csv.string(), .fix = "save it as CSV (UTF-8)"});
    if (text.find('\0') != std::string::npos)
        throw UserError("this is not text", {.where = csv.string(), .fix = "save the levels as CSV (UTF-8)"});
    if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
    for (std::size_t at = 0; (at = text.find('\r', at)) != std::string::npos;)
        if (at + 1 < text.size() && text[at + 1] == '\n')
            text.erase(at, 1);
        else
            text[at] = '\n';
    return text;
}

struct Column {
    std::size_t place = 0;
    double unit = 0.0;  // 0: not found
};

Column find_column(const std::vector<std::string>& header, const std::map<std::string, double>& names, const std::string& where) {
    Column column;
    for (std::size_t i = 0; i < header.size(); ++i)
        if (const auto found = names.find(lower(header[i])); found != names.end()) {
            if (column.unit > 0.0)
                throw UserError(
                    fmt::format("the columns {} and {} state the same quantity", header[column.place], header[i]),
                    {.where = where, .allowed = "one column of times and one of levels", .fix = "remove or rename the other one"});
            column = {i, found->second};
        }
    return column;
}

// Where columns are not separated by commas, a comma is a decimal sign.
double number_in(const std::vector<std::string>& cells, const Column& column, char separator, const std::string& where) {
    const std::string text = column.place < cells.size() ? cells[column.place] : std::string();
    std::string digits = text;
    if (separator != ',' && text.find('.') == std::string::npos && std::count(text.begin(), text.end(), ',') == 1)
        std::replace(digits.begin(), digits.end(), ',', '.');
    const char *start = digits.data() + (digits.starts_with('+') ? 1 : 0), *stop = digits.data() + digits.size();
    double value = 0.0;
    const auto [end, fault] = std::from_chars(start, stop, value);  // decimal only
    if (fault != std::errc() || end != stop || !std::isfinite(value))
        throw UserError("\"" + excerpt(text) + "\" is no number",
                        {.where = where,
                         .allowed = "digits with one decimal sign, no unit, no thousands separator",
                         .fix = "remove lines without a level: gaps are allowed"});
    return value * column.unit;
}

}  // namespace

LevelCurve read_level_curve(const Path& csv) {
    static const std::map<std::string, double> times = {{"time_s", 1.0}, {"time_ms", 1e-3}, {"time_min", 60.0}},
                                               levels = {{"level_m", 1.0}, {"level_cm", 1e-2}, {"level_mm", 1e-3}};
    LevelCurve curve{.name = csv.string(), .packing = {}, .time_s = {}, .level_m = {}};
    Column time, level;
    char separator = ',';
    std::size_t columns = 0;
    long number = 0;
    std::istringstream in(text_of(csv));
    for (std::string line; std::getline(in, line);) {
        ++number;
        const std::string where = fmt::format("{}:{}", csv.string(), number);
        line = trimmed(line);
        if (line.starts_with("#")) {
            const std::string comment = trimmed(line.substr(1));
            if (!comment.starts_with("packing:")) continue;
            const std::string packing = trimmed(comment.substr(8));
            if (!curve.packing.empty() && packing != curve.packing)
                throw UserError(fmt::format("one curve belongs to one packing, not to {} and {}", curve.packing, packing),
                                {.where = where, .fix = "one file per curve"});
            curve.packing = packing;
            continue;
        }
        if (line.find_first_not_of(",;\t ") == std::string::npos) continue;
        if (time.unit == 0.0) {
            separator = separator_of(line);
            const auto names = cells_of(line, separator);
            columns = names.size();
            time = find_column(names, times, where);
            level = find_column(names, levels, where);
            if (time.unit == 0.0 || level.unit == 0.0)
                throw UserError("the header does not name a time and a level with their units: " + excerpt(line),
                                {.where = where,
                                 .allowed = "time_s, time_ms or time_min, and level_m, level_cm or level_mm",
                                 .fix = "write for instance \"time_s,level_mm\" above the numbers"});
            continue;
        }
        const auto cells = cells_of(line, separator);
        if (cells.size() > columns)
            throw UserError(fmt::format("{} numbers where the header has {} columns: {}", cells.size(), columns, excerpt(line)),
                            {.where = where, .fix = "if commas are decimal signs, separate the columns (the header's too) by semicolons"});
        const double t = number_in(cells, time, separator, where), h = number_in(cells, level, separator, where);
        if (!curve.time_s.empty() && t <= curve.time_s.back())
            throw UserError(fmt::format("the time {:g} s does not follow {:g} s", t, curve.time_s.back()),
                            {.where = where, .fix = "sort the lines by time and remove duplicates"});
        curve.time_s.push_back(t);
        curve.level_m.push_back(h);
    }
    if (curve.time_s.empty())
        throw UserError("no numbers in " + csv.string(),
                        {.allowed = "CSV (UTF-8)", .fix = "a header such as time_s,level_m, then one line per frame"});
    return curve;
}

LevelCurve take_window(const LevelCurve& curve, const FallingHeadConfig& config) {
    const double low = std::min(config.window_m[0], config.window_m[1]), high = std::max(config.window_m[0], config.window_m[1]);
    const auto [lowest, highest] = std::minmax_element(curve.level_m.begin(), curve.level_m.end());
    const auto outside = [&](const std::string& what) {
        throw UserError(what, {.where = curve.name,
                               .allowed = fmt::format("the levels of the file reach from {:g} to {:g} m", *lowest, *highest),
                               .fix = "window_m (--window, two levels in metres), or the unit in the file's header"});
    };
    if (*highest <= 0.0) outside("the level starts below the top of the sample");
    if (*lowest > high || *highest < low) outside(fmt::format("no level lies in the window {:g} to {:g} m", low, high));
    std::size_t first = 0, end = curve.time_s.size();
    while (first < end && curve.level_m[first] > high) ++first;
    while (end > first && curve.level_m[end - 1] < low) --end;
    LevelCurve part{.name = curve.name, .packing = curve.packing, .time_s = {}, .level_m = {}, .warnings = curve.warnings};
    const auto range = [&](const std::vector<double>& all) {
        return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(first), all.begin() + static_cast<std::ptrdiff_t>(end));
    };
    part.time_s = range(curve.time_s);
    part.level_m = range(curve.level_m);
    const std::size_t n = part.time_s.size();
    if (n < 5) outside(fmt::format("{} points lie in the window {:g} to {:g} m: too few for two resistances and a start", n, low, high));
    const auto [floor, ceiling] = std::minmax_element(part.level_m.begin(), part.level_m.end());
    const double noise = noise_of(part);
    // Mean levels of the first and the last fifth.
    const auto fifth = static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, n / 5));
    const double fall = (std::accumulate(part.level_m.begin(), part.level_m.begin() + fifth, 0.0) -
                         std::accumulate(part.level_m.end() - fifth, part.level_m.end(), 0.0)) /
                        static_cast<double>(fifth);
    // Four standard errors of the difference between two means of a fifth of the points.
    if (fall < std::max(1e-9, 4.0 * noise * std::sqrt(2.0 / static_cast<double>(fifth))))
        outside(fmt::format("the level does not fall: {:g} m at first, {:g} m at last", part.level_m.front(), part.level_m.back()));
    const auto note = [&](const std::string& text) { part.warnings.push_back(curve.name + ": " + text); };
    const auto warn = [&](const std::string& text) {
        note(text);
        part.doubtful = true;
    };
    if (config.sample_length_m > 3.0 * *ceiling)
        warn(fmt::format("the sample is {:g} m long, the levels are at most {:g} m: is sample_length_m in metres?", config.sample_length_m,
                         *ceiling));
    if (config.kinematic_viscosity_m2_per_s < 1e-8 || config.kinematic_viscosity_m2_per_s > 1e-3)
        warn(fmt::format("a kinematic viscosity of {:g} m2/s: water has 1e-6", config.kinematic_viscosity_m2_per_s));
    if (*ceiling > 20.0 || *ceiling < 0.01) warn(fmt::format("levels of {:g} to {:g} m: is the header's unit right?", *floor, *ceiling));
    // Water cannot fall faster than in free fall.
    const double speed = (part.level_m.front() - part.level_m.back()) / (part.time_s.back() - part.time_s.front());
    const double free_fall = std::sqrt(2.0 * config.gravity_m_per_s2 * (*ceiling + config.sample_length_m));
    if (speed > free_fall)
        warn(fmt::format("the level falls at {:.3g} m/s, faster than water falls freely from there ({:.3g} m/s): are the units mixed up?",
                         speed, free_fall));
    std::vector<double> steps, falls;
    for (std::size_t i = 1; i < n; ++i) {
        steps.push_back(part.time_s[i] - part.time_s[i - 1]);
        falls.push_back((part.level_m[i - 1] - part.level_m[i]) / steps.back());
    }
    const double step = median(steps);
    for (std::size_t i = 0; i + 1 < n; ++i) {
        if (steps[i] > 5.0 * step && steps[i] > 0.02 * (part.time_s.back() - part.time_s.front()))
            note(fmt::format("a gap of {:.3g} s after {:.4g} s", steps[i], part.time_s[i]));
        // The median speed of seven steps, which a single jump does not change. A jump must exceed eight times the noise, 5 mm, and half of
        // the usual fall of a step.
        const std::size_t from = i > 3 ? i - 3 : 0, to = std::min(falls.size(), i + 4);
        const double usual = median({falls.begin() + static_cast<std::ptrdiff_t>(from), falls.begin() + static_cast<std::ptrdiff_t>(to)});
        const double jump = (falls[i] - usual) * steps[i];
        if (std::abs(jump) > std::max(8.0 * noise, 0.005) && std::abs(jump) > 0.5 * std::abs(usual) * steps[i])
            warn(fmt::format("a jump of {:.3g} m at {:.4g} s", -jump, part.time_s[i + 1]));
    }
    return part;
}

double noise_of(const LevelCurve& curve) {
    std::vector<double> seconds;
    for (std::size_t i = 1; i + 1 < curve.time_s.size(); ++i) {
        // Deviation from the line through its neighbours, scaled to the noise of one level.
        const double part = (curve.time_s[i] - curve.time_s[i - 1]) / (curve.time_s[i + 1] - curve.time_s[i - 1]);
        const double off = curve.level_m[i] - (1.0 - part) * curve.level_m[i - 1] - part * curve.level_m[i + 1];
        seconds.push_back(std::abs(off) / std::sqrt(1.0 + part * part + (1.0 - part) * (1.0 - part)));
    }
    return seconds.empty() ? 1e-7 : std::max(1e-7, median(seconds) / 0.6745);
}

}  // namespace porepack::falling_head
