// Configuration: every table of case.toml is a struct, and one function `describe` per struct lists its keys with unit,
// range, default and meaning. Reading TOML, command-line flags, the resolved configuration and the reference page all
// come from that one list.
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/choice.hpp"
#include "core/json_fwd.hpp"

namespace porepack::record {

/// Allowed values of a number; always finite.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool low_open = false;
    bool zero_is_auto = false;  ///< 0 stands for "chosen automatically"
    [[nodiscard]] bool holds(double value) const;
    [[nodiscard]] std::string text() const;
};

// Sizes beyond these limits are typing errors, and their powers would overflow.
inline constexpr double min_size = 1e-30, max_size = 1e12;

[[nodiscard]] inline Range positive() {
    return {.low = min_size, .high = max_size};
}
[[nodiscard]] inline Range positive_or_auto() {
    return {.low = min_size, .high = max_size, .zero_is_auto = true};
}
[[nodiscard]] inline Range not_negative() {
    return {.low = 0.0, .high = max_size};
}
/// A length in metres.
[[nodiscard]] inline Range length_range() {
    return {.low = 1e-12, .high = 1e6};
}
[[nodiscard]] inline Range length_range_or_auto() {
    return {.low = 1e-12, .high = 1e6, .zero_is_auto = true};
}
[[nodiscard]] inline Range between(double low, double high) {
    return {.low = low, .high = high};
}

/// Size of an array of tables, which stays unchanged.
inline constexpr std::size_t keep_size = std::numeric_limits<std::size_t>::max();

class ConfigVisitor {
public:
    virtual ~ConfigVisitor() = default;
    virtual void number(const char* key, double& value, const Range& range, const char* meaning) = 0;
    virtual void integer(const char* key, long& value, const Range& range, const char* meaning) = 0;
    virtual void boolean(const char* key, bool& value, const char* meaning) = 0;
    virtual void text(const char* key, std::string& value, const char* meaning) = 0;
    /// One of a few names.
    virtual void word(const char* key, std::string& value, const std::vector<std::string>& allowed, const char* meaning) = 0;
    /// An enum with names (core/choice.hpp).
    template <core::NamedEnum Enum>
    void choice(const char* key, Enum& value, const char* meaning) {
        std::vector<std::string> names;
        for (const auto& one : choices_of(value)) names.emplace_back(one.name);
        std::string name(core::name_of(value));
        word(key, name, names, meaning);
        value = core::choice_named<Enum>(name).value();
    }
    /// Only these choices are allowed.
    template <core::NamedEnum Enum>
    void choice(const char* key, Enum& value, const std::vector<Enum>& allowed, const char* meaning) {
        std::vector<std::string> names;
        for (const Enum one : allowed) names.emplace_back(core::name_of(one));
        std::string name(core::name_of(value));
        word(key, name, names, meaning);
        value = core::choice_named<Enum>(name).value();
    }
    /// A key's name in an earlier version: still read for one version, with a warning.
    virtual void renamed(const char* old_key, const char* key) = 0;
    /// The same of a word that a key may have; before the key itself.
    virtual void renamed_word(const char* /*key*/, const char* /*old_word*/, const char* /*word*/) {}
    /// The key was in another table in an earlier version, where moved_to() declares it: still read from there for one version, with a
    /// warning.
    virtual void moved_here(const char* /*old_table*/, const char* /*key*/) {}
    virtual void moved_to(const char* /*table*/, const char* /*key*/) {}
    /// A list of `sizes.first` to `sizes.second` numbers (an empty list stands for "not given").
    virtual void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes, const Range& range,
                         const char* meaning) = 0;
    virtual void booleans(const char* key, std::vector<bool>& values, std::size_t size, const char* meaning) = 0;
    /// A value of any type, which the owner of the struct checks; null stands for "not given".
    virtual void any(const char* key, core::Json& value, const char* type, const char* meaning) = 0;
    /// An array of tables; `resize` sets the number of entries, `describe_one` lists the keys of entry i.
    virtual void tables(const char* key, const std::function<std::size_t(std::size_t)>& resize,
                        const std::function<void(std::size_t, ConfigVisitor&)>& describe_one, const char* meaning) = 0;
};

using Describe = std::function<void(ConfigVisitor&)>;
/// Values from the command line by key; they take precedence over the file.
using Flags = std::map<std::string, std::string>;

/// One row per key, for help and for the reference page.
struct KeyRow {
    std::string key, unit, type, allowed, standard, meaning;
};
[[nodiscard]] std::vector<KeyRow> key_rows(const Describe& describe);

/// "voxel_size_m" -> {"voxel_size", "m"}; the unit is empty when the key has none.
[[nodiscard]] std::pair<std::string, std::string> split_unit(std::string_view key);
/// "voxel_size_m" -> "--voxel-size".
[[nodiscard]] std::string flag_of(std::string_view key);
/// Old name -> new name of the keys that were renamed; "table.key" of those that moved to another table.
[[nodiscard]] std::map<std::string, std::string> renamed_keys(const Describe& describe);
/// The known word nearest to `word` (Levenshtein distance), or empty when none is near.
[[nodiscard]] std::string nearest(std::string_view word, const std::vector<std::string>& known);
/// "perhaps `word`", or empty: how to fix an unknown word.
[[nodiscard]] std::string perhaps(const std::string& near);

}  // namespace porepack::record
