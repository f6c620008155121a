#include "study/study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>

#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/owned_names.hpp"
#include "core/parallel.hpp"
#include "record/digest.hpp"
#include "record/toml_file.hpp"
#include "study/case_pipeline.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace fs = std::filesystem;
namespace {

constexpr long max_points = 100000;

// The values of an axis: one row per step, one value per key.
struct Axis {
    std::vector<std::string> keys;
    std::vector<std::vector<Json>> rows;
};

struct Place {
    std::string file, text;
    [[noreturn]] void fail(const std::string& what, const Advice& more = {}) const {
        throw UserError(what, {.where = fmt::format("{}, {}", file, text), .allowed = more.allowed, .fix = more.fix});
    }
};

std::vector<std::string> keys_of(const AxisConfig& axis, const Place& place) {
    std::vector<std::string> keys;
    for (const Json& key : axis.key.is_array() ? axis.key : Json::array({axis.key})) {
        const std::string name = key.is_string() ? key.get<std::string>() : std::string();
        if (std::count(name.begin(), name.end(), '.') != 1)
            place.fail("`key` is not the name of a key",
                       {.allowed = "\"table.key\", or a list of them", .fix = "key = \"shape.sphericity\""});
        keys.push_back(name);
    }
    if (keys.empty()) place.fail("`key` is missing");
    return keys;
}

std::vector<Json> range_of(const AxisConfig& axis, const Place& place) {
    if (axis.number < 1) place.fail("`values` is missing", {.fix = "values = [...], or from, to and number"});
    if (axis.spacing == Spacing::logarithmic && !(axis.from > 0.0 && axis.to > 0.0)) place.fail("a logarithmic range needs positive ends");
    std::vector<Json> values;
    for (long i = 0; i < axis.number; ++i) {
        const double t = axis.number == 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(axis.number - 1);
        const double value =
            axis.spacing == Spacing::linear ? axis.from + t * (axis.to - axis.from) : axis.from * std::pow(axis.to / axis.from, t);
        // Twelve digits: 0.3, not 0.30000000000000004. A whole number is one for keys that need it (seeds, numbers of grains).
        const double rounded = std::stod(fmt::format("{:.12g}", value));
        if (rounded == std::round(rounded) && std::abs(rounded) < 1e15)
            values.emplace_back(static_cast<std::int64_t>(rounded));
        else
            values.emplace_back(rounded);
    }
    return values;
}

Axis axis_of(const AxisConfig& config, const Place& place) {
    Axis axis{.keys = keys_of(config, place), .rows = {}};
    if (!config.values.is_null() && config.number != 0) place.fail("`values` and `number` exclude each other");
    if (config.values.is_null()) {
        if (axis.keys.size() > 1) place.fail("a range belongs to one key", {.fix = "values = [[1, 0.5], [2, 0.6]]"});
        for (const Json& value : range_of(config, place)) axis.rows.push_back({value});
        return axis;
    }
    if (!config.values.is_array() || config.values.empty()) place.fail("`values` is not a list of values");
    for (const Json& row : config.values) {
        if (axis.keys.size() == 1) {
            axis.rows.push_back({row});
        } else {
            if (!row.is_array() || row.size() != axis.keys.size())
                place.fail(fmt::format("`values` needs a list of {} values for each step", axis.keys.size()));
            axis.rows.emplace_back(row.begin(), row.end());
        }
    }
    return axis;
}

// "tetrapod_0.53"
std::string name_part(const Json& value) {
    return value.is_string()         ? value.get<std::string>()
           : value.is_number_float() ? fmt::format("{:.12g}", value.get<double>())
                                     : value.dump();
}

bool same_value(const Json& one, const Json& other) {
    return one == other || (one.is_number() && other.is_number() && one.get<double>() == other.get<double>());
}

// A point is left out if all keys of an entry have (one of) its values.
bool matches(const Json& entry, const std::vector<std::pair<std::string, Json>>& values) {
    return std::all_of(values.begin(), values.end(), [&](const auto& pair) {
        const std::string& key = pair.first;
        const std::size_t dot = key.find('.');
        const Json::json_pointer at("/" + key.substr(0, dot) + "/" + key.substr(dot + 1));
        if (!entry.contains(at)) return true;
        const Json allowed = entry.at(at).is_array() ? entry.at(at) : Json::array({entry.at(at)});
        return std::any_of(allowed.begin(), allowed.end(), [&](const Json& one) { return same_value(one, pair.second); });
    });
}

void require_axes_of(const Json& entry, const std::vector<std::string>& keys, const Place& place) {
    const std::string form = "where = { shape.kind = \"tetrahedron\", shape.sphericity = [0.81, 0.87] }";
    if (!entry.is_object() || entry.empty()) place.fail("`where` is missing", {.fix = form});
    for (const auto& [table, inner] : entry.items()) {
        if (!inner.is_object()) place.fail(fmt::format("`{}` is not a key", table), {.fix = form});
        for (const auto& [key, value] : inner.items())
            if (const std::string whole = fmt::format("{}.{}", table, key); std::find(keys.begin(), keys.end(), whole) == keys.end())
                place.fail(fmt::format("no axis has the key `{}`", whole), {.allowed = fmt::format("{}", fmt::join(keys, ", "))});
    }
}

std::map<std::string, Flags> set_of(const std::vector<std::pair<std::string, Json>>& values) {
    std::map<std::string, Flags> set;
    for (const auto& [key, value] : values) {
        const std::size_t dot = key.find('.');
        set[key.substr(0, dot)][key.substr(dot + 1)] = toml_text(value);
    }
    return set;
}

// Of all stages but the report, whose texts and pictures are not numbers.
Json identity_of_numbers(const Case& c, const std::string& last) {
    Json kept = Json::array();
    for (const Json& stage : pipeline::identity_of(case_pipeline(c), last))
        if (stage["stage"] != "report") kept.push_back(stage);
    return kept;
}

// Each point as a case. A thousand take about a second.
void plan_points(Study& study, const Path& base) {
    // In blocks, so that the progress is shown between parallel loops.
    constexpr std::size_t at_once = 256;
    Progress progress("reading the points of the study");
    for (std::size_t first = 0; first < study.points.size(); first += at_once) {
        parallel_for(std::min(at_once, study.points.size() - first), [&](std::size_t i) {
            Point& point = study.points[first + i];
            point.planned = read_case(base, {}, {}, set_of(point.values));
            point.planned.output = study.folder_of(point) / "results";
            point.identity = identity_of_numbers(point.planned, study.config.up_to);
            point.digest = sha256(point.identity.dump());
        });
        progress.update(static_cast<double>(std::min(first + at_once, study.points.size())) / static_cast<double>(study.points.size()));
    }
}

void cross(Study& study, const std::vector<Axis>& axes, const Path& base, const std::string& file) {
    long total = 1;
    for (const Axis& axis : axes) {
        total *= static_cast<long>(axis.rows.size());
        if (total > max_points) throw UserError(fmt::format("more than {} points", max_points), {.where = file});
    }
    std::map<std::string, long> names;
    for (long index = 0; index < total; ++index) {
        Point point;
        // The index in mixed radix: each axis takes its digit, the last one the lowest.
        long rest = index, of_axis = total;
        for (const Axis& axis : axes) {
            of_axis /= static_cast<long>(axis.rows.size());
            const auto& row = axis.rows[static_cast<std::size_t>(rest / of_axis)];
            rest %= of_axis;
            for (std::size_t k = 0; k < axis.keys.size(); ++k) {
                point.values.emplace_back(axis.keys[k], row[k]);
                point.name += (point.name.empty() ? "" : "_") + name_part(row[k]);
            }
        }
        // Before the names are compared: points that are left out may have any.
        if (std::any_of(study.config.left_out.begin(), study.config.left_out.end(),
                        [&](const Json& entry) { return matches(entry, point.values); }))
            continue;
        point.name = as_plain_name(point.name);  // of its folder
        if (names[point.name]++ > 0)
            throw UserError(fmt::format("two points have the name {}", point.name),
                            {.where = file,
                             .fix = "their values differ too little, a value is listed twice, or the name is longer than 200 characters"});
        study.points.push_back(std::move(point));
    }
    if (study.points.empty()) throw UserError("the study has no points", {.where = file, .fix = "every point is left out"});
    plan_points(study, base);
}

}  // namespace

