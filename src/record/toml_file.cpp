#include "record/toml_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"

namespace porepack::record {

struct TomlFile::Content {
    toml::table table;
    Path path;
    bool has_lines = true;

    [[nodiscard]] std::string where(const toml::node& node) const {
        return has_lines ? fmt::format("{}, line {}", path.string(), node.source().begin.line) : path.string();
    }
};

namespace {

Json json_of(const toml::node& node) {
    if (const auto* table = node.as_table()) {
        Json json = Json::object();
        for (const auto& [key, value] : *table) json[std::string(key.str())] = json_of(value);
        return json;
    }
    if (const auto* array = node.as_array()) {
        Json json = Json::array();
        for (const auto& value : *array) json.push_back(json_of(value));
        return json;
    }
    if (const auto text = node.value_exact<std::string>()) return *text;
    if (const auto whole = node.value_exact<std::int64_t>()) return *whole;
    if (const auto number = node.value_exact<double>()) return *number;
    if (const auto boolean = node.value_exact<bool>()) return *boolean;
    // Dates and times have no JSON type: as text.
    std::ostringstream text;
    node.visit([&](const auto& date_or_time) { text << date_or_time; });
    return text.str();
}

using Where = std::function<std::string(const toml::node&)>;

// Reads one table and records which keys were read; all other keys of the table are unknown.
class Reader : public ConfigVisitor {
public:
    Reader(const toml::table* table, const toml::table& whole, std::string place, Where in_file, const Flags& flags, const Flags& set)
        : table_(table), whole_(whole), place_(std::move(place)), in_file_(std::move(in_file)), flags_(flags), set_(set) {}

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
    void renamed(const char* old_key, const char* key) override {
        if (table_ == nullptr || !table_->contains(old_key)) return;
        const toml::node* node = table_->get(old_key);
        if (table_->contains(key)) fail(old_key, *node, fmt::format("is the old name of `{}`, which is given too", key), "one of them");
        log_warning(
            fmt::format("{}: `{}{}` is now called `{}`; the old name is read until version 0.4", where(*node), place_, old_key, key));
        renamed_[key] = old_key;
        known_.emplace_back(old_key);
    }
    void renamed_word(const char* key, const char* old_word, const char* word) override { old_words_[key][old_word] = word; }
    void moved_here(const char* old_table, const char* key) override {
        const toml::node* node = whole_[old_table][key].node();
        if (node == nullptr) return;
        if (table_ != nullptr && table_->contains(key))
            fail(key, *table_->get(key), fmt::format("is given in [{}] too", old_table), "one of them");
        log_warning(
            fmt::format("{}: `{}.{}` is now `{}{}`; the old place is read until version 0.4", where(*node), old_table, key, place_, key));
        moved_[key] = node;
    }
    void moved_to(const char*, const char* key) override { known_.emplace_back(key); }
    void word(const char* key, std::string& value, const std::vector<std::string>& allowed, const char*) override {
        const auto node = find(key);
        if (!node) return;
        const std::string list = fmt::format("\"{}\"", fmt::join(allowed, "\", \""));
        std::string given = text_of(*node, key, list);
        if (const auto renamed = old_words_[key].find(given); renamed != old_words_[key].end()) {
            log_warning(fmt::format("{}: \"{}\" of `{}{}` is now called \"{}\"; the old name is read until version 0.4", where(*node),
                                    given, place_, key, renamed->second));
            given = renamed->second;
        }
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
        if (array->empty() && values.empty()) return;  // "not given", as it stands in the resolved configuration
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
            fail(key, *node, "has the wrong form", fmt::format("a list of {} values true or false", size));
        values.clear();
        for (const auto& entry : *array) values.push_back(boolean_of(entry, key));
    }
    void any(const char* key, Json& value, const char*, const char*) override {
        if (const auto node = find(key)) value = json_of(*node);
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
            Reader entry(array->get(i)->as_table(), whole_, fmt::format("{}{}[{}].", place_, key, i), in_file_, none_, none_);
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
            throw UserError(fmt::format("unknown key `{}{}`", place_, name),
                            {.where = where(node), .allowed = fmt::format("{}", fmt::join(known_, ", ")), .fix = fix_unknown(name, near)});
        }
    }

private:
    [[nodiscard]] static std::string fix_unknown(const std::string& name, const std::string& near) {
        if (near.empty()) return "remove the key";
        if (split_unit(near).first == name) return fmt::format("the unit is missing: write `{}`", near);
        return perhaps(near);
    }

    // A value from the command line is parsed with the same rules as a value from the file.
    // Order of precedence: --set, the command's own flag, an old place or name in the file, the file. Each key that is asked for is
    // recorded, so that the keys left over are the unknown ones.
    const toml::node* find(const char* key, bool list = false) {
        known_.emplace_back(key);
        for (const Flags* values : {&set_, &flags_})
            if (const auto given = values->find(key); given != values->end()) {
                const std::string value = list && !given->second.starts_with("[") ? "[" + given->second + "]" : given->second;
                return parse_flag(value, values == &set_ ? fmt::format("--set {}{}", place_, key) : flag_of(key));
            }
        if (const auto old = moved_.find(key); old != moved_.end()) return old->second;
        if (table_ == nullptr) return nullptr;
        const auto old = renamed_.find(key);
        return table_->get(old == renamed_.end() ? key : old->second.c_str());
    }

