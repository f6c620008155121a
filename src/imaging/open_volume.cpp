#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "imaging/file_axes.hpp"
#include "imaging/layer_files.hpp"

namespace porepack::imaging {
namespace fs = std::filesystem;
namespace {

constexpr const char* axis_names = "xyz";
constexpr std::array usual_units = {1.0, 1e-3, 1e-6, 1e-9};
constexpr double smallest_voxel_m = 1e-12, largest_voxel_m = 1e6;  // as of --image-voxel-size
constexpr double contradiction = 1e-3;                             // relative difference between two voxel sizes that are meant to be equal

// File axis i is the axis `axis` of the image, against its direction if `reversed`.
struct AxisMap {
    std::array<std::size_t, 3> axis = {0, 1, 2};
    std::array<bool, 3> reversed = {false, false, false};
};

AxisMap map_of_text(const std::string& text, const Path& file) {
    AxisMap map;
    std::array<bool, 3> found = {false, false, false};
    std::size_t number = 0;
    bool reversed = false, right = true;
    for (const char c : text) {
        if (c == '-' && !reversed) {
            reversed = true;
            continue;
        }
        const char* place = c == '\0' ? nullptr : std::strchr(axis_names, c);
        if (place == nullptr || number == 3) {
            right = false;
            break;
        }
        const auto axis = static_cast<std::size_t>(place - axis_names);
        right = right && !found[axis];
        found[axis] = true;
        map.axis[number] = axis;
        map.reversed[number++] = reversed;
        reversed = false;
    }
    if (!right || number != 3 || reversed)
        throw UserError(fmt::format("\"{}\" does not name the file's three axes", text),
                        {.where = "--image-axes, or axes in [image], of " + file.string(),
                         .allowed = "x, y and z in any order, the fastest axis of the file first, each perhaps with a minus sign",
                         .fix = "\"xyz\", or \"zyx\" for an array [x, y, z] in C order"});
    return map;
}

// Axis permutations and mirrored axes are honoured; oblique axes are refused, because voxels would not be aligned with the container.
AxisMap map_of_direction(const FileVolume& file, const Path& path) {
    AxisMap map;
    std::array<bool, 3> found = {false, false, false};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto& column = file.direction[i];
        std::size_t largest = 0;
        double norm = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            norm += column[axis] * column[axis];
            if (std::abs(column[axis]) > std::abs(column[largest])) largest = axis;
        }
        norm = std::sqrt(norm);
        if (!(std::abs(column[largest]) > (1.0 - 1e-6) * norm) || !(norm > 0.0) || found[largest])
            throw UserError(
                fmt::format("axis {} of the file has the direction ({:g}, {:g}, {:g}): it is oblique", i, column[0], column[1], column[2]),
                {.where = path.string(),
                 .allowed = "axes along x, y and z, in any order and direction",
                 .fix = "resample the image along its own axes, or write it without a direction"});
        found[largest] = true;
        map.axis[i] = largest;
        map.reversed[i] = column[largest] < 0.0;
    }
    return map;
}

std::string text_of(const AxisMap& map, const FileVolume& file) {
    std::string text = "axes of the file, fastest first: ";
    for (std::size_t i = 0; i < 3; ++i)
        text += fmt::format("{}{}{}", i == 0 ? "" : ", ", map.reversed[i] ? "-" : "", axis_names[map.axis[i]]);
    return text + (file.states_direction ? " (direction in the file)" : " (declared)");
}

AxisMap map_of(const FileVolume& file, const ImageConfig& config, const Path& path) {
    const AxisMap declared = map_of_text(config.axes, path);
    if (!file.states_direction) return declared;
    if (config.axes != "xyz")
        throw UserError("the file states the directions of its axes, and --image-axes states others",
                        {.where = path.string(), .fix = "remove --image-axes"});
    return map_of_direction(file, path);
}

