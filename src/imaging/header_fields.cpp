#include "imaging/header_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;

bool HeaderFields::read_line(std::ifstream& file, std::string& line) {
    constexpr std::size_t longest_header = 65536;
    line.clear();
    for (int c = file.get(); c != '\n'; c = file.get()) {
        if (c == std::ifstream::traits_type::eof()) return !line.empty();
        if (++length_ > longest_header) fail("its header does not end");
        line += static_cast<char>(c);
    }
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    return true;
}

void HeaderFields::add(const std::string& key, const std::string& value) {
    if (!fields_.emplace(key, value).second) fail(fmt::format("\"{}\" stands twice in its header", key.substr(0, 60)), {}, "remove one");
}

std::string HeaderFields::text(const std::string& key, const std::string& standard) const {
    const auto found = fields_.find(key);
    return found == fields_.end() ? standard : found->second;
}

std::vector<double> HeaderFields::numbers(const std::string& key, std::size_t count) const {
    std::string values = text(key);
    std::replace_if(
        values.begin(), values.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
    std::istringstream words(values);
    std::vector<double> list(count);
    std::string more;
    for (double& number : list)
        if (!(words >> number) || !std::isfinite(number)) refuse(key, fmt::format("{} numbers", count));
    if (words >> more) refuse(key, fmt::format("{} numbers", count));
    return list;
}

std::array<std::int64_t, 3> HeaderFields::sizes(const std::string& key) const {
    const std::vector<double> list = numbers(key, 3);
    std::array<std::int64_t, 3> sizes{};
    for (std::size_t i = 0; i < 3; ++i) {
        if (!(list[i] >= 1.0) || list[i] > 1e6 || list[i] != std::floor(list[i])) refuse(key, "whole numbers from 1 on");
        sizes[i] = static_cast<std::int64_t>(list[i]);
    }
    return sizes;
}

std::string HeaderFields::only_one_of(const std::vector<std::string>& names) const {
    std::string found;
    for (const std::string& name : names) {
        if (!contains(name)) continue;
        if (!found.empty()) fail(fmt::format("\"{}\" and \"{}\" mean the same", found, name), {}, "remove one");
        found = name;
    }
    return found;
}

void HeaderFields::refuse(const std::string& key, const std::string& allowed, const std::string& fix) const {
    fail(fmt::format("{}: {}", key, text(key).substr(0, 60)), allowed, fix);
}

void HeaderFields::fail(const std::string& what, const std::string& allowed, const std::string& fix) const {
    throw UserError(fmt::format("not a {}, or a damaged one: {}", format_, what),
                    {.where = path_.string(), .allowed = allowed, .fix = fix});
}

Path HeaderFields::data_file(const std::string& name) const {
    std::error_code ignored;
    const Path data = path_.parent_path() / name;
    if (name.size() > 255 || !fs::is_regular_file(data, ignored)) fail("its data are missing: " + name.substr(0, 60));
    if (Path(name).has_parent_path()) log_info("the values of {} are read from {}", path_.string(), data.string());
    return data;
}

std::uint64_t HeaderFields::skip(const std::string& key, const Path& data, double value_bytes) const {
    if (!contains(key)) return 0;
    const double bytes = numbers(key, 1).front(), all = static_cast<double>(fs::file_size(data));
    if (bytes == -1.0) {
        if (all < value_bytes) fail(fmt::format("{} has {:.0f} bytes, and its values need {:.0f}", data.string(), all, value_bytes));
        return static_cast<std::uint64_t>(all - value_bytes);
    }
    if (!(bytes >= 0.0) || bytes > 1e15 || bytes != std::floor(bytes)) refuse(key, "a number of bytes, or -1: the values stand last");
    return static_cast<std::uint64_t>(bytes);
}

}  // namespace porepack::imaging
