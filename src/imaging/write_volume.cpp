#include "imaging/write_volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

template <typename Value>
void convert(std::span<const float> values, std::vector<char>& bytes) {
    bytes.resize(values.size() * sizeof(Value));
    auto* to = reinterpret_cast<Value*>(bytes.data());
    for (std::size_t i = 0; i < values.size(); ++i) to[i] = static_cast<Value>(values[i]);
}

void to_bytes(std::span<const float> values, ValueType type, std::vector<char>& bytes) {
    switch (type) {
        case ValueType::uint8:
            return convert<std::uint8_t>(values, bytes);
        case ValueType::int8:
            return convert<std::int8_t>(values, bytes);
        case ValueType::uint16:
            return convert<std::uint16_t>(values, bytes);
        case ValueType::int16:
            return convert<std::int16_t>(values, bytes);
        case ValueType::uint32:
            return convert<std::uint32_t>(values, bytes);
        case ValueType::int32:
            return convert<std::int32_t>(values, bytes);
        case ValueType::float32:
            return convert<float>(values, bytes);
        case ValueType::float64:
            return convert<double>(values, bytes);
    }
}

bool big() {
    return std::endian::native == std::endian::big;
}

// Millimetres with all digits: what MetaImage and NRRD users expect.
std::string in_mm(const std::array<double, 3>& lengths_m, double offset = 0.0, const std::array<double, 3>& step_m = {0, 0, 0}) {
    return fmt::format("{:.10g} {:.10g} {:.10g}", 1e3 * (lengths_m[0] + offset * step_m[0]), 1e3 * (lengths_m[1] + offset * step_m[1]),
                       1e3 * (lengths_m[2] + offset * step_m[2]));
}

// MetaImage and NRRD place the centre of the first voxel, VTK the corner of the image: hence half a voxel is added to the origin here.
std::string mhd_header(const VolumeHeader& h, const std::string& data) {
    static const std::map<ValueType, const char*> names = {{ValueType::uint8, "MET_UCHAR"},   {ValueType::int8, "MET_CHAR"},
                                                           {ValueType::uint16, "MET_USHORT"}, {ValueType::int16, "MET_SHORT"},
                                                           {ValueType::uint32, "MET_UINT"},   {ValueType::int32, "MET_INT"},
                                                           {ValueType::float32, "MET_FLOAT"}, {ValueType::float64, "MET_DOUBLE"}};
    return fmt::format(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\nCompressedData = False\n"
        "Offset = {}\nElementSpacing = {}\nDimSize = {} {} {}\nElementType = {}\nElementDataFile = {}\n",
        big() ? "True" : "False", in_mm(h.origin_m, 0.5, h.spacing_m), in_mm(h.spacing_m), h.voxels[0], h.voxels[1], h.voxels[2],
        names.at(h.type), data);
}

std::string nrrd_header(const VolumeHeader& h) {
    static const std::map<ValueType, const char*> names = {
        {ValueType::uint8, "uint8"},   {ValueType::int8, "int8"},   {ValueType::uint16, "uint16"}, {ValueType::int16, "int16"},
        {ValueType::uint32, "uint32"}, {ValueType::int32, "int32"}, {ValueType::float32, "float"}, {ValueType::float64, "double"}};
    const auto mm = [](double length_m) { return fmt::format("{:.10g}", 1e3 * length_m); };
    return fmt::format(
        "NRRD0004\ntype: {}\ndimension: 3\nspace dimension: 3\nsizes: {} {} {}\nspace directions: ({},0,0) (0,{},0) (0,0,{})\n"
        "space units: \"mm\" \"mm\" \"mm\"\nspace origin: ({},{},{})\nkinds: domain domain domain\nendian: {}\nencoding: raw\n\n",
        names.at(h.type), h.voxels[0], h.voxels[1], h.voxels[2], mm(h.spacing_m[0]), mm(h.spacing_m[1]), mm(h.spacing_m[2]),
        mm(h.origin_m[0] + 0.5 * h.spacing_m[0]), mm(h.origin_m[1] + 0.5 * h.spacing_m[1]), mm(h.origin_m[2] + 0.5 * h.spacing_m[2]),
        big() ? "big" : "little");
}

