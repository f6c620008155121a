// Images as other programs leave them: what their pages mean, what is missing, what a library does not survive.
#include <fmt/format.h>
#include <signal.h>
#include <tiffio.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/own_process.hpp"
#include "imaging/volume.hpp"
#include "io/image.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using namespace imaging;
using test::has;
using test::message_of;

constexpr int nx = 5, ny = 4, nz = 3, layer = nx * ny;
const ImageConfig sized{.voxel_size_m = {1e-3}};

std::vector<std::uint8_t> ramp(int count = layer * nz) {
    std::vector<std::uint8_t> values(static_cast<std::size_t>(count));
    std::iota(values.begin(), values.end(), std::uint8_t{1});
    return values;
}

struct Tags {
    int meaning = PHOTOMETRIC_MINISBLACK, orientation = ORIENTATION_TOPLEFT;
    std::string description = {};
    bool preview_last = false;
    int pages = nz;
};

Path tiff(const test::Folder& folder, const Tags& tags) {
    const Path path = folder.path() / "image.tif";
    TIFF* file = TIFFOpen(path.c_str(), "w");
    std::vector<std::uint8_t> values = ramp(layer * tags.pages);
    for (int z = 0; z < tags.pages; ++z) {
        const bool preview = tags.preview_last && z + 1 == tags.pages;
        TIFFSetField(file, TIFFTAG_IMAGEWIDTH, nx);
        TIFFSetField(file, TIFFTAG_IMAGELENGTH, preview ? 1 : ny);
        TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 8);
        TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
        TIFFSetField(file, TIFFTAG_ROWSPERSTRIP, ny);
        TIFFSetField(file, TIFFTAG_PHOTOMETRIC, tags.meaning);
        TIFFSetField(file, TIFFTAG_ORIENTATION, tags.orientation);
        if (preview) TIFFSetField(file, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
        if (z == 0 && !tags.description.empty()) TIFFSetField(file, TIFFTAG_IMAGEDESCRIPTION, tags.description.c_str());
        std::vector<std::uint16_t> colours(256, 0);
        if (tags.meaning == PHOTOMETRIC_PALETTE) TIFFSetField(file, TIFFTAG_COLORMAP, colours.data(), colours.data(), colours.data());
        for (int y = 0; y < (preview ? 1 : ny); ++y)
            TIFFWriteScanline(file, values.data() + z * layer + y * nx, static_cast<std::uint32_t>(y), 0);
        TIFFWriteDirectory(file);
    }
    TIFFClose(file);
    return path;
}

std::vector<float> values_in(const Path& path) {
    const VolumeSource source = open_volume(path, sized);
    std::vector<float> values(static_cast<std::size_t>(source.header.count()));
    source.read(0, values);
    return values;
}

std::string refusal(const Path& path) {
    return message_of<UserError>([&] { (void)values_in(path); });
}

TEST(ForeignImages, PagesOfATiffAreLayersOnlyIfNothingSaysOtherwise) {
    const test::Folder folder;
    for (const char* one : {"", "ImageJ=1.54\nimages=3\nslices=3\n", "{\"shape\": [3, 4, 5]}", "{\"shape\": [1, 3, 4, 5]}",
                            "<?xml version=\"1.0\"?><OME><Pixels SizeC=\"1\" SizeT=\"1\" SizeX=\"5\" SizeY=\"4\" SizeZ=\"3\"/></OME>"})
        EXPECT_EQ(values_in(tiff(folder, {.description = one})).size(), 60U) << one;
    for (const char* other : {"ImageJ=1.54\nimages=3\nchannels=3\n", "ImageJ=1.54\nimages=3\nframes=3\n",
                              "<?xml version=\"1.0\"?><OME><Pixels SizeC=\"3\" SizeT=\"1\" SizeZ=\"1\"/></OME>",
                              "<OME><Pixels SizeC=\"1\" SizeT=\"3\"/></OME>"})
        EXPECT_TRUE(has(refusal(tiff(folder, {.description = other})), "channels and")) << other;
    EXPECT_TRUE(has(refusal(tiff(folder, {.description = "{\"shape\": [2, 3, 4, 5]}", .pages = 6})), "an array of 4 axes: [2,3,4,5]"));
    EXPECT_EQ(values_in(tiff(folder, {.preview_last = true, .pages = 4})).size(), 60U) << "a preview is no layer";
}

