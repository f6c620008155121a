#include "io/vti_file.hpp"

#include <fmt/format.h>
#include <vtkBase64InputStream.h>
#include <vtkBase64Utilities.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkZLibDataCompressor.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/error.hpp"

namespace porepack::io {
namespace {

[[noreturn]] void refuse_length(const Path& path, const std::string& field, bool fewer, std::uint64_t wanted) {
    throw UserError(fmt::format("the array `{}` has {} values than the image", field, fewer ? "fewer" : "more"),
                    {.where = path.string(), .allowed = fmt::format("{} values", wanted), .fix = "write the file again"});
}

// Base64 text from `at` on: so many letters without gaps, then padding. VTK takes other signs as zeros, and gaps shift all that follows.
void require_base64(File& file, std::streamoff at, std::uint64_t bytes, const std::string& field) {
    const std::uint64_t letters = (4 * bytes + 2) / 3;
    const std::string padding(static_cast<std::size_t>((3 - bytes % 3) % 3), '=');
    const auto is_letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '+' || c == '/'; };
    file.stream.clear();
    file.stream.seekg(at);
    std::string block;
    for (std::uint64_t done = 0; done < letters; done += block.size()) {
        block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(letters - done, 1U << 20U)));
        if (!file.stream.read(block.data(), static_cast<std::streamsize>(block.size())) ||
            !std::all_of(block.begin(), block.end(), is_letter))
            refuse(file.path, fmt::format("the base64 text of the array `{}` has gaps or other signs, or ends early", field));
    }
    block.assign(padding.size(), ' ');
    if (!file.stream.read(block.data(), static_cast<std::streamsize>(block.size())) || block != padding)
        refuse(file.path, fmt::format("the base64 text of the array `{}` does not end where its length says", field));
}

}  // namespace

void refuse(const Path& path, const std::string& what) {
    throw UserError("the image cannot be read: " + what, {.where = path.string(), .fix = "the file may be incomplete: write it again"});
}

std::size_t File::read_apart(const Piece& piece, char* into, std::uint64_t start, std::size_t count) {
    const std::uint64_t words = piece.values();
    count = start < words ? static_cast<std::size_t>(std::min<std::uint64_t>(count, words - start)) : 0;
    stream.clear();
    stream.seekg(piece.apart_at);
    vtkNew<vtkBase64InputStream> decoder;
    decoder->SetStream(&stream);
    decoder->StartReading();
    std::size_t got = 0;
    if (decoder->Seek(static_cast<vtkTypeInt64>(start * word.bytes)) == 1) got = decoder->Read(into, count * word.bytes) / word.bytes;
    decoder->EndReading();
    if (parser->big_endian())
        for (std::size_t i = 0; i < got; ++i) std::reverse(into + i * word.bytes, into + (i + 1) * word.bytes);
    return got;
}

// From text that has been read as double, for VTK takes 300 as 44 in UInt8, and passes over what follows the last value.
std::size_t File::read_ascii(const Piece& piece, char* into, std::uint64_t start, std::size_t count) const {
    const std::size_t got = start < piece.values() ? static_cast<std::size_t>(std::min<std::uint64_t>(count, piece.values() - start)) : 0;
    const double* values = piece.ascii_values.data() + start;
    const auto put = [&](auto kind) {
        for (std::size_t i = 0; i < got; ++i) {
            const auto value = static_cast<decltype(kind)>(values[i]);
            std::memcpy(into + i * sizeof value, &value, sizeof value);
        }
    };
    switch (word.vtk) {
        case VTK_TYPE_INT8:
            put(std::int8_t{});
            break;
        case VTK_TYPE_UINT8:
            put(std::uint8_t{});
            break;
        case VTK_TYPE_INT16:
            put(std::int16_t{});
            break;
        case VTK_TYPE_UINT16:
            put(std::uint16_t{});
            break;
        case VTK_TYPE_INT32:
            put(std::int32_t{});
            break;
        case VTK_TYPE_UINT32:
            put(std::uint32_t{});
            break;
        case VTK_TYPE_FLOAT32:
            put(float{});
            break;
        default:
            put(double{});
    }
    return got;
}

