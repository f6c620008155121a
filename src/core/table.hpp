// Tables of results, written as CSV: the only CSV writer of the project.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <optional>

#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"

namespace porepack::inline core {

class Table {
public:
    /// Column names; a quantity's name ends in its unit.
    explicit Table(std::vector<std::string> columns) : columns_(std::move(columns)) {
        for (std::string& column : columns_) column = field(column);
    }

    /// One row, one value per column: numbers with `digits` significant digits (whole numbers in full), text quoted where necessary,
    /// with spaces for line breaks.
    /// A value that is not known (NaN, an empty optional) is an empty field. Throws std::logic_error when the number of values is wrong.
    template <typename... Values>
    void add(const Values&... values) {
        add_row({field(values)...});
    }
    void add_row(std::vector<std::string> fields);

    [[nodiscard]] std::size_t rows() const { return rows_.size(); }
    [[nodiscard]] std::string csv() const;
    void write(const Path& path) const;

    int digits = 9;
    std::string note = {};  ///< a comment line ("# note") below the header

    [[nodiscard]] std::string field(double value) const;
    [[nodiscard]] std::string field(const std::string& text) const;
    [[nodiscard]] std::string field(const char* text) const { return field(std::string(text)); }
    template <std::integral Integer>
    [[nodiscard]] std::string field(Integer value) const {
        return fmt::format("{}", value);
    }
    template <typename Value>
    [[nodiscard]] std::string field(const std::optional<Value>& value) const {
        return value ? field(*value) : std::string();
    }

private:
    std::vector<std::string> columns_;
    std::vector<std::vector<std::string>> rows_;
};

/// A CSV file with text in it: quoted fields may hold commas and quotes. Lines that begin with # are left out. Throws UserError for a line
/// with another number of fields than the header.
struct TextTable {
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;
};
[[nodiscard]] TextTable read_text_table(const Path& path);

/// The numbers of a file that Table has written, row by row without the header; an empty field is NaN. Throws UserError for text.
[[nodiscard]] std::vector<std::vector<double>> read_table(const Path& path);

}  // namespace porepack::inline core
