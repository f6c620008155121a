#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/values_of_file.hpp"

namespace porepack::imaging {
using namespace core;
namespace fs = std::filesystem;

// "key: value" in each line up to an empty one; the data behind it or in a file of their own. (ITK's reader does not survive damaged
// headers, and takes surplus data.)
FileVolume open_nrrd(const Path& path) {
    constexpr std::size_t longest_header = 65536;
    const auto fail = [&](const std::string& what, const std::string& allowed = {}) -> void {
        throw UserError("not a NRRD image, or a damaged one: " + what, {.where = path.string(), .allowed = allowed});
    };
    if (!fs::is_regular_file(path)) fail("not a regular file");
    std::ifstream file(path, std::ios::binary);
    std::map<std::string, std::string> fields;
    std::string line;
    if (!std::getline(file, line) || !line.starts_with("NRRD000")) fail("its first line");
    for (std::size_t length = line.size(); std::getline(file, line);) {
        length += line.size() + 1;
        if (length > longest_header) fail("its header does not end");
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (line.empty()) break;
        if (line.starts_with('#') || line.find(":=") != std::string::npos) continue;  // remarks, and keys of other programs
        const std::size_t colon = line.find(": ");
        if (colon == std::string::npos) fail("the line \"" + line.substr(0, 60) + "\"", "key: value");
        fields[line.substr(0, colon)] = line.substr(line.find_first_not_of(' ', colon + 1));
    }
    const auto text = [&](const char* key, const std::string& standard = {}) {
        const auto found = fields.find(key);
        return found == fields.end() ? standard : found->second;
    };
    const auto numbers = [&](const std::string& key, std::size_t count) {
        std::string values = fields[key];
        std::replace_if(
            values.begin(), values.end(), [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
        std::istringstream words(values);
        std::vector<double> list(count);
        for (double& number : list)
            if (!(words >> number) || !std::isfinite(number)) fail(key + ": " + values.substr(0, 60), fmt::format("{} numbers", count));
        std::string more;
        if (words >> more) fail(key + ": " + values.substr(0, 60), fmt::format("{} numbers", count));
        return list;
    };
    if (text("dimension") != "3") fail("dimension: " + text("dimension"), "3");
    static const std::map<std::string, ValueType> types = {
        {"signed char", ValueType::int8},      {"int8", ValueType::int8},     {"int8_t", ValueType::int8},
        {"uchar", ValueType::uint8},           {"uint8", ValueType::uint8},   {"uint8_t", ValueType::uint8},
        {"unsigned char", ValueType::uint8},   {"short", ValueType::int16},   {"short int", ValueType::int16},
        {"signed short", ValueType::int16},    {"int16", ValueType::int16},   {"int16_t", ValueType::int16},
        {"ushort", ValueType::uint16},         {"uint16", ValueType::uint16}, {"uint16_t", ValueType::uint16},
        {"unsigned short", ValueType::uint16}, {"int", ValueType::int32},     {"signed int", ValueType::int32},
        {"int32", ValueType::int32},           {"int32_t", ValueType::int32}, {"uint", ValueType::uint32},
        {"unsigned int", ValueType::uint32},   {"uint32", ValueType::uint32}, {"uint32_t", ValueType::uint32},
        {"float", ValueType::float32},         {"double", ValueType::float64}};
    const auto type = types.find(text("type"));
    if (type == types.end()) fail("type: " + text("type"), "8, 16 or 32 bits, float or double");
    FileVolume volume{.type = type->second, .format = fmt::format("NRRD, {}", name_of(type->second))};
    const std::vector<double> sizes = numbers("sizes", 3);
    for (std::size_t i = 0; i < 3; ++i) {
        if (!(sizes[i] >= 1.0) || sizes[i] > 1e6 || sizes[i] != std::floor(sizes[i]))
            fail("sizes: " + text("sizes"), "whole numbers from 1 on");
        volume.voxels[i] = static_cast<std::int64_t>(sizes[i]);
    }
    if (fields.contains("axis mins") || fields.contains("axis maxs"))
        fail("it has axis mins or axis maxs", "spacings, or space directions");
    if (fields.contains("space directions")) {
        const std::vector<double> columns = numbers("space directions", 9);
        volume.spacing = {0, 0, 0};
        for (std::size_t i = 0; i < 3; ++i) {
            double& length = (*volume.spacing)[i];
            length = std::hypot(columns[3 * i], columns[3 * i + 1], columns[3 * i + 2]);
            if (!(length > 0.0)) fail("space directions: " + text("space directions").substr(0, 60));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                volume.direction[i][axis] = columns[3 * i + axis] / length;
                if (std::abs(volume.direction[i][axis] - (axis == i ? 1.0 : 0.0)) > 1e-9) volume.states_direction = true;
            }
        }
        if (fields.contains("space origin")) {
            const std::vector<double> place = numbers("space origin", 3);
            volume.origin = {place[0], place[1], place[2]};
        }
    } else if (fields.contains("spacings")) {
        const std::vector<double> lengths = numbers("spacings", 3);
        volume.spacing = {lengths[0], lengths[1], lengths[2]};
    }
    if (const std::string units = text("space units", text("units")); !units.empty()) {
        static const std::map<std::string, double> known = {{"mm", 1e-3}, {"um", 1e-6}, {"micron", 1e-6}, {"microns", 1e-6},
                                                            {"cm", 1e-2}, {"m", 1.0},   {"nm", 1e-9}};
        std::vector<std::string> names;
        for (std::size_t at = units.find('"'); at != std::string::npos; at = units.find('"', at)) {
            const std::size_t close = units.find('"', at + 1);
            if (close == std::string::npos) break;
            names.push_back(units.substr(at + 1, close - at - 1));
            at = close + 1;
        }
        if (names.size() != 3 || names[0] != names[1] || names[0] != names[2])
            fail("units: " + units.substr(0, 60), "the same unit for the three axes");
        if (const auto found = known.find(names[0]); found != known.end()) volume.unit_m = found->second;
    }
    std::string encoding = text("encoding");
    std::transform(encoding.begin(), encoding.end(), encoding.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool packed = encoding == "gzip" || encoding == "gz";
    if (!packed && encoding != "raw") fail("encoding: " + encoding, "raw, gzip");
    if (text("line skip", "0") != "0" || text("byte skip", "0") != "0") fail("it skips lines or bytes", "line skip: 0, byte skip: 0");
    const std::string endian = text("endian");
    if (size_of(volume.type) > 1 && endian != "little" && endian != "big") fail("endian: " + endian, "little, big");
    const std::string name = text("data file", text("datafile"));
    if (name.starts_with("LIST") || name.find('%') != std::string::npos || name.size() > 255)
        fail("data file: " + name.substr(0, 60), "one file");
    std::error_code ignored;
    const Path data = name.empty() ? path : path.parent_path() / name;
    if (!fs::exists(data, ignored)) fail("its data are missing: " + name);
    if (name.empty() && !file) fail("its header does not end with an empty line");
    const auto start = name.empty() ? static_cast<std::uint64_t>(file.tellg()) : 0U;
    if (!name.empty()) volume.files.push_back(path);
    read_values(volume, {.path = data, .start = start, .packed = packed, .big_endian = endian == "big"});
    return volume;
}

}  // namespace porepack::imaging
