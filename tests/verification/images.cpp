// Images of every format, written by the libraries that users' programs use, give the same voxels and axes.
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/json.hpp"
#include "imaging/write_volume.hpp"
#include "io/image.hpp"
#include "pore_space/pore_space.hpp"
#include "scans/phases.hpp"
#include "support/helpers.hpp"
#include "support/image_files.hpp"

namespace porepack {
namespace {

using namespace imaging;
using namespace test::image_files;
using core::UserError;

TEST(Images, Raw) {
    const test::Folder folder;
    const Path file = folder.path() / "l.raw";
    write_values(file, values_of<std::uint8_t>());
    expect_body(file, raw(ValueType::uint8), "raw, uint8");
    write_values(file, values_of<float>());
    expect_body(file, raw(ValueType::float32), "raw, float32");
    std::vector<std::uint16_t> swapped = values_of<std::uint16_t>();
    for (std::uint16_t& value : swapped) value = static_cast<std::uint16_t>(value << 8 | value >> 8);
    write_values(file, swapped);
    ImageConfig big = raw(ValueType::uint16);
    big.byte_order = ByteOrder::big;
    expect_body(file, big, "big byte order");
    // An array [x, y, z] in C order, and one whose z falls.
    write_values(file, values_of<std::int16_t>({2, 1, 0}));
    ImageConfig c_order = raw(ValueType::int16);
    c_order.dims = {4, 5, 6};
    c_order.axes = "zyx";
    expect_body(file, c_order, "int16");
    write_values(file, values_of<std::uint8_t>({1, 0, 2}));
    ImageConfig yx = raw(ValueType::uint8);
    yx.dims = {5, 6, 4};
    yx.axes = "yxz";
    expect_body(file, yx, "raw");
    std::vector<std::uint8_t> turned = values_of<std::uint8_t>();
    std::reverse(turned.begin(), turned.end());
    write_values(file, turned);
    ImageConfig back = raw(ValueType::uint8);
    back.axes = "-x-y-z";
    expect_body(file, back, "raw");
    const Path packed = folder.path() / "l.raw.gz";
    gzFile out = gzopen(packed.c_str(), "wb");
    const std::vector<std::uint8_t> bytes = values_of<std::uint8_t>();
    gzwrite(out, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(out);
    expect_body(packed, raw(ValueType::uint8), "raw");
    // Behind a header.
    std::string with_header = "twelve bytes";
    with_header.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    write_bytes(file, with_header.data(), with_header.size());
    ImageConfig behind = raw(ValueType::uint8);
    behind.header_bytes = 12;
    expect_body(file, behind, "raw");
}

TEST(Images, OwnWritersAndTheirReaders) {
    const test::Folder folder;
    const Path file = folder.path() / "l.raw";
    write_values(file, values_of<std::uint16_t>());
    const VolumeSource source = open_volume(file, raw(ValueType::uint16));
    for (const auto& [name, config, format] : {std::tuple("o.mhd", ImageConfig{.unit_m = 1e-3}, "MetaImage, uint16"),
                                               {"o.nrrd", ImageConfig{}, "NRRD, uint16"},
                                               {"o.npy", sized, "NumPy, uint16, C order"},
                                               {"o.vti", ImageConfig{.unit_m = 1.0}, "`value` at cells, appended"}}) {
        write_volume(folder.path() / name, source);
        expect_body(folder.path() / name, config, format);
    }
}

TEST(Images, NumpyArrays) {
    const test::Folder folder;
    const auto write = [&](const std::string& dictionary, const auto& values, int version) {
        std::string head = "\x93NUMPY";
        head += static_cast<char>(version);
        head += '\0';
        std::string text = dictionary;
        text.append(117 - text.size(), ' ');
        text += '\n';
        head += static_cast<char>(text.size());
        head += '\0';
        if (version > 1) head.append(2, '\0');
        head += text;
        head.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
        write_bytes(folder.path() / "l.npy", head.data(), head.size());
    };
    write("{'descr': '<f4', 'fortran_order': False, 'shape': (4, 5, 6), }", values_of<float>(), 1);
    expect_body(folder.path() / "l.npy", sized, "NumPy, float32, C order (shape 4, 5, 6)");
    write("{'descr': '|u1', 'fortran_order': True, 'shape': (6, 5, 4), }", values_of<std::uint8_t>(), 2);
    expect_body(folder.path() / "l.npy", sized, "NumPy, uint8, Fortran order");
    write("{'descr': '<f8', 'fortran_order': False, 'shape': (6, 5, 4), }", values_of<double>({2, 1, 0}), 1);
    expect_body(folder.path() / "l.npy", {.axes = "zyx", .voxel_size_m = {h}}, "NumPy, float64, C order");
    for (const char* wrong : {"{'descr': '<c8', 'fortran_order': False, 'shape': (4, 5, 6), }",
                              "{'descr': '<f4', 'fortran_order': False, 'shape': (4, 30), }", "{'descr': '<f4', 'shape': (4, 5, 6), }"}) {
        write(wrong, values_of<float>(), 1);
        EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)open_volume(folder.path() / "l.npy", sized); }), "not a NumPy array"))
            << wrong;
    }
}