std::string npy_header(const VolumeHeader& h) {
    static const std::map<ValueType, const char*> names = {{ValueType::uint8, "|u1"},  {ValueType::int8, "|i1"},  {ValueType::uint16, "u2"},
                                                           {ValueType::int16, "i2"},   {ValueType::uint32, "u4"}, {ValueType::int32, "i4"},
                                                           {ValueType::float32, "f4"}, {ValueType::float64, "f8"}};
    std::string type = names.at(h.type);
    if (type[0] != '|') type.insert(0, big() ? ">" : "<");
    std::string text =
        fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}, {}, {}), }}", type, h.voxels[2], h.voxels[1], h.voxels[0]);
    // The format: magic (6 bytes), version (2), length of the text (2, little-endian), then the text, padded so that the data begin at a
    // multiple of 64 bytes.
    text.append(63 - (10 + text.size()) % 64, ' ');
    text += '\n';
    std::string head = "\x93NUMPY";
    head += std::string("\x01\x00", 2);
    head += static_cast<char>(text.size() & 0xFFU);
    head += static_cast<char>(text.size() >> 8U);
    return head + text;
}

std::string vti_header(const VolumeHeader& h) {
    static const std::map<ValueType, const char*> names = {
        {ValueType::uint8, "UInt8"},   {ValueType::int8, "Int8"},   {ValueType::uint16, "UInt16"},   {ValueType::int16, "Int16"},
        {ValueType::uint32, "UInt32"}, {ValueType::int32, "Int32"}, {ValueType::float32, "Float32"}, {ValueType::float64, "Float64"}};
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", h.voxels[0], h.voxels[1], h.voxels[2]);
    std::string text = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">\n"
        "<ImageData WholeExtent=\"{}\" Origin=\"{:.17g} {:.17g} {:.17g}\" Spacing=\"{:.17g} {:.17g} {:.17g}\">\n<Piece Extent=\"{}\">\n"
        "<CellData Scalars=\"value\"><DataArray type=\"{}\" Name=\"value\" format=\"appended\" offset=\"0\"/></CellData>\n"
        "</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_",
        big() ? "BigEndian" : "LittleEndian", extent, h.origin_m[0], h.origin_m[1], h.origin_m[2], h.spacing_m[0], h.spacing_m[1],
        h.spacing_m[2], extent, names.at(h.type));
    // Appended raw data begin after the underscore with their length in bytes (header_type UInt64).
    const std::uint64_t bytes = static_cast<std::uint64_t>(h.count()) * size_of(h.type);
    text.append(reinterpret_cast<const char*>(&bytes), sizeof(bytes));
    return text;
}

void write_layers(std::ofstream& file, const VolumeSource& source, const Path& path) {
    std::vector<float> layer(static_cast<std::size_t>(source.header.layer()));
    std::vector<char> bytes;
    Progress progress("image");
    for (std::int64_t z = 0; z < source.header.voxels[2]; ++z) {
        source.read(z, layer);
        to_bytes(layer, source.header.type, bytes);
        if (!file.write(bytes.data(), static_cast<std::streamsize>(bytes.size())))
            throw MachineError("cannot write " + path.string(), {.fix = "free some disk space, or choose another folder"});
        progress.update(static_cast<double>(z + 1) / static_cast<double>(source.header.voxels[2]));
    }
}

// Whether a MetaImage that is there names this file as its data.
bool names_data(const Path& header, const Path& data) {
    std::ifstream file(header);
    std::string line;
    for (int lines = 0; lines < 100 && std::getline(file, line); ++lines)
        if (line.starts_with("ElementDataFile")) return line.substr(line.find_last_of("= ") + 1) == data.filename().string();
    return false;
}

}  // namespace

VolumeSource cropped(VolumeSource source, const Box& box) {
    VolumeHeader header = source.header;
    for (std::size_t i = 0; i < 3; ++i) {
        if (box.low[i] < 0 || box.low[i] >= box.high[i] || box.high[i] > header.voxels[i])
            throw UserError(fmt::format("the box from {} to {} along {} is not in the image", box.low[i], box.high[i], "xyz"[i]),
                            {.allowed = fmt::format("0 <= low < high <= {}", header.voxels[i])});
        header.voxels[i] = box.high[i] - box.low[i];
        header.origin_m[i] += static_cast<double>(box.low[i]) * header.spacing_m[i];
    }
    header.notes.clear();  // the container and the section of the whole image
    header.own_phases = header.own_fractions = false;
    const std::int64_t wide = source.header.voxels[0], layer = source.header.layer();
    VolumeSource part{.header = header, .memory_bytes = source.memory_bytes};
    part.read = [source = std::move(source), box, n = header.voxels, wide, layer](std::int64_t first, std::span<float> values) {
        std::vector<float> whole(static_cast<std::size_t>(layer));
        auto to = values.begin();
        for (std::int64_t z = first; to != values.end(); ++z) {
            source.read(box.low[2] + z, whole);
            for (std::int64_t y = 0; y < n[1]; ++y) to = std::copy_n(whole.begin() + (box.low[1] + y) * wide + box.low[0], n[0], to);
        }
    };
    return part;
}

