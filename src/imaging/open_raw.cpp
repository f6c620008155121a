// Raw files, and those of NumPy.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/values_of_file.hpp"

namespace porepack::imaging {
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

namespace {

// The dictionary in the header of a NumPy file, a Python literal: {'descr': '<u2', 'fortran_order': False, 'shape': (12, 18, 26), }
class NumpyHeader {
public:
    std::string type;
    bool fortran = false;
    std::vector<long long> shape;

    // The reason if it is not understood.
    std::string parse(const std::string& text) {
        text_ = text;
        bool known[3] = {false, false, false};
        if (!take('{')) return "its header is no dictionary";
        while (!take('}')) {
            std::string key;
            if (!string(key) || !take(':')) return "its header is damaged";
            const int which = key == "descr" ? 0 : key == "fortran_order" ? 1 : key == "shape" ? 2 : 3;
            if (which == 3 || known[which])
                return fmt::format("its header has {} \"{}\"", which == 3 ? "a key" : "twice", key.substr(0, 20));
            known[which] = true;
            if (which == 0 && !string(type)) return "its values are records, not numbers";
            if (which == 1 && !truth()) return "fortran_order is neither True nor False";
            if (which == 2 && !tuple()) return "its shape is not understood";
            if (!take(',') && peek() != '}') return "its header is damaged";
        }
        for (const bool one : known)
            if (!one) return "its header names not all of descr, fortran_order and shape";
        return peek() == '\0' ? std::string() : "text follows its header";
    }

private:
    char peek() {
        while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(char c) { return peek() == c && c != '\0' && ++at_ > 0; }
    bool string(std::string& into) {
        const char quote = peek();
        if (quote != '\'' && quote != '"') return false;
        const std::size_t end = text_.find(quote, at_ + 1);
        if (end == std::string::npos) return false;
        into = text_.substr(at_ + 1, end - at_ - 1);
        at_ = end + 1;
        return true;
    }
    bool truth() {
        peek();
        fortran = text_.compare(at_, 4, "True") == 0;
        if (!fortran && text_.compare(at_, 5, "False") != 0) return false;
        at_ += fortran ? 4 : 5;
        return true;
    }
    bool tuple() {
        if (!take('(')) return false;
        while (!take(')')) {
            peek();
            long long number = 0;
            const auto [end, fault] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
            if (fault != std::errc() || number < 1 || number > 1000000000) return false;
            at_ = static_cast<std::size_t>(end - text_.data());
            take('L');  // of Python 2
            shape.push_back(number);
            if (!take(',') && peek() != ')') return false;
        }
        return true;
    }

    std::string text_;
    std::size_t at_ = 0;
};

}  // namespace

// NumPy's format 1 to 3: magic, version, length of the header, and a Python dictionary as text.
FileVolume open_npy(const Path& path) {
    const auto fail = [&](const std::string& what, const std::string& fix = {}) -> void {
        throw UserError("not a NumPy array of three dimensions: " + what,
                        {.where = path.string(), .allowed = "b1, u1, i1, u2, i2, u4, i4, f4, f8 in C or Fortran order", .fix = fix});
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
    NumpyHeader header;
    if (const std::string fault = header.parse(text); !fault.empty()) fail(fault);
    const std::vector<long long>& n = header.shape;
    if (n.size() != 3)
        fail(fmt::format("its shape is ({})", fmt::join(n, ", ")),
             "save one channel as an array of three dimensions: numpy.save(file, a[..., 0])");
    FileVolume volume;
    static const std::map<std::string, ValueType> types = {
        {"b1", ValueType::uint8},  {"u1", ValueType::uint8},   {"i1", ValueType::int8},
        {"u2", ValueType::uint16}, {"i2", ValueType::int16},   {"u4", ValueType::uint32},
        {"i4", ValueType::int32},  {"f4", ValueType::float32}, {"f8", ValueType::float64}};
    const auto type = header.type.empty() ? types.end() : types.find(header.type.substr(1));
    if (type == types.end() || std::string("<>|=").find(header.type[0]) == std::string::npos)
        fail(fmt::format("its type is '{}'", header.type.substr(0, 12)), "convert it, for instance a.astype('float32')");
    if (header.type[0] == '|' && size_of(type->second) > 1) fail("its type has no byte order");
    volume.type = type->second;
    for (std::size_t i = 0; i < 3; ++i) volume.voxels[header.fortran ? i : 2 - i] = n[i];
    if (static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]) > 1e15) fail("so many values");
    volume.format =
        fmt::format("NumPy, {}, {} order (shape {}, {}, {})", name_of(volume.type), header.fortran ? "Fortran" : "C", n[0], n[1], n[2]);
    read_values(volume, {.path = path, .start = head + length, .big_endian = header.type[0] == '>'});
    return volume;
}

}  // namespace porepack::imaging