// One directory, and the values of all layers behind each other, as ImageJ writes above 4 GB.
std::string one_page(const std::string& description, int layers) {
    std::string bytes("II*\0", 4);
    const auto number = [&](std::uint32_t value, int size) {
        bytes.append(reinterpret_cast<const char*>(&value), static_cast<std::size_t>(size));
    };
    const std::vector<std::array<std::uint32_t, 4>> entries = {
        {256, 4, 1, nx},   {257, 4, 1, ny}, {258, 3, 1, 8},
        {259, 3, 1, 1},    {262, 3, 1, 1},  {270, 2, static_cast<std::uint32_t>(description.size() + 1), 0},
        {273, 4, 1, 0},    {277, 3, 1, 1},  {278, 4, 1, ny},
        {279, 4, 1, layer}};
    const auto text = static_cast<std::uint32_t>(8 + 2 + 12 * entries.size() + 4),
               values = text + static_cast<std::uint32_t>(description.size() + 1);
    number(8, 4);
    number(static_cast<std::uint32_t>(entries.size()), 2);
    for (const auto& [tag, type, count, value] : entries) {
        number(tag, 2);
        number(type, 2);
        number(count, 4);
        number(tag == 270 ? text : tag == 273 ? values : value, 4);
    }
    number(0, 4);
    bytes += description + std::string(1, '\0');
    const std::vector<std::uint8_t> all = ramp(layer * layers);
    return bytes + std::string(all.begin(), all.end());
}

TEST(ForeignImages, LayersBehindOnePageOfATiff) {
    const test::Folder folder;
    const std::string description = "ImageJ=1.54\nimages=3\nslices=3\n";
    const Path path = folder.write("one.tif", one_page(description, nz));
    EXPECT_EQ(open_volume(path, sized).header.format, "TIFF, uint8, 3 layers behind one page");
    // The same values as with a page for each layer.
    EXPECT_EQ(values_in(path), values_in(tiff(folder, {.description = description})));
    EXPECT_TRUE(has(refusal(folder.write("cut.tif", one_page(description, nz - 1))), "names 3 layers, and the file has 1 pages"));
}

TEST(ForeignImages, WhatWouldChangeTheMeaningOfAValueIsRefused) {
    const test::Folder folder;
    EXPECT_TRUE(has(refusal(tiff(folder, {.meaning = PHOTOMETRIC_MINISWHITE})), "white is zero"));
    EXPECT_TRUE(has(refusal(tiff(folder, {.meaning = PHOTOMETRIC_PALETTE})), "a lookup table"));
    EXPECT_TRUE(has(refusal(tiff(folder, {.orientation = ORIENTATION_BOTLEFT})), "turned or mirrored (orientation 4)"));
}

TEST(ForeignImages, ACutPngOfAStackIsNamed) {
    const test::Folder folder;
    const Path pictures = folder.path() / "s";
    make_folder(pictures);
    for (int z = 0; z < nz; ++z) write_gray_png(pictures / fmt::format("{}.png", z), nx, ny, ramp(layer));
    EXPECT_EQ(values_in(folder.path() / "s").size(), 60U);
    const std::string whole = read_text(folder.path() / "s/1.png");
    for (const std::size_t kept : {std::size_t{20}, whole.size() / 2, whole.size() - 20}) {
        write_text(folder.path() / "s/1.png", whole.substr(0, kept));
        EXPECT_TRUE(has(refusal(folder.path() / "s"), "1.png")) << kept;
    }
}

