// Damaged files for every reader: each is refused with an error of this program, or read, and then an independent small reader finds the
// same. POREPACK_FUZZ=100000 tests more files than the default, POREPACK_FUZZ_SEED others.
#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "core/json.hpp"
#include "falling_head/level_curve.hpp"
#include "imaging/write_volume.hpp"
#include "io/image.hpp"
#include "lbm/checkpoint.hpp"
#include "pore_space/pore_space.hpp"
#include "stages/case.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

long environment(const char* name, long standard) {
    const char* text = std::getenv(name);
    return text == nullptr ? standard : std::atol(text);
}

// Changes a text at one to three places: bytes, pieces, and numbers.
class Mutator {
public:
    Mutator() : random_(static_cast<unsigned>(environment("POREPACK_FUZZ_SEED", 1))) {}

    std::string change(std::string text) {
        for (std::size_t places = 1 + below(3); places > 0; --places) change_once(text);
        return text;
    }

private:
    std::size_t below(std::size_t end) { return end == 0 ? 0 : random_() % end; }

    void change_once(std::string& text) {
        static const std::vector<std::string> words = {"nan",
                                                       "inf",
                                                       "-inf",
                                                       "1e400",
                                                       "-1",
                                                       "0",
                                                       "1e-300",
                                                       "1e300",
                                                       "-0.0",
                                                       "0.01",
                                                       "0.02",
                                                       "1",
                                                       "2",
                                                       "4294967296",
                                                       "true",
                                                       "null",
                                                       "\"",
                                                       "\"\"",
                                                       "{",
                                                       "}",
                                                       "[",
                                                       "]",
                                                       "[]",
                                                       "{}",
                                                       ",",
                                                       ":",
                                                       "=",
                                                       "\n",
                                                       "#",
                                                       std::string(1, '\0'),
                                                       "\xff\xfe",
                                                       "\xc3\x28",
                                                       "a_m",
                                                       std::string(3000, '['),
                                                       std::string(400, '9')};
        const std::size_t at = below(text.size() + 1), length = std::min(text.size() - at, 1 + below(40));
        switch (below(11)) {
            case 0:
                if (at < text.size()) text[at] = static_cast<char>(below(256));
                break;
            case 1:
                text.erase(at, length);
                break;
            case 2:
                text.insert(below(text.size() + 1), text.substr(at, length));
                break;
            case 3:
                text.insert(at, words[below(words.size())]);
                break;
            case 4:
                text.resize(at);
                break;
            case 5:
            case 6:
            case 7:  // another value of the same kind
                if (const std::size_t digit = text.find_first_of("0123456789", at); digit != std::string::npos)
                    text[digit] = static_cast<char>('0' + below(10));
                break;
            default:
                replace_number(text, at, words[below(words.size())]);
        }
    }
    static void replace_number(std::string& text, std::size_t from, const std::string& word) {
        const std::size_t first = text.find_first_of("0123456789", from);
        if (first == std::string::npos) return;
        const std::size_t end = std::min(text.size(), text.find_first_not_of("0123456789.e-+", first));
        text.replace(first, end - first, word);
    }

    std::mt19937 random_;
};

// Counts what `read` accepts. Any exception but our own, or a crash, is a failure. `slow`: a tenth of the files, unless POREPACK_FUZZ says
// how many.
template <typename Read>
void fuzz(const std::string& name, const std::string& good, const Read& read, bool slow = false) {
    const test::Folder folder;
    Mutator mutator;
    ASSERT_NO_THROW(read(folder.write(name, good))) << "the good file must be accepted";
    long accepted = 0;
    const long count = environment("POREPACK_FUZZ", slow ? 25 : 250);
    for (long i = 0; i < count && !::testing::Test::HasFailure(); ++i) {
        const std::string text = mutator.change(good);
        const Path file = folder.write(name, text);
        try {
            read(file);
            ++accepted;
        } catch (const core::Error& refused) {
            EXPECT_NE(refused.code(), core::ExitCode::machine) << refused.what();
            EXPECT_STRNE(refused.what(), "");
        } catch (const std::exception& other) {
            ADD_FAILURE() << "not an error of ours: " << other.what();
        }
        if (::testing::Test::HasFailure()) std::printf("file %ld:\n%s\n", i, text.substr(0, 3000).c_str());
    }
    std::printf("  %s: %ld of %ld accepted\n", name.c_str(), accepted, count);
}

// ---- a small reader of packings of its own

