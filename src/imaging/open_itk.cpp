// Formats that ITK reads: PNG, DICOM.
#include <fmt/format.h>
#include <gdcm-3.0/gdcmReader.h>
#include <gdcm-3.0/gdcmSequenceOfFragments.h>
#include <gdcm-3.0/gdcmStringFilter.h>
#include <gdcm-3.0/gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>
#include <itkPNGImageIO.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/own_process.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/layer_files.hpp"

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

// ITK and the libraries below it abort on some damaged files, print their own remarks, and name their own sources in errors.
// file(): the one that is being read.
std::string with_itk(const std::function<Path()>& file, const std::function<std::string()>& work) {
    const auto what = [&] { return "the image cannot be read: " + file().string(); };
    return in_own_process(
        [&]() -> std::string {
            try {
                return work();
            } catch (const itk::ExceptionObject&) {
                throw UserError(what(), {.fix = "the file may be incomplete or damaged: write it again"});
            }
        },
        what);
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
void read_all(itk::ImageIOBase& io, std::span<char> bytes, const Path& path) {
    if (static_cast<std::size_t>(io.GetImageSizeInBytes()) != bytes.size())
        throw UserError("the image has another size than its first layer", {.where = path.string()});
    itk::ImageIORegion region(io.GetNumberOfDimensions());
    for (unsigned i = 0; i < io.GetNumberOfDimensions(); ++i) region.SetSize(i, io.GetDimensions(i));
    io.SetIORegion(region);
    io.Read(bytes.data());
}

// Layers with a file each, read block by block in a process that may crash.
class LayerFiles {
public:
    using ReadOne = std::function<void(const Path& file, std::int64_t z, std::span<char> bytes)>;
    LayerFiles(std::vector<Path> files, ValueType type, std::int64_t values_per_layer, ReadOne read_one)
        : files_(std::move(files)),
          type_(type),
          values_(static_cast<std::size_t>(values_per_layer)),
          bytes_(values_ * size_of(type)),
          read_one_(std::move(read_one)),
          per_block_(std::clamp<std::int64_t>(static_cast<std::int64_t>(block_bytes / std::max<std::size_t>(bytes_, 1)), 1,
                                              static_cast<std::int64_t>(files_.size()))) {}

    void read(std::int64_t z, std::span<float> values) {
        for (std::size_t done = 0; done < values.size(); done += values_, ++z) {
            if (z / per_block_ != block_) read_block(z / per_block_);
            const auto layer = static_cast<std::size_t>(z % per_block_);
            to_float(shared_->bytes().subspan(layer * bytes_, bytes_).data(), type_, values.subspan(done, values_),
                     files_[static_cast<std::size_t>(z)]);
        }
    }

private:
    static constexpr std::size_t block_bytes = 64U << 20U;

    void read_block(std::int64_t block) {
        block_ = -1;
        if (!shared_) {
            require_memory(static_cast<double>(bytes_) * static_cast<double>(per_block_), files_.front());
            shared_.emplace(bytes_ * static_cast<std::size_t>(per_block_));
        }
        const std::int64_t first = block * per_block_, end = std::min(first + per_block_, static_cast<std::int64_t>(files_.size()));
        const SharedBytes place(sizeof first);  // of the layer that is being read, where the process ends in it
        const auto file = [&] {
            std::int64_t z = 0;
            std::memcpy(&z, place.bytes().data(), sizeof z);
            return files_[static_cast<std::size_t>(z)];
        };
        (void)with_itk(file, [&] {
            for (std::int64_t z = first; z < end; ++z) {
                std::memcpy(place.bytes().data(), &z, sizeof z);
                read_one_(files_[static_cast<std::size_t>(z)], z,
                          shared_->bytes().subspan(static_cast<std::size_t>(z - first) * bytes_, bytes_));
            }
            return std::string();
        });
        block_ = block;
    }

    std::vector<Path> files_;
    ValueType type_;
    std::size_t values_, bytes_;
    ReadOne read_one_;
    std::int64_t per_block_, block_ = -1;
    std::optional<SharedBytes> shared_;
};

}  // namespace

namespace {

// Byte 25 of the file: 0 gray, 2 colours, 3 a lookup table, 4 and 6 with transparency.
void require_gray_png(const Path& path) {
    std::array<char, 26> start{};
    std::ifstream file(path, std::ios::binary);
    if (!file.read(start.data(), start.size()) || start[25] == 0) return;  // too short: the reader says so
    throw UserError(start[25] == 3 ? "the values of the image are places in a lookup table of colours" : "the image is in colours",
                    {.where = path.string(),
                     .allowed = "gray values, without transparency",
                     .fix = "save it as gray values: in ImageJ Image > Lookup Tables > Grays (the values stay), then save as TIFF"});
}

}  // namespace

