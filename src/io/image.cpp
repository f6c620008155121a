#include "io/image.hpp"

#include <fmt/format.h>
#include <vtkCellData.h>
#include <vtkFieldData.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkPointData.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnsignedIntArray.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>
#include <zlib.h>

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::io {
namespace {

// Errors are reported by PorePack's own messages.
const bool vtk_is_silent = [] {
    vtkObject::GlobalWarningDisplayOff();
    return true;
}();

void add_notes(vtkImageData* image, const std::map<std::string, std::string>& notes) {
    for (const auto& [name, value] : notes) {
        vtkNew<vtkStringArray> array;
        array->SetName(name.c_str());
        array->InsertNextValue(value);
        image->GetFieldData()->AddArray(array);
    }
}

vtkNew<vtkImageData> make_image(const Grid& grid, const std::map<std::string, std::string>& notes) {
    vtkNew<vtkImageData> image;
    image->SetDimensions(grid.cells[0] + 1, grid.cells[1] + 1, grid.cells[2] + 1);
    image->SetOrigin(grid.origin_m.data());
    image->SetSpacing(grid.spacing_m.data());
    add_notes(image, notes);
    return image;
}

// The array refers to the caller's memory; nothing is copied.
template <typename Array, typename Value>
vtkNew<Array> wrap(const char* name, const std::vector<Value>& values, int components) {
    vtkNew<Array> array;
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetArray(const_cast<Value*>(values.data()), static_cast<vtkIdType>(values.size()), 1);
    return array;
}

void write_image(const Path& path, vtkImageData* image) {
    write_whole(path, [&](const Path& name) {
        vtkNew<vtkXMLImageDataWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputData(image);
        writer->SetDataModeToBinary();  // flow_file.cpp says why
        writer->SetCompressorTypeToZLib();
        writer->SetCompressionLevel(1);
        if (writer->Write() != 1 || writer->GetErrorCode() != 0)
            throw MachineError("cannot write " + path.string(), {.fix = "free some disk space or choose another folder with --output"});
    });
}

vtkNew<vtkXMLImageDataReader> open_image(const Path& path) {
    const std::string text = read_text(path);
    if (text.find("<VTKFile") == std::string::npos || text.find("ImageData") == std::string::npos)
        throw UserError("not a VTK image: " + path.string(), {.allowed = "an XML image (.vti) with cell data"});
    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(path.c_str());
    reader->Update();
    if (reader->GetErrorCode() != 0 || reader->GetOutput()->GetNumberOfCells() == 0)
        throw UserError("the image cannot be read: " + path.string(), {.fix = "the file may be incomplete: write it again"});
    return reader;
}

Grid grid_of(vtkImageData* image, const Path& path) {
    Grid grid;
    int dimensions[3];
    image->GetDimensions(dimensions);
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        grid.cells[a] = dimensions[axis] - 1;
        grid.origin_m[a] = image->GetOrigin()[axis];
        grid.spacing_m[a] = image->GetSpacing()[axis];
        if (!(grid.spacing_m[a] > 0.0) || !std::isfinite(grid.spacing_m[a]) || !std::isfinite(grid.origin_m[a]) || grid.cells[a] < 1)
            throw UserError(fmt::format("the image's grid is not valid: {} cells of {:g} m from {:g} m along axis {}", grid.cells[a],
                                        grid.spacing_m[a], grid.origin_m[a], axis),
                            {.where = path.string(), .allowed = "finite origin, spacing > 0 (metres)"});
    }
    return grid;
}

std::map<std::string, std::string> notes_of(vtkImageData* image) {
    std::map<std::string, std::string> notes;
    for (int i = 0; i < image->GetFieldData()->GetNumberOfArrays(); ++i)
        if (auto* array = vtkStringArray::SafeDownCast(image->GetFieldData()->GetAbstractArray(i));
            array != nullptr && array->GetNumberOfValues() > 0)
            notes[array->GetName()] = array->GetValue(0);
    return notes;
}

vtkDataArray* require_array(vtkImageData* image, const char* name, int components, const Path& path) {
    vtkDataArray* array = image->GetCellData()->GetArray(name);
    if (array == nullptr || array->GetNumberOfComponents() != components)
        throw UserError(fmt::format("{} has no cell data `{}` of {} component(s)", path.string(), name, components),
                        {.allowed = "pore.vti: uint8 cell data `phase` (0 grain, 1 pore, 2 outside); flow.vti: `velocity` and `pressure`"});
    return array;
}

std::vector<std::uint8_t> phases_of(vtkImageData* image, const Path& path) {
    vtkDataArray* array = require_array(image, "phase", 1, path);
    std::vector<std::uint8_t> phase(static_cast<std::size_t>(array->GetNumberOfTuples()));
    for (std::size_t i = 0; i < phase.size(); ++i) {
        const double value = array->GetTuple1(static_cast<vtkIdType>(i));
        if (value != 0.0 && value != 1.0 && value != 2.0)
            throw UserError(fmt::format("phase {:g} in cell {} of {}", value, i, path.string()),
                            {.allowed = "0 grain, 1 pore, 2 outside the container"});
        phase[i] = static_cast<std::uint8_t>(value);
    }
    return phase;
}

// VTK's reader crashes on a damaged image: the length and checksum of every chunk are checked first.
void require_whole_png(const std::string& bytes, const Path& path) {
    const auto number = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
        return value;
    };
    if (!bytes.starts_with("\x89PNG\r\n\x1a\n")) throw UserError("not a PNG image: " + path.string());
    std::size_t at = 8;
    while (at + 12 <= bytes.size()) {
        const std::size_t length = number(at);
        if (at + 12 + length > bytes.size()) break;
        const auto* body = reinterpret_cast<const Bytef*>(bytes.data() + at + 4);
        if (crc32(0, body, static_cast<uInt>(length + 4)) != number(at + 8 + length)) break;
        if (bytes.compare(at + 4, 4, "IEND") == 0) return;
        at += 12 + length;
    }
    throw UserError("the image is damaged or incomplete: " + path.string(), {.fix = "write it again"});
}

