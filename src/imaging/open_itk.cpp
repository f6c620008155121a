// Formats that ITK reads: PNG, DICOM.
#include <fmt/format.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
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
    } catch (const itk::ExceptionObject&) {  // its text names addresses and its own sources
        throw UserError("the image cannot be read: " + path.string(), {.fix = "the file may be incomplete or damaged: write it again"});
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
                          .type = type_of(*first, files.front()),
                          .files = files};
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
        volume.files.assign(files.begin(), files.end());
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
