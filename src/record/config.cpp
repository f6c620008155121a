#include "record/config.hpp"
#include "core/json.hpp"
#include "record/resolved_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace porepack::record {

bool Range::holds(double value) const {
    if (!std::isfinite(value)) return false;
    if (zero_is_auto && value == 0.0) return true;
    return (low_open ? value > low : value >= low) && value <= high;
}

std::string Range::text() const {
    std::string text = "a finite number";
    if (low == min_size && high == max_size)
        text = fmt::format("> 0, at most {:g}", high);
    else if (std::isfinite(low) && std::isfinite(high))
        text = fmt::format("{:g} {} value <= {:g}", low, low_open ? "<" : "<=", high);
    else if (std::isfinite(low))
        text = fmt::format("{} {:g}", low_open ? ">" : ">=", low);
    else if (std::isfinite(high))
        text = fmt::format("<= {:g}", high);
    return zero_is_auto ? text + ", or 0 (chosen automatically)" : text;
}

std::pair<std::string, std::string> split_unit(std::string_view key) {
    static const std::vector<std::string> units = {"kg_per_m3", "m2_per_s", "m_per_s2", "N_per_m", "m_per_s", "Pa_s", "mm", "deg",
                                                   "m3",        "m2",       "Pa",       "kg",      "m",       "s",    "C"};
    for (const auto& unit : units)
        if (key.size() > unit.size() + 1 && key.ends_with("_" + unit) && !key.ends_with("_per_" + unit))  // frames_per_s has no unit
            return {std::string(key.substr(0, key.size() - unit.size() - 1)), unit};
    return {std::string(key), ""};
}

std::string flag_of(std::string_view key) {
    std::string flag = split_unit(key).first;
    std::replace(flag.begin(), flag.end(), '_', '-');
    return "--" + flag;
}

std::string perhaps(const std::string& near) {
    return near.empty() ? std::string() : fmt::format("perhaps `{}`", near);
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
    std::string best;
    std::size_t minimum = std::max<std::size_t>(3, word.size() / 2);
    for (const auto& candidate : known) {
        if (split_unit(candidate).first == word) return candidate;  // only the unit is missing
        std::vector<std::size_t> row(candidate.size() + 1);
        std::iota(row.begin(), row.end(), 0);
        for (std::size_t i = 0; i < word.size(); ++i) {
            std::size_t diagonal = row[0];
            row[0] = i + 1;
            for (std::size_t j = 0; j < candidate.size(); ++j) {
                const std::size_t change = diagonal + (word[i] == candidate[j] ? 0 : 1);
                diagonal = row[j + 1];
                row[j + 1] = std::min({change, row[j] + 1, diagonal + 1});
            }
        }
        if (row.back() < minimum) {
            minimum = row.back();
            best = candidate;
        }
    }
    return best;
}

namespace {

class JsonWriter : public ConfigVisitor {
public:
    Json json = Json::object();
    void number(const char* key, double& value, const Range&, const char*) override { json[key] = value; }
    void integer(const char* key, long& value, const Range&, const char*) override { json[key] = value; }
    void boolean(const char* key, bool& value, const char*) override { json[key] = value; }
    void text(const char* key, std::string& value, const char*) override { json[key] = value; }
    void word(const char* key, std::string& value, const std::vector<std::string>&, const char*) override { json[key] = value; }
    void renamed(const char*, const char*) override {}
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t>, const Range&, const char*) override {
        json[key] = values;
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t, const char*) override { json[key] = values; }
    void any(const char* key, Json& value, const char*, const char*) override { json[key] = value; }
    void tables(const char* key, const std::function<std::size_t(std::size_t)>& resize,
                const std::function<void(std::size_t, ConfigVisitor&)>& describe_one, const char*) override {
        json[key] = Json::array();
        const std::size_t count = resize(keep_size);
        for (std::size_t i = 0; i < count; ++i) {
            JsonWriter entry;
            describe_one(i, entry);
            json[key].push_back(entry.json);
        }
    }
};

class RowWriter : public ConfigVisitor {
public:
    std::vector<KeyRow> rows;
    std::map<std::string, std::string> old_names;
    void number(const char* key, double& value, const Range& range, const char* meaning) override {
        add(key, "number", range.text(), range.zero_is_auto && value == 0.0 ? "auto" : fmt::format("{:g}", value), meaning);
    }
    void integer(const char* key, long& value, const Range& range, const char* meaning) override {
        add(key, "whole number", range.text(), range.zero_is_auto && value == 0 ? "auto" : fmt::format("{}", value), meaning);
    }
    void boolean(const char* key, bool& value, const char* meaning) override {
        add(key, "true or false", "true, false", value ? "true" : "false", meaning);
    }
    void text(const char* key, std::string& value, const char* meaning) override { add(key, "text", "", value, meaning); }
    void renamed(const char* old_key, const char* key) override { old_names[old_key] = key; }
    void moved_to(const char* table, const char* key) override { old_names[key] = fmt::format("{}.{}", table, key); }
    void word(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning) override {
        add(key, "choice", fmt::format("{}", fmt::join(allowed, ", ")), value, meaning);
    }
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes, const Range& range,
                 const char* meaning) override {
        const std::string count =
            sizes.first == sizes.second ? fmt::format("{}", sizes.first) : fmt::format("{} to {}", sizes.first, sizes.second);
        add(key, "list of " + count + " numbers", range.text(), values.empty() ? "auto" : fmt::format("{}", fmt::join(values, ", ")),
            meaning);
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t size, const char* meaning) override {
        add(key, fmt::format("list of {}", size), "true, false", fmt::format("{}", fmt::join(values, ", ")), meaning);
    }
    void any(const char* key, Json&, const char* type, const char* meaning) override { add(key, type, "", "none", meaning); }
    void tables(const char* key, const std::function<std::size_t(std::size_t)>&, const std::function<void(std::size_t, ConfigVisitor&)>&,
                const char* meaning) override {
        add(key, "array of tables", "", "none", meaning);
    }

private:
    void add(const char* key, const std::string& type, const std::string& allowed, const std::string& standard, const char* meaning) {
        rows.push_back({key, split_unit(key).second, type, allowed, standard, meaning});
    }
};

}  // namespace

Json resolved(const Describe& describe) {
    JsonWriter writer;
    describe(writer);
    return writer.json;
}

std::vector<KeyRow> key_rows(const Describe& describe) {
    RowWriter writer;
    describe(writer);
    return writer.rows;
}

std::map<std::string, std::string> renamed_keys(const Describe& describe) {
    RowWriter writer;
    describe(writer);
    return writer.old_names;
}

}  // namespace porepack::record
