// Segmentation of simulated scans whose grains are known.
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "analysis/segment.hpp"
#include "converters/surface.hpp"
#include "core/members_json.hpp"
#include "imaging/separate.hpp"
#include "imaging/write_volume.hpp"
#include "inputs/pore_space_input.hpp"
#include "io/stl.hpp"
#include "scans/gray_levels.hpp"
#include "support/helpers.hpp"
#include "support/simulated_scan.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using core::Json;
using core::Path;
using core::UserError;
using geometry::GrayImage;
using shapes::Vec3;

// Spheres of 8 mm in contact, 20 voxels each, in a tube of 32 mm: four layers of five, the lowest and the highest cut by the ends.
packing::Packing stacked_spheres() {
    packing::Packing packing{.container = vessels::parse_container("cylinder:0.032,0.024"),
                             .shapes = {shapes::make_preset(shapes::ShapeKind::sphere, 0.008, 0.0)},
                             .bodies = {}};
    for (int k = 0; k < 4; ++k)
        for (const auto& [x, y] : {std::pair(0.0, 0.0), {0.008, 0.0}, {-0.008, 0.0}, {0.0, 0.008}, {0.0, -0.008}})
            packing.bodies.push_back({.shape = 0, .position_m = Vec3(x, y, 0.008 * k)});
    return packing;
}

Path write_scan(const test::Folder& folder, const packing::Packing& packing, const std::function<void(GrayImage&)>& change = {}) {
    GrayImage image = test::simulated_scan(packing::Grains(packing), packing.container, 4e-4,
                                           {.blur_voxels = 0.7, .noise = 0.03, .seed = 2, .tube = true});
    if (change) change(image);
    imaging::write_volume(folder.path() / "scan.nrrd", scans::scan_of(image, 60.0, 180.0, imaging::ValueType::uint8));
    return folder.path() / "scan.nrrd";
}

TEST(Segment, GrainsTubeCavitiesAndCutGrains) {
    const test::Folder folder;
    const packing::Packing packing = stacked_spheres();
    // A cavity in one grain, and dust in the water.
    const Path scan = write_scan(folder, packing, [](GrayImage& image) {
        const geometry::Grid& grid = image.grid;
        const auto ball = [&](const Vec3& centre, double radius, double value) {
            for (int k = 0; k < grid.cells[2]; ++k)
                for (int j = 0; j < grid.cells[1]; ++j)
                    for (int i = 0; i < grid.cells[0]; ++i)
                        if ((Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)) - centre).norm() < radius)
                            image.packed[grid.index(i, j, k)] = GrayImage::pack(value);
        };
        ball(Vec3(0.0, 0.0, 0.008), 0.0014, 0.0);
        ball(Vec3(0.008, 0.008, 0.012), 0.0009, 1.0);
    });
    const Path target = folder.path() / "out";
    std::filesystem::create_directory(target);
    const results::Segment found = written(segment_image(scan, {.find_container = true}, std::nullopt, {}), target);
    EXPECT_NEAR(found.container["diameter_m"].get<double>(), 0.032, 2e-4);
    EXPECT_EQ(found.grains.whole, 10) << json_of(found).dump(1);
    EXPECT_EQ(found.grains.cut, 10);
    EXPECT_EQ(found.grains.speck, 1);
    EXPECT_EQ(found.grains.merged, 0);
    EXPECT_EQ(found.grains.split, 0);
    EXPECT_GT(found.cavity_voxels, 50);
    const double volume = 4.0 / 3.0 * std::numbers::pi * std::pow(0.004, 3.0);
    EXPECT_NEAR(found.median_grain_volume_m3 / volume, 1.0, 0.02);
    // No grain reaches from the removed ones into the section, so its porosity is that of the bed; four slices would be left out.
    ASSERT_TRUE(found.section_m);
    const packing::Section section{found.section_m->low, found.section_m->high};
    EXPECT_NEAR(section.z0_m, 0.0044, 9e-4);
    EXPECT_NEAR(section.z1_m, 0.0196, 9e-4);
    EXPECT_NEAR(*found.porosity, packing::porosity(packing::Grains(packing), packing.container, section).value, 0.004);
    // Every later stage takes the files.
    const pore_space::PoreSpace gray = load_pore_space(target / "gray.vti");
    ASSERT_TRUE(gray.gray());
    EXPECT_NEAR(gray.section.z0_m, section.z0_m, 1e-9);
    EXPECT_NEAR(gray.porosity().value, *found.porosity, 1e-3);
    const pore_space::PoreSpace voxels = load_pore_space(target / "pore.vti");
    ASSERT_TRUE(voxels.own_grid());
    EXPECT_NEAR(voxels.porosity().value, gray.porosity().value, 0.01);
    const auto surface = io::read_stl(target / "solid.stl");
    double of_surface = 0.0;
    for (const auto& triangle : surface.triangles) {
        const auto point = [&](std::size_t corner) {
            const auto& p = surface.points[static_cast<std::size_t>(triangle[corner])];
            return Vec3(p[0], p[1], p[2]);
        };
        of_surface += point(0).dot(point(1).cross(point(2))) / 6.0;
    }
    EXPECT_NEAR(of_surface / (10.0 * volume), 1.0, 0.02) << "closed, and the normals point outwards";
    for (const char* file : {"labels.vti", "grains.csv", "step_1_scan.png", "step_2_threshold.png", "step_3_filled.png",
                             "step_4_grains.png", "step_5_kept.png"})
        EXPECT_TRUE(std::filesystem::exists(target / file)) << file;
}