void write_png(const Path& path, int width, int height, std::span<const std::uint8_t> pixels, int components) {
    vtkNew<vtkImageData> image;
    image->SetDimensions(width, height, 1);
    vtkNew<vtkUnsignedCharArray> array;
    array->SetNumberOfComponents(components);
    array->SetArray(const_cast<std::uint8_t*>(pixels.data()), static_cast<vtkIdType>(pixels.size()), 1);
    image->GetPointData()->SetScalars(array);
    write_whole(path, [&](const Path& name) {
        vtkNew<vtkPNGWriter> writer;
        writer->SetFileName(name.c_str());
        writer->SetInputData(image);
        writer->Write();
        if (writer->GetErrorCode() != 0)
            throw MachineError("cannot write " + path.string(), {.fix = "free some disk space or choose another folder with --output"});
    });
}

}  // namespace

void write_phase_image(const Path& path, const PhaseImage& image) {
    const auto data = make_image(image.grid, image.notes);
    const auto phase = wrap<vtkUnsignedCharArray>("phase", image.phase, 1);
    data->GetCellData()->SetScalars(phase);
    write_image(path, data);
}

void write_gray_image(const Path& path, const GrayImage& image) {
    std::vector<float> values(image.packed.size());
    for (std::size_t cell = 0; cell < values.size(); ++cell) values[cell] = static_cast<float>(image.at(cell));
    const auto data = make_image(image.grid, image.notes);
    data->GetCellData()->SetScalars(wrap<vtkFloatArray>("solid_fraction", values, 1));
    write_image(path, data);
}

void write_label_image(const Path& path, const Grid& grid, const std::vector<std::uint32_t>& label) {
    const auto data = make_image(grid, {});
    data->GetCellData()->SetScalars(wrap<vtkUnsignedIntArray>("label", label, 1));
    write_image(path, data);
}

FlowImage read_flow_image(const Path& path) {
    const auto reader = open_image(path);
    vtkImageData* data = reader->GetOutput();
    FlowImage image{.grid = grid_of(data, path), .velocity_m_per_s = {}, .pressure_Pa = {}, .phase = {}, .notes = notes_of(data)};
    const bool is_old = data->GetCellData()->HasArray("velocity") == 1;  // of version 0.2
    vtkDataArray* velocity = require_array(data, is_old ? "velocity" : "velocity_m_per_s", 3, path);
    image.velocity_m_per_s.resize(3 * image.grid.size());
    for (std::size_t i = 0; i < image.grid.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const double value = velocity->GetComponent(static_cast<vtkIdType>(i), axis);
            if (!std::isfinite(value))
                throw UserError(fmt::format("the velocity is not finite in cell {} of {}", i, path.string()),
                                {.fix = "the flow run that wrote it failed: run it again"});
            image.velocity_m_per_s[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(value);
        }
    if (data->GetCellData()->HasArray("phase") == 1) image.phase = phases_of(data, path);
    if (vtkDataArray* const pressure = data->GetCellData()->GetArray(is_old ? "pressure" : "pressure_Pa")) {
        image.pressure_Pa.resize(image.grid.size());
        for (std::size_t i = 0; i < image.grid.size(); ++i)
            image.pressure_Pa[i] = static_cast<float>(pressure->GetComponent(static_cast<vtkIdType>(i), 0));
    }
    return image;
}

void write_gray_png(const Path& path, int width, int height, std::span<const std::uint8_t> pixels) {
    write_png(path, width, height, pixels, 1);
}

void write_colour_png(const Path& path, int width, int height, std::span<const std::uint8_t> pixels) {
    write_png(path, width, height, pixels, 3);
}

std::vector<std::uint8_t> read_gray_png(const Path& path, int& width, int& height) {
    require_whole_png(read_text(path), path);
    vtkNew<vtkPNGReader> reader;
    if (reader->CanReadFile(path.c_str()) == 0) throw UserError("not a PNG image: " + path.string());
    reader->SetFileName(path.c_str());
    reader->Update();
    int dimensions[3] = {0, 0, 0};
    reader->GetOutput()->GetDimensions(dimensions);
    width = dimensions[0];
    height = dimensions[1];
    vtkDataArray* array = reader->GetOutput()->GetPointData()->GetScalars();
    if (reader->GetErrorCode() != 0 || array == nullptr || width < 1 || height < 1)
        throw UserError("the image cannot be read: " + path.string(), {.fix = "the file may be incomplete: write it again"});
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(array->GetNumberOfTuples()));
    for (std::size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = static_cast<std::uint8_t>(array->GetComponent(static_cast<vtkIdType>(i), 0));
    return pixels;
}

}  // namespace porepack::io