Vec3 vector_of(const Json& json) {
    return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

// Share of random points of the container that are in no grain. Bodies beyond a periodic face count in their images.
double porosity_by_points(const Json& packing, int points) {
    struct Rod {
        Vec3 a, b;
        double radius;
    };
    std::vector<Rod> rods;
    for (const Json& body : packing["bodies"])
        for (const Json& shape : packing["shapes"]) {
            if (shape["id"] != body["shape"]) continue;
            const Json& q = body["orientation"];
            const Eigen::Matrix3d turn =
                Quaternion(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>()).normalized().toRotationMatrix();
            for (const Json& capsule : shape["capsules"])
                rods.push_back({turn * vector_of(capsule["a_m"]) + vector_of(body["position_m"]),
                                turn * vector_of(capsule["b_m"]) + vector_of(body["position_m"]), capsule["radius_m"].get<double>()});
        }
    const Json& container = packing["container"];
    const bool cylinder = container["kind"] == "cylinder";
    const double width = cylinder ? container["diameter_m"].get<double>() : 0.0;
    const Vec3 size = cylinder ? Vec3(width, width, container["height_m"].get<double>()) : vector_of(container["size_m"]);
    std::array<bool, 3> periodic = {false, false, false};
    if (container.contains("periodic"))
        for (std::size_t a = 0; a < 3; ++a) periodic[a] = container["periodic"][a].get<bool>();
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const auto images = [&](int axis) { return periodic[static_cast<std::size_t>(axis)] ? 1 : 0; };
    long inside = 0, pores = 0;
    while (inside < points) {
        Vec3 p(uniform(random) * size.x(), uniform(random) * size.y(), uniform(random) * size.z());
        if (cylinder) p -= Vec3(0.5 * width, 0.5 * width, 0.0);
        if (cylinder && p.head<2>().norm() > 0.5 * width) continue;
        ++inside;
        bool solid = false;
        for (int i = -images(0); i <= images(0); ++i)
            for (int j = -images(1); j <= images(1); ++j)
                for (int k = -images(2); k <= images(2); ++k)
                    for (const Rod& rod : rods) {
                        const Vec3 shifted = p + Vec3(i * size.x(), j * size.y(), k * size.z()), axis = rod.b - rod.a;
                        const double t =
                            axis.squaredNorm() > 0.0 ? std::clamp((shifted - rod.a).dot(axis) / axis.squaredNorm(), 0.0, 1.0) : 0.0;
                        solid = solid || (shifted - rod.a - t * axis).norm() < rod.radius;
                    }
        pores += solid ? 0 : 1;
    }
    return static_cast<double>(pores) / static_cast<double>(points);
}

TEST(Fuzz, Packings) {
    Packing packing{.container = parse_container("box:0.03,0.03,0.05"),
                    .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0), make_preset(ShapeKind::rod, 0.006, 0.01)},
                    .bodies = {}};
    for (int i = 0; i < 4; ++i) packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.0151, 0.0149, 0.006 + 0.0105 * i)});
    packing.bodies.push_back(
        {.shape = 1, .position_m = Vec3(0.026, 0.015, 0.02), .orientation = Quaternion(Eigen::AngleAxisd(0.4, Vec3::UnitX()))});
    const test::Folder folder;
    write_packing(folder.path() / "good.json", packing);
    fuzz("packing.json", read_text(folder.path() / "good.json"), [](const Path& file) {
        const PoreSpace space = pore_space_of(read_packing(file));
        const Section all{0.0, space.container.height()};
        constexpr int points = 20000;
        const double expected = porosity_by_points(Json::parse(read_text(file)), points);
        EXPECT_NEAR(porosity(*space.grains(), space.container, all, 4000).value, expected, 5.0 * std::sqrt(0.25 / points));
    });
}

TEST(Fuzz, Surfaces) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("box:0.03,0.03,0.05"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.015, 0.015, 0.01)});
    write_stl(folder.path() / "good.stl", make_surface(packing, {.deviation_m = 4e-4, .max_volume_error = 0.1}).surface);
    // The volume by the triangles as they lie in the file: 80 bytes, their number, 50 bytes each.
    fuzz("grains.stl", read_text(folder.path() / "good.stl"), [](const Path& file) {
        const SurfaceCheck check = check_surface(read_stl(file));
        require_sound(check, file.string());
        const std::string bytes = read_text(file);
        double volume = 0.0;
        for (std::size_t at = 84; at + 50 <= bytes.size(); at += 50) {
            float numbers[12];
            std::memcpy(numbers, bytes.data() + at, sizeof numbers);
            const auto corner = [&](int c) { return Vec3(numbers[3 + 3 * c], numbers[4 + 3 * c], numbers[5 + 3 * c]); };
            volume += corner(0).dot(corner(1).cross(corner(2))) / 6.0;
        }
        EXPECT_NEAR(check.volume_m3, volume, 1e-4 * std::abs(volume) + 1e-15);
    });
}

