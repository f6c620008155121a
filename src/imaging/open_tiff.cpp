// TIFF: one file with a page per layer, or a file per layer. libtiff is used directly: ITK loses the distance of the layers.
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <atomic>
#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {
namespace {

struct Close {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using File = std::unique_ptr<TIFF, Close>;

[[noreturn]] void fail(const Path& path, const std::string& what,
                       const std::string& fix = "export the image again, for instance from ImageJ, as gray values") {
    throw UserError(what, {.where = path.string(),
                           .allowed = "gray TIFF images of 8, 16 or 32 bits, all pages of one size and type, one channel and one time",
                           .fix = fix});
}

// libtiff reports a damaged directory only by its error handler: the end of the list looks the same.
std::atomic<long> tiff_errors = 0;
void count_error(const char* /*module*/, const char* /*format*/, va_list /*values*/) {
    ++tiff_errors;
}
// A list of pages that leads back to one of them ends with a warning only.
void count_loop(const char* /*module*/, const char* format, va_list /*values*/) {
    if (std::string_view(format).find("loop") != std::string_view::npos) ++tiff_errors;
}

File open(const Path& path) {
    require_file(path);
    TIFFSetWarningHandler(count_loop);
    TIFFSetErrorHandler(count_error);
    File file(TIFFOpen(path.c_str(), "r"));
    if (!file) fail(path, "not a TIFF image, or a damaged one");
    return file;
}

struct Page {
    std::uint32_t width = 0, height = 0;
    ValueType type = ValueType::uint8;
    bool operator==(const Page&) const = default;
};

Page page_of(TIFF* file, const Path& path) {
    Page page;
    std::uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, meaning = PHOTOMETRIC_MINISBLACK, orientation = ORIENTATION_TOPLEFT;
    TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &page.width);
    TIFFGetField(file, TIFFTAG_IMAGELENGTH, &page.height);
    TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &meaning);
    TIFFGetFieldDefaulted(file, TIFFTAG_ORIENTATION, &orientation);
    if (meaning == PHOTOMETRIC_PALETTE)
        fail(path, "the image has a table of colours (a lookup table): its values are numbers of colours",
             "remove the table, in ImageJ by Image > Lookup Tables > Grays (the values stay), and save it again");
    if (meaning == PHOTOMETRIC_MINISWHITE)
        fail(path, "white is zero in this image: what looks dark has high values, so pores and solid would be exchanged",
             "in ImageJ: Image > Lookup Tables > Invert LUT, then Edit > Invert if it should look as before, and save it again");
    if (samples != 1 || meaning != PHOTOMETRIC_MINISBLACK) fail(path, "the image has colours");
    if (orientation != ORIENTATION_TOPLEFT)
        fail(path, fmt::format("the image is turned or mirrored (orientation {})", orientation),
             "write it as it is to be read, for instance with convert -auto-orient of ImageMagick");
    static const std::map<std::pair<int, int>, ValueType> types = {
        {{8, SAMPLEFORMAT_UINT}, ValueType::uint8},      {{8, SAMPLEFORMAT_INT}, ValueType::int8},
        {{16, SAMPLEFORMAT_UINT}, ValueType::uint16},    {{16, SAMPLEFORMAT_INT}, ValueType::int16},
        {{32, SAMPLEFORMAT_UINT}, ValueType::uint32},    {{32, SAMPLEFORMAT_INT}, ValueType::int32},
        {{32, SAMPLEFORMAT_IEEEFP}, ValueType::float32}, {{64, SAMPLEFORMAT_IEEEFP}, ValueType::float64}};
    const auto found = types.find({bits, format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : format});
    if (found == types.end()) fail(path, fmt::format("the values have {} bits", bits));
    page.type = found->second;
    if (page.width == 0 || page.height == 0 || TIFFScanlineSize(file) < 0) fail(path, "the image has no pixels");
    return page;
}

