#include "io/vti_volume.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vtkDataArraySelection.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkStringArray.h>
#include <vtkXMLImageDataReader.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "io/vti_file.hpp"

namespace porepack::io {
namespace {

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
// Boxes inside the whole that do not overlap fill it exactly if their volumes sum up to it. Points count by the intervals between them, so
// that shared planes have no volume. The products are whole numbers below 2^53, exact in double precision.
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
    // VTK reads the field data alone: all arrays are disabled.
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

// Layers of all pieces, row by row.
void read_layers(File& file, const VtiVolume& volume, const std::array<std::int64_t, 3>& low, std::int64_t first, std::int64_t count,
                 char* into) {
    std::vector<char> slab;
    for (const Piece& piece : file.pieces) {
        const std::int64_t begin = std::max(first + low[2], piece.low[2]),
                           end = std::min(first + count + low[2], piece.low[2] + piece.count[2]);
        if (begin >= end) continue;
        const std::int64_t layer = piece.count[0] * piece.count[1], number = layer * (end - begin);
        // A piece as wide as the image is read into place; others row by row, by way of a buffer.
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
    require_file(path);
    file->stream.open(path, std::ios::binary);
    file->parser->SetStream(&file->stream);
    // Only the structure is parsed here. The values are read later from the file, layer by layer, because an image may exceed the memory.
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
    // A matrix row by row; its column i is the direction of axis i.
    const auto rows = numbers_of<double, 9>(image, "Direction", path, "1 0 0 0 1 0 0 0 1");
    for (std::size_t i = 0; i < 3; ++i) {
        volume.origin[i] = origin[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            volume.direction[i][axis] = rows[3 * axis + i];
        }
    }
    // The file's origin is the point of index 0, and an extent may begin elsewhere. Cell values lie half a cell further.
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