// In metres, along the file's axes.
// Two sources may state the size. What the file states needs a unit, its own or a given one. A given size wins, but must agree with the
// file where that says anything: a contradiction points to a wrong unit or file, and k grows as the square of the size.
std::array<double, 3> spacing_m(const FileVolume& file, const AxisMap& map, const ImageConfig& config, const Path& path,
                                std::string& source) {
    const char* flag = "--image-voxel-size in metres";
    std::optional<std::array<double, 3>> stated = file.spacing;
    if (stated)
        for (const double length : *stated)
            if (!std::isfinite(length) || !(length > 0.0))
                throw UserError(fmt::format("the file states a voxel size of {:g}", length),
                                {.where = path.string(), .allowed = "positive, finite"});
    const std::optional<double> unit = config.unit_m > 0.0 ? std::optional(config.unit_m) : file.unit_m;
    if (config.unit_m > 0.0 && file.unit_m && std::abs(config.unit_m / *file.unit_m - 1.0) > contradiction)
        throw UserError(fmt::format("the file's unit is {:g} m, --image-unit says {:g} m", *file.unit_m, config.unit_m),
                        {.where = path.string(), .fix = "remove --image-unit"});
    if (config.voxel_size_m.empty()) {
        if (!stated || !unit)
            throw UserError(stated ? fmt::format("the file states a voxel size of {:g} x {:g} x {:g}, but not its unit", (*stated)[0],
                                                 (*stated)[1], (*stated)[2])
                                   : std::string("the file does not state its voxel size"),
                            {.where = path.string(), .fix = stated ? std::string("--image-unit 0.001 (millimetres), or ") + flag : flag});
        source = fmt::format("file, unit of {:g} m", *unit);
        for (double& length : *stated) {
            const double size = length * *unit;
            if (!(size >= smallest_voxel_m && size <= largest_voxel_m))
                throw UserError(fmt::format("the file states voxels of {:g} in units of {:g} m", length, *unit),
                                {.where = path.string(),
                                 .allowed = fmt::format("{:g} to {:g} m", smallest_voxel_m, largest_voxel_m),
                                 .fix = "correct the file's voxel size or its unit"});
            length = size;
        }
        return *stated;
    }
    // Given along x, y, z of the image; the file's sizes follow the axes of the file.
    std::array<double, 3> given{};
    for (std::size_t i = 0; i < 3; ++i)
        given[i] = config.voxel_size_m.size() == 3 ? config.voxel_size_m[map.axis[i]] : config.voxel_size_m[0];
    if (config.voxel_size_m.size() == 2)
        throw UserError("two voxel sizes are given", {.where = flag, .allowed = "one, or three along x, y, z"});
    source = "given";
    // A spacing of 1 in all directions is what writers put where they know none.
    if (stated && (unit || *stated != std::array{1.0, 1.0, 1.0})) {
        const double factor = unit.value_or(given[0] / (*stated)[0]);
        bool agrees = true;
        for (std::size_t i = 0; i < 3; ++i) agrees = agrees && std::abs((*stated)[i] * factor / given[i] - 1.0) <= contradiction;
        if (!unit)  // the file's number in metres, millimetres or micrometres
            agrees = agrees && std::any_of(usual_units.begin(), usual_units.end(),
                                           [&](double one) { return std::abs(factor / one - 1.0) <= contradiction; });
        if (!agrees)
            throw UserError(fmt::format("the file states voxels of {:g} x {:g} x {:g}{}, and {:g} x {:g} x {:g} m are given", (*stated)[0],
                                        (*stated)[1], (*stated)[2], unit ? fmt::format(" in units of {:g} m", *unit) : std::string(),
                                        given[0], given[1], given[2]),
                            {.where = path.string(), .fix = "correct --image-voxel-size, or the file"});
        source = "given, as in the file";
    }
    return given;
}

// Where the values of an image lie among those of a file with n voxels along its own axes, the fastest first.
struct Places {
    std::array<std::int64_t, 3> size{}, step{};  // along x, y, z
    std::int64_t start = 0;
};

// Permutation and mirroring are one affine index: start + x step[0] + y step[1] + z step[2]. A reversed axis starts at its far end with a
// negative step.
Places places_of(const std::array<std::int64_t, 3>& n, const AxisMap& map) {
    const std::array<std::int64_t, 3> stride = {1, n[0], n[0] * n[1]};
    Places places;
    for (std::size_t i = 0; i < 3; ++i) {
        places.size[map.axis[i]] = n[i];
        places.step[map.axis[i]] = map.reversed[i] ? -stride[i] : stride[i];
        if (map.reversed[i]) places.start += (n[i] - 1) * stride[i];
    }
    return places;
}

// The layers of z from `first` on.
void copy_layers(const std::vector<float>& from, const Places& p, std::int64_t first, std::span<float> into) {
    std::size_t at = 0;
    for (std::int64_t z = first; at < into.size(); ++z)
        for (std::int64_t y = 0; y < p.size[1]; ++y)
            for (std::int64_t x = 0; x < p.size[0]; ++x)
                into[at++] = from[static_cast<std::size_t>(p.start + x * p.step[0] + y * p.step[1] + z * p.step[2])];
}

