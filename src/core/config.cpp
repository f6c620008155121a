#include "core/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

#include "core/error.hpp"

namespace porepack {

bool Range::holds(double value) const {
    if (!std::isfinite(value)) return false;
    if (zero_is_auto && value == 0.0) return true;
    return (low_open ? value > low : value >= low) && value <= high;
}

std::string Range::text() const {
    std::string text = "a finite number";
    if (low == smallest_size && high == largest_size)
        text = fmt::format("> 0, at most {:g}", high);
    else if (std::isfinite(low) && std::isfinite(high))
        text = fmt::format("{:g} {} value <= {:g}", low, low_open ? "<" : "<=", high);
    else if (std::isfinite(low))
        text = fmt::format("{} {:g}", low_open ? ">" : ">=", low);
    else if (std::isfinite(high))
        text = fmt::format("<= {:g}", high);
    return zero_is_auto ? text + ", or 0 (chosen from the scene)" : text;
}

std::pair<std::string, std::string> split_unit(std::string_view key) {
    static const std::vector<std::string> units = {"kg_per_m3", "m2_per_s", "m_per_s2", "N_per_m", "m_per_s", "Pa_s", "mm",
                                                   "deg",       "m3",       "m2",       "Pa",      "kg",      "m",    "s"};
    for (const auto& unit : units)
        if (key.size() > unit.size() + 1 && key.ends_with("_" + unit) && !key.ends_with("_per_" + unit))  // frames_per_s has none
            return {std::string(key.substr(0, key.size() - unit.size() - 1)), unit};
    return {std::string(key), ""};
}

std::string flag_of(std::string_view key) {
    std::string flag = split_unit(key).first;
    std::replace(flag.begin(), flag.end(), '_', '-');
    return "--" + flag;
}

std::string nearest(std::string_view word, const std::vector<std::string>& known) {
    std::string best;
    std::size_t least = std::max<std::size_t>(3, word.size() / 2);
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
        if (row.back() < least) {
            least = row.back();
            best = candidate;
        }
    }
    return best;
}

struct TomlFile::Content {
    toml::table table;
    Path path;
};

namespace {

// Reads one table; remembers which keys were asked for, so that the others are known to be unknown.
class Reader : public ConfigVisitor {
public:
    Reader(const toml::table* table, std::string place, Path file, const Flags& flags)
        : table_(table), place_(std::move(place)), file_(std::move(file)), flags_(flags) {}