void describe(ConfigVisitor& v, AxisConfig& c) {
    v.any("key", c.key, "text, or list of texts", "key of case.toml that changes (\"shape.sphericity\"), or several that change together");
    v.any("values", c.values, "list", "values of the key; of several keys, a list of values for each step");
    v.number("from", c.from, {}, "first value of a range, instead of values");
    v.number("to", c.to, {}, "last value of the range");
    v.integer("number", c.number, between(0, max_points), "number of values of the range");
    v.choice("spacing", c.spacing, "of the range");
}

void describe(ConfigVisitor& v, ColumnConfig& c) {
    v.text("name", c.name, "of the column, with its unit at the end");
    v.text("formula", c.formula, "of other columns: \"permeability_m2/equal_volume_diameter_m^2\"");
}

void describe(ConfigVisitor& v, FitConfig& c) {
    v.text("name", c.name, "of the fit");
    v.text("x", c.x, "column of study.csv, or of [[column]]");
    v.text("y", c.y, "column of study.csv, or of [[column]]");
    v.text("by", c.by, "column: a fit for each of its values");
    v.choice("form", c.form,
             "polynomial c0 + c1 x + ...; exponential c0 exp(c1 x) and power c0 x^c1, fitted to ln y; logarithmic c0 + c1 ln x; given: "
             "`formula`, whose residuals are computed");
    v.integer("degree", c.degree, between(0, 6), "of the polynomial");
    v.text("formula", c.formula, "form = given: formula of x");
    v.boolean("relative", c.relative, "form = given: residuals of ln y instead of y");
}