TEST(Fuzz, LevelCurves) {
    std::string text = "# packing: A\ntime_s,level_m\n";
    for (int i = 0; i < 40; ++i) text += fmt::format("{},{}\n", 0.04 * i, 1.3 - 0.02 * i);
    fuzz("curve.csv", text, [](const Path& file) {
        const LevelCurve curve = read_level_curve(file);
        ASSERT_EQ(curve.time_s.size(), curve.level_m.size());
        for (std::size_t i = 0; i < curve.time_s.size(); ++i) {
            EXPECT_TRUE(std::isfinite(curve.time_s[i]) && std::isfinite(curve.level_m[i]));
            if (i > 0) {
                EXPECT_GT(curve.time_s[i], curve.time_s[i - 1]);
            }
        }
    });
}

// All tables, and a union of capsules.
TEST(Fuzz, Cases) {
    const std::string text =
        "[shape]\nkind = \"capsules\"\n[[shape.capsule]]\na_m = [0.0, 0.0, 0.0]\nb_m = [0.01, 0.0, 0.0]\nradius_m = 0.003\n"
        "[[shape.capsule]]\na_m = [0.0, 0.0, 0.0]\nb_m = [0.0, 0.01, 0.0]\nradius_m = 0.003\n"
        "[container]\nkind = \"cylinder\"\ndiameter_m = 0.05\nheight_m = 0.15\n[packing]\ngrains = 60\nseed = 1\n"
        "[geometry]\nsection_m = [0.02, 0.05]\n[section]\nends = \"in_situ\"\nbuffer_m = 0.01\n[lbm]\ntolerance = 0.02\nfields = \"none\"\n"
        "[forchheimer]\nenabled = true\nreynolds = [1, 2, 5]\n[falling_head]\nsample_length_m = 0.12\n";
    fuzz("case.toml", text, [](const Path& file) {
        const Case read = read_case(file);
        const Json tables = Case(read).settings.resolved_tables(Settings::tables());
        EXPECT_EQ(tables.dump().find("nan"), std::string::npos);
        for (const ShapeShare& share : make_shapes(read.settings.shape)) {
            EXPECT_FALSE(share.shape.capsules.empty());
            for (const Capsule& capsule : share.shape.capsules)
                EXPECT_TRUE(capsule.a.allFinite() && capsule.b.allFinite() && capsule.radius > 0.0);
        }
    });
}

TEST(Fuzz, Checkpoints) {
    const test::Folder folder;
    SavedRun saved{.identity = "a run", .attempts = 1, .relaxation_time = 1.2, .grids = {}, .run = {}};
    saved.run.steps = 400;
    saved.run.history.push_back({.step = 40, .permeability_lu = 0.1});
    saved.run.balance.density = {0.1, 0.2, 0.3};
    PhaseImage image{.grid = {.cells = {2, 2, 2}}, .phase = std::vector<std::uint8_t>(8, Phase::pore), .notes = {}};
    const Domain domain = build_domain(image, {.axis = 2, .periodic = {true, true, true}}, nullptr);
    const auto flow = make_flow(Kernel::reference, domain, {});
    write_checkpoint(folder.path() / "good", saved, *flow, domain);
    fuzz("lbm.checkpoint", read_text(folder.path() / "good"), [&](const Path& file) {
        (void)read_checkpoint(file);
        read_checkpoint_populations(file, *flow, domain);
        std::vector<double> read(19 * domain.nodes());
        flow->populations(0, std::as_writable_bytes(std::span(read)));
        for (const double population : read) EXPECT_TRUE(std::isfinite(population));
    });
}

// One layer of a CT series in explicit little endian, 6 x 5 pixels of 16 bits, at z = 1 mm times `number`.
std::string dicom_layer(int number, const std::string& pixels) {
    const auto little = [](std::uint32_t value, int count) {
        std::string text;
        for (int i = 0; i < count; ++i) text += static_cast<char>(value >> (8 * i));
        return text;
    };
    const auto element = [&](std::uint32_t group, std::uint32_t number_in_group, const std::string& kind, std::string value) {
        if (value.size() % 2 == 1) value += kind == "UI" ? '\0' : ' ';
        const bool is_long = kind == "OW" || kind == "OB";
        return little(group, 2) + little(number_in_group, 2) + kind +
               (is_long ? std::string(2, '\0') + little(static_cast<std::uint32_t>(value.size()), 4)
                        : little(static_cast<std::uint32_t>(value.size()), 2)) +
               value;
    };
    const std::string id = "1.2.826.0.1.3680043.2.1125.", ct = "1.2.840.10008.5.1.4.1.1.2", instance = id + std::to_string(10 + number);
    const std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct) + element(2, 3, "UI", instance) +
                             element(2, 0x10, "UI", "1.2.840.10008.1.2.1") + element(2, 0x12, "UI", id + "1");
    return std::string(128, '\0') + "DICM" + element(2, 0, "UL", little(static_cast<std::uint32_t>(meta.size()), 4)) + meta +
           element(8, 0x16, "UI", ct) + element(8, 0x18, "UI", instance) + element(8, 0x60, "CS", "CT") + element(0x18, 0x50, "DS", "1.0") +
           element(0x20, 0xd, "UI", id + "2") + element(0x20, 0xe, "UI", id + "3") + element(0x20, 0x13, "IS", std::to_string(number + 1)) +
           element(0x20, 0x32, "DS", "0\\0\\" + std::to_string(number)) + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0") +
           element(0x28, 2, "US", little(1, 2)) + element(0x28, 4, "CS", "MONOCHROME2") + element(0x28, 0x10, "US", little(5, 2)) +
           element(0x28, 0x11, "US", little(6, 2)) + element(0x28, 0x30, "DS", "1.0\\1.0") + element(0x28, 0x100, "US", little(16, 2)) +
           element(0x28, 0x101, "US", little(16, 2)) + element(0x28, 0x102, "US", little(15, 2)) +
           element(0x28, 0x103, "US", little(0, 2)) + element(0x7fe0, 0x10, "OW", pixels);
}