FileVolume open_png_stack(const std::vector<Path>& files) {
    const auto open = [](const Path& path) {
        const auto io = itk::PNGImageIO::New();
        if (!io->CanReadFile(path.c_str())) throw UserError("not a PNG image, or a damaged one: " + path.string());
        require_gray_png(path);
        io->SetFileName(path.string());
        io->ReadImageInformation();
        return io;
    };
    const Json header = Json::parse(with_itk([&] { return files.front(); },
                                             [&] {
                                                 const auto first = open(files.front());
                                                 return Json{{"size", {first->GetDimensions(0), first->GetDimensions(1)}},
                                                             {"type", name_of(type_of(*first, files.front()))}}
                                                     .dump();
                                             }));
    const auto type = choice_named<ValueType>(header["type"].get<std::string>()).value();
    FileVolume volume{
        .voxels = {header["size"][0].get<std::int64_t>(), header["size"][1].get<std::int64_t>(), static_cast<std::int64_t>(files.size())},
        .type = type,
        .files = files};
    volume.format = fmt::format("PNG, {}, {} files, {} to {}", name_of(type), files.size(), files.front().filename().string(),
                                files.back().filename().string());
    const auto read_one = [open, type, n = volume.voxels, first = files.front().filename().string()](const Path& path, std::int64_t,
                                                                                                     std::span<char> bytes) {
        const auto io = open(path);
        if (static_cast<std::int64_t>(io->GetDimensions(0)) != n[0] || static_cast<std::int64_t>(io->GetDimensions(1)) != n[1] ||
            type_of(*io, path) != type)
            throw UserError("the image has another size or type than " + first, {.where = path.string()});
        read_all(*io, bytes, path);
    };
    volume.read = [layers = std::make_shared<LayerFiles>(files, type, volume.voxels[0] * volume.voxels[1], read_one)](
                      std::int64_t z, std::span<float> values) { layers->read(z, values); };
    return volume;
}

namespace {

// What a DICOM file states; ITK and GDCM invent what is missing, and take what contradicts itself.
struct DicomHeader {
    explicit DicomHeader(const Path& file) : path(file) {
        // GDCM fills values that the file does not hold with zeros, and only warns.
        std::ostringstream warnings;
        gdcm::Trace::SetWarningStream(warnings);
        gdcm::Trace::WarningOn();
        reader.SetFileName(path.c_str());
        const bool read = reader.Read();
        gdcm::Trace::SetWarningStream(std::cerr);
        gdcm::Trace::WarningOff();
        if (warnings.str().find("Incomplete Pixel Data") != std::string::npos)
            throw UserError("the values of the image are not all there: " + path.string(),
                            {.fix = "the file is incomplete: copy it again"});
        if (!read) throw UserError("not a DICOM file, or a damaged one: " + path.string());
        filter.SetFile(reader.GetFile());
    }

    // Without the blanks that fill it; empty if the file does not have it.
    [[nodiscard]] std::string text(std::uint16_t group, std::uint16_t number) const {
        const gdcm::Tag tag(group, number);
        if (!reader.GetFile().GetDataSet().FindDataElement(tag)) return {};
        std::string value = filter.ToString(tag);
        value.erase(std::remove_if(value.begin(), value.end(), [](unsigned char c) { return c == '\0' || std::isspace(c) != 0; }),
                    value.end());
        return value;
    }

    // Numbers that are separated by backslashes; none if one of them is no finite number.
    [[nodiscard]] std::vector<double> numbers(std::uint16_t group, std::uint16_t number) const {
        std::string value = text(group, number);
        std::replace(value.begin(), value.end(), '\\', ' ');
        std::istringstream words(value);
        std::vector<double> list;
        for (std::string word; words >> word;) {
            const char *start = word.data() + (word.starts_with('+') ? 1 : 0), *stop = word.data() + word.size();
            double one = 0.0;
            const auto [end, fault] = std::from_chars(start, stop, one);
            if (fault != std::errc() || end != stop || !std::isfinite(one)) return {};
            list.push_back(one);
        }
        return list;
    }

    [[noreturn]] void refuse(const std::string& what, const std::string& allowed, const std::string& fix = {}) const {
        throw UserError(what, {.where = path.string(), .allowed = allowed, .fix = fix});
    }