// Rows from the top down, as in the file.
void read_page(TIFF* file, const Page& page, std::span<float> values, const Path& path) {
    const std::size_t size = size_of(page.type), row_bytes = page.width * size;
    if (TIFFIsTiled(file) != 0) {
        std::uint32_t width = 0, height = 0;
        TIFFGetField(file, TIFFTAG_TILEWIDTH, &width);
        TIFFGetField(file, TIFFTAG_TILELENGTH, &height);
        if (width == 0 || height == 0 || TIFFTileSize(file) < static_cast<tmsize_t>(width * height * size))
            fail(path, "its tiles are damaged");
        std::vector<char> tile(static_cast<std::size_t>(TIFFTileSize(file)));
        for (std::uint32_t y = 0; y < page.height; y += height)
            for (std::uint32_t x = 0; x < page.width; x += width) {
                if (TIFFReadTile(file, tile.data(), x, y, 0, 0) < 0) fail(path, "a page is incomplete or damaged");
                for (std::uint32_t row = 0; row < std::min(height, page.height - y); ++row)
                    to_float(tile.data() + row * width * size, page.type,
                             values.subspan(static_cast<std::size_t>(y + row) * page.width + x, std::min(width, page.width - x)), path);
            }
        return;
    }
    if (static_cast<std::size_t>(TIFFScanlineSize(file)) != row_bytes) fail(path, "its rows are damaged");
    std::vector<char> row(row_bytes);
    for (std::uint32_t y = 0; y < page.height; ++y) {
        if (TIFFReadScanline(file, row.data(), y, 0) < 0) fail(path, "a page is incomplete or damaged");
        to_float(row.data(), page.type, values.subspan(static_cast<std::size_t>(y) * page.width, page.width), path);
    }
}

// ImageJ writes "spacing=0.05" and "unit=mm" into the description, and pixels per unit into the resolution.
void read_spacing(TIFF* file, FileVolume& volume) {
    float x = 0.0F, y = 0.0F;
    std::uint16_t resolution_unit = RESUNIT_INCH;
    char* description = nullptr;
    TIFFGetFieldDefaulted(file, TIFFTAG_RESOLUTIONUNIT, &resolution_unit);
    const bool has_resolution =
        TIFFGetField(file, TIFFTAG_XRESOLUTION, &x) == 1 && TIFFGetField(file, TIFFTAG_YRESOLUTION, &y) == 1 && x > 0.0F && y > 0.0F;
    if (TIFFGetField(file, TIFFTAG_IMAGEDESCRIPTION, &description) != 1 || description == nullptr) return;
    const std::string text = description;
    const auto value_of = [&](const std::string& key) {
        const std::size_t at = text.rfind("\n" + key + "=");
        if (at == std::string::npos) return std::string();
        const std::size_t from = at + key.size() + 2;
        return text.substr(from, text.find('\n', from) - from);
    };
    if (!text.starts_with("ImageJ") || !has_resolution) return;
    const std::string spacing = value_of("spacing"), unit = value_of("unit");
    for (const char* key : {"yunit", "zunit"})
        if (const std::string other = value_of(key); !other.empty() && other != unit) return;  // the voxel size must be given
    static const std::map<std::string, double> units = {{"mm", 1e-3},      {"cm", 1e-2},         {"m", 1.0},     {"um", 1e-6},
                                                        {"micron", 1e-6},  {"\\u00B5m", 1e-6},   {"µm", 1e-6},   {"nm", 1e-9},
                                                        {"microns", 1e-6}, {"millimeter", 1e-3}, {"meter", 1.0}, {"inch", 0.0254}};
    const auto found = units.find(unit);
    if (found == units.end() || spacing.empty()) return;
    volume.spacing = {1.0 / x, 1.0 / y, std::strtod(spacing.c_str(), nullptr)};
    volume.unit_m = found->second;
}

// A small copy of an image for previews.
bool is_preview(TIFF* file) {
    std::uint32_t kind = 0;
    return TIFFGetField(file, TIFFTAG_SUBFILETYPE, &kind) == 1 && (kind & FILETYPE_REDUCEDIMAGE) != 0;
}

