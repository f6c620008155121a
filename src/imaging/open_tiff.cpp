// TIFF: one file with a page per layer, or a file per layer. libtiff is used directly: ITK loses the distance of the layers.
#include <fmt/format.h>
#include <tiffio.h>

#include <atomic>
#include <cstdarg>
#include <cstring>
#include <memory>

#include "core/error.hpp"
#include "imaging/file_axes.hpp"

namespace porepack::imaging {
using namespace core;
namespace {

struct Close {
    void operator()(TIFF* file) const { TIFFClose(file); }
};
using File = std::unique_ptr<TIFF, Close>;

[[noreturn]] void fail(const Path& path, const std::string& what) {
    throw UserError(what, {.where = path.string(),
                           .allowed = "gray TIFF images of 8, 16 or 32 bits, all pages of one size and type",
                           .fix = "export the image again, for instance from ImageJ, as gray values"});
}

// libtiff reports a damaged directory only by its error handler: the end of the list looks the same.
std::atomic<long> tiff_errors = 0;
void count_error(const char* /*module*/, const char* /*format*/, va_list /*values*/) {
    ++tiff_errors;
}

File open(const Path& path) {
    if (!std::filesystem::is_regular_file(path)) throw UserError("not a regular file: " + path.string());
    TIFFSetWarningHandler(nullptr);
    TIFFSetErrorHandler(count_error);
    File file(TIFFOpen(path.c_str(), "r"));
    if (!file) fail(path, "not a TIFF image, or a damaged one");
    return file;
}

struct Page {
    std::uint32_t width = 0, height = 0;
    ValueType type = ValueType::uint8;
    bool inverted = false;
    bool operator==(const Page&) const = default;
};

Page page_of(TIFF* file, const Path& path) {
    Page page;
    std::uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, meaning = PHOTOMETRIC_MINISBLACK;
    TIFFGetField(file, TIFFTAG_IMAGEWIDTH, &page.width);
    TIFFGetField(file, TIFFTAG_IMAGELENGTH, &page.height);
    TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(file, TIFFTAG_PHOTOMETRIC, &meaning);
    if (samples != 1 || (meaning != PHOTOMETRIC_MINISBLACK && meaning != PHOTOMETRIC_MINISWHITE))
        fail(path, "the image has colours or a palette");
    static const std::map<std::pair<int, int>, ValueType> types = {
        {{8, SAMPLEFORMAT_UINT}, ValueType::uint8},      {{8, SAMPLEFORMAT_INT}, ValueType::int8},
        {{16, SAMPLEFORMAT_UINT}, ValueType::uint16},    {{16, SAMPLEFORMAT_INT}, ValueType::int16},
        {{32, SAMPLEFORMAT_UINT}, ValueType::uint32},    {{32, SAMPLEFORMAT_INT}, ValueType::int32},
        {{32, SAMPLEFORMAT_IEEEFP}, ValueType::float32}, {{64, SAMPLEFORMAT_IEEEFP}, ValueType::float64}};
    const auto found = types.find({bits, format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : format});
    if (found == types.end()) fail(path, fmt::format("the values have {} bits", bits));
    page.type = found->second;
    page.inverted = meaning == PHOTOMETRIC_MINISWHITE;
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

}  // namespace

FileVolume open_tiff(const std::vector<Path>& files) {
    const auto first = std::make_shared<File>(open(files.front()));
    const Page page = page_of(first->get(), files.front());
    FileVolume volume{.voxels = {page.width, page.height, 0}, .type = page.type};
    volume.files = files;
    read_spacing(first->get(), volume);
    // ImageJ writes files above 4 GB as one page with all layers behind it.
    if (files.size() == 1) {
        std::int64_t pages = 0;
        const long before = tiff_errors;
        do {
            if (page_of(first->get(), files.front()) != page)
                fail(files.front(), fmt::format("page {} has another size or type", pages + 1));
            ++pages;
        } while (TIFFReadDirectory(first->get()) == 1);
        if (tiff_errors != before) fail(files.front(), fmt::format("page {} is incomplete or damaged", pages + 1));
        char* description = nullptr;
        TIFFSetDirectory(first->get(), 0);
        long images = 0, channels = 1, frames = 1;
        if (TIFFGetField(first->get(), TIFFTAG_IMAGEDESCRIPTION, &description) == 1 && description != nullptr)
            if (const char* at = std::strstr(description, "images=")) images = std::strtol(at + 7, nullptr, 10);
        for (const auto& [key, value] : {std::pair("channels=", &channels), {"frames=", &frames}})
            if (const char* at = description == nullptr ? nullptr : std::strstr(description, key))
                *value = std::strtol(at + std::strlen(key), nullptr, 10);
        if (channels > 1 || frames > 1) fail(files.front(), fmt::format("the image has {} channels and {} frames", channels, frames));
        if (images > pages) fail(files.front(), fmt::format("the description names {} layers, and the file has {} pages", images, pages));
        volume.voxels[2] = pages;
        volume.format = fmt::format("TIFF, {}, {} pages", name_of(page.type), pages);
        volume.read = [first, page, path = files.front()](std::int64_t z, std::span<float> values) {
            const std::size_t layer = std::size_t{page.width} * page.height;
            for (std::size_t done = 0; done < values.size(); done += layer, ++z) {
                // Directories are linked lists: the next page is near.
                const bool there = static_cast<std::int64_t>(TIFFCurrentDirectory(first->get())) + 1 == z
                                       ? TIFFReadDirectory(first->get()) == 1
                                       : TIFFSetDirectory(first->get(), static_cast<tdir_t>(z)) == 1;
                if (!there) fail(path, fmt::format("page {} cannot be read", z + 1));
                read_page(first->get(), page, values.subspan(done, layer), path);
            }
        };
        return volume;
    }
    volume.voxels[2] = static_cast<std::int64_t>(files.size());
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