// Layers of the file become layers of the image. Where the slowest axis is not z, or a packed file would be read backwards, the first
// read takes the whole file into memory.
void connect(VolumeSource& source, FileVolume file, const AxisMap& map, const Path& path) {
    const std::array<std::int64_t, 3> n = file.voxels;  // along the file's axes
    const bool by_layer = map.axis[2] == 2 && !(map.reversed[2] && file.sequential);
    // The file's order is that of the image: its reader is used without a copy.
    if (by_layer && map.axis[0] == 0 && map.reversed == std::array{false, false, false}) {
        source.read = std::move(file.read);
        return;
    }
    // Only the axes within a layer differ: each layer is rearranged when it is read.
    if (by_layer) {
        source.read = [file = std::move(file), map, places = places_of({n[0], n[1], 1}, map), n](std::int64_t first,
                                                                                                 std::span<float> values) {
            std::vector<float> layer(static_cast<std::size_t>(n[0] * n[1]));
            for (std::size_t done = 0; done < values.size(); done += layer.size(), ++first) {
                file.read(map.reversed[2] ? n[2] - 1 - first : first, layer);
                copy_layers(layer, places, 0, values.subspan(done, layer.size()));
            }
        };
        return;
    }
    const double bytes = 4.0 * static_cast<double>(n[0]) * static_cast<double>(n[1]) * static_cast<double>(n[2]);
    if (const double free = available_memory_bytes(); free > 0.0 && bytes > 0.9 * free)
        throw UserError(
            fmt::format("the image must be held in memory ({}, free: {}), because the slowest axis of the file is not z, or the file is "
                        "packed and its z axis reversed",
                        human_bytes(bytes), human_bytes(free)),
            {.where = path.string(), .fix = "write the image with z as its slowest axis"});
    source.memory_bytes = file.memory_bytes + bytes;
    const auto all = std::make_shared<std::vector<float>>();
    source.read = [all, file = std::move(file), places = places_of(n, map)](std::int64_t first, std::span<float> values) {
        if (all->empty()) {
            all->resize(static_cast<std::size_t>(file.voxels[0] * file.voxels[1] * file.voxels[2]));
            file.read(0, *all);
        }
        copy_layers(*all, places, first, values);
    };
}

const std::array known_extensions = {".npy", ".tif", ".tiff", ".vti", ".mhd", ".mha", ".nrrd", ".nhdr"};

bool is_known(const Path& path) {
    return std::find(known_extensions.begin(), known_extensions.end(), lower_extension(path)) != known_extensions.end();
}

bool is_raw(const Path& path) {
    const std::string extension = lower_extension(path), inner = lower_extension(path.stem());
    return extension == ".raw" || (extension == ".gz" && inner == ".raw");
}

// Raw values under another name (.bin, .dat, .vol) are those of whom the number of voxels is given.
bool is_raw(const Path& path, const ImageConfig& config) {
    return is_raw(path) || (!config.dims.empty() && std::filesystem::is_regular_file(path) && !is_known(path));
}

FileVolume open_file(const Path& path, const ImageConfig& config) {
    if (!fs::exists(path)) throw UserError("no such image: " + path.string());
    if (fs::is_directory(path)) {
        const auto tiff = layers_in(path, {".tif", ".tiff"}), png = layers_in(path, {".png"}), dicom = layers_in(path, {".dcm"});
        if ((tiff.empty() ? 0 : 1) + (png.empty() ? 0 : 1) + (dicom.empty() ? 0 : 1) > 1)
            throw UserError("the folder contains images of several formats",
                            {.where = path.string(), .fix = "keep the layers of one image in it"});
        require_numbered(tiff.empty() ? png : tiff);
        if (!tiff.empty()) return open_tiff(tiff);
        if (!png.empty()) return open_png_stack(png);
        return open_dicom(path);
    }
    const std::string extension = lower_extension(path);
    if (is_raw(path, config)) return open_raw(path, config);
    if (extension == ".npy") return open_npy(path);
    if (extension == ".tif" || extension == ".tiff") return open_tiff({path});
    if (extension == ".vti") return open_vti(path, config.field);
    if (extension == ".mhd" || extension == ".mha") return open_meta(path);
    if (extension == ".nrrd" || extension == ".nhdr") return open_nrrd(path);
    throw UserError("the format of the image is not known: " + path.string(),
                    {.allowed = ".raw, .raw.gz, .mhd, .mha, .nrrd, .nhdr, .tif, .npy, .vti, or a folder of .tif, .png or DICOM files",
                     .fix = extension == ".dcm"   ? "name the folder of the series"
                            : extension == ".png" ? "name the folder of the layers"
                                                  : "raw values: --image-dims NX,NY,NZ --image-type uint8"});
}

