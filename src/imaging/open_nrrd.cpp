#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/header_fields.hpp"
#include "imaging/values_of_file.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

// The format's names of its fields may be written with blanks, and with others for some.
std::string field_name(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    static const std::map<std::string, std::string> others = {
        {"datafile", "data file"},   {"byteskip", "byte skip"},      {"lineskip", "line skip"}, {"axismins", "axis mins"},
        {"axismaxs", "axis maxs"},   {"centerings", "centers"},      {"oldmin", "old min"},     {"oldmax", "old max"},
        {"blocksize", "block size"}, {"sampleunits", "sample units"}};
    const auto found = others.find(text);
    return found == others.end() ? text : found->second;
}

// Fields of the format that change neither values nor places.
const std::set<std::string> other_fields = {"content", "thicknesses",       "labels",  "number",
                                            "space",   "measurement frame", "centers", "sample units"};
const std::set<std::string> used_fields = {"dimension",        "type",         "sizes",       "spacings",  "space dimension",
                                           "space directions", "space origin", "space units", "units",     "kinds",
                                           "encoding",         "endian",       "byte skip",   "line skip", "data file"};

HeaderFields read_header(std::ifstream& file, const Path& path) {
    HeaderFields fields(path, "NRRD image");
    std::string line;
    if (!fields.read_line(file, line) || !line.starts_with("NRRD000")) fields.fail("its first line");
    while (fields.read_line(file, line) && !line.empty()) {
        if (line.starts_with('#')) continue;
        const std::size_t colon = line.find(':');
        if (colon != std::string::npos && line.substr(colon).starts_with(":=")) continue;  // keys of other programs
        if (colon == std::string::npos || !line.substr(colon).starts_with(": "))
            fields.fail("the line \"" + line.substr(0, 60) + "\"", "key: value");
        const std::string name = field_name(line.substr(0, colon));
        const std::size_t start = line.find_first_not_of(' ', colon + 1);
        fields.add(name, start == std::string::npos ? std::string() : line.substr(start));
        if (!used_fields.contains(name) && !other_fields.contains(name))
            fields.refuse(name, "fields that state sizes, places and encoding",
                          "if it means nothing for the values, remove the line; else write the image without it");
    }
    return fields;
}

// Axes of colours, vectors, times or lists are no axes of space.
void require_axes_of_space(const HeaderFields& fields) {
    if (fields.text("dimension") != "3") fields.refuse("dimension", "3", "write one channel and one time, as an image with three axes");
    if (!fields.contains("kinds")) return;
    std::istringstream words(fields.text("kinds"));
    std::size_t count = 0;
    for (std::string kind; words >> kind; ++count)
        if (kind != "domain" && kind != "space" && kind != "none" && kind != "???")
            fields.refuse("kinds", "domain, space, none", "write one channel and one time, as an image with three axes");
    if (count != 3) fields.refuse("kinds", "one for each axis");
}

ValueType type_of(const HeaderFields& fields) {
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
    const auto type = types.find(fields.text("type"));
    if (type == types.end()) fields.refuse("type", "8, 16 or 32 bits, float or double");
    return type->second;
}

void take_places(FileVolume& volume, const HeaderFields& fields) {
    if (!fields.only_one_of({"spacings", "space directions"}).starts_with("space ") && fields.contains("spacings")) {
        const std::vector<double> lengths = fields.numbers("spacings", 3);
        volume.spacing = {lengths[0], lengths[1], lengths[2]};
    }
    if (fields.contains("space directions")) {
        const std::vector<double> columns = fields.numbers("space directions", 9);
        volume.spacing = {0, 0, 0};
        for (std::size_t i = 0; i < 3; ++i) {
            double& length = (*volume.spacing)[i];
            length = std::hypot(columns[3 * i], columns[3 * i + 1], columns[3 * i + 2]);
            if (!(length > 0.0) || !std::isfinite(length)) fields.refuse("space directions", "vectors with a length");
            for (std::size_t axis = 0; axis < 3; ++axis) {
                volume.direction[i][axis] = columns[3 * i + axis] / length;
                if (std::abs(volume.direction[i][axis] - (axis == i ? 1.0 : 0.0)) > 1e-9) volume.states_direction = true;
            }
        }
    }
    if (fields.contains("space origin")) {
        const std::vector<double> place = fields.numbers("space origin", 3);
        volume.origin = {place[0], place[1], place[2]};
    }
}