TEST(Images, RefusedWithTheReason) {
    const test::Folder folder;
    const Path file = folder.path() / "l.raw";
    write_values(file, values_of<std::uint8_t>());
    const auto fault = [&](const Path& path, const ImageConfig& config, const char* message) {
        EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)open_volume(path, config); }), message)) << message;
    };
    const auto changed = [](ImageConfig config, const auto& change) {
        change(config);
        return config;
    };
    const ImageConfig right = raw(ValueType::uint8);
    fault(file, {}, "needs the number of voxels");
    fault(file, changed(right, [](auto& c) { c.dims = {6, 5, 5}; }), "the data have 120 bytes, and 6 x 5 x 5 values");
    fault(file, changed(right, [](auto& c) { c.dims = {6, 5, 3}; }), "the data have 120 bytes");
    fault(file, changed(right, [](auto& c) { c.type = ValueType::uint16; }), "values of 2 bytes");
    fault(file, changed(right, [](auto& c) { c.dims = {1e9, 1e9, 1e9}; }), "so many voxels");
    fault(file, changed(right, [](auto& c) { c.dims = {6.5, 5, 4}; }), "no number of voxels");
    fault(file, changed(right, [](auto& c) { c.axes = "xyx"; }), "does not name the file's three axes");
    fault(file, changed(right, [](auto& c) { c.axes = "xy"; }), "does not name the file's three axes");
    fault(file, changed(right, [](auto& c) { c.voxel_size_m = {}; }), "does not state its voxel size");
    fault(folder.path() / "none.raw", right, "no such image");
    fault(folder.path() / "sub", {}, "no such image");
    folder.write("x.jpg", "x");
    fault(folder.path() / "x.jpg", {}, "the format of the image is not known");
    for (const char* name : {"x.mhd", "x.nrrd", "x.tif", "x.vti", "x.npy"}) {
        folder.write(name, "not an image, but some text that is long enough to be read");
        EXPECT_NE(test::message_of<UserError>([&] { (void)open_volume(folder.path() / name, sized); }), "") << name;
    }
    // Data that are shorter or longer than the header says.
    write_volume(folder.path() / "o.mhd", open_volume(file, right));
    write_volume(folder.path() / "o.nrrd", open_volume(file, right));
    for (const char* name : {"o.raw", "o.nrrd"}) {
        const Path path = folder.path() / name;
        const auto size = std::filesystem::file_size(path);
        for (const auto other : {size - 7, size + 7}) {
            std::filesystem::resize_file(path, other);
            fault(name[2] == 'r' ? folder.path() / "o.mhd" : path, {.unit_m = 1e-3}, "the data have");
        }
        std::filesystem::resize_file(path, size);
    }
    // A voxel size that contradicts the file; in millimetres it agrees.
    write_volume(folder.path() / "o.mhd", open_volume(file, right));
    fault(folder.path() / "o.mhd", {}, "but not its unit");
    fault(folder.path() / "o.mhd", {.voxel_size_m = {3e-5}}, "and 3e-05 x 3e-05 x 3e-05 m are given");
    EXPECT_TRUE(test::has(open_volume(folder.path() / "o.mhd", {.voxel_size_m = {h}}).header.size_source, "as in the file"));
    write_volume(folder.path() / "o.nrrd", open_volume(file, right));
    fault(folder.path() / "o.nrrd", {.unit_m = 1.0}, "--image-unit says 1 m");
    fault(folder.path() / "o.nrrd", {.dims = {6, 5, 4}}, "has no effect here");
    // NaN.
    std::vector<float> holes = values_of<float>();
    holes[17] = std::nanf("");
    write_values(file, holes);
    const VolumeSource source = open_volume(file, raw(ValueType::float32));
    std::vector<float> all(120);
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { source.read(0, all); }), "voxel 17"));
}

