// Files whose values follow each other without structure: raw, .npy, MetaImage, NRRD.
#include <fmt/format.h>
#include <zlib.h>

#include <bit>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {
using namespace core;
namespace fs = std::filesystem;
namespace {

constexpr std::size_t block_bytes = std::size_t{1} << 22;

// The bytes of a file from `start` on, or of what is packed there by gzip or zlib.
class Bytes {
public:
    Bytes(Path path, std::uint64_t start, bool packed)
        : path_(std::move(path)), start_(start), packed_(packed), input_(packed ? chunk : 0) {
        if (!fs::is_regular_file(path_)) throw UserError("not a regular file: " + path_.string());
        file_.open(path_, std::ios::binary);
        if (!file_) throw UserError("the file cannot be opened: " + path_.string());
        if (packed_) rewind();
    }
    ~Bytes() { inflateEnd(&stream_); }
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;
    [[nodiscard]] bool packed() const { return packed_; }

    void read(std::uint64_t at, char* into, std::size_t count) {
        if (packed_) {
            if (at < position_) rewind();
            std::vector<char> skipped(std::min<std::uint64_t>(chunk, at - position_));
            while (position_ < at)
                if (unpack(skipped.data(), std::min<std::uint64_t>(skipped.size(), at - position_)) == 0) too_short();
            while (count > 0) {
                const std::size_t got = unpack(into, count);
                if (got == 0) too_short();
                into += got;
                count -= got;
            }
            return;
        }
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(start_ + at));
        if (!file_.read(into, static_cast<std::streamsize>(count))) too_short();
    }

    // True if nothing follows.
    bool ends_at(std::uint64_t at) {
        if (!packed_) return fs::file_size(path_) == start_ + at;
        char one = 0;
        return position_ == at && unpack(&one, 1) == 0;
    }

private:
    static constexpr std::size_t chunk = std::size_t{1} << 18;

    void rewind() {
        inflateEnd(&stream_);
        stream_ = {};
        if (inflateInit2(&stream_, 15 + 32) != Z_OK) throw MachineError("not enough memory to unpack " + path_.string());  // gzip or zlib
        file_.clear();
        file_.seekg(static_cast<std::streamoff>(start_));
        position_ = 0;
        ended_ = false;
    }

    // 0 at the end of the packed bytes.
    std::size_t unpack(char* into, std::size_t count) {
        stream_.next_out = reinterpret_cast<Bytef*>(into);
        stream_.avail_out = static_cast<uInt>(std::min(count, block_bytes));
        const uInt asked = stream_.avail_out;
        while (!ended_ && stream_.avail_out == asked) {
            if (stream_.avail_in == 0) {
                file_.read(input_.data(), static_cast<std::streamsize>(input_.size()));
                stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
                stream_.avail_in = static_cast<uInt>(file_.gcount());
                if (stream_.avail_in == 0) too_short();
            }
            const int state = inflate(&stream_, Z_NO_FLUSH);
            if (state == Z_STREAM_END)  // several gzip members may follow each other
                ended_ = stream_.avail_in == 0 && file_.peek() == std::ifstream::traits_type::eof();
            else if (state != Z_OK)
                too_short();
            if (state == Z_STREAM_END && !ended_ && inflateReset(&stream_) != Z_OK) too_short();
        }
        const std::size_t got = asked - stream_.avail_out;
        position_ += got;
        return got;
    }

    [[noreturn]] void too_short() const {
        throw UserError("the image ends before its last voxel, or is damaged: " + path_.string(), {.fix = "write it again"});
    }

    Path path_;
    std::uint64_t start_, position_ = 0;
    bool packed_, ended_ = false;
    std::ifstream file_;
    std::vector<char> input_;
    z_stream stream_ = {};
};

// `swapped`: the bytes of a value are in the other order than the machine's.
void read_values(FileVolume& volume, const Path& path, const std::shared_ptr<Bytes>& bytes, std::uint64_t start, bool swapped) {
    volume.sequential = bytes->packed();
    volume.files.push_back(path);
    const std::uint64_t size = size_of(volume.type), layer = static_cast<std::uint64_t>(volume.voxels[0] * volume.voxels[1]);
    const std::uint64_t end = start + size * layer * static_cast<std::uint64_t>(volume.voxels[2]);
    if (!bytes->packed() && !bytes->ends_at(end))
        throw UserError(fmt::format("the data have {} bytes, and {} x {} x {} values of {} bytes are {}",
                                    fs::file_size(path) - std::min<std::uintmax_t>(start, fs::file_size(path)), volume.voxels[0],
                                    volume.voxels[1], volume.voxels[2], size, end - start),
                        {.where = path.string(),
                         .fix = "correct the header, or of a raw file --image-dims, --image-type or --image-header-bytes; or the file is "
                                "incomplete"});
    volume.read = [=, type = volume.type](std::int64_t first, std::span<float> values) {
        const std::size_t at_once = std::max<std::size_t>(1, block_bytes / size);
        std::vector<char> block(std::min(values.size(), at_once) * size);
        std::uint64_t at = start + size * layer * static_cast<std::uint64_t>(first);
        for (std::size_t done = 0; done < values.size();) {
            const std::size_t count = std::min(at_once, values.size() - done);
            bytes->read(at, block.data(), count * size);
            if (swapped) swap_bytes(block.data(), size, count);
            to_float(block.data(), type, values.subspan(done, count), path);
            at += count * size;
            done += count;
        }
        if (bytes->packed() && at == end && !bytes->ends_at(end))
            throw UserError("bytes follow the last voxel", {.where = path.string(), .fix = "correct --image-dims or --image-type"});
    };
}

