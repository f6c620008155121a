// Raw files, and those of NumPy.
#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <map>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/values_of_file.hpp"

namespace porepack::imaging {
using namespace core;
namespace fs = std::filesystem;

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
    read_values(volume, {.path = path,
                         .packed = path.extension() == ".gz",
                         .skip = static_cast<std::uint64_t>(config.header_bytes),
                         .big_endian = config.byte_order == ByteOrder::big});
    return volume;
}

// NumPy's format 1 to 3: magic, version, length of the header, and a Python dictionary as text.
FileVolume open_npy(const Path& path) {
    const auto fail = [&](const std::string& what) -> void {
        throw UserError("not a NumPy array of three dimensions: " + what,
                        {.where = path.string(), .allowed = "b1, u1, i1, u2, i2, u4, i4, f4, f8 in C or Fortran order"});
    };
    std::ifstream file(path, std::ios::binary);
    unsigned char start[12] = {};
    if (!fs::is_regular_file(path) || !file.read(reinterpret_cast<char*>(start), sizeof start)) fail("its first bytes");
    if (std::string(reinterpret_cast<char*>(start), 6) != "\x93NUMPY" || start[6] < 1 || start[6] > 3) fail("its first bytes");
    const std::uint64_t head = start[6] == 1 ? 10 : 12;
    std::uint64_t length = start[8] + 256U * start[9];
    if (start[6] > 1) length += 65536U * start[10] + 16777216U * start[11];
    if (length > 65536) fail("its header is too long");
    std::string text(length, ' ');
    file.seekg(static_cast<std::streamoff>(head));
    if (!file.read(text.data(), static_cast<std::streamsize>(length))) fail("it ends in its header");
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
    read_values(volume, {.path = path, .start = head + length, .big_endian = descr[1] == '>'});
    return volume;
}

}  // namespace porepack::imaging