TEST(Segment, MergedAndSplitGrainsAreFlagged) {
    // Two spheres that overlap deeply stay one grain of twice the volume beside five of one.
    packing::Packing packing{.container = vessels::parse_container("cylinder:0.032,0.032"),
                             .shapes = {shapes::make_preset(shapes::ShapeKind::sphere, 0.008, 0.0)},
                             .bodies = {}};
    for (const auto& at : {Vec3(0.009, 0.0, 0.01), Vec3(-0.009, 0.0, 0.01), Vec3(0.0, 0.009, 0.01), Vec3(0.0, -0.009, 0.01),
                           Vec3(0.009, 0.0, 0.022), Vec3(0.0, 0.0, 0.019), Vec3(0.0, 0.0, 0.025)})
        packing.bodies.push_back({.shape = 0, .position_m = at});
    const test::Folder folder;
    const Path scan = write_scan(folder, packing);
    const auto counted = [&](double separation) {
        return segment_image(scan, {}, packing.container, {.separation = separation}).outcome.result.grains;
    };
    const results::SegmentedGrains merged = counted(0.6), apart = counted(0.2);
    EXPECT_EQ(merged.merged, 1);
    EXPECT_EQ(merged.whole, 5);
    EXPECT_EQ(apart.merged, 0);
    EXPECT_EQ(apart.whole, 7);
}

TEST(Segment, EmptyScansAndScansWithoutATubeAreNamed) {
    const test::Folder folder;
    packing::Packing packing = stacked_spheres();
    packing.bodies.resize(5);
    const Path scan = write_scan(folder, packing);
    const auto message = [&](const imaging::ImageConfig& image, const std::optional<vessels::Container>& container) -> std::string {
        try {
            (void)segment_image(scan, image, container, {});
        } catch (const UserError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_TRUE(test::has(message({}, packing.container), "no grain is left: 5 are cut"));
    EXPECT_TRUE(test::has(message({.find_container = true}, packing.container), "exclude each other"));
    GrayImage open = test::simulated_scan(packing::Grains(packing), packing.container, 4e-4, {.blur_voxels = 0.7});
    imaging::write_volume(folder.path() / "open.nrrd", scans::scan_of(open, 60.0, 180.0, imaging::ValueType::uint8));
    EXPECT_THROW((void)segment_image(folder.path() / "open.nrrd", {.find_container = true}, std::nullopt, {}), UserError);
}

}  // namespace
}  // namespace porepack