std::optional<double> unit_of(const HeaderFields& fields) {
    static const std::map<std::string, double> known = {{"mm", 1e-3},      {"um", 1e-6}, {"\xC2\xB5m", 1e-6}, {"micron", 1e-6},
                                                        {"microns", 1e-6}, {"cm", 1e-2}, {"m", 1.0},          {"nm", 1e-9}};
    const std::string key = fields.only_one_of({"space units", "units"});
    if (key.empty()) return std::nullopt;
    const std::string units = fields.text(key);
    std::vector<std::string> names;
    for (std::size_t at = units.find('"'); at != std::string::npos; at = units.find('"', at)) {
        const std::size_t close = units.find('"', at + 1);
        if (close == std::string::npos) break;
        names.push_back(units.substr(at + 1, close - at - 1));
        at = close + 1;
    }
    if (names.size() != 3 || names[0] != names[1] || names[0] != names[2]) fields.refuse(key, "the same unit for the three axes");
    const auto found = known.find(names[0]);
    return found == known.end() ? std::nullopt : std::optional(found->second);
}

}  // namespace

// The data stand behind the header, or in a file of their own. (ITK's reader does not survive damaged headers, and takes surplus data.)
FileVolume open_nrrd(const Path& path) {
    std::ifstream file(path, std::ios::binary);
    require_file(path);
    const HeaderFields fields = read_header(file, path);
    require_axes_of_space(fields);
    FileVolume volume{.type = type_of(fields)};
    volume.format = fmt::format("NRRD, {}", name_of(volume.type));
    volume.voxels = fields.sizes("sizes");
    take_places(volume, fields);
    volume.unit_m = unit_of(fields);

    std::string encoding = fields.text("encoding");
    std::transform(encoding.begin(), encoding.end(), encoding.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const bool packed = encoding == "gzip" || encoding == "gz";
    if (!packed && encoding != "raw") fields.refuse("encoding", "raw, gzip");
    const std::string endian = fields.text("endian");
    if (size_of(volume.type) > 1 && endian != "little" && endian != "big") fields.refuse("endian", "little, big");
    if (fields.contains("line skip") && fields.numbers("line skip", 1).front() != 0.0)
        fields.refuse("line skip", "0", "state the length of these lines as byte skip");
    const std::string name = fields.text("data file");
    if (fields.contains("data file") && (name.empty() || name.starts_with("LIST") || name.find('%') != std::string::npos))
        fields.refuse("data file", "the name of one file");
    if (name.empty() && !file) fields.fail("its header does not end with an empty line");
    const Path data = name.empty() ? path : fields.data_file(name);
    const double count =
        static_cast<double>(volume.voxels[0]) * static_cast<double>(volume.voxels[1]) * static_cast<double>(volume.voxels[2]);
    if (packed && fields.text("byte skip", "0") != "0") fields.refuse("byte skip", "0 in a packed file");
    std::uint64_t skip = fields.skip("byte skip", data, count * static_cast<double>(size_of(volume.type)));
    const auto start = name.empty() ? static_cast<std::uint64_t>(file.tellg()) : 0U;
    if (name.empty() && fields.text("byte skip") == "-1") {  // counted from the beginning of the file
        if (skip < start) fields.fail("its values are not all there");
        skip -= start;
    }
    if (!name.empty()) volume.files.push_back(path);
    read_values(volume, {.path = data, .start = start, .packed = packed, .skip = skip, .big_endian = endian == "big"});
    return volume;
}

}  // namespace porepack::imaging