VolumeSource binned(VolumeSource source, std::int64_t factor) {
    const VolumeHeader whole = source.header;
    VolumeHeader header = whole;
    const std::int64_t smallest = *std::min_element(whole.voxels.begin(), whole.voxels.end());
    if (factor < 2 || factor > smallest)
        throw UserError(fmt::format("a factor of {} is not possible", factor), {.allowed = fmt::format("2 to {}", smallest)});
    for (std::size_t i = 0; i < 3; ++i) {
        header.voxels[i] /= factor;
        header.spacing_m[i] *= static_cast<double>(factor);
    }
    header.type = ValueType::float32;
    header.notes.clear();
    header.own_phases = header.own_fractions = false;
    VolumeSource part{.header = header, .memory_bytes = source.memory_bytes};
    part.read = [source = std::move(source), whole, n = header.voxels, factor](std::int64_t first, std::span<float> values) {
        std::vector<float> layer(static_cast<std::size_t>(whole.layer()));
        std::vector<double> sums(static_cast<std::size_t>(n[0] * n[1]));
        auto to = values.begin();
        for (std::int64_t z = first; to != values.end(); ++z) {
            std::fill(sums.begin(), sums.end(), 0.0);
            for (std::int64_t k = 0; k < factor; ++k) {
                source.read(z * factor + k, layer);
                for (std::int64_t y = 0; y < n[1] * factor; ++y)
                    for (std::int64_t x = 0; x < n[0] * factor; ++x)
                        sums[static_cast<std::size_t>(y / factor * n[0] + x / factor)] +=
                            layer[static_cast<std::size_t>(y * whole.voxels[0] + x)];
            }
            const double volume = static_cast<double>(factor * factor * factor);
            to = std::transform(sums.begin(), sums.end(), to, [&](double sum) { return static_cast<float>(sum / volume); });
        }
    };
    return part;
}

VolumeSource source_of(const Grid& grid, const std::vector<float>& values) {
    VolumeSource source;
    for (std::size_t a = 0; a < 3; ++a) {
        source.header.voxels[a] = grid.cells[a];
        source.header.spacing_m[a] = grid.spacing_m[a];
        source.header.origin_m[a] = grid.origin_m[a];
    }
    source.header.type = ValueType::float32;
    source.header.format = "computed";
    source.header.orientation = "z along the axis of the container";
    source.read = [&values, layer = grid.index(0, 0, 1)](std::int64_t first, std::span<float> to) {
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(first) * layer), to.size(), to.begin());
    };
    return source;
}

void write_volume(const Path& path, const VolumeSource& source) {
    const std::string kind = path.extension().string();
    const Path data = kind == ".mhd" ? Path(path).replace_extension(".raw") : path;
    std::string head;
    if (kind == ".nrrd") head = nrrd_header(source.header);
    if (kind == ".npy") head = npy_header(source.header);
    if (kind == ".vti") head = vti_header(source.header);
    if (head.empty() && kind != ".raw" && kind != ".mhd")
        throw UserError("images are not written as " + path.string(), {.allowed = ".raw, .mhd, .nrrd, .npy, .vti"});
    if (fs::is_directory(path)) throw UserError("a folder has this name: " + path.string(), {.fix = "choose another name"});
    if (kind == ".mhd" && (data.filename().string().starts_with("LIST") || data.filename().string().find('%') != std::string::npos))
        throw UserError("MetaImage gives such a name a meaning: " + data.filename().string(), {.fix = "choose a name without % and LIST"});
    for (const Path& written : {path, data}) {
        if (!fs::exists(written)) continue;
        for (const Path& read : source.header.files)
            if (fs::exists(read) && fs::equivalent(written, read))
                throw UserError("the image would be written over itself: " + written.string(), {.fix = "choose another name"});
        // The pair of an earlier run may be replaced; a .raw file that does not belong to this header may not.
        if (written == data && kind == ".mhd" && !names_data(path, data))
            throw UserError("the values of the image would be written over another file: " + data.string(), {.fix = "choose another name"});
    }
    write_whole(data, [&](const Path& name) {
        std::ofstream file(name, std::ios::binary);
        file << head;
        write_layers(file, source, data);
        if (kind == ".vti") file << "\n</AppendedData>\n</VTKFile>\n";
        file.close();
        if (!file) throw MachineError("cannot write " + data.string(), {.fix = "free some disk space, or choose another folder"});
    });
    // Last, when the values that it names are complete.
    if (kind == ".mhd") write_text(path, mhd_header(source.header, data.filename().string()));
}

}  // namespace porepack::imaging