std::string description_of(TIFF* file) {
    char* text = nullptr;
    return TIFFGetField(file, TIFFTAG_IMAGEDESCRIPTION, &text) == 1 && text != nullptr ? std::string(text) : std::string();
}

// The number behind `key` in a text; `standard` where there is none.
long number_behind(const std::string& text, const std::string& key, long standard) {
    const std::size_t at = text.find(key);
    return at == std::string::npos ? standard : std::strtol(text.c_str() + at + key.size(), nullptr, 10);
}

// Pages may be layers, channels or times; only the description tells. Throws UserError unless all are layers.
void require_layers(const std::string& description, const Path& path) {
    long channels = 1, times = 1;
    if (description.find("<OME") != std::string::npos) {
        channels = number_behind(description, "SizeC=\"", 1);
        times = number_behind(description, "SizeT=\"", 1);
    } else if (description.starts_with("ImageJ")) {
        channels = number_behind(description, "channels=", 1);
        times = number_behind(description, "frames=", 1);
    } else if (const Json json = Json::parse(description, nullptr, false); json.is_object() && json.contains("shape")) {  // of tifffile
        const std::string axes = json.contains("axes") && json["axes"].is_string() ? json["axes"].get<std::string>() : std::string();
        std::string long_axes;
        for (std::size_t i = 0; json["shape"].is_array() && i < json["shape"].size(); ++i)
            if (json["shape"][i].is_number() && json["shape"][i].get<double>() > 1.0) long_axes += i < axes.size() ? axes[i] : '?';
        if (long_axes.size() > 3 || long_axes.find_first_of("CTS") != std::string::npos)
            fail(path,
                 fmt::format("the file holds an array of {} axes{}: {}", long_axes.size(), axes.empty() ? "" : " (" + axes + ")",
                             json["shape"].dump()),
                 "write one channel and one time, with the axes ZYX, into a file of its own");
    }
    if (channels > 1 || times > 1)
        fail(path, fmt::format("the image has {} channels and {} times", channels, times),
             "write the one that shows the grains into a file of its own, in ImageJ by Image > Color > Split Channels; if they are layers: "
             "Image > Properties, 1 channel, 1 frame, and all of them as slices");
}

// ImageJ writes files above 4 GB as one page with the values of all layers behind it, one after the other.
std::optional<std::uint64_t> values_behind_one_page(TIFF* file, const Page& page, long layers, const Path& path) {
    std::uint16_t compression = COMPRESSION_NONE;
    std::uint64_t* offsets = nullptr;
    TIFFGetFieldDefaulted(file, TIFFTAG_COMPRESSION, &compression);
    if (compression != COMPRESSION_NONE || TIFFIsTiled(file) != 0 || TIFFGetField(file, TIFFTAG_STRIPOFFSETS, &offsets) != 1 ||
        offsets == nullptr)
        return std::nullopt;
    const double needed =
        static_cast<double>(offsets[0]) + static_cast<double>(layers) * page.width * page.height * static_cast<double>(size_of(page.type));
    return static_cast<double>(std::filesystem::file_size(path)) < needed ? std::nullopt : std::optional(offsets[0]);
}

FileVolume layers_behind_one_page(FileVolume volume, const Path& path, std::uint64_t begin, bool swapped) {
    volume.format = fmt::format("TIFF, {}, {} layers behind one page", name_of(volume.type), volume.voxels[2]);
    volume.read = [path, begin, swapped, type = volume.type, n = volume.voxels](std::int64_t z, std::span<float> values) {
        const std::size_t size = size_of(type), layer = static_cast<std::size_t>(n[0] * n[1]);
        std::ifstream in(path, std::ios::binary);
        in.seekg(static_cast<std::streamoff>(begin + static_cast<std::uint64_t>(z) * layer * size));
        std::vector<char> bytes(layer * size);
        for (std::size_t done = 0; done < values.size(); done += layer) {
            if (!in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) fail(path, "the file is incomplete");
            if (swapped) swap_bytes(bytes.data(), size, layer);
            to_float(bytes.data(), type, values.subspan(done, layer), path);
        }
    };
    return volume;
}