constexpr const char* vti_start =
    "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><ImageData WholeExtent=\"0 3 0 1 0 2\" "
    "Origin=\"0 0 0\" Spacing=\"1e-3 1e-3 1e-3\"><Piece Extent=\"0 3 0 1 0 2\"><CellData><DataArray type=\"UInt8\" Name=\"v\" format=\"";
constexpr const char* vti_end = "</DataArray></CellData></Piece></ImageData></VTKFile>";

TEST(ForeignImages, TextAndBase64OfAVtiAreReadToTheLetter) {
    const test::Folder folder;
    const std::vector<float> values = {1, 2, 3, 4, 5, 6};
    const auto file = [&](const std::string& rest) { return folder.write("a.vti", vti_start + rest + vti_end); };
    // Length and values encoded in one, and apart.
    EXPECT_EQ(values_in(file("binary\">BgAAAAECAwQFBg==")), values);
    EXPECT_EQ(values_in(file("binary\">BgAAAA==AQIDBAUG")), values);
    EXPECT_EQ(values_in(file("ascii\"> 1 2 3\n4 5 6 ")), values);
    for (const char* wrong : {"binary\">BgAAAAEC AwQFBg==", "binary\">BgAAAA==AQI=BAUG", "binary\">BwAAAA==AQIDBAUG",
                              "binary\">BgAAAA==AQID", "ascii\">1 2 3 4 5", "ascii\">1 2 3 4 5 300", "ascii\">1 2 3 4 5 -1",
                              "ascii\">1 2 3 4 5 1.5", "ascii\">1 2 3 4 5 6 7", "ascii\">1 2 3 4 5 0x6"})
        EXPECT_NE(refusal(file(wrong)), "") << wrong;
    std::string deep;
    for (int i = 0; i < 100000; ++i) deep += "<a>";
    EXPECT_TRUE(has(refusal(folder.write("b.vti", "<VTKFile>" + deep)), "b.vti"));
}

TEST(ForeignImages, FieldsOfANrrdAreUnderstoodOrRefused) {
    const test::Folder folder;
    const auto file = [&](const std::string& fields, const std::string& before = {}) {
        return folder.write("a.nrrd",
                            "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 1 2\nencoding: raw\n" + fields + "\n" + before + "\1\2\3\4\5\6");
    };
    const std::vector<float> values = {1, 2, 3, 4, 5, 6};
    for (const auto& [fields, before] :
         {std::pair("", ""), {"kinds: domain domain domain\n", ""}, {"byte skip: 4\n", "abcd"}, {"byteskip: -1\n", "xyz"}})
        EXPECT_EQ(values_in(file(fields, before)), values) << fields;
    for (const char* wrong : {"kinds: RGB-color domain domain\n", "kinds: domain domain time\n", "kinds: list domain domain\n",
                              "sizes: 3 2 1\n", "byte skip: 2\n", "line skip: 1\n", "old min: 0\n", "gamma: 2\n",
                              "spacings: 1e305 1e305 1e305\nunits: \"mm\" \"mm\" \"mm\"\n", "spacings: 1e-313 1 1\n", "data file: LIST\n"})
        EXPECT_NE(refusal(file(wrong)), "") << wrong;
}