void describe(ConfigVisitor& v, FigureConfig& c) {
    v.text("name", c.name, "of the files");
    v.text("x", c.x, "column of study.csv");
    v.text("y", c.y, "column of study.csv; its interval is drawn if the table has one");
    v.text("by", c.by, "column whose values are told apart by colour and symbol");
    v.boolean("logarithmic", c.logarithmic, "logarithmic axis of y");
    v.boolean("logarithmic_x", c.logarithmic_x, "logarithmic axis of x");
    v.any("fits", c.fits, "list of texts", "names of fits of the same x and y, drawn as curves");
    v.any("curves", c.curves, "list of tables", "curves drawn beside the points: { title = \"Eq. 22\", formula = \"5.3e-9*exp(7.3*x)\" }");
    v.any("marks", c.marks, "list of tables", "single values drawn beside the points: { title = \"measured\", x = 0.53, y = 0.685 }");
}

void describe(ConfigVisitor& v, StudyConfig& c) {
    v.text("base", c.base, "folder of the case whose keys the points have, except for those of the axes");
    v.text("up_to", c.up_to, "last stage of each point; only what it needs is run");
    v.tables(
        "axis",
        [&](std::size_t n) {
            if (n != keep_size) c.axes.resize(n);
            return c.axes.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) { describe(entry, c.axes[i]); }, "keys and values; several axes are crossed");
    v.tables(
        "leave_out",
        [&](std::size_t n) {
            if (n != keep_size) c.left_out.resize(n);
            return c.left_out.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) { entry.any("where", c.left_out[i], "table", "keys and values of points to leave out"); },
        "points that are not run");
    v.tables(
        "column",
        [&](std::size_t n) {
            if (n != keep_size) c.columns.resize(n);
            return c.columns.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) { describe(entry, c.columns[i]); }, "columns that follow from others");
    v.tables(
        "fit",
        [&](std::size_t n) {
            if (n != keep_size) c.fits.resize(n);
            return c.fits.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) { describe(entry, c.fits[i]); }, "curves fitted to columns, and given ones");
    v.tables(
        "figure",
        [&](std::size_t n) {
            if (n != keep_size) c.figures.resize(n);
            return c.figures.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) { describe(entry, c.figures[i]); }, "figures of study.html");
}

Study read_study(const Path& path) {
    const Path file = fs::is_directory(path) ? path / "study.toml" : path;
    if (!fs::exists(file)) throw UserError("no such study: " + file.string(), {.fix = "a study is a folder with a file study.toml in it"});
    const TomlFile toml(file);
    toml.require_known_tables({"base", "up_to", "axis", "leave_out", "column", "fit", "figure"});
    Study study;
    study.folder = file.parent_path().empty() ? Path(".") : file.parent_path();
    toml.read("", [&](ConfigVisitor& v) { describe(v, study.config); });
    std::vector<Axis> axes;
    for (std::size_t i = 0; i < study.config.axes.size(); ++i) {
        axes.push_back(axis_of(study.config.axes[i], {file.string(), fmt::format("[[axis]] {}", i + 1)}));
        for (const std::string& key : axes.back().keys) {
            if (std::find(study.keys.begin(), study.keys.end(), key) != study.keys.end())
                throw UserError(fmt::format("two axes have the key `{}`", key), {.where = file.string()});
            study.keys.push_back(key);
        }
    }
    if (axes.empty()) throw UserError("the study has no axis", {.where = file.string(), .fix = "[[axis]] with key and values"});
    for (std::size_t i = 0; i < study.config.left_out.size(); ++i)
        require_axes_of(study.config.left_out[i], study.keys, {file.string(), fmt::format("[[leave_out]] {}", i + 1)});
    for (std::size_t i = 0; i < study.config.figures.size(); ++i)
        require_plain_name(study.config.figures[i].name, "the name of a figure",
                           fmt::format("{}, [[figure]] {}, `name`", file.string(), i + 1));
    cross(study, axes, study.folder / study.config.base, file.string());
    return study;
}

