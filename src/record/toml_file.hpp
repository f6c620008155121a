// case.toml and other TOML files: tables are read into structs with the lists of their keys (record/config.hpp).
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "record/config.hpp"

namespace porepack::record {

/// A parsed TOML file. Syntax errors throw UserError with file and line.
class TomlFile {
public:
    explicit TomlFile(const core::Path& path);
    /// An object of values of a program instead of a file; `place` stands in messages where a file and a line would.
    TomlFile(const core::Json& values, const std::string& place);
    TomlFile();  ///< an empty one: defaults and flags only
    ~TomlFile();
    TomlFile(TomlFile&&) noexcept;
    TomlFile& operator=(TomlFile&&) noexcept;

    /// Reads table `name` ("" = the top level) into what `describe` lists. An unknown key, a wrong type and a value out
    /// of range throw UserError with file, line, what is allowed and the nearest known key. `flags` (--voxel-size) and `set`
    /// (--set table.key) take precedence over the file.
    void read(std::string_view name, const Describe& describe, const Flags& flags = {}, const Flags& set = {}) const;
    [[nodiscard]] bool has(std::string_view name) const;
    /// The file with other values of keys by table; each value is written as in TOML ("0.5", "\"box\""), and an empty one removes the key.
    [[nodiscard]] TomlFile with(const std::map<std::string, Flags>& set) const;
    [[nodiscard]] std::string text() const;  ///< without comments
    /// The keys of a table, each with its place ("case.toml, line 12").
    [[nodiscard]] std::map<std::string, std::string> keys_of(std::string_view name) const;
    /// Throws UserError when the file has a table that is not in `known`.
    void require_known_tables(const std::vector<std::string>& known) const;

private:
    struct Content;
    std::unique_ptr<Content> content_;
};

/// Reads an object's values into a table's struct with the rules of the file.
template <typename Config>
void read_values(const core::Json& values, Config& config, const std::string& place) {
    TomlFile(values, place).read("", [&](ConfigVisitor& v) { describe(v, config); });
}

/// A value as in TOML on one line: "0.5", "[1, 2]", "{ radius_m = 1e-3 }".
[[nodiscard]] std::string toml_text(const core::Json& value);

/// Reads flags into a table's struct with the rules of the file.
template <typename Config>
[[nodiscard]] Config config_from_flags(const Flags& flags) {
    Config config;
    TomlFile().read(
        "", [&](ConfigVisitor& v) { describe(v, config); }, flags);
    return config;
}

}  // namespace porepack::record