// What is read lies in `bytes` of the files.
void expect_sound(const imaging::VolumeSource& source, std::uintmax_t bytes) {
    const imaging::VolumeHeader& header = source.header;
    const imaging::VolumeStatistics found = imaging::statistics_of(source);
    ASSERT_LE(static_cast<std::uintmax_t>(header.count()) * imaging::size_of(header.type), bytes) << header.format;
    EXPECT_TRUE(std::isfinite(found.mean) && found.minimum <= found.maximum);
}

// No format of these is compressed.
TEST(Fuzz, Images) {
    const test::Folder folder;
    std::string bytes;
    for (int i = 0; i < 240; ++i) bytes += static_cast<char>(i);
    const Path raw = folder.write("source.raw", bytes);
    const imaging::VolumeSource good =
        imaging::open_volume(raw, {.dims = {6, 5, 4}, .type = imaging::ValueType::uint16, .voxel_size_m = {1e-3}});
    const Path tiff = folder.path() / "good.tif";
    TIFF* file = TIFFOpen(tiff.c_str(), "w");
    for (int z = 0; z < 4; ++z) {
        TIFFSetField(file, TIFFTAG_IMAGEWIDTH, 6);
        TIFFSetField(file, TIFFTAG_IMAGELENGTH, 5);
        TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 16);
        TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 1);
        TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        for (std::uint32_t y = 0; y < 5; ++y) TIFFWriteScanline(file, bytes.data() + (z * 5 + static_cast<int>(y)) * 12, y, 0);
        TIFFWriteDirectory(file);
    }
    TIFFClose(file);
    // fuzz() uses a folder of the same name: all good files are made before.
    std::vector<std::pair<std::string, std::string>> files;
    for (const char* kind : {".nrrd", ".npy", ".vti", ".mhd", ".tif"}) {
        const Path path = folder.path() / (std::string("good") + kind);
        if (path.extension() != ".tif") imaging::write_volume(path, good);
        files.emplace_back(std::string("image") + kind, read_text(path));
    }
    for (const auto& [name, text] : files)
        fuzz(name, text, [&](const Path& changed) {
            const bool header_alone = changed.extension() == ".mhd";
            if (header_alone) core::write_text(changed.parent_path() / "good.raw", bytes);
            const imaging::VolumeSource source = imaging::open_volume(changed, {.voxel_size_m = {1e-3}});
            expect_sound(source, header_alone ? bytes.size() : std::filesystem::file_size(changed));
        });
}

// One layer of three is damaged.
TEST(Fuzz, Layers) {
    const test::Folder folder;
    std::string pixels;
    for (int i = 0; i < 60; ++i) pixels += static_cast<char>(i);
    io::write_gray_png(folder.path() / "good.png", 6, 5, std::vector<std::uint8_t>(pixels.begin(), pixels.begin() + 30));
    const std::string png = read_text(folder.path() / "good.png");
    fuzz("slice_1.png", png, [&](const Path& changed) {
        for (const char* name : {"slice_0.png", "slice_2.png"}) core::write_text(changed.parent_path() / name, png);
        expect_sound(imaging::open_volume(changed.parent_path(), {.voxel_size_m = {1e-3}}), 90);
    });
    // GDCM takes memory for a length before it looks at the file.
    const auto dicom = [&](const Path& changed) {
        for (const int number : {0, 2})
            core::write_text(changed.parent_path() / fmt::format("slice_{}.dcm", number), dicom_layer(number, pixels));
        expect_sound(imaging::open_volume(changed.parent_path(), {}), 180);
    };
    fuzz("slice_1.dcm", dicom_layer(1, pixels), dicom, true);
}

}  // namespace
}  // namespace porepack
