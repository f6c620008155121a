// Formats that ITK reads: NRRD, PNG, DICOM.
#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkNrrdImageIO.h>
#include <itkPNGImageIO.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {
using namespace core;
namespace {

using Type = itk::CommonEnums::IOComponent;

ValueType type_of(const itk::ImageIOBase& io, const Path& path) {
    static const std::map<Type, ValueType> types = {{Type::UCHAR, ValueType::uint8},   {Type::CHAR, ValueType::int8},
                                                    {Type::USHORT, ValueType::uint16}, {Type::SHORT, ValueType::int16},
                                                    {Type::UINT, ValueType::uint32},   {Type::INT, ValueType::int32},
                                                    {Type::FLOAT, ValueType::float32}, {Type::DOUBLE, ValueType::float64}};
    const auto found = types.find(io.GetComponentType());
    if (found == types.end() || io.GetNumberOfComponents() != 1)
        throw UserError(fmt::format("the image has {} values of type {} per voxel", io.GetNumberOfComponents(),
                                    itk::ImageIOBase::GetComponentTypeAsString(io.GetComponentType())),
                        {.where = path.string(), .allowed = "one value per voxel: 8, 16 or 32 bits, or floating point"});
    return found->second;
}

// The libraries below ITK print their own remarks.
class Quiet {
public:
    Quiet() : out_(std::cout.rdbuf(nullptr)), err_(std::cerr.rdbuf(nullptr)) {}
    ~Quiet() {
        std::cout.rdbuf(out_);
        std::cerr.rdbuf(err_);
        std::cout.clear();
        std::cerr.clear();
    }
    Quiet(const Quiet&) = delete;
    Quiet& operator=(const Quiet&) = delete;

private:
    std::streambuf *out_, *err_;
};

// ITK's errors name its own source files.
template <typename Work>
auto translated(const Path& path, const Work& work) {
    const Quiet quiet;
    try {
        return work();
    } catch (const itk::ExceptionObject& error) {
        std::string text = error.GetDescription();
        text = text.substr(0, text.find('\n'));
        throw UserError("the image cannot be read: " + path.string(), {.where = text, .fix = "the file may be incomplete: write it again"});
    } catch (const std::bad_alloc&) {
        throw MachineError("not enough memory to read " + path.string());
    }
}

void require_memory(double bytes, const Path& path) {
    if (const double free = available_memory_bytes(); free > 0.0 && bytes > 0.9 * free)
        throw MachineError(fmt::format("the image needs {}, and {} are free", human_bytes(bytes), human_bytes(free)),
                           {.where = path.string(),
                            .fix = "convert it on a larger machine to a format that is read layer by layer: porepack image convert"});
}

void take_geometry(FileVolume& volume, const itk::ImageIOBase& io) {
    volume.spacing.emplace();
    for (unsigned i = 0; i < 3; ++i) {
        volume.voxels[i] = static_cast<std::int64_t>(io.GetDimensions(i));
        (*volume.spacing)[i] = io.GetSpacing(i);
        volume.origin[i] = io.GetOrigin(i);
        const std::vector<double> direction = io.GetDirection(i);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            volume.direction[i][axis] = direction[axis];
            if (direction[axis] != (axis == i ? 1.0 : 0.0)) volume.states_direction = true;
        }
    }
}

// ITK's parser prints what it does not understand into a buffer of fixed size. A header is text, in lines of moderate length, up to an
// empty line; a detached one may end without it.
void require_sane_header(const Path& path) {
    constexpr std::size_t longest = 400;
    constexpr int most_lines = 500;
    std::ifstream file(path, std::ios::binary);
    std::string line;
    char c = 0;
    for (int lines = 0; lines < most_lines && file.get(c);) {
        if (c != '\n') {
            const auto code = static_cast<unsigned char>(c);
            if (line.size() >= longest || (code < 32 && c != '\t' && c != '\r') || code > 126) break;
            line += c;
            continue;
        }
        if (line.empty() || line == "\r") return;
        line.clear();
        ++lines;
    }
    if (file.eof() && path.extension() == ".nhdr") return;
    throw UserError("not a NRRD image, or a damaged one: " + path.string(),
                    {.where = "its header is not text in lines of moderate length, or does not end"});
}

