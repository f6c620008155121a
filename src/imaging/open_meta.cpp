#include <fmt/format.h>

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

// "Key = value" in each line, the data behind the last one or in a file of their own. (ITK's MetaIO does not survive damaged headers.)
FileVolume open_meta(const Path& path) {
    constexpr std::size_t longest_header = 65536;
    const auto fail = [&](const std::string& what, const std::string& allowed = {}) -> void {
        throw UserError("not a MetaImage, or a damaged one: " + what, {.where = path.string(), .allowed = allowed});
    };
    if (!fs::is_regular_file(path)) fail("not a regular file");
    std::ifstream file(path, std::ios::binary);
    std::map<std::string, std::string> fields;
    std::string line;
    std::size_t length = 0;
    while (!fields.contains("ElementDataFile")) {
        if (!std::getline(file, line)) fail("ElementDataFile is missing");
        length += line.size() + 1;
        if (length > longest_header) fail("its header does not end");
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) {
            if (line.empty()) continue;
            fail("the line \"" + line.substr(0, 60) + "\"", "Key = value");
        }
        const std::size_t end = line.find_last_not_of(" \t", equals == 0 ? 0 : equals - 1),
                          from = line.find_first_not_of(" \t", equals + 1);
        fields[line.substr(0, end + 1)] = from == std::string::npos ? std::string() : line.substr(from);
    }
    const auto text = [&](const char* key, const char* standard) {
        const auto found = fields.find(key);
        return found == fields.end() ? std::string(standard) : found->second;
    };
    const auto numbers = [&](const std::string& key, const std::string& values, std::size_t count) {
        std::istringstream words(values);
        std::vector<double> list(count);
        for (double& number : list)
            if (!(words >> number) || !std::isfinite(number)) fail(key + " = " + values.substr(0, 60), fmt::format("{} numbers", count));
        std::string more;
        if (words >> more) fail(key + " = " + values.substr(0, 60), fmt::format("{} numbers", count));
        return list;
    };
    const auto truth = [&](const char* key, bool standard) {
        const std::string value = text(key, standard ? "True" : "False");
        if (value != "True" && value != "true" && value != "False" && value != "false")
            fail(fmt::format("{} = {}", key, value), "True, False");
        return value == "True" || value == "true";
    };
    const auto expect = [&](const char* key, const char* standard, const char* only) {
        if (text(key, standard) != only) fail(fmt::format("{} = {}", key, text(key, standard)), only);
    };
    expect("ObjectType", "Image", "Image");
    expect("NDims", "", "3");
    expect("ElementNumberOfChannels", "1", "1");
    expect("HeaderSize", "0", "0");
    if (!truth("BinaryData", true)) fail("BinaryData = False", "True");

    static const std::map<std::string, ValueType> types = {{"MET_UCHAR", ValueType::uint8},   {"MET_CHAR", ValueType::int8},
                                                           {"MET_USHORT", ValueType::uint16}, {"MET_SHORT", ValueType::int16},
                                                           {"MET_UINT", ValueType::uint32},   {"MET_INT", ValueType::int32},
                                                           {"MET_FLOAT", ValueType::float32}, {"MET_DOUBLE", ValueType::float64}};
    const auto type = types.find(text("ElementType", ""));
    if (type == types.end()) fail("ElementType = " + text("ElementType", ""), "MET_UCHAR, MET_USHORT, MET_FLOAT and others of one value");
    FileVolume volume{.type = type->second, .format = fmt::format("MetaImage, {}", name_of(type->second))};
    const std::vector<double> dims = numbers("DimSize", text("DimSize", ""), 3);
    for (std::size_t i = 0; i < 3; ++i) {
        if (!(dims[i] >= 1.0) || dims[i] > 1e6 || dims[i] != std::floor(dims[i]))
            fail("DimSize = " + text("DimSize", ""), "whole numbers from 1 on");
        volume.voxels[i] = static_cast<std::int64_t>(dims[i]);
    }
    for (const char* key : {"ElementSpacing", "ElementSize"})
        if (fields.contains(key) && !volume.spacing) {
            const std::vector<double> lengths = numbers(key, fields[key], 3);
            volume.spacing = {lengths[0], lengths[1], lengths[2]};
        }
    for (const char* key : {"Offset", "Position", "Origin"})
        if (fields.contains(key)) {
            const std::vector<double> place = numbers(key, fields[key], 3);
            volume.origin = {place[0], place[1], place[2]};
        }
    for (const char* key : {"TransformMatrix", "Rotation", "Orientation"})
        if (fields.contains(key)) {
            const std::vector<double> matrix = numbers(key, fields[key], 9);  // row i: direction of axis i
            for (std::size_t i = 0; i < 9; ++i) {
                volume.direction[i / 3][i % 3] = matrix[i];
                if (matrix[i] != (i % 4 == 0 ? 1.0 : 0.0)) volume.states_direction = true;
            }
        }
    const bool big = truth(fields.contains("ElementByteOrderMSB") ? "ElementByteOrderMSB" : "BinaryDataByteOrderMSB", false);
    const bool packed = truth("CompressedData", false), local = fields["ElementDataFile"] == "LOCAL";
    const std::string& name = fields["ElementDataFile"];
    if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos)
        fail("ElementDataFile = " + name, "LOCAL, or the name of one file");
    const Path data = local ? path : path.parent_path() / name;
    std::error_code ignored;
    if (name.size() > 255 || !fs::exists(data, ignored)) fail("its data are missing: " + name.substr(0, 60));
    if (!local) volume.files.push_back(path);
    const auto start = local ? static_cast<std::uint64_t>(file.tellg()) : 0U;
    read_values(volume, {.path = data, .start = start, .packed = packed, .big_endian = big});
    return volume;
}

}  // namespace porepack::imaging
