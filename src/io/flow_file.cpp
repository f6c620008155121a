// flow.vti: one piece, whose arrays are compressed layer by layer, so that each part of the computation writes its own layers.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <exception>
#include <limits>

#include "core/error.hpp"
#include "core/shared_file.hpp"
#include "io/image.hpp"

namespace porepack::io {
using namespace core;
using namespace geometry;
namespace {

struct Array {
    const char* name;
    const char* type;
    std::size_t components, bytes;  // of a cell
};
constexpr std::array<Array, 3> arrays = {{{"velocity", "Float32", 3, 12}, {"pressure", "Float32", 1, 4}, {"phase", "UInt8", 1, 1}}};

// The values of one array, of some layers.
struct CompressedLayers {
    std::vector<std::uint64_t> sizes;  // of each layer
    Bytes bytes;

    void add(const Bytes& layer) {
        sizes.push_back(layer.size());
        bytes.insert(bytes.end(), layer.begin(), layer.end());
    }
};
using CompressedArrays = std::array<CompressedLayers, arrays.size()>;

Bytes compressed(std::span<const std::byte> values) {
    uLongf size = compressBound(values.size());
    Bytes bytes(size);
    if (compress2(reinterpret_cast<Bytef*>(bytes.data()), &size, reinterpret_cast<const Bytef*>(values.data()), values.size(),
                  Z_BEST_SPEED) != Z_OK)
        throw MachineError("not enough memory to compress the flow field", {.fix = "write none: --no-fields, or fields = \"none\""});
    bytes.resize(size);
    return bytes;
}

CompressedArrays compressed_layers(const LayeredFlow& flow) {
    const int count = flow.own[1] - flow.own[0];
    std::vector<std::array<Bytes, arrays.size()>> layers(static_cast<std::size_t>(count));
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
    for (std::array<Bytes, arrays.size()>& layer : layers)
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

std::string head_of(const LayeredFlow& flow, const std::array<std::uint64_t, arrays.size()>& offsets) {
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
    head += fmt::format("    </FieldData>\n    <Piece Extent=\"{}\">\n      <PointData/>\n      <CellData Vectors=\"velocity\">\n", extent);
    for (std::size_t a = 0; a < arrays.size(); ++a)
        head += fmt::format("        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
                            arrays[a].type, arrays[a].name, arrays[a].components, offsets[a]);
    return head + "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _";
}

}  // namespace

void write_flow_image(const Path& path, const LayeredFlow& flow, const Communicator& parts) {
    const CompressedArrays own = compressed_layers(flow);
    CompressedArrays all;  // only the sizes
    std::array<std::uint64_t, arrays.size()> offsets{}, below{};
    std::uint64_t end = 0;
    for (std::size_t a = 0; a < arrays.size(); ++a) {
        for (const Bytes& of_part : parts.gather(bytes_of(own[a].sizes))) {
            const std::vector<std::uint64_t> sizes = list_of<std::uint64_t>(of_part);
            all[a].sizes.insert(all[a].sizes.end(), sizes.begin(), sizes.end());
        }
        below[a] = sum_below(parts, own[a].bytes.size());
        offsets[a] = end;
        end += sizeof(std::uint64_t) * (3 + all[a].sizes.size());
        for (const std::uint64_t size : all[a].sizes) end += size;
    }
    const std::string head = head_of(flow, offsets), tail = "\n  </AppendedData>\n</VTKFile>\n";
    write_together(path, "the flow field", parts, [&](SharedFile& file) {
        for (std::size_t a = 0; a < arrays.size(); ++a) {
            const std::vector<std::uint64_t> table = block_table(arrays[a], flow.grid, all[a].sizes);
            const std::uint64_t at = head.size() + offsets[a];
            if (parts.part() == 0) file.write(at, bytes_of(table));
            file.write(at + sizeof(std::uint64_t) * table.size() + below[a], own[a].bytes);
        }
        if (parts.part() > 0) return;
        file.write(0, std::as_bytes(std::span(head)));
        file.write(head.size() + end, std::as_bytes(std::span(tail)));
    });
}

}  // namespace porepack::io