    void number(const char* key, double& value, const Range& range, const char*) override {
        if (const auto node = find(key)) value = number_of(*node, key, range);
    }
    void integer(const char* key, long& value, const Range& range, const char*) override {
        const auto node = find(key);
        if (!node) return;
        const auto whole = node->value_exact<int64_t>();
        if (!whole) fail(key, *node, "is not a whole number", range.text());
        if (!range.holds(static_cast<double>(*whole))) fail(key, *node, fmt::format("is out of range: {}", *whole), range.text());
        value = *whole;
    }
    void boolean(const char* key, bool& value, const char*) override {
        if (const auto node = find(key)) value = boolean_of(*node, key);
    }
    void text(const char* key, std::string& value, const char*) override {
        if (const auto node = find(key)) value = text_of(*node, key, "text in quotes");
    }
    void choice(const char* key, std::string& value, const std::vector<std::string>& allowed, const char*) override {
        const auto node = find(key);
        if (!node) return;
        const std::string list = fmt::format("\"{}\"", fmt::join(allowed, "\", \""));
        const std::string given = text_of(*node, key, list);
        if (std::find(allowed.begin(), allowed.end(), given) == allowed.end()) {
            const std::string near = nearest(given, allowed);
            fail(key, *node, fmt::format("is not known: \"{}\"", given), list, near.empty() ? "" : fmt::format("perhaps \"{}\"", near));
        }
        value = given;
    }
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes, const Range& range,
                 const char*) override {
        const auto node = find(key, true);
        if (!node) return;
        const std::string allowed = sizes.first == sizes.second
                                        ? fmt::format("a list of {} numbers, each {}", sizes.first, range.text())
                                        : fmt::format("a list of {} to {} numbers, each {}", sizes.first, sizes.second, range.text());
        const toml::array* array = node->as_array();
        if (array == nullptr) fail(key, *node, "is not a list", allowed);
        if (array->size() < sizes.first || array->size() > sizes.second)
            fail(key, *node, fmt::format("has {} entries", array->size()), allowed);
        values.clear();
        for (const auto& entry : *array) values.push_back(number_of(entry, key, range));
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t size, const char*) override {
        const auto node = find(key, true);
        if (!node) return;
        const toml::array* array = node->as_array();
        if (array == nullptr || array->size() != size)
            fail(key, *node, "has the wrong form", fmt::format("a list of {} times true or false", size));
        values.clear();
        for (const auto& entry : *array) values.push_back(boolean_of(entry, key));
    }
    void tables(const char* key, const std::function<std::size_t(std::size_t)>& resize,
                const std::function<void(std::size_t, ConfigVisitor&)>& describe_one, const char*) override {
        const auto node = find(key);
        if (!node) return;
        const toml::array* array = node->as_array();
        if (array == nullptr || !array->is_array_of_tables())
            fail(key, *node, "is not an array of tables", fmt::format("[[{}]] once for each entry", place_ + key));
        resize(array->size());
        for (std::size_t i = 0; i < array->size(); ++i) {
            Reader entry(array->get(i)->as_table(), fmt::format("{}{}[{}].", place_, key, i), file_, no_flags_);
            describe_one(i, entry);
            entry.require_known_keys();
        }
    }

    void require_known_keys() const {
        if (table_ == nullptr) return;
        for (const auto& [key, node] : *table_) {
            const std::string name(key.str());
            if (node.is_table() && place_.empty()) continue;  // checked by require_known_tables
            if (std::find(known_.begin(), known_.end(), name) != known_.end()) continue;
            const std::string near = nearest(name, known_);
            throw UserError(
                fmt::format("unknown key `{}{}`", place_, name),
                {.where = where(node), .allowed = fmt::format("{}", fmt::join(known_, ", ")), .mend = mend_unknown(name, near)});
        }
    }

private:
    [[nodiscard]] static std::string mend_unknown(const std::string& name, const std::string& near) {
        if (near.empty()) return "remove the key";
        if (split_unit(near).first == name) return fmt::format("the unit is missing: write `{}`", near);
        return fmt::format("perhaps `{}`", near);
    }

    // A value from the command line is read by the same rules as one from the file.
    const toml::node* find(const char* key, bool list = false) {
        known_.emplace_back(key);
        if (const auto flag = flags_.find(key); flag != flags_.end()) {
            const std::string value = list && !flag->second.starts_with("[") ? "[" + flag->second + "]" : flag->second;
            return parse_flag(key, value);
        }
        return table_ == nullptr ? nullptr : table_->get(key);
    }

    const toml::node* parse_flag(const char* key, const std::string& value) {
        try {
            from_flags_.push_back(toml::parse("value = " + value));
        } catch (const toml::parse_error&) {
            from_flags_.emplace_back();
            from_flags_.back().insert_or_assign("value", value);
        }
        flag_nodes_[from_flags_.back().get("value")] = flag_of(key);
        return from_flags_.back().get("value");
    }

    double number_of(const toml::node& node, const char* key, const Range& range) {
        if (!node.is_floating_point() && !node.is_integer()) fail(key, node, "is not a number", range.text());
        const double value = *node.value<double>();
        if (!range.holds(value)) fail(key, node, fmt::format("is out of range: {:g}", value), range.text());
        return value;
    }
    bool boolean_of(const toml::node& node, const char* key) {
        if (!node.is_boolean()) fail(key, node, "is neither true nor false", "true, false");
        return *node.value<bool>();
    }
    std::string text_of(const toml::node& node, const char* key, const std::string& allowed) {
        if (!node.is_string()) fail(key, node, "is not text", allowed);
        return *node.value<std::string>();
    }

