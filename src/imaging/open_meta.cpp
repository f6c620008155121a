#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/header_fields.hpp"
#include "imaging/values_of_file.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

// "Key = value" in each line up to ElementDataFile.
HeaderFields read_header(std::ifstream& file, const Path& path) {
    HeaderFields fields(path, "MetaImage");
    std::string line;
    while (!fields.contains("ElementDataFile")) {
        if (!fields.read_line(file, line)) fields.fail("ElementDataFile is missing");
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) {
            if (line.empty()) continue;
            fields.fail("the line \"" + line.substr(0, 60) + "\"", "Key = value");
        }
        const std::size_t end = line.find_last_not_of(" \t", equals == 0 ? 0 : equals - 1),
                          from = line.find_first_not_of(" \t", equals + 1);
        fields.add(line.substr(0, end + 1), from == std::string::npos ? std::string() : line.substr(from));
    }
    return fields;
}

bool truth(const HeaderFields& fields, const std::string& key) {
    const std::string value = key.empty() ? "False" : fields.text(key, "False");
    if (value != "True" && value != "true" && value != "False" && value != "false") fields.refuse(key, "True, False");
    return value == "True" || value == "true";
}

ValueType type_of(const HeaderFields& fields) {
    static const std::map<std::string, ValueType> types = {{"MET_UCHAR", ValueType::uint8},   {"MET_CHAR", ValueType::int8},
                                                           {"MET_USHORT", ValueType::uint16}, {"MET_SHORT", ValueType::int16},
                                                           {"MET_UINT", ValueType::uint32},   {"MET_INT", ValueType::int32},
                                                           {"MET_FLOAT", ValueType::float32}, {"MET_DOUBLE", ValueType::float64}};
    const auto type = types.find(fields.text("ElementType"));
    if (type == types.end()) fields.refuse("ElementType", "MET_UCHAR, MET_USHORT, MET_FLOAT and others of one value");
    return type->second;
}

void take_places(FileVolume& volume, const HeaderFields& fields) {
    for (const char* key : {"ElementSize", "ElementSpacing"})  // the distance of the voxels counts, where both are stated
        if (fields.contains(key)) {
            const std::vector<double> lengths = fields.numbers(key, 3);
            volume.spacing = {lengths[0], lengths[1], lengths[2]};
        }
    if (const std::string key = fields.only_one_of({"Offset", "Position", "Origin"}); !key.empty()) {
        const std::vector<double> place = fields.numbers(key, 3);
        volume.origin = {place[0], place[1], place[2]};
    }
    if (const std::string key = fields.only_one_of({"TransformMatrix", "Rotation", "Orientation"}); !key.empty()) {
        const std::vector<double> matrix = fields.numbers(key, 9);  // row i: direction of axis i
        for (std::size_t i = 0; i < 9; ++i) {
            volume.direction[i / 3][i % 3] = matrix[i];
            if (matrix[i] != (i % 4 == 0 ? 1.0 : 0.0)) volume.states_direction = true;
        }
    }
    if (fields.contains("DistanceUnits")) {
        static const std::map<std::string, double> units = {{"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"?", 0.0}};
        const auto unit = units.find(fields.text("DistanceUnits"));
        if (unit == units.end()) fields.refuse("DistanceUnits", "um, mm, cm");
        if (unit->second > 0.0) volume.unit_m = unit->second;
    }
}

}  // namespace

// The data stand behind the header, or in a file of their own. (ITK's MetaIO does not survive damaged headers.)
FileVolume open_meta(const Path& path) {
    std::ifstream file(path, std::ios::binary);
    require_file(path);
    const HeaderFields fields = read_header(file, path);
    const auto expect = [&](const char* key, const char* standard, const char* only) {
        if (fields.text(key, standard) != only) fields.refuse(key, only);
    };
    expect("ObjectType", "Image", "Image");
    expect("NDims", "", "3");
    expect("ElementNumberOfChannels", "1", "1");
    expect("BinaryData", "True", "True");
    for (const auto& [key, neutral] :
         {std::pair("ElementToIntensityFunctionSlope", 1.0), std::pair("ElementToIntensityFunctionOffset", 0.0)})
        if (fields.contains(key) && fields.numbers(key, 1).front() != neutral)
            fields.refuse(key, fmt::format("{:g}", neutral), "write the image with its values, not those before a conversion");

    FileVolume volume{.type = type_of(fields)};
    volume.format = fmt::format("MetaImage, {}", name_of(volume.type));
    volume.voxels = fields.sizes("DimSize");
    take_places(volume, fields);
    const bool big = truth(fields, fields.only_one_of({"ElementByteOrderMSB", "BinaryDataByteOrderMSB"})),
               packed = truth(fields, "CompressedData");
    const std::string name = fields.text("ElementDataFile");
    const bool local = name == "LOCAL";
    if (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos)
        fields.refuse("ElementDataFile", "LOCAL, or the name of one file",
                      "write the layers as one file, or name their folder as the image");
    const Path data = local ? path : fields.data_file(name);
    if (!local) volume.files.push_back(path);
    const double count =
        static_cast<double>(volume.voxels[0]) * static_cast<double>(volume.voxels[1]) * static_cast<double>(volume.voxels[2]);
    if ((packed || local) && fields.text("HeaderSize", "0") != "0") fields.refuse("HeaderSize", "0 here");
    const std::uint64_t skip = fields.skip("HeaderSize", data, count * static_cast<double>(size_of(volume.type)));
    const auto start = local ? static_cast<std::uint64_t>(file.tellg()) : 0U;
    read_values(volume, {.path = data, .start = start, .packed = packed, .skip = skip, .big_endian = big});
    return volume;
}

}  // namespace porepack::imaging