    Path path;
    gdcm::Reader reader;
    mutable gdcm::StringFilter filter;
};

// "2, -1024": values = slope x stored values + intercept.
std::string scale_of(const DicomHeader& header) {
    const std::string slope = header.text(0x28, 0x1053), intercept = header.text(0x28, 0x1052);
    return (slope.empty() ? "1" : slope) + ", " + (intercept.empty() ? "0" : intercept);
}

// One frame of gray values, all of them there, at a stated place.
void require_gray_frame(const DicomHeader& header) {
    const std::string meaning = header.text(0x28, 0x4), frames = header.text(0x28, 0x8), samples = header.text(0x28, 0x2);
    if (!frames.empty() && frames != "1")
        header.refuse(fmt::format("the file has {} frames", frames), "one frame per file",
                      "write each frame into a file of its own, for instance with gdcmimg or emf2sf of dcm4che");
    if (meaning != "MONOCHROME2")
        header.refuse(
            fmt::format("the photometric interpretation of the image is \"{}\"", meaning), "MONOCHROME2: larger values are brighter",
            meaning == "MONOCHROME1" ? "convert the series, for instance with dcmj2pnm, or gdcmconv of GDCM" : "write gray values");
    if (!samples.empty() && samples != "1") header.refuse(fmt::format("the image has {} values per voxel", samples), "1");
    const std::vector<double> rows = header.numbers(0x28, 0x10), columns = header.numbers(0x28, 0x11), bits = header.numbers(0x28, 0x100);
    if (rows.size() != 1 || columns.size() != 1 || bits.size() != 1)
        header.refuse("Rows, Columns or Bits Allocated are missing", "one number each");
    const gdcm::Tag values(0x7fe0, 0x10);
    const gdcm::DataSet& data = header.reader.GetFile().GetDataSet();
    const gdcm::ByteValue* bytes = data.FindDataElement(values) ? data.GetDataElement(values).GetByteValue() : nullptr;
    const bool packed = data.FindDataElement(values) && data.GetDataElement(values).GetSequenceOfFragments() != nullptr;
    const double wanted = rows[0] * columns[0] * bits[0] / 8.0, found = bytes == nullptr ? 0.0 : static_cast<double>(bytes->GetLength());
    if (!packed && (wanted < 1.0 || found != wanted + std::fmod(wanted, 2.0)))
        header.refuse(fmt::format("the file has {:.0f} bytes of values, and {:.0f} x {:.0f} values of {:.0f} bits are {:.0f}", found,
                                  columns[0], rows[0], bits[0], wanted),
                      "as many as Rows and Columns say", "the file is incomplete or damaged: copy it again");
    if (const std::string slope = header.text(0x28, 0x1053); !slope.empty()) {
        const std::vector<double> number = header.numbers(0x28, 0x1053);
        if (number.size() != 1 || number[0] == 0.0)
            header.refuse(fmt::format("the rescale slope is \"{}\"", slope), "a number other than 0");
    }
    const std::vector<double> place = header.numbers(0x20, 0x32), axes = header.numbers(0x20, 0x37);
    if (place.size() != 3) header.refuse("the position of the layer (Image Position Patient) is missing", "three numbers");
    double square_u = 0.0, square_v = 0.0, product = 0.0;
    for (std::size_t i = 0; i < 3 && axes.size() == 6; ++i) {
        square_u += axes[i] * axes[i];
        square_v += axes[3 + i] * axes[3 + i];
        product += axes[i] * axes[3 + i];
    }
    constexpr double rounding = 1e-3;
    if (std::abs(square_u - 1.0) > rounding || std::abs(square_v - 1.0) > rounding || std::abs(product) > rounding)
        header.refuse("the directions of rows and columns (Image Orientation Patient) are missing, or no unit vectors at right angles",
                      "six numbers");
}

itk::GDCMImageIO::Pointer open_dicom_file(const DicomHeader& header) {
    require_gray_frame(header);
    const auto io = itk::GDCMImageIO::New();
    io->SetFileName(header.path.string());
    io->ReadImageInformation();
    return io;
}

FileVolume dicom_of(const Json& header) {
    FileVolume volume{.type = choice_named<ValueType>(header["type"].get<std::string>()).value(), .unit_m = 1e-3};
    volume.voxels = header["voxels"].get<std::array<std::int64_t, 3>>();
    volume.origin = header["origin"].get<std::array<double, 3>>();
    volume.direction = header["direction"].get<std::array<std::array<double, 3>, 3>>();
    volume.states_direction = true;
    if (!header["spacing"].is_null()) volume.spacing = header["spacing"].get<std::array<double, 3>>();
    for (const Json& file : header["files"]) volume.files.emplace_back(file.get<std::string>());
    return volume;
}

// GDCM passes over files that it cannot read: then a layer would be missing.
void require_all_in_series(const Path& folder, const std::vector<std::string>& series) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string(), ending = lower_extension(entry.path());
        const bool looks_like_one =
            ending == ".dcm" || ending == ".ima" || ending.empty() || ending.find_first_not_of(".0123456789") == std::string::npos;
        if (!entry.is_regular_file() || name.starts_with('.') || name == "DICOMDIR" || !looks_like_one) continue;
        if (std::none_of(series.begin(), series.end(), [&](const std::string& one) { return Path(one).filename() == name; }))
            throw UserError("the file is not a layer of the series, or is damaged: " + entry.path().string(),
                            {.fix = "copy it again, or move it to another folder"});
    }
}

