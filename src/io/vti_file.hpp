// The values of a VTK image file: text, base64, raw, compressed. Only for the sources of this folder.
#pragma once

#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLDataParser.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::io {

/// "the image cannot be read: ..."
[[noreturn]] void refuse(const core::Path& path, const std::string& what);

struct WordType {
    const char* name;
    int vtk;
    std::size_t bytes;
    double low, high;  // of whole numbers; 0: any number
};
inline constexpr WordType word_types[] = {{"Int8", VTK_TYPE_INT8, 1, -128, 127},
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
    core::Path path;
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

void set_compressor(File& file, vtkXMLDataElement* root, std::string& storage);
void read_ascii_values(File& file, Piece& piece, const std::string& field);
/// Length and values in one, or one after the other, each with its own padding, as some writers do.
void find_base64_data(File& file, Piece& piece, const std::string& field);
/// One value more than the image has must not be there, and the last one must.
void require_length(File& file, const Piece& piece, const std::string& field);

}  // namespace porepack::io