// Text of a header field; empty if it is not there.
std::string header_field(const Path& path, const std::string& name) {
    std::ifstream file(path, std::ios::binary);
    std::string line;
    for (int lines = 0; lines < 1000 && std::getline(file, line) && !line.empty() && line != "\r"; ++lines) {
        if (!line.starts_with(name + ":")) continue;
        const std::size_t at = line.find_first_not_of(" =:\t", name.size());
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        return at < line.size() ? line.substr(at) : std::string();
    }
    return {};
}

// What a reader would have to allocate and may silently leave empty: the size of uncompressed data.
void require_size_of_data(const Path& path, const FileVolume& volume) {
    if (header_field(path, "encoding") != "raw") return;
    std::string data = header_field(path, "data file");
    if (data.empty()) data = header_field(path, "datafile");
    const std::uintmax_t bytes = size_of(volume.type) * static_cast<std::uintmax_t>(volume.voxels[0] * volume.voxels[1] * volume.voxels[2]);
    std::uintmax_t there = 0;
    if (data.empty()) {
        std::ifstream file(path, std::ios::binary);
        std::string line;
        while (std::getline(file, line) && !line.empty() && line != "\r") continue;
        there = std::filesystem::file_size(path) - static_cast<std::uintmax_t>(file.tellg());
    } else if (const Path file = path.parent_path() / data; data.size() < 256 && std::filesystem::exists(file)) {
        there = std::filesystem::file_size(file);
    } else {
        return;  // lists and patterns of files
    }
    if (there != bytes)
        throw UserError(fmt::format("the data have {} bytes, and {} x {} x {} values of {} bytes are {}", there, volume.voxels[0],
                                    volume.voxels[1], volume.voxels[2], size_of(volume.type), bytes),
                        {.where = path.string(), .fix = "the file is incomplete, or its header is wrong: write it again"});
}

std::optional<double> unit_of(const Path& path) {
    const std::string text = header_field(path, "space units");
    for (const auto& [name, unit] : {std::pair("\"mm\"", 1e-3), {"\"um\"", 1e-6}, {"\"m\"", 1.0}, {"\"cm\"", 1e-2}, {"\"microns\"", 1e-6}})
        if (text.find(name) != std::string::npos) return unit;
    return std::nullopt;
}

// All of the image, in its own type.
std::shared_ptr<const std::vector<char>> read_all(itk::ImageIOBase& io, const Path& path) {
    const auto size = static_cast<std::size_t>(io.GetImageSizeInBytes());
    require_memory(static_cast<double>(size), path);
    auto data = std::make_shared<std::vector<char>>(size);
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned i = 0; i < io.GetNumberOfDimensions(); ++i) region.SetSize(i, io.GetDimensions(i));
    io.SetIORegion(region);
    io.Read(data->data());
    return data;
}

}  // namespace

FileVolume open_nrrd(const Path& path) {
    return translated(path, [&] {
        const auto io = itk::NrrdImageIO::New();
        if (std::filesystem::is_regular_file(path)) require_sane_header(path);
        if (!std::filesystem::is_regular_file(path) || !io->CanReadFile(path.c_str()))
            throw UserError("not a NRRD image, or a damaged one: " + path.string());
        io->SetFileName(path.string());
        io->ReadImageInformation();
        if (io->GetNumberOfDimensions() != 3)
            throw UserError(fmt::format("the image has {} dimensions", io->GetNumberOfDimensions()),
                            {.where = path.string(), .allowed = "3"});
        FileVolume volume{.type = type_of(*io, path)};
        volume.format = fmt::format("NRRD, {}", name_of(volume.type));
        take_geometry(volume, *io);
        volume.unit_m = unit_of(path);
        require_size_of_data(path, volume);
        const auto data = read_all(*io, path);
        volume.memory_bytes = static_cast<double>(data->size());
        volume.read = [data, path, type = volume.type, layer = volume.voxels[0] * volume.voxels[1]](std::int64_t first,
                                                                                                    std::span<float> values) {
            to_float(data->data() + static_cast<std::size_t>(first * layer) * size_of(type), type, values, path);
        };
        return volume;
    });
}