// In the process that may crash.
Json dicom_header(const Path& folder) {
    const auto names = itk::GDCMSeriesFileNames::New();
    names->SetUseSeriesDetails(true);
    names->SetDirectory(folder.string());
    const auto& series = names->GetSeriesUIDs();
    if (series.empty())
        throw UserError("the folder contains no images", {.where = folder.string(), .allowed = "files .tif, .png, or of a DICOM series"});
    if (series.size() > 1)
        throw UserError(fmt::format("the folder contains {} DICOM series", series.size()),
                        {.where = folder.string(), .fix = "put each series into a folder of its own"});
    const std::vector<std::string> files = names->GetFileNames(series.front());
    require_all_in_series(folder, files);
    const DicomHeader header(files.front());
    const auto first = open_dicom_file(header), last = open_dicom_file(DicomHeader(files.back()));
    FileVolume volume{.type = type_of(*first, files.front())};
    take_geometry(volume, *first);
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
    // GDCM takes 1 mm where the file has no PixelSpacing, nor the one of the detector.
    bool stated = false;
    for (const auto& [group, number] : {std::pair<std::uint16_t, std::uint16_t>(0x28, 0x30), {0x18, 0x1164}}) {
        if (header.text(group, number).empty()) continue;
        stated = true;
        const std::vector<double> spacing = header.numbers(group, number);
        if (spacing.size() != 2 || !(spacing[0] > 0.0) || !(spacing[1] > 0.0))
            header.refuse(fmt::format("the spacing of the pixels is \"{}\"", header.text(group, number)), "two positive numbers");
        break;
    }
    return {{"type", name_of(volume.type)},
            {"voxels", {volume.voxels[0], volume.voxels[1], static_cast<std::int64_t>(files.size())}},
            {"spacing", stated ? Json(*volume.spacing) : Json(nullptr)},
            {"step", (*volume.spacing)[2]},
            {"scale", scale_of(header)},
            {"origin", volume.origin},
            {"direction", volume.direction},
            {"files", files}};
}

}  // namespace

// Layers in the order of their positions; they must be equally distant.
FileVolume open_dicom(const Path& folder) {
    const Json header = Json::parse(with_itk([&] { return folder; }, [&] { return dicom_header(folder).dump(); }));
    FileVolume volume = dicom_of(header);
    volume.format = fmt::format("DICOM, {}, {} files", name_of(volume.type), volume.files.size());
    const auto read_one = [type = volume.type, n = volume.voxels, origin = volume.origin, direction = volume.direction[2],
                           step = header["step"].get<double>(),
                           first_scale = header["scale"].get<std::string>()](const Path& path, std::int64_t z, std::span<char> bytes) {
        const DicomHeader stated(path);
        const auto io = open_dicom_file(stated);
        if (const std::string scale = scale_of(stated); scale != first_scale && type_of(*io, path) != type)
            throw UserError(fmt::format("the layer has the rescale slope and intercept {}, the first layer {}", scale, first_scale),
                            {.where = path.string(),
                             .allowed = "one conversion for all layers where it decides the type of the values",
                             .fix = "write the series with converted values"});
        if (static_cast<std::int64_t>(io->GetDimensions(0)) != n[0] || static_cast<std::int64_t>(io->GetDimensions(1)) != n[1] ||
            type_of(*io, path) != type)
            throw UserError("the layer has another size or type than the first", {.where = path.string()});
        for (unsigned i = 0; i < 3; ++i)
            if (std::abs(io->GetOrigin(i) - origin[i] - static_cast<double>(z) * step * direction[i]) > 0.01 * step)
                throw UserError("the layers are not equally distant: one is missing or twice there", {.where = path.string()});
        read_all(*io, bytes, path);
    };
    volume.read = [layers = std::make_shared<LayerFiles>(volume.files, volume.type, volume.voxels[0] * volume.voxels[1], read_one)](
                      std::int64_t z, std::span<float> values) { layers->read(z, values); };
    return volume;
}

}  // namespace porepack::imaging
