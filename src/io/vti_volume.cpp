#include "io/vti_volume.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vtkBase64InputStream.h>
#include <vtkBase64Utilities.h>
#include <vtkDataArraySelection.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkStringArray.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>
#include <vtkXMLImageDataReader.h>
#include <vtkZLibDataCompressor.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

#include "core/error.hpp"

namespace porepack::io {
using namespace core;
namespace {

[[noreturn]] void refuse(const Path& path, const std::string& what) {
    throw UserError("the image cannot be read: " + what, {.where = path.string(), .fix = "the file may be incomplete: write it again"});
}

struct WordType {
    const char* name;
    int vtk;
    std::size_t bytes;
    double low, high;  // of whole numbers; 0: any number
};
constexpr WordType word_types[] = {{"Int8", VTK_TYPE_INT8, 1, -128, 127},
                                   {"UInt8", VTK_TYPE_UINT8, 1, 0, 255},
                                   {"Int16", VTK_TYPE_INT16, 2, -32768, 32767},
                                   {"UInt16", VTK_TYPE_UINT16, 2, 0, 65535},
                                   {"Int32", VTK_TYPE_INT32, 4, -2147483648.0, 2147483647.0},
                                   {"UInt32", VTK_TYPE_UINT32, 4, 0, 4294967295.0},
                                   {"Float32", VTK_TYPE_FLOAT32, 4, 0, 0},
                                   {"Float64", VTK_TYPE_FLOAT64, 8, 0, 0}};

// VTK's parser without elements nested so deep that they exhaust the stack.
class Parser : public vtkXMLDataParser {
public:
    static Parser* New() { VTK_STANDARD_NEW_BODY(Parser); }
    vtkTypeMacro(Parser, vtkXMLDataParser);

    [[nodiscard]] bool too_deep() const { return too_deep_; }
    [[nodiscard]] bool big_endian() const { return ByteOrder == vtkXMLDataParser::BigEndian; }
    [[nodiscard]] std::size_t header_bytes() const { return HeaderType == 64 ? 8 : 4; }
    std::streamoff inline_data_at(vtkXMLDataElement* array) {
        SeekInlineDataPosition(array);
        return Stream->tellg();
    }

protected:
    void StartElement(const char* name, const char** attributes) override {
        if (++depth_ <= deepest)
            vtkXMLDataParser::StartElement(name, attributes);
        else
            too_deep_ = true;
    }
    void EndElement(const char* name) override {
        if (depth_-- <= deepest) vtkXMLDataParser::EndElement(name);
    }

private:
    static constexpr int deepest = 20;
    int depth_ = 0;
    bool too_deep_ = false;
};

struct Piece {
    std::array<std::int64_t, 3> low, count;  // of values
    vtkXMLDataElement* array;
    bool ascii, appended;
    vtkTypeInt64 offset;
    // Base64 data whose length is encoded apart from them; VTK expects both in one.
    std::streamoff apart_at;
    std::vector<double> ascii_values;

    [[nodiscard]] std::uint64_t values() const { return static_cast<std::uint64_t>(count[0] * count[1] * count[2]); }
};

// The parsed file; elements belong to the parser.
struct File {
    std::ifstream stream;
    vtkNew<Parser> parser;
    Path path;
    WordType word = word_types[0];
    std::vector<Piece> pieces;