std::vector<Point> chosen_points(const Study& study, const std::string& names) {
    if (names.empty()) return study.points;
    const auto unknown = [&](const std::string& name) {
        std::vector<std::string> known;
        for (const Point& point : study.points) known.push_back(point.name);
        throw UserError(fmt::format("the study has no point \"{}\"", name),
                        {.where = "--points",
                         .allowed = fmt::format("names, or numbers from 1 to {}: {}", known.size(), fmt::join(known, ", ")),
                         .fix = perhaps(nearest(name, known))});
    };
    // A name is tried first, because a point may have a name such as "7" or "10-12". Numbers and ranges must use up the whole word (%n).
    std::vector<Point> chosen;
    for (std::size_t at = 0; at <= names.size();) {
        const std::size_t comma = std::min(names.find(',', at), names.size());
        const std::string word = names.substr(at, comma - at);
        at = comma + 1;
        const auto found = std::find_if(study.points.begin(), study.points.end(), [&](const Point& point) { return point.name == word; });
        if (found != study.points.end()) {
            chosen.push_back(*found);
            continue;
        }
        long first = 0, last = 0;
        int used = 0;
        if (std::sscanf(word.c_str(), "%ld-%ld%n", &first, &last, &used) != 2 || static_cast<std::size_t>(used) != word.size()) {
            if (std::sscanf(word.c_str(), "%ld%n", &first, &used) != 1 || static_cast<std::size_t>(used) != word.size()) unknown(word);
            last = first;
        }
        if (first < 1 || last < first || last > static_cast<long>(study.points.size())) unknown(word);
        chosen.insert(chosen.end(), study.points.begin() + first - 1, study.points.begin() + last);
    }
    return chosen;
}

std::vector<std::string> stages_left_out(const Study& study) {
    const pipeline::Pipeline chain = case_pipeline(study.points.front().planned);
    const Json run = pipeline::identity_of(chain, study.config.up_to);
    std::vector<std::string> left_out;
    for (const pipeline::Stage& stage : chain.stages)
        if (std::none_of(run.begin(), run.end(), [&](const Json& one) { return one["stage"] == stage.name; }))
            left_out.push_back(stage.name);
    return left_out;
}

Case write_point(const Study& study, const Point& point) {
    // The point's case must not depend on the study: all keys of the base case with the point's values.
    const Path base = study.folder / study.config.base, folder = study.folder_of(point);
    std::map<std::string, Flags> set = set_of(point.values);
    // Files are named relative to the case.
    for (const auto& [table, file] : {std::pair("shape", point.planned.settings.shape.file),
                                      {"packing", point.planned.settings.packing.file},
                                      {"image", point.planned.settings.image.file}})
        if (!file.empty() && !Path(file).is_absolute())
            set[table]["file"] = Json(fs::relative(fs::absolute(base / file), fs::absolute(folder)).string()).dump();
    for (const shapes::ShapeConfig& part : point.planned.settings.shape.component)
        if (!part.file.empty() && !Path(part.file).is_absolute())
            throw UserError("a component names " + part.file + ", relative to its case",
                            {.where = base.string(), .fix = "in a study, give the files of components with their whole path"});
    const std::string text =
        fmt::format("# Written by `porepack study run`: the point {} of ../../study.toml. Change the values there.\n\n", point.name) +
        TomlFile(fs::is_directory(base) ? base / "case.toml" : base).with(set).text();
    const Path file = folder / "case.toml";
    make_folder(folder);
    write_own_text(file, text);
    return read_case(file);
}

core::Expectation expectation_of(const Study& study, const Point& point) {
    try {
        return pipeline::expected_of(case_pipeline(point.planned), study.config.up_to);
    } catch (const Error& error) {
        const std::string message = error.what();
        return {.text = "cannot be run: " + message.substr(0, message.find('\n'))};
    }
}

}  // namespace porepack::study