    const toml::node* parse_flag(const std::string& value, const std::string& place) {
        try {
            // Nodes are returned by address: a deque does not move its elements when it grows.
            from_flags_.push_back(toml::parse("value = " + value));
            if (from_flags_.back().size() > 1) throw UserError("more than one value: " + value, {.where = place});
        } catch (const toml::parse_error&) {
            // Text without quotes, as users type it, is not TOML: it is taken as a string.
            from_flags_.emplace_back();
            from_flags_.back().insert_or_assign("value", value);
        }
        flag_nodes_[from_flags_.back().get("value")] = place;
        return from_flags_.back().get("value");
    }

    double number_of(const toml::node& node, const char* key, const Range& range) {
        if (!node.is_floating_point() && !node.is_integer()) fail(key, node, "is not a number", range.text());
        const double value = *node.value<double>();
        if (!range.holds(value)) fail(key, node, fmt::format("is out of range: {:g}", value), range.text());
        return value;
    }
    // No conversion from numbers or text: 0 and "false" are errors.
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
        return in_file_(node);
    }
    [[noreturn]] void fail(const char* key, const toml::node& node, const std::string& fault, const std::string& allowed,
                           const std::string& fix = {}) const {
        throw UserError(fmt::format("`{}{}` {}", place_, key, fault), {.where = where(node), .allowed = allowed, .fix = fix});
    }

    const toml::table* table_;
    const toml::table& whole_;
    std::string place_;
    Where in_file_;
    const Flags& flags_;
    const Flags& set_;
    const Flags none_;
    std::vector<std::string> known_;
    std::map<std::string, std::string> renamed_;                           // key -> its old name, used by the file
    std::map<std::string, std::map<std::string, std::string>> old_words_;  // by key: old and new
    std::map<std::string, const toml::node*> moved_;                       // key -> its value in the table where it was
    std::deque<toml::table> from_flags_;
    std::map<const toml::node*, std::string> flag_nodes_;
};

}  // namespace

std::string toml_text(const Json& value) {
    std::string inner;
    if (value.is_object()) {
        for (const auto& [key, one] : value.items())
            inner += fmt::format("{}{} = {}", inner.empty() ? "" : ", ", Json(key).dump(), toml_text(one));
        return "{ " + inner + " }";
    }
    if (value.is_array()) {
        for (const Json& one : value) inner += (inner.empty() ? "" : ", ") + toml_text(one);
        return "[" + inner + "]";
    }
    return value.dump();
}

TomlFile::TomlFile() : content_(std::make_unique<Content>()) {}
TomlFile::~TomlFile() = default;
TomlFile::TomlFile(TomlFile&&) noexcept = default;
TomlFile& TomlFile::operator=(TomlFile&&) noexcept = default;

TomlFile::TomlFile(const Path& path) : content_(std::make_unique<Content>()) {
    const std::string text = read_text(path, 16e6);
    content_->path = path;
    try {
        content_->table = toml::parse(text, path.string());
    } catch (const toml::parse_error& fault) {
        throw UserError(fmt::format("not valid TOML: {}", fault.description()),
                        {.where = fmt::format("{}, line {}", path.string(), fault.source().begin.line)});
    }
}

TomlFile::TomlFile(const Json& values, const std::string& place) : content_(std::make_unique<Content>()) {
    content_->path = place;
    content_->has_lines = false;
    std::string text;
    for (const auto& [key, value] : values.items()) text += fmt::format("{} = {}\n", Json(key).dump(), toml_text(value));
    content_->table = toml::parse(text);
}

void TomlFile::read(std::string_view name, const Describe& describe, const Flags& flags, const Flags& set) const {
    const toml::table* table = name.empty() ? &content_->table : nullptr;
    if (!name.empty())
        if (const auto* node = content_->table.get(name)) {
            table = node->as_table();
            if (table == nullptr)
                throw UserError(
                    fmt::format("`{}` is not a table", name),
                    {.where = content_->where(*node), .fix = fmt::format("write [{}] on a line of its own, its keys below", name)});
        }
    const Where where = [this](const toml::node& node) { return content_->where(node); };
    Reader reader(table, content_->table, name.empty() ? "" : fmt::format("{}.", name), where, flags, set);
    describe(reader);
    reader.require_known_keys();
}

bool TomlFile::has(std::string_view name) const {
    return content_->table.contains(name);
}

TomlFile TomlFile::with(const std::map<std::string, Flags>& set) const {
    TomlFile changed;
    *changed.content_ = *content_;
    toml::table& all = changed.content_->table;
    for (const auto& [name, keys] : set) {
        if (!all.contains(name)) all.insert(name, toml::table{});
        if (!all[name].is_table()) throw UserError("`" + name + "` is no table", {.where = content_->path});
        toml::table& table = *all[name].as_table();
        for (const auto& [key, value] : keys) {
            if (value.empty()) {
                table.erase(key);
                continue;
            }
            const toml::table parsed = toml::parse("value = " + value);
            table.insert_or_assign(key, *parsed.get("value"));
        }
    }
    return changed;
}

std::string TomlFile::text() const {
    std::ostringstream text;
    text << content_->table << "\n";
    return text.str();
}

std::map<std::string, std::string> TomlFile::keys_of(std::string_view name) const {
    std::map<std::string, std::string> keys;
    if (const toml::table* table = content_->table[name].as_table())
        for (const auto& [key, node] : *table) keys[std::string(key.str())] = content_->where(node);
    return keys;
}

void TomlFile::require_known_tables(const std::vector<std::string>& known) const {
    for (const auto& [key, node] : content_->table) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        const std::string near = nearest(name, known);
        throw UserError(fmt::format("unknown table or key `{}`", name),
                        {.where = content_->where(node),
                         .allowed = fmt::format("[{}]", fmt::join(known, "] [")),
                         .fix = near.empty() ? "remove it" : fmt::format("perhaps [{}]", near)});
    }
}

}  // namespace porepack::record