    // Number of values read.
    std::size_t read(const Piece& piece, char* into, std::int64_t start, std::size_t count) {
        const auto from = static_cast<vtkTypeUInt64>(start);
        if (piece.apart_at > 0) return read_apart(piece, into, from, count);
        if (piece.ascii) return read_ascii(piece, into, from, count);
        return piece.appended ? parser->ReadAppendedData(piece.offset, into, from, count, word.vtk)
                              : parser->ReadInlineData(piece.array, 0, into, from, count, word.vtk);
    }

private:
    std::size_t read_apart(const Piece& piece, char* into, std::uint64_t start, std::size_t count);
    std::size_t read_ascii(const Piece& piece, char* into, std::uint64_t start, std::size_t count) const;
};

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

template <typename Number, std::size_t count>
std::array<Number, count> numbers_of(vtkXMLDataElement* element, const char* name, const Path& path, const char* standard = nullptr) {
    const char* text = element->GetAttribute(name);
    if (text == nullptr) text = standard;
    std::array<Number, count> numbers{};
    std::istringstream words(text == nullptr ? "" : text);
    for (Number& number : numbers)
        if (!(words >> number)) refuse(path, fmt::format("{} is not {} numbers", name, count));
    std::string more;
    if (words >> more) refuse(path, fmt::format("{} is not {} numbers", name, count));
    return numbers;
}

std::vector<vtkXMLDataElement*> children(vtkXMLDataElement* element, const char* name) {
    std::vector<vtkXMLDataElement*> found;
    for (int i = 0; element != nullptr && i < element->GetNumberOfNestedElements(); ++i)
        if (std::string(element->GetNestedElement(i)->GetName()) == name) found.push_back(element->GetNestedElement(i));
    return found;
}

std::vector<vtkXMLDataElement*> arrays_of(vtkXMLDataElement* piece, bool at_points) {
    const auto data = children(piece, at_points ? "PointData" : "CellData");
    return data.empty() ? std::vector<vtkXMLDataElement*>() : children(data.front(), "DataArray");
}

std::string name_of_array(vtkXMLDataElement* array) {
    const char* name = array->GetAttribute("Name");
    return name == nullptr ? std::string() : name;
}

// Which array: that of the name, `phase`, or the only one; and where its values are.
std::pair<std::string, bool> choose_array(vtkXMLDataElement* piece, const std::string& wanted, const Path& path) {
    std::vector<std::pair<std::string, bool>> all;
    for (const bool at_points : {false, true})
        for (vtkXMLDataElement* array : arrays_of(piece, at_points)) {
            const char* components = array->GetAttribute("NumberOfComponents");
            if (components == nullptr || std::string(components) == "1" || std::string(components) == "0")
                all.emplace_back(name_of_array(array), at_points);
        }
    for (const std::string& name : {wanted, wanted.empty() ? std::string("phase") : std::string()})
        for (const auto& one : all)
            if (!name.empty() && one.first == name) return one;
    if (wanted.empty() && all.size() == 1) return all.front();
    std::vector<std::string> names;
    for (const auto& one : all) names.push_back(one.first);
    throw UserError(wanted.empty() ? fmt::format("the image has {} arrays of one value per cell or point", all.size())
                                   : fmt::format("the image has no array `{}` of one value per cell or point", wanted),
                    {.where = path.string(), .allowed = fmt::format("{}", fmt::join(names, ", ")), .fix = "--image-field NAME"});
}

// "0 9 0 9 0 19": points; `low` and number of values.
void take_extent(vtkXMLDataElement* element, const char* name, bool at_points, std::array<std::int64_t, 3>& low,
                 std::array<std::int64_t, 3>& count, const Path& path) {
    const auto extent = numbers_of<std::int64_t, 6>(element, name, path);
    for (std::size_t i = 0; i < 3; ++i) {
        low[i] = extent[2 * i];
        count[i] = extent[2 * i + 1] - extent[2 * i] + (at_points ? 1 : 0);
        if (count[i] < 1 || count[i] > 1000000000 || std::abs(low[i]) > 1000000000)
            refuse(path, fmt::format("{} has no {} along axis {}", name, at_points ? "points" : "cells", i));
    }
}

// Pieces may share points, but not cells, and must fill the whole.
void require_cover(const std::vector<Piece>& pieces, const std::array<std::int64_t, 3>& low, const std::array<std::int64_t, 3>& count,
                   bool at_points, const Path& path) {
    const std::int64_t shared = at_points ? 1 : 0;
    const auto volume = [&](const std::array<std::int64_t, 3>& n) {
        double product = 1.0;
        for (const std::int64_t one : n) product *= static_cast<double>(std::max<std::int64_t>(1, one - shared));
        return product;
    };
    double sum = 0.0;
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        for (std::size_t i = 0; i < 3; ++i)
            if (pieces[p].low[i] < low[i] || pieces[p].low[i] + pieces[p].count[i] > low[i] + count[i])
                refuse(path, fmt::format("piece {} reaches beyond WholeExtent", p + 1));
        for (std::size_t q = 0; q < p; ++q) {
            bool overlap = true;
            for (std::size_t i = 0; i < 3; ++i)
                overlap = overlap && pieces[p].low[i] < pieces[q].low[i] + pieces[q].count[i] - shared &&
                          pieces[q].low[i] < pieces[p].low[i] + pieces[p].count[i] - shared;
            if (overlap) refuse(path, fmt::format("pieces {} and {} overlap", q + 1, p + 1));
        }
        sum += volume(pieces[p].count);
    }
    if (sum != volume(count)) refuse(path, "its pieces do not fill WholeExtent");
}

std::map<std::string, std::string> notes_of(const Path& path) {
    std::map<std::string, std::string> notes;
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(path.c_str());
    reader->UpdateInformation();
    reader->GetCellDataArraySelection()->DisableAllArrays();
    reader->GetPointDataArraySelection()->DisableAllArrays();
    reader->Update();
    vtkFieldData* data = reader->GetOutput()->GetFieldData();
    for (int i = 0; i < data->GetNumberOfArrays(); ++i)
        if (auto* array = vtkStringArray::SafeDownCast(data->GetAbstractArray(i)); array != nullptr && array->GetNumberOfValues() > 0)
            notes[array->GetName()] = array->GetValue(0);
    return notes;
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

[[noreturn]] void refuse_length(const Path& path, const std::string& field, bool fewer, std::uint64_t wanted) {
    throw UserError(fmt::format("the array `{}` has {} values than the image", field, fewer ? "fewer" : "more"),
                    {.where = path.string(), .allowed = fmt::format("{} values", wanted), .fix = "write the file again"});
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

// Length and values in one, or one after the other, each with its own padding, as some writers do.
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

// One value more than the image has must not be there, and the last one must.
void require_length(File& file, const Piece& piece, const std::string& field) {
    std::vector<char> two(2 * file.word.bytes);
    if (const std::size_t got = file.read(piece, two.data(), static_cast<std::int64_t>(piece.values()) - 1, 2); got != 1)
        refuse_length(file.path, field, got == 0, piece.values());
}

// Layers of all pieces, row by row.
void read_layers(File& file, const VtiVolume& volume, const std::array<std::int64_t, 3>& low, std::int64_t first, std::int64_t count,
                 char* into) {
    std::vector<char> slab;
    for (const Piece& piece : file.pieces) {
        const std::int64_t begin = std::max(first + low[2], piece.low[2]),
                           end = std::min(first + count + low[2], piece.low[2] + piece.count[2]);
        if (begin >= end) continue;
        const std::int64_t layer = piece.count[0] * piece.count[1], number = layer * (end - begin);
        const bool whole = piece.count[0] == volume.values[0] && piece.count[1] == volume.values[1];
        char* target = into + static_cast<std::size_t>((begin - low[2] - first) * volume.values[0] * volume.values[1]) * volume.bytes;
        if (!whole) slab.resize(static_cast<std::size_t>(number) * volume.bytes);
        if (file.read(piece, whole ? target : slab.data(), (begin - piece.low[2]) * layer, static_cast<std::size_t>(number)) !=
            static_cast<std::size_t>(number))
            refuse(file.path, fmt::format("the array `{}` ends early or is damaged", volume.field));
        if (whole) continue;
        const std::size_t row = static_cast<std::size_t>(piece.count[0]) * volume.bytes;
        for (std::int64_t z = 0; z < end - begin; ++z)
            for (std::int64_t y = 0; y < piece.count[1]; ++y) {
                const std::int64_t to = (z * volume.values[1] + y + piece.low[1] - low[1]) * volume.values[0] + piece.low[0] - low[0];
                std::copy_n(slab.data() + static_cast<std::size_t>(z * piece.count[1] + y) * row, row,
                            target + static_cast<std::size_t>(to) * volume.bytes);
            }
    }
}

}  // namespace

VtiVolume open_vti_volume(const Path& path, const std::string& field) {
    const auto file = std::make_shared<File>();
    file->path = path;
    if (!std::filesystem::is_regular_file(path)) throw UserError("not a regular file: " + path.string());
    file->stream.open(path, std::ios::binary);
    file->parser->SetStream(&file->stream);
    file->parser->SetIgnoreCharacterData(1);
    vtkXMLDataElement* root = file->parser->Parse() == 1 ? file->parser->GetRootElement() : nullptr;
    if (file->parser->too_deep()) refuse(path, "its elements are nested too deep");
    if (root == nullptr || std::string(root->GetName()) != "VTKFile" || children(root, "ImageData").size() != 1)
        throw UserError("not a VTK image: " + path.string(), {.allowed = "an XML image (.vti)"});
    vtkXMLDataElement* image = children(root, "ImageData").front();
    const auto pieces = children(image, "Piece");
    if (pieces.empty()) refuse(path, "it has no pieces");

    VtiVolume volume;
    std::tie(volume.field, volume.at_points) = choose_array(pieces.front(), field, path);
    std::array<std::int64_t, 3> low{};
    take_extent(image, "WholeExtent", volume.at_points, low, volume.values, path);
    volume.spacing = numbers_of<double, 3>(image, "Spacing", path, "1 1 1");
    if (static_cast<double>(volume.values[0]) * static_cast<double>(volume.values[1]) * static_cast<double>(volume.values[2]) > 1e15)
        refuse(path, "WholeExtent has more than 1e15 values");
    volume.has_spacing = image->GetAttribute("Spacing") != nullptr;
    const auto origin = numbers_of<double, 3>(image, "Origin", path, "0 0 0");
    const auto rows = numbers_of<double, 9>(image, "Direction", path, "1 0 0 0 1 0 0 0 1");
    for (std::size_t i = 0; i < 3; ++i) {
        volume.origin[i] = origin[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            volume.direction[i][axis] = rows[3 * axis + i];
        }
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t i = 0; i < 3; ++i)
            volume.origin[axis] += rows[3 * axis + i] * volume.spacing[i] * (static_cast<double>(low[i]) + (volume.at_points ? 0.0 : 0.5));

    for (vtkXMLDataElement* element : pieces) {
        Piece piece{};
        take_extent(element, "Extent", volume.at_points, piece.low, piece.count, path);
        for (vtkXMLDataElement* array : arrays_of(element, volume.at_points))
            if (name_of_array(array) == volume.field) piece.array = array;
        if (piece.array == nullptr) refuse(path, fmt::format("a piece has no array `{}`", volume.field));
        const char *type = piece.array->GetAttribute("type"), *format = piece.array->GetAttribute("format");
        const auto known = std::find_if(std::begin(word_types), std::end(word_types),
                                        [&](const WordType& one) { return type != nullptr && one.name == std::string(type); });
        if (known == std::end(word_types) || (!volume.type.empty() && volume.type != type))
            throw UserError(fmt::format("the array `{}` has values of the type {}", volume.field, type == nullptr ? "?" : type),
                            {.where = path.string(), .allowed = "Int8 to UInt32, Float32, Float64, the same in all pieces"});
        volume.type = known->name;
        volume.bytes = known->bytes;
        file->word = *known;
        const std::string text = format == nullptr ? "" : format;
        piece.ascii = text == "ascii";
        piece.appended = text == "appended";
        if (piece.appended && (piece.array->GetScalarAttribute("offset", piece.offset) != 1 || piece.offset < 0))
            refuse(path, "an offset is missing");
        volume.storage = text;
        file->pieces.push_back(piece);
    }
    set_compressor(*file, root, volume.storage);
    const auto appended = children(root, "AppendedData");
    const char* encoding = appended.empty() ? nullptr : appended.front()->GetAttribute("encoding");
    for (Piece& piece : file->pieces)
        if (piece.ascii)
            read_ascii_values(*file, piece, volume.field);
        else if (root->GetAttribute("compressor") == nullptr && !(piece.appended && encoding != nullptr && std::string(encoding) == "raw"))
            find_base64_data(*file, piece, volume.field);
    require_cover(file->pieces, low, volume.values, volume.at_points, path);
    for (const Piece& piece : file->pieces) require_length(*file, piece, volume.field);
    volume.notes = notes_of(path);
    volume.read = [file, shown = VtiVolume(volume), low](std::int64_t first, std::int64_t count, void* values) {
        read_layers(*file, shown, low, first, count, static_cast<char*>(values));
    };
    return volume;
}

}  // namespace porepack::io