TEST(Images, CropBinAndPhases) {
    const test::Folder folder;
    const Path file = folder.path() / "l.raw";
    write_values(file, values_of<std::uint8_t>());
    const VolumeSource part = cropped(open_volume(file, raw(ValueType::uint8)), {.low = {1, 1, 1}, .high = {5, 4, 3}});
    std::vector<float> values(24);
    part.read(0, values);
    for (int z = 0; z < 2; ++z)
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 4; ++x) EXPECT_EQ(values[static_cast<std::size_t>((z * 3 + y) * 4 + x)], value_at(x + 1, y + 1, z + 1));
    EXPECT_NEAR(part.header.origin_m[2], h, 1e-15);
    EXPECT_THROW((void)cropped(open_volume(file, raw(ValueType::uint8)), {.low = {0, 0, 0}, .high = {7, 5, 4}}), UserError);
    const VolumeSource coarse = binned(open_volume(file, raw(ValueType::uint8)), 2);
    ASSERT_EQ(coarse.header.voxels, (std::array<std::int64_t, 3>{3, 2, 2}));
    std::vector<float> means(12);
    coarse.read(0, means);
    double sum = 0.0;
    for (int z = 2; z < 4; ++z)
        for (int y = 0; y < 2; ++y)
            for (int x = 2; x < 4; ++x) sum += value_at(x, y, z) / 8.0;
    EXPECT_NEAR(means[1 * 6 + 0 * 3 + 1], sum, 1e-5);
    EXPECT_NEAR(coarse.header.spacing_m[0], 2 * h, 1e-15);

    ImageConfig gray = raw(ValueType::uint8);
    EXPECT_TRUE(
        test::has(test::message_of<UserError>([&] { (void)segmented(open_volume(file, gray), gray, "l"); }), "no threshold is given"));
    gray.threshold = 100.0;
    const SegmentedImage found = segmented(open_volume(file, gray), gray, "l");
    EXPECT_EQ(std::count(found.image.phase.begin(), found.image.phase.end(), geometry::Phase::grain), 7);
    EXPECT_EQ(found.pore_level, "values below 100");
    gray.pore_side = PoreSide::above;
    const SegmentedImage swapped = segmented(open_volume(file, gray), gray, "l");
    EXPECT_EQ(std::count(swapped.image.phase.begin(), swapped.image.phase.end(), geometry::Phase::pore), 7);
    gray.threshold = 500.0;
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)segmented(open_volume(file, gray), gray, "l"); }),
                          "nothing of the image is pore"));
    gray.threshold.reset();
    gray.pore = {10, 11, 12};
    EXPECT_EQ(segmented(open_volume(file, gray), gray, "l").pore_level, "value 10, 11, 12");
    // A segmented image is its own grid.
    const vessels::Container box = vessels::make_box({n[0] * h, n[1] * h, n[2] * h});
    const pore_space::PoreSpace space = pore_space_of(found.image, box, {0.0, n[2] * h}, "l.raw");
    EXPECT_EQ(space.voxel_size_m(0.0), h);
    EXPECT_EQ(space.voxel_size_m(h), h);
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)space.voxel_size_m(2.0 * h); }), "is its own grid"));
    gray.voxel_size_m = {h, h, 2 * h};
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { (void)segmented(open_volume(file, gray), gray, "l"); }), "no cubes"));
}

