// flow.vti: one piece, whose arrays are compressed layer by layer, so that each part of the computation writes its own layers. They stand
// within the elements, in base64: after a security update of its XML parser, Debian's ParaView (5.11) no longer reads appended data.
#include <fmt/format.h>
#include <vtkBase64Utilities.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/shared_file.hpp"
#include "io/image.hpp"

namespace porepack::io {
namespace {

struct Array {
    const char* name;
    const char* type;
    std::size_t components, bytes;  // of a cell
};
constexpr std::array<Array, 3> arrays = {
    {{"velocity_m_per_s", "Float32", 3, 12}, {"pressure_Pa", "Float32", 1, 4}, {"phase", "UInt8", 1, 1}}};

struct Layer {
    std::uint64_t bytes = 0;
    std::string text;  // of them
};

// The values of one array, of some layers.
struct CompressedLayers {
    std::vector<std::uint64_t> sizes;  // of each layer, in bytes before they become text
    std::string text;

    void add(const Layer& layer) {
        sizes.push_back(layer.bytes);
        text += layer.text;
    }
};
using CompressedArrays = std::array<CompressedLayers, arrays.size()>;

std::size_t base64_length(std::size_t bytes) {
    return 4 * ((bytes + 2) / 3);
}

std::string base64(std::span<const std::byte> bytes) {
    std::string text(base64_length(bytes.size()), '\0');
    vtkBase64Utilities::Encode(reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                               reinterpret_cast<unsigned char*>(text.data()));
    return text;
}

Layer compressed(std::span<const std::byte> values) {
    uLongf size = compressBound(values.size());
    Bytes bytes(size);
    if (compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(values.data()), values.size(),
                  Z_BEST_SPEED) != Z_OK)
        throw MachineError("not enough memory to compress the flow field", {.fix = "write none: --no-fields, or fields = \"none\""});
    // Three bytes are four characters, so that the layers can follow each other as one text. zlib does not look beyond the end.
    bytes.resize((size + 2) / 3 * 3, std::byte{0});
    return {bytes.size(), base64(bytes)};
}

CompressedArrays compressed_layers(const LayeredFlow& flow) {
    const int count = flow.own[1] - flow.own[0];
    std::vector<std::array<Layer, arrays.size()>> layers(static_cast<std::size_t>(count));
    std::exception_ptr fault;
#pragma omp parallel for schedule(dynamic)
    for (int layer = 0; layer < count; ++layer) try {
            const FlowImage image = flow.layers(flow.own[0] + layer, flow.own[0] + layer + 1);
            layers[static_cast<std::size_t>(layer)] = {compressed(bytes_of(image.velocity_m_per_s)),
                                                       compressed(bytes_of(image.pressure_Pa)), compressed(bytes_of(image.phase))};
        } catch (...) {
#pragma omp critical
            fault = std::current_exception();
        }
    if (fault) std::rethrow_exception(fault);
    CompressedArrays all;
    for (std::array<Layer, arrays.size()>& layer : layers)
        for (std::size_t a = 0; a < arrays.size(); ++a) all[a].add(std::exchange(layer[a], {}));
    return all;
}

// What VTK puts before compressed values: the number of blocks, the bytes of one, those of a shorter last one, and each one's compressed
// bytes.
std::vector<std::uint64_t> block_table(const Array& array, const Grid& grid, const std::vector<std::uint64_t>& sizes) {
    std::vector<std::uint64_t> table = {sizes.size(), grid.index(0, 0, 1) * array.bytes, 0};
    table.insert(table.end(), sizes.begin(), sizes.end());
    return table;
}

std::string head_of(const LayeredFlow& flow) {
    const Grid& grid = flow.grid;
    const std::string extent = fmt::format("0 {} 0 {} 0 {}", grid.cells[0], grid.cells[1], grid.cells[2]);
    std::string head =
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\">\n";
    head +=
        fmt::format("  <ImageData WholeExtent=\"{}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\" Direction=\"1 0 0 0 1 0 0 0 1\">\n", extent,
                    grid.origin_m[0], grid.origin_m[1], grid.origin_m[2], grid.spacing_m[0], grid.spacing_m[1], grid.spacing_m[2]);
    head += "    <FieldData>\n";
    for (const auto& [name, value] : flow.notes) {  // texts are written as the numbers of their characters
        head += fmt::format("      <Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">\n       ", name);
        for (const char character : value) head += fmt::format(" {}", static_cast<int>(character));
        head += " 0\n      </Array>\n";
    }
    return head + fmt::format("    </FieldData>\n    <Piece Extent=\"{}\">\n      <PointData/>\n      <CellData Vectors=\"{}\">\n", extent,
                              arrays.front().name);
}

}  // namespace

void write_flow_image(const Path& path, const LayeredFlow& flow, const Communicator& parts) {
    CompressedArrays own = compressed_layers(flow);
    struct Place {
        std::uint64_t byte;
        std::string text;
    };
    std::vector<Place> of_all, of_own;  // what the first part writes, and each part
    std::uint64_t at = 0;
    std::string before = head_of(flow);
    for (std::size_t a = 0; a < arrays.size(); ++a) {
        std::vector<std::uint64_t> sizes;
        for (const Bytes& of_part : parts.gather(bytes_of(own[a].sizes))) {
            const std::vector<std::uint64_t> list = list_of<std::uint64_t>(of_part);
            sizes.insert(sizes.end(), list.begin(), list.end());
        }
        before += fmt::format("        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n          ",
                              arrays[a].type, arrays[a].name, arrays[a].components) +
                  base64(bytes_of(block_table(arrays[a], flow.grid, sizes)));
        of_all.push_back({at, before});
        at += before.size();
        const std::uint64_t below = sum_below(parts, own[a].text.size());
        of_own.push_back({at + below, std::move(own[a].text)});
        for (const std::uint64_t size : sizes) at += base64_length(size);
        before = "\n        </DataArray>\n";
    }
    of_all.push_back({at, before + "      </CellData>\n    </Piece>\n  </ImageData>\n</VTKFile>\n"});
    write_together(path, "the flow field", parts, [&](SharedFile& file) {
        for (const auto& [byte, text] : of_own) file.write(byte, std::as_bytes(std::span(text)));
        if (parts.part() > 0) return;
        for (const auto& [byte, text] : of_all) file.write(byte, std::as_bytes(std::span(text)));
    });
}

}  // namespace porepack::io
