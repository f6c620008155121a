// An image whose axes and values a reader cannot confuse, for tests of formats.
#pragma once

#include <tiffio.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "imaging/volume.hpp"
#include "support/helpers.hpp"

namespace porepack::test::image_files {

using namespace imaging;

// An L with a third, shorter arm: no rotation or mirror image of it is itself. Values below 256, so that all formats hold them.
inline constexpr std::array<int, 3> n = {6, 5, 4};
inline constexpr double h = 2e-5;

inline int value_at(int x, int y, int z) {
    const bool body =
        (y == 1 && z == 1 && x >= 1 && x <= 4) || (x == 1 && z == 1 && y >= 1 && y <= 3) || (x == 1 && y == 1 && z >= 1 && z <= 2);
    return body ? 200 : 10 + x + y;
}

template <typename Value>
std::vector<Value> values_of(const std::array<int, 3>& fastest_first = {0, 1, 2}) {
    std::vector<Value> values;
    std::array<int, 3> at{};
    for (at[2] = 0; at[2] < n[static_cast<std::size_t>(fastest_first[2])]; ++at[2])
        for (at[1] = 0; at[1] < n[static_cast<std::size_t>(fastest_first[1])]; ++at[1])
            for (at[0] = 0; at[0] < n[static_cast<std::size_t>(fastest_first[0])]; ++at[0]) {
                std::array<int, 3> x{};
                for (std::size_t i = 0; i < 3; ++i) x[static_cast<std::size_t>(fastest_first[i])] = at[i];
                values.push_back(static_cast<Value>(value_at(x[0], x[1], x[2])));
            }
    return values;
}

inline void expect_body(const core::Path& path, const ImageConfig& config, const char* format) {
    SCOPED_TRACE(path.filename().string() + ", " + format);
    const VolumeSource source = open_volume(path, config);
    EXPECT_TRUE(has(source.header.format, format)) << source.header.format;
    for (std::size_t i = 0; i < 3; ++i) {
        ASSERT_EQ(source.header.voxels[i], n[i]);
        EXPECT_NEAR(source.header.spacing_m[i] / h, 1.0, 1e-5);
    }
    // Layer by layer, and all at once.
    std::vector<float> all(static_cast<std::size_t>(source.header.count())), layer(static_cast<std::size_t>(source.header.layer()));
    source.read(0, all);
    for (int z = n[2] - 1; z >= 0; --z) {
        source.read(z, layer);
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x) {
                const auto at = static_cast<std::size_t>(y * n[0] + x);
                ASSERT_EQ(layer[at], value_at(x, y, z)) << x << " " << y << " " << z;
                ASSERT_EQ(all[static_cast<std::size_t>(z) * layer.size() + at], layer[at]);
            }
    }
}

inline void write_bytes(const core::Path& path, const void* bytes, std::size_t size) {
    std::ofstream(path, std::ios::binary).write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
}
template <typename Value>
void write_values(const core::Path& path, const std::vector<Value>& values) {
    write_bytes(path, values.data(), values.size() * sizeof(Value));
}

inline const ImageConfig sized = {.voxel_size_m = {h}};
inline ImageConfig raw(ValueType type) {
    return {.dims = {6, 5, 4}, .type = type, .voxel_size_m = {h}};
}

inline void tiff_page(TIFF* file, const std::uint16_t* values, const char* description) {
    TIFFSetField(file, TIFFTAG_IMAGEWIDTH, n[0]);
    TIFFSetField(file, TIFFTAG_IMAGELENGTH, n[1]);
    TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(file, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    if (description != nullptr) {
        TIFFSetField(file, TIFFTAG_IMAGEDESCRIPTION, description);
        TIFFSetField(file, TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
        TIFFSetField(file, TIFFTAG_XRESOLUTION, 1e-3 / h);
        TIFFSetField(file, TIFFTAG_YRESOLUTION, 1e-3 / h);
    }
    for (int y = 0; y < n[1]; ++y) TIFFWriteScanline(file, const_cast<std::uint16_t*>(values + y * n[0]), static_cast<std::uint32_t>(y), 0);
    TIFFWriteDirectory(file);
}

}  // namespace porepack::test::image_files
