// Series of DICOM files.
#include <fmt/format.h>
#include <gdcm-3.0/gdcmReader.h>
#include <gdcm-3.0/gdcmSequenceOfFragments.h>
#include <gdcm-3.0/gdcmStringFilter.h>
#include <gdcm-3.0/gdcmTrace.h>
#include <itkGDCMImageIO.h>
#include <itkGDCMSeriesFileNames.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "imaging/itk_files.hpp"

namespace porepack::imaging {
namespace {

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