FileVolume open_png_stack(const std::vector<Path>& files) {
    const auto open = [](const Path& path) {
        const auto io = itk::PNGImageIO::New();
        if (!io->CanReadFile(path.c_str())) throw UserError("not a PNG image, or a damaged one: " + path.string());
        io->SetFileName(path.string());
        io->ReadImageInformation();
        return io;
    };
    return translated(files.front(), [&] {
        const auto first = open(files.front());
        FileVolume volume{.voxels = {static_cast<std::int64_t>(first->GetDimensions(0)), static_cast<std::int64_t>(first->GetDimensions(1)),
                                     static_cast<std::int64_t>(files.size())},
                          .type = type_of(*first, files.front())};
        volume.format = fmt::format("PNG, {}, {} files, {} to {}", name_of(volume.type), files.size(), files.front().filename().string(),
                                    files.back().filename().string());
        volume.read = [files, open, type = volume.type, n = volume.voxels](std::int64_t z, std::span<float> values) {
            const auto layer = static_cast<std::size_t>(n[0] * n[1]);
            for (std::size_t done = 0; done < values.size(); done += layer, ++z) {
                const Path& path = files[static_cast<std::size_t>(z)];
                translated(path, [&] {
                    const auto io = open(path);
                    if (static_cast<std::int64_t>(io->GetDimensions(0)) != n[0] ||
                        static_cast<std::int64_t>(io->GetDimensions(1)) != n[1] || type_of(*io, path) != type)
                        throw UserError("the image has another size or type than " + files.front().filename().string(),
                                        {.where = path.string()});
                    const auto data = read_all(*io, path);
                    to_float(data->data(), type, values.subspan(done, layer), path);
                    return 0;
                });
            }
        };
        return volume;
    });
}

// Layers in the order of their positions; they must be equally distant.
FileVolume open_dicom(const Path& folder) {
    return translated(folder, [&] {
        const auto names = itk::GDCMSeriesFileNames::New();
        names->SetUseSeriesDetails(true);
        names->SetDirectory(folder.string());
        const auto& series = names->GetSeriesUIDs();
        if (series.empty())
            throw UserError("the folder contains no images",
                            {.where = folder.string(), .allowed = "files .tif, .png, or of a DICOM series"});
        if (series.size() > 1)
            throw UserError(fmt::format("the folder contains {} DICOM series", series.size()),
                            {.where = folder.string(), .fix = "put each series into a folder of its own"});
        const std::vector<std::string> files = names->GetFileNames(series.front());
        const auto open = [](const std::string& path) {
            const auto io = itk::GDCMImageIO::New();
            io->SetFileName(path);
            io->ReadImageInformation();
            return io;
        };
        const auto first = open(files.front()), last = open(files.back());
        FileVolume volume{.type = type_of(*first, files.front()), .unit_m = 1e-3};
        take_geometry(volume, *first);
        volume.voxels[2] = static_cast<std::int64_t>(files.size());
        volume.states_direction = true;
        if (files.size() > 1) {
            double length = 0.0;
            std::array<double, 3> along{};
            for (unsigned i = 0; i < 3; ++i) {
                along[i] = last->GetOrigin(i) - first->GetOrigin(i);
                length += along[i] * along[i];
            }
            length = std::sqrt(length);
            if (!(length > 0.0)) throw UserError("all layers have the same position", {.where = folder.string()});
            for (std::size_t i = 0; i < 3; ++i) volume.direction[2][i] = along[i] / length;
            (*volume.spacing)[2] = length / static_cast<double>(files.size() - 1);
        }
        volume.format = fmt::format("DICOM, {}, {} files", name_of(volume.type), files.size());
        volume.read = [files, open, type = volume.type, n = volume.voxels, origin = volume.origin, direction = volume.direction[2],
                       step = (*volume.spacing)[2]](std::int64_t z, std::span<float> values) {
            const auto layer = static_cast<std::size_t>(n[0] * n[1]);
            for (std::size_t done = 0; done < values.size(); done += layer, ++z) {
                const std::string& path = files[static_cast<std::size_t>(z)];
                translated(path, [&] {
                    const auto io = open(path);
                    if (static_cast<std::int64_t>(io->GetDimensions(0)) != n[0] ||
                        static_cast<std::int64_t>(io->GetDimensions(1)) != n[1] || type_of(*io, path) != type)
                        throw UserError("the layer has another size or type than the first", {.where = path});
                    for (unsigned i = 0; i < 3; ++i)
                        if (std::abs(io->GetOrigin(i) - origin[i] - static_cast<double>(z) * step * direction[i]) > 0.01 * step)
                            throw UserError("the layers are not equally distant: one is missing or twice there", {.where = path});
                    const auto data = read_all(*io, path);
                    to_float(data->data(), type, values.subspan(done, layer), path);
                    return 0;
                });
            }
        };
        return volume;
    });
}

}  // namespace porepack::imaging