// What a hostile reader found: each was taken in silence once.
TEST(Images, NothingIsTakenInSilence) {
    const test::Folder folder;
    const Path file = folder.path() / "l.raw";
    write_values(file, values_of<std::uint8_t>());
    const auto fault = [](const auto& work, const char* message) {
        EXPECT_TRUE(test::has(test::message_of<UserError>(work), message)) << message;
    };
    // Data beside a header are input, too.
    const VolumeSource source = open_volume(file, raw(ValueType::uint8));
    fault([&] { write_volume(folder.path() / "l.mhd", source); }, "over itself");
    folder.write("other.raw", "precious");
    fault([&] { write_volume(folder.path() / "other.mhd", source); }, "over another file");
    write_volume(folder.path() / "o.mhd", source);
    const VolumeSource with_header = open_volume(folder.path() / "o.mhd", {.unit_m = 1e-3});
    fault([&] { write_volume(folder.path() / "o.raw", with_header); }, "over itself");
    // TIFF: a page that is cut off, channels, several pages in a file of a folder.
    const auto values = values_of<std::uint16_t>();
    const std::size_t layer = static_cast<std::size_t>(n[0] * n[1]);
    const auto write_tiff = [&](const Path& path, std::size_t pages, const char* description) {
        TIFF* out = TIFFOpen(path.c_str(), "w");
        for (std::size_t z = 0; z < pages; ++z) tiff_page(out, values.data() + z * layer, z == 0 ? description : nullptr);
        TIFFClose(out);
    };
    write_tiff(folder.path() / "cut.tif", 4, nullptr);
    std::filesystem::resize_file(folder.path() / "cut.tif", std::filesystem::file_size(folder.path() / "cut.tif") * 2 / 3);
    fault([&] { (void)open_volume(folder.path() / "cut.tif", sized); }, "incomplete or damaged");
    write_tiff(folder.path() / "two.tif", 4, "ImageJ=1.53\nimages=4\nchannels=2\nslices=2\nunit=mm\nspacing=0.02\n");
    fault([&] { (void)open_volume(folder.path() / "two.tif", {}); }, "2 channels");
    write_tiff(folder.path() / "zu.tif", 4, "ImageJ=1.53\nimages=4\nslices=4\nunit=mm\nzunit=um\nspacing=20\n");
    fault([&] { (void)open_volume(folder.path() / "zu.tif", {}); }, "does not state its voxel size");
    std::filesystem::create_directories(folder.path() / "stack");
    for (const int z : {1, 2, 4}) write_tiff(folder.path() / "stack" / fmt::format("s_{}.tif", z), 1, nullptr);
    fault([&] { (void)open_volume(folder.path() / "stack", sized); }, "a layer is missing");
    write_tiff(folder.path() / "stack" / "s_3.tif", 2, nullptr);
    const VolumeSource pages = open_volume(folder.path() / "stack", sized);
    std::vector<float> all(static_cast<std::size_t>(pages.header.count()));
    fault([&] { pages.read(0, all); }, "several pages");
    folder.write("stack/a.png", "x");
    fault([&] { (void)open_volume(folder.path() / "stack", sized); }, "several formats");
    // NRRD: units that differ, no spacing, data that are packed and too long, text as data.
    const std::string head = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 5 4\n";
    const auto bytes = values_of<std::uint8_t>();
    const std::string body(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const auto nrrd = [&](const std::string& more, const std::string& data) { return folder.write("t.nrrd", head + more + "\n" + data); };
    expect_body(nrrd("encoding: RAW\n", body), sized, "NRRD, uint8");
    fault([&] { (void)open_volume(nrrd("encoding: raw\n", body), {.unit_m = 1e-3}); }, "does not state its voxel size");
    fault([&] { (void)open_volume(nrrd("encoding: RAW\n", body + "four"), sized); }, "the data have 124 bytes");
    fault([&] { (void)open_volume(nrrd("encoding: ascii\n", "1 2 3"), sized); }, "encoding: ascii");
    fault([&] { (void)open_volume(nrrd("encoding: raw\nspacings: 1 1 1\nunits: \"um\" \"um\" \"mm\"\n", body), {}); }, "the same unit");
    // Packed: a second part that does not belong to it; two members that do.
    const auto gz = [&](const std::vector<std::size_t>& lengths) {
        const Path packed = folder.path() / "l.raw.gz";
        std::filesystem::remove(packed);
        std::size_t at = 0;
        for (const std::size_t length : lengths) {
            gzFile out = gzopen(packed.c_str(), "ab");
            gzwrite(out, bytes.data() + at % bytes.size(), static_cast<unsigned>(length));
            gzclose(out);
            at += length;
        }
        return packed;
    };
    expect_body(gz({50, 70}), raw(ValueType::uint8), "raw");
    fault([&] { (void)statistics_of(open_volume(gz({120, 60}), raw(ValueType::uint8))); }, "bytes follow the last voxel");
    ImageConfig turned = raw(ValueType::uint8);
    turned.axes = "xy-z";
    EXPECT_GT(open_volume(gz({120}), turned).memory_bytes, 0.0) << "read once, not once per layer";
    // Values that single precision rounds.
    std::vector<double> tenths(120, 0.1);
    for (std::size_t i = 0; i < 30; ++i) tenths[i] = 2.0;
    write_values(file, tenths);
    ImageConfig rounded = raw(ValueType::float64);
    rounded.pore = {0.1};
    const SegmentedImage found = segmented(open_volume(file, rounded), rounded, "l");
    EXPECT_EQ(std::count(found.image.phase.begin(), found.image.phase.end(), geometry::Phase::pore), 90);
    rounded.pore = {0.1, 3};
    fault([&] { (void)segmented(open_volume(file, rounded), rounded, "l"); }, "no voxel of the pore value 3");
}

}  // namespace
}  // namespace porepack