TEST(ForeignImages, NamesOfLayersDifferInOneNumberThatGrowsEvenly) {
    const test::Folder folder;
    int made = 0;
    const auto folder_with = [&](const std::vector<std::string>& names) {
        const Path in = folder.path() / fmt::format("stack_{}", ++made);
        std::filesystem::create_directories(in);
        for (const std::string& name : names) std::filesystem::copy_file(tiff(folder, {.pages = 1}), in / name);
        return in;
    };
    const auto stack = [&](const std::vector<std::string>& names) {
        return message_of<UserError>([&] { (void)open_volume(folder_with(names), sized); });
    };
    for (const auto& good : std::vector<std::vector<std::string>>{{"a9.tif", "a10.tif", "a11.tif"},
                                                                  {"r_00_8bit.tif", "r_01_8bit.tif", "r_02_8bit.tif"},
                                                                  {"z0.5mm.tif", "z1.0mm.tif", "z1.5mm.tif"},
                                                                  {"i_153000_0.tif", "i_153007_1.tif", "i_153009_2.tif"},
                                                                  {"b000.tif", "b002.tif", "b004.tif"}})
        EXPECT_EQ(open_volume(folder_with(good), sized).header.voxels[2], 3) << good[0];
    EXPECT_TRUE(
        has(stack({"r_00_8bit.tif", "r_01_8bit.tif", "r_03_8bit.tif"}), "between r_01_8bit.tif and r_03_8bit.tif the number grows by 2"));
    EXPECT_TRUE(has(stack({"s0.tif", "s1.tif", "s2.tif", "a_preview.tif"}), "a_preview.tif is not named as s0.tif"));
    EXPECT_TRUE(has(stack({"s0.tif", "s1.tif", "s1 (copy).tif"}), "s1 (copy).tif is not named as s0.tif"));
    EXPECT_TRUE(has(stack({"a.tif", "b.tif"}), "is not named as"));
}

TEST(ForeignImages, TheHeaderOfAnArrayIsParsed) {
    const test::Folder folder;
    const auto file = [&](const std::string& header) {
        const std::string text = header + "\n";
        return folder.write("a.npy", std::string("\x93NUMPY\1\0", 8) + static_cast<char>(text.size()) + '\0' + text + "\1\2\3\4\5\6");
    };
    const std::vector<float> values = {1, 2, 3, 4, 5, 6};
    for (const char* right : {"{'shape': (2, 1, 3), 'fortran_order': False, 'descr': '|u1'}",
                              "{\"descr\": \"|u1\", 'fortran_order': True, 'shape': (3, 1, 2,)}"})
        EXPECT_EQ(values_in(file(right)), values) << right;
    for (const char* wrong :
         {"{'descr': '|u1', 'fortran_order': False, 'fortran_order': True, 'shape': (2, 1, 3)}",
          "{'descr': '|u1', 'fortran_order': 0, 'shape': (2, 1, 3)}",
          "{'x': \"'fortran_order': True\", 'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 3)}",
          "{'descr': '|u1', 'fortran_order': False, 'shape': (6,)}", "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 3)} x"})
        EXPECT_NE(refusal(file(wrong)), "") << wrong;
}

TEST(OwnProcess, ResultsErrorsAndDeaths) {
    SharedBytes shared(3);
    EXPECT_EQ(in_own_process(
                  [&] {
                      shared.bytes()[1] = 'x';
                      return std::string(100000, 'a');
                  },
                  [] { return std::string("it failed"); }),
              std::string(100000, 'a'));
    EXPECT_EQ(shared.bytes()[1], 'x');
    EXPECT_EQ(message_of<UserError>([] {
                  (void)in_own_process([]() -> std::string { throw UserError("bad input"); }, [] { return std::string("it failed"); });
              }),
              "bad input");
    EXPECT_TRUE(has(message_of<MachineError>(
                        [] { (void)in_own_process([]() -> std::string { throw MachineError("full"); }, [] { return std::string(); }); }),
                    "full"));
    for (const auto& death : std::vector<std::function<std::string()>>{[]() -> std::string { std::abort(); },
                                                                       []() -> std::string { throw std::runtime_error("of a library"); },
                                                                       []() -> std::string { _exit(0); },
                                                                       []() -> std::string {
                                                                           raise(SIGSEGV);
                                                                           return "";
                                                                       }})
        EXPECT_TRUE(has(message_of<UserError>([&] { (void)in_own_process(death, [] { return std::string("it failed"); }); }), "it failed"));
    EXPECT_TRUE(has(message_of<UserError>([] {
                        (void)in_own_process(
                            []() -> std::string {
                                for (volatile bool on = true; on;) {
                                }
                                return "";
                            },
                            [] { return std::string("it failed"); }, 1.0);
                    }),
                    "it failed"));
}

}  // namespace
}  // namespace porepack