bool machine_is_big() {
    return std::endian::native == std::endian::big;
}

}  // namespace

FileVolume open_raw(const Path& path, const ImageConfig& config) {
    if (config.dims.empty())
        throw UserError(
            "a raw file needs the number of voxels along its axes",
            {.where = path.string(), .fix = "--image-dims NX,NY,NZ --image-type uint8, and --image-axes if x is not the fastest axis"});
    FileVolume volume{.type = config.type,
                      .format = fmt::format("raw, {}, {} byte order", name_of(config.type), name_of(config.byte_order))};
    double total = static_cast<double>(size_of(config.type));
    for (std::size_t i = 0; i < 3; ++i) {
        if (config.dims[i] != std::floor(config.dims[i]))
            throw UserError(fmt::format("{:g} is no number of voxels", config.dims[i]), {.where = "--image-dims"});
        volume.voxels[i] = static_cast<std::int64_t>(config.dims[i]);
        total *= config.dims[i];
    }
    if (total > 1e18) throw UserError("so many voxels are no image", {.where = "--image-dims"});
    read_values(volume, path, std::make_shared<Bytes>(path, 0, path.extension() == ".gz"), static_cast<std::uint64_t>(config.header_bytes),
                (config.byte_order == ByteOrder::big) != machine_is_big());
    return volume;
}

// NumPy's format 1 to 3: magic, version, length of the header, and a Python dictionary as text.
FileVolume open_npy(const Path& path) {
    const auto bytes = std::make_shared<Bytes>(path, 0, false);
    unsigned char start[12] = {};
    const auto fail = [&](const std::string& what) -> void {
        throw UserError("not a NumPy array of three dimensions: " + what,
                        {.where = path.string(), .allowed = "b1, u1, i1, u2, i2, u4, i4, f4, f8 in C or Fortran order"});
    };
    bytes->read(0, reinterpret_cast<char*>(start), 12);
    if (std::string(reinterpret_cast<char*>(start), 6) != "\x93NUMPY" || start[6] < 1 || start[6] > 3) fail("its first bytes");
    const std::uint64_t head = start[6] == 1 ? 10 : 12;
    std::uint64_t length = start[8] + 256U * start[9];
    if (start[6] > 1) length += 65536U * start[10] + 16777216U * start[11];
    if (length > 65536) fail("its header is too long");
    std::string text(length, ' ');
    bytes->read(head, text.data(), length);
    const auto value = [&](const char* key) {
        const std::size_t at = text.find(key);
        if (at == std::string::npos) fail(fmt::format("its header has no {}", key));
        std::size_t from = text.find(':', at);
        from = from == std::string::npos ? text.size() : text.find_first_not_of(' ', from + 1);
        return from == std::string::npos ? std::string() : text.substr(from);
    };
    FileVolume volume;
    const std::string descr = value("'descr'");
    static const std::map<std::string, ValueType> types = {
        {"b1", ValueType::uint8},  {"u1", ValueType::uint8},   {"i1", ValueType::int8},
        {"u2", ValueType::uint16}, {"i2", ValueType::int16},   {"u4", ValueType::uint32},
        {"i4", ValueType::int32},  {"f4", ValueType::float32}, {"f8", ValueType::float64}};
    const auto type = descr.size() > 4 && descr[0] == '\'' ? types.find(descr.substr(2, 2)) : types.end();
    if (type == types.end() || descr[4] != '\'') fail("its type is " + descr.substr(0, 8));
    volume.type = type->second;
    const bool big = descr[1] == '>';
    const bool fortran = value("'fortran_order'").starts_with("True");
    long long n[3] = {0, 0, 0};
    char close = 0;
    if (std::sscanf(value("'shape'").c_str(), "(%lld, %lld, %lld%c", &n[0], &n[1], &n[2], &close) != 4 || (close != ')' && close != ','))
        fail("its shape is " + value("'shape'").substr(0, 24));
    for (std::size_t i = 0; i < 3; ++i) {
        if (n[i] < 1 || n[i] > 1000000000) fail("its shape");
        volume.voxels[fortran ? i : 2 - i] = n[i];
    }
    if (static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]) > 1e15) fail("so many values");
    volume.format =
        fmt::format("NumPy, {}, {} order (shape {}, {}, {})", name_of(volume.type), fortran ? "Fortran" : "C", n[0], n[1], n[2]);
    read_values(volume, path, bytes, head + length, big != machine_is_big() && size_of(volume.type) > 1);
    return volume;
}

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
    read_values(volume, data, std::make_shared<Bytes>(data, packed ? start : 0, packed), packed ? 0 : start,
                big != machine_is_big() && size_of(volume.type) > 1);
    return volume;
}

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
    read_values(volume, data, std::make_shared<Bytes>(data, packed ? start : 0, packed), packed ? 0 : start,
                size_of(volume.type) > 1 && (endian == "big") != machine_is_big());
    return volume;
}

}  // namespace porepack::imaging