// Each page of one file is a layer, apart from previews.
FileVolume open_pages(const std::shared_ptr<File>& file, const Page& page, FileVolume volume) {
    const Path path = volume.files.front();
    const std::string description = description_of(file->get());
    require_layers(description, path);
    std::vector<tdir_t> pages;
    const long before = tiff_errors;
    do {
        if (is_preview(file->get())) continue;
        if (page_of(file->get(), path) != page) fail(path, fmt::format("page {} has another size or type", pages.size() + 1));
        pages.push_back(TIFFCurrentDirectory(file->get()));
    } while (TIFFReadDirectory(file->get()) == 1);
    if (tiff_errors != before) fail(path, fmt::format("page {} is incomplete or damaged", pages.size() + 1));
    TIFFSetDirectory(file->get(), 0);
    const long layers = description.starts_with("ImageJ") ? number_behind(description, "images=", 0) : 0;
    if (layers > 1 && pages.size() == 1)
        if (const auto begin = values_behind_one_page(file->get(), page, layers, path)) {
            volume.voxels[2] = layers;
            return layers_behind_one_page(std::move(volume), path, *begin, TIFFIsByteSwapped(file->get()) != 0);
        }
    if (layers > static_cast<long>(pages.size()))
        fail(path, fmt::format("the description names {} layers, and the file has {} pages", layers, pages.size()),
             "the file is incomplete: copy it again, or save it again as a TIFF with a page for each layer");
    volume.voxels[2] = static_cast<std::int64_t>(pages.size());
    volume.format = fmt::format("TIFF, {}, {} pages", name_of(page.type), pages.size());
    volume.read = [file, page, path, pages](std::int64_t z, std::span<float> values) {
        const std::size_t layer = std::size_t{page.width} * page.height;
        for (std::size_t done = 0; done < values.size(); done += layer, ++z) {
            // Directories are linked lists: the next page is near.
            const tdir_t wanted = pages[static_cast<std::size_t>(z)], now = TIFFCurrentDirectory(file->get());
            const bool there =
                now == wanted || (now + 1 == wanted ? TIFFReadDirectory(file->get()) == 1 : TIFFSetDirectory(file->get(), wanted) == 1);
            if (!there) fail(path, fmt::format("page {} cannot be read", z + 1));
            read_page(file->get(), page, values.subspan(done, layer), path);
        }
    };
    return volume;
}

}  // namespace

FileVolume open_tiff(const std::vector<Path>& files) {
    const auto first = std::make_shared<File>(open(files.front()));
    const Page page = page_of(first->get(), files.front());
    FileVolume volume{.voxels = {page.width, page.height, static_cast<std::int64_t>(files.size())}, .type = page.type};
    volume.files = files;
    read_spacing(first->get(), volume);
    if (files.size() == 1) return open_pages(first, page, std::move(volume));
    volume.format = fmt::format("TIFF, {}, {} files, {} to {}", name_of(page.type), files.size(), files.front().filename().string(),
                                files.back().filename().string());
    volume.read = [files, page](std::int64_t z, std::span<float> values) {
        const std::size_t layer = std::size_t{page.width} * page.height;
        for (std::size_t done = 0; done < values.size(); done += layer, ++z) {
            const Path& path = files[static_cast<std::size_t>(z)];
            const File file = open(path);
            if (TIFFLastDirectory(file.get()) == 0) fail(path, "the file has several pages, and the folder several files");
            if (page_of(file.get(), path) != page)
                fail(path, "the image has another size or type than " + files.front().filename().string());
            read_page(file.get(), page, values.subspan(done, layer), path);
        }
    };
    return volume;
}

}  // namespace porepack::imaging