    [[nodiscard]] std::string where(const toml::node& node) const {
        if (const auto flag = flag_nodes_.find(&node); flag != flag_nodes_.end()) return flag->second;
        return fmt::format("{}, line {}", file_.string(), node.source().begin.line);
    }
    [[noreturn]] void fail(const char* key, const toml::node& node, const std::string& fault, const std::string& allowed,
                           const std::string& mend = {}) const {
        throw UserError(fmt::format("`{}{}` {}", place_, key, fault), {.where = where(node), .allowed = allowed, .mend = mend});
    }

    const toml::table* table_;
    std::string place_;
    Path file_;
    const Flags& flags_;
    Flags no_flags_;
    std::vector<std::string> known_;
    std::deque<toml::table> from_flags_;
    std::map<const toml::node*, std::string> flag_nodes_;
};

class JsonWriter : public ConfigVisitor {
public:
    Json json = Json::object();
    void number(const char* key, double& value, const Range&, const char*) override { json[key] = value; }
    void integer(const char* key, long& value, const Range&, const char*) override { json[key] = value; }
    void boolean(const char* key, bool& value, const char*) override { json[key] = value; }
    void text(const char* key, std::string& value, const char*) override { json[key] = value; }
    void choice(const char* key, std::string& value, const std::vector<std::string>&, const char*) override { json[key] = value; }
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t>, const Range&, const char*) override {
        json[key] = values;
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t, const char*) override { json[key] = values; }
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
    void choice(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning) override {
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

TomlFile::TomlFile() : content_(std::make_unique<Content>()) {}
TomlFile::~TomlFile() = default;
TomlFile::TomlFile(TomlFile&&) noexcept = default;
TomlFile& TomlFile::operator=(TomlFile&&) noexcept = default;

TomlFile::TomlFile(const Path& path) : content_(std::make_unique<Content>()) {
    const std::string text = read_text(path);
    content_->path = path;
    try {
        content_->table = toml::parse(text, path.string());
    } catch (const toml::parse_error& fault) {
        throw UserError(fmt::format("not valid TOML: {}", fault.description()),
                        {.where = fmt::format("{}, line {}", path.string(), fault.source().begin.line)});
    }
}

void TomlFile::read(std::string_view name, const Describe& describe, const Flags& flags) const {
    const toml::table* table = name.empty() ? &content_->table : nullptr;
    if (!name.empty())
        if (const auto* node = content_->table.get(name)) {
            table = node->as_table();
            if (table == nullptr)
                throw UserError(fmt::format("`{}` is not a table", name),
                                {.where = fmt::format("{}, line {}", content_->path.string(), node->source().begin.line),
                                 .mend = fmt::format("write [{}] on a line of its own, its keys below", name)});
        }
    Reader reader(table, name.empty() ? "" : fmt::format("{}.", name), content_->path, flags);
    describe(reader);
    reader.require_known_keys();
}

bool TomlFile::has(std::string_view name) const {
    return content_->table.contains(name);
}

void TomlFile::require_known_tables(const std::vector<std::string>& known) const {
    for (const auto& [key, node] : content_->table) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        const std::string near = nearest(name, known);
        throw UserError(fmt::format("unknown table or key `{}`", name),
                        {.where = fmt::format("{}, line {}", content_->path.string(), node.source().begin.line),
                         .allowed = fmt::format("[{}]", fmt::join(known, "] [")),
                         .mend = near.empty() ? "remove it" : fmt::format("perhaps [{}]", near)});
    }
}

Json to_json(const Describe& describe) {
    JsonWriter writer;
    describe(writer);
    return writer.json;
}

std::vector<KeyRow> key_rows(const Describe& describe) {
    RowWriter writer;
    describe(writer);
    return writer.rows;
}

}  // namespace porepack