void set_compressor(File& file, vtkXMLDataElement* root, std::string& storage) {
    const char* name = root->GetAttribute("compressor");
    if (name == nullptr) return;
    const std::string text = name;
    if (text == "vtkZLibDataCompressor")
        file.parser->SetCompressor(vtkNew<vtkZLibDataCompressor>());
    else if (text == "vtkLZ4DataCompressor")
        file.parser->SetCompressor(vtkNew<vtkLZ4DataCompressor>());
    else if (text == "vtkLZMADataCompressor")
        file.parser->SetCompressor(vtkNew<vtkLZMADataCompressor>());
    else
        refuse(file.path, "its compressor " + text + " is not known");
    storage += ", " + text;
}

void read_ascii_values(File& file, Piece& piece, const std::string& field) {
    file.stream.clear();
    file.stream.seekg(file.parser->inline_data_at(piece.array));
    std::string text;
    for (bool ended = false; !ended && file.stream >> text;) {
        const std::size_t end = text.find('<');
        ended = end != std::string::npos;
        if (ended) text.resize(end);
        if (text.empty()) continue;
        double value = 0.0;
        const auto [stop, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (fault != std::errc() || stop != text.data() + text.size())
            refuse(file.path, fmt::format("\"{}\" in the array `{}` is no number", text.substr(0, 20), field));
        const WordType& word = file.word;
        if (word.low != word.high && (value != std::floor(value) || value < word.low || value > word.high))
            throw UserError(
                fmt::format("value {} of the array `{}`, of the type {}, is {:g}", piece.ascii_values.size(), field, word.name, value),
                {.where = file.path.string(), .allowed = fmt::format("whole numbers from {:.0f} to {:.0f}", word.low, word.high)});
        if (piece.ascii_values.size() == piece.values()) refuse_length(file.path, field, false, piece.values());
        piece.ascii_values.push_back(value);
    }
    if (piece.ascii_values.size() < piece.values()) refuse_length(file.path, field, true, piece.values());
}

void find_base64_data(File& file, Piece& piece, const std::string& field) {
    const std::size_t bytes = file.parser->header_bytes(), letters = bytes == 4 ? 8 : 12;
    const std::streamoff at =
        piece.appended ? file.parser->GetAppendedDataPosition() + piece.offset : file.parser->inline_data_at(piece.array);
    std::string text(letters, ' ');
    file.stream.clear();
    file.stream.seekg(at);
    std::array<unsigned char, 16> decoded{};
    if (!file.stream.read(text.data(), static_cast<std::streamsize>(letters)) ||
        vtkBase64Utilities::DecodeSafely(reinterpret_cast<const unsigned char*>(text.data()), letters, decoded.data(), decoded.size()) <
            bytes)
        refuse(file.path, fmt::format("the base64 text of the array `{}` is damaged", field));
    if (file.parser->big_endian()) std::reverse(decoded.begin(), decoded.begin() + static_cast<std::ptrdiff_t>(bytes));
    std::uint64_t length = 0;
    for (std::size_t i = bytes; i-- > 0;) length = length << 8U | decoded[i];
    const std::uint64_t wanted = piece.values() * file.word.bytes;
    if (length != wanted) refuse_length(file.path, field, length < wanted, piece.values());
    const bool apart = text.ends_with(bytes == 4 ? "==" : "=");
    if (apart) piece.apart_at = at + static_cast<std::streamoff>(letters);
    if (apart) {
        require_base64(file, at, bytes, field);
        require_base64(file, piece.apart_at, length, field);
    } else {
        require_base64(file, at, bytes + length, field);
    }
}

void require_length(File& file, const Piece& piece, const std::string& field) {
    std::vector<char> two(2 * file.word.bytes);
    if (const std::size_t got = file.read(piece, two.data(), static_cast<std::int64_t>(piece.values()) - 1, 2); got != 1)
        refuse_length(file.path, field, got == 0, piece.values());
}

}  // namespace porepack::io