void refuse_what_has_no_effect(const Path& path, const ImageConfig& config) {
    const auto refuse = [&](bool given, const char* flag, const char* of) {
        if (given)
            throw UserError(fmt::format("{} has no effect here: it belongs to {}", flag, of), {.where = path.string(), .fix = "remove it"});
    };
    const bool raw = is_raw(path, config);
    refuse(!raw && !config.dims.empty(), "--image-dims", "raw files");
    refuse(!raw && config.type != ValueType::uint8, "--image-type", "raw files");
    refuse(!raw && config.byte_order != ByteOrder::little, "--image-byte-order", "raw files");
    refuse(!raw && config.header_bytes != 0, "--image-header-bytes", "raw files");
    refuse(lower_extension(path) != ".vti" && !config.field.empty(), "--image-field", ".vti files");
}

}  // namespace

std::size_t size_of(ValueType type) {
    switch (type) {
        case ValueType::uint8:
        case ValueType::int8:
            return 1;
        case ValueType::uint16:
        case ValueType::int16:
            return 2;
        case ValueType::uint32:
        case ValueType::int32:
        case ValueType::float32:
            return 4;
        default:
            return 8;
    }
}

bool is_volume(const Path& path) {
    if (fs::is_directory(path))
        return !fs::exists(path / "slices.json") && !fs::exists(path / "case.toml") &&
               !layers_in(path, {".tif", ".tiff", ".png", ".dcm"}).empty();
    return is_raw(path) || is_known(path);
}

VolumeSource open_volume(const Path& path, const ImageConfig& config) {
    refuse_what_has_no_effect(path, config);
    FileVolume file = open_file(path, config);
    for (const std::int64_t n : file.voxels)
        if (n < 1) throw UserError("the image has no voxels", {.where = path.string()});
    double count = 1.0;
    for (const std::int64_t n : file.voxels) count *= static_cast<double>(n);
    if (count > 1e15) throw UserError(fmt::format("so many voxels ({:.2g}) are no image", count), {.where = path.string()});
    const double layer_bytes = 4.0 * static_cast<double>(file.voxels[0]) * static_cast<double>(file.voxels[1]);
    if (const double free = available_memory_bytes(); free > 0.0 && layer_bytes > 0.5 * free)
        throw UserError(fmt::format("one layer of the image needs {}, and {} are free", human_bytes(layer_bytes), human_bytes(free)),
                        {.where = path.string()});
    const AxisMap map = map_of(file, config, path);
    VolumeSource source;
    VolumeHeader& header = source.header;
    const std::array<double, 3> size = spacing_m(file, map, config, path, header.size_source);
    if (*std::max_element(size.begin(), size.end()) >= 0.1)
        log_warning(fmt::format("the voxels of {} are {:g} m long: is the unit right?", path.string(),
                                *std::max_element(size.begin(), size.end())));
    const double unit = file.unit_m.value_or(config.unit_m > 0.0 ? config.unit_m : 0.0);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t axis = map.axis[i];
        header.voxels[axis] = file.voxels[i];
        header.spacing_m[axis] = size[i];
    }
    // The origin is the position of the file's first voxel, which lies at the far end of a reversed axis. Without a unit it has no meaning.
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t axis = map.axis[i];
        if (!(std::abs(file.origin[axis]) * std::max(unit, 1e-3) < 1e9))
            throw UserError(fmt::format("the origin of the image is {:g} along {}", file.origin[axis], "xyz"[axis]),
                            {.where = path.string(), .fix = "correct the file"});
        const double length = size[i] * static_cast<double>(file.voxels[i] - 1);
        header.origin_m[axis] = unit * file.origin[axis] - (map.reversed[i] ? length : 0.0) - (file.origin_is_corner ? 0.0 : 0.5 * size[i]);
        if (unit == 0.0) header.origin_m[axis] = 0.0;
    }
    header.type = file.type;
    header.format = file.format;
    header.own_phases = file.own_phases;
    header.own_fractions = file.own_fractions;
    header.files = file.files;
    header.notes = file.notes;
    header.orientation = text_of(map, file);
    source.memory_bytes = file.memory_bytes;
    connect(source, std::move(file), map, path);
    return source;
}

}  // namespace porepack::imaging
