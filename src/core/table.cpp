#include "core/table.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/error.hpp"

namespace porepack::inline core {

std::string Table::field(double value) const {
    return std::isnan(value) ? std::string() : fmt::format("{:.{}g}", value, digits);
}

std::string Table::field(const std::string& text) const {
    if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' || c == '\r' ? ' ' : c);
    return quoted + "\"";
}

void Table::add_row(std::vector<std::string> fields) {
    if (fields.size() != columns_.size())
        throw std::logic_error(fmt::format("a row of {} values in a table of {} columns", fields.size(), columns_.size()));
    rows_.push_back(std::move(fields));
}

std::string Table::csv() const {
    const auto line = [](const std::vector<std::string>& fields) {
        std::string text;
        for (const std::string& field : fields) text += (text.empty() && &field == &fields.front() ? "" : ",") + field;
        return text + "\n";
    };
    std::string text = line(columns_);
    if (!note.empty()) text += "# " + note + "\n";
    for (const auto& row : rows_) text += line(row);
    return text;
}

void Table::write(const Path& path) const {
    write_text(path, csv());
}

namespace {

std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
            fields.back() += line[++i];
        else if (c == '"')
            quoted = !quoted;
        else if (c == ',' && !quoted)
            fields.emplace_back();
        else
            fields.back() += c;
    }
    return fields;
}

}  // namespace

TextTable read_text_table(const Path& path) {
    std::istringstream lines(read_text(path));
    TextTable table;
    std::string line;
    for (long number = 1; std::getline(lines, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty() || line.front() == '#') continue;
        std::vector<std::string> fields = fields_of(line);
        if (table.columns.empty()) {
            table.columns = std::move(fields);
            continue;
        }
        if (fields.size() != table.columns.size())
            throw UserError(fmt::format("{} fields, but the header has {}", fields.size(), table.columns.size()),
                            {.where = fmt::format("{}, line {}", path.string(), number)});
        table.rows.push_back(std::move(fields));
    }
    return table;
}

std::vector<std::vector<double>> read_table(const Path& path) {
    std::istringstream lines(read_text(path));
    std::vector<std::vector<double>> rows;
    std::string line;
    std::getline(lines, line);  // the header
    for (long number = 2; std::getline(lines, line); ++number) {
        if (line.empty() || line.front() == '#') continue;
        std::vector<double> row;
        std::istringstream fields(line + ",");
        for (std::string field; std::getline(fields, field, ',');) {
            char* end = nullptr;
            row.push_back(field.empty() ? std::nan("") : std::strtod(field.c_str(), &end));
            if (!field.empty() && *end != '\0')
                throw UserError("not a number: " + field, {.where = fmt::format("{}, line {}", path.string(), number)});
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace porepack::inline core
