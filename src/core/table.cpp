#include "core/table.hpp"

#include <cmath>
#include <stdexcept>

namespace porepack::core {

std::string Table::field(double value) const {
    return std::isnan(value) ? std::string() : fmt::format("{:.{}g}", value, digits);
}

std::string Table::field(const std::string& text) const {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
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
    for (const auto& row : rows_) text += line(row);
    return text;
}

std::string Table::csv_with_note(const std::string& note) const {
    std::string text = csv();
    return text.insert(text.find('\n') + 1, "# " + note + "\n");
}

void Table::write(const Path& path) const {
    write_text(path, csv());
}

}  // namespace porepack::core
