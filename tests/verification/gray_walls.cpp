// Walls from gray values: simulated scans of known flows and beds.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/gray_parts.hpp"
#include "analysis/tortuosity.hpp"
#include "core/members_json.hpp"
#include "geometry/gray_filters.hpp"
#include "imaging/write_volume.hpp"
#include "scans/find_tube.hpp"
#include "scans/gray_input.hpp"
#include "support/helpers.hpp"
#include "support/known_flows.hpp"
#include "support/simulated_scan.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using namespace imaging;
using core::UserError;

double gray_permeability(const test::KnownFlow& flow, double voxels, double blur, double noise,
                         std::optional<core::Interval>* interval = nullptr) {
    const geometry::GrayImage scan = test::simulated_scan(*flow.solid, flow.container, flow.diameter_m / voxels, {blur, noise, 3});
    const scans::GrayInput input = scans::read_gray(
        scan_of(scan, 0.0, 1.0), {.threshold = imaging::ThresholdRule::volume, .gray_levels = {0.0, 1.0}}, flow.container, flow.name);
    const pore_space::PoreSpace space = pore_space_of(input.solid, flow.container, {0.0, flow.container.height()}, flow.name);
    EXPECT_NEAR(space.porosity().value, flow.space().porosity().value, 0.002) << flow.name;
    lbm::LbmResult result = lbm_permeability(space, space.voxel_size_m(0.0), {.fields = lbm::FieldFiles::none});
    if (interval != nullptr) {
        add_gray_parts(result, space, {.fields = lbm::FieldFiles::none});
        *interval = result.interval_m2();
    }
    return result.permeability_m2 / flow.permeability_m2 - 1.0;
}

TEST(GrayWalls, ErrorsFallWithTheVoxels) {
    const shapes::Vec3 shift(0.13, 0.29, 0.41);
    const auto loose = test::sphere_array(0.343, 15.39949, test::simple_cubic(), shift);
    const auto touching = test::sphere_array(std::numbers::pi / 6.0, 42.1005, test::simple_cubic(), shift);
    std::vector<double> far, near;
    for (const double voxels : {10.0, 20.0, 40.0}) {
        far.push_back(std::abs(gray_permeability(loose, voxels, 0.5, 0.0)));
        near.push_back(std::abs(gray_permeability(touching, voxels, 0.5, 0.0)));
    }
    EXPECT_LT(far[0], 0.03);
    EXPECT_LT(far[2], 0.003);
    // Contacts: blur of a fixed number of voxels fills them, order 1 or more.
    EXPECT_LT(near[1], 0.5 * near[0]) << near[0];
    EXPECT_LT(near[2], 0.5 * near[1]) << near[1];
    EXPECT_LT(near[2], 0.012);
}

TEST(GrayWalls, TheIntervalHoldsNoiseBlurAndContacts) {
    for (const auto& [solid, drag, centres] : {std::tuple(0.343, 15.39949, test::simple_cubic()),
                                               {std::numbers::pi / 6.0, 42.1005, test::simple_cubic()},
                                               {0.6, 88.8734, test::body_centred()}}) {
        const auto flow = test::sphere_array(solid, drag, centres, {0.4, 0.1, 0.7});
        std::optional<core::Interval> interval;
        const double error = gray_permeability(flow, 20.0, 1.0, 0.03, &interval);
        ASSERT_TRUE(interval.has_value());
        EXPECT_LE(interval->low, flow.permeability_m2) << flow.name << error;
        EXPECT_GE(interval->high, flow.permeability_m2) << flow.name << error;
        EXPECT_LT(interval->high - interval->low, 0.4 * flow.permeability_m2) << "an interval that says nothing";
    }
}

// The tortuosity factors of these arrays: see diffusive_walls.cpp. The constant for contacts comes from the last two with a blur of 0.7
// voxels at 12 and 20 voxels per diameter, and from poured tetrapods; these scans are others.
TEST(GrayWalls, TheIntervalOfTheTortuosityFactorHoldsBlurAndContacts) {
    for (const auto& [solid, exact, centres] : {std::tuple(0.343, 1.1825, test::simple_cubic()),
                                                {std::numbers::pi / 6.0, 1.3865, test::simple_cubic()},
                                                {std::sqrt(3.0) * std::numbers::pi / 8.0, 1.4763, test::body_centred()}})
        for (const double blur : {0.5, 1.1}) {
            const auto flow = test::sphere_array(solid, 1.0, centres, {0.2, 0.6, 0.3});
            const geometry::GrayImage scan = test::simulated_scan(*flow.solid, flow.container, flow.diameter_m / 15.0, {blur, 0.02, 4});
            const scans::GrayInput input =
                scans::read_gray(scan_of(scan, 0.0, 1.0), {.threshold = imaging::ThresholdRule::volume, .gray_levels = {0.0, 1.0}},
                                 flow.container, flow.name);
            const pore_space::PoreSpace space = pore_space_of(input.solid, flow.container, {0.0, flow.container.height()}, flow.name);
            const results::Diffusive found = compute_diffusive_tortuosity(space, {}, core::Axis::z);
            ASSERT_TRUE(found.interval);
            const auto [low, high] = *found.interval;
            std::printf("  %s, blur %g: %.4f (%.4f to %.4f), exact %.4f\n", flow.name.c_str(), blur, found.tortuosity_factor, low, high,
                        exact);
            EXPECT_LE(low, exact) << flow.name;
            EXPECT_GE(high, exact) << flow.name;
            EXPECT_LT(high - low, exact - 1.0) << "an interval that says nothing";
        }
}

// k of an image of half the resolution, computed as a change: that of an image which was made with such voxels.
TEST(GrayWalls, TheAveragedImageIsThatOfLargerVoxels) {
    const auto flow = test::sphere_array(0.343, 15.39949, test::simple_cubic(), {0.13, 0.29, 0.41});
    const auto input_of = [&](double voxels, double blur) {
        const geometry::GrayImage scan = test::simulated_scan(*flow.solid, flow.container, flow.diameter_m / voxels, {blur, 0.0, 3});
        return scans::read_gray(scan_of(scan, 0.0, 1.0), {.threshold = imaging::ThresholdRule::volume, .gray_levels = {0.0, 1.0}},
                                flow.container, flow.name);
    };
    const scans::GrayInput fine = input_of(16.0, 1.4), coarse = input_of(8.0, 0.7);
    const geometry::GrayImage means = averaged(*fine.solid->image(), 2);
    const auto& cells = coarse.solid->image()->grid.cells;
    ASSERT_EQ(means.grid.cells, cells);
    double difference = 0.0;
    for (std::size_t cell = 0; cell < means.grid.size(); ++cell) difference += std::abs(means.at(cell) - coarse.solid->image()->at(cell));
    EXPECT_LT(difference / static_cast<double>(means.grid.size()), 0.02);
    const auto k_of = [&](const scans::GrayInput& input, bool parts, double voxel_m) {
        const pore_space::PoreSpace space = pore_space_of(input.solid, flow.container, {0.0, flow.container.height()}, flow.name);
        lbm::LbmResult result = lbm_permeability(space, voxel_m, {.fields = lbm::FieldFiles::none});
        if (parts) add_gray_parts(result, space, {.fields = lbm::FieldFiles::none});
        return result;
    };
    const double voxel_m = flow.diameter_m / 16.0;
    const lbm::LbmResult of_fine = k_of(fine, true, voxel_m), of_coarse = k_of(coarse, false, voxel_m);
    ASSERT_TRUE(of_fine.averaged_image_change);
    const auto middle = [](const lbm::LbmResult& result) { return result.grids[1].permeability_m2; };
    EXPECT_NEAR(*of_fine.averaged_image_change, middle(of_coarse) / middle(of_fine) - 1.0, 0.003);
    EXPECT_GT(std::abs(*of_fine.averaged_image_change), 0.001);
}

TEST(GrayWalls, LevelsAreFoundAndTheTubeIsSubtracted) {
    const vessels::Container tube = vessels::parse_container("cylinder:0.04,0.04");
    packing::Packing packing{.container = tube, .shapes = {shapes::make_preset(shapes::ShapeKind::sphere, 0.008, 0.0)}, .bodies = {}};
    const double a = 0.0082;
    for (int k = 0; k < 4; ++k)
        for (int j = -2; j <= 2; ++j)
            for (int i = -2; i <= 2; ++i)
                if (std::hypot(i, j) * a < 0.0158)
                    packing.bodies.push_back({.shape = 0, .position_m = shapes::Vec3(i * a, j * a, 0.006 + k * a)});
    const packing::Grains solid(packing);
    const double exact = packing::porosity(solid, tube, {0.0, 0.04}).value;
    for (const double noise : {0.0, 0.05}) {
        const geometry::GrayImage image =
            test::simulated_scan(solid, tube, 4e-4, {.blur_voxels = 0.8, .noise = noise, .seed = 7, .tube = true});
        const scans::GrayInput input =
            scans::read_gray(scan_of(image, 40.0, 180.0), {.threshold = imaging::ThresholdRule::volume}, tube, "scan");
        EXPECT_NEAR(input.notes.pore_level, 40.0, 0.3);
        EXPECT_NEAR(input.notes.solid_level, 180.0, 0.6);
        EXPECT_NEAR(input.notes.noise, noise, 0.2 * noise + 0.002);
        EXPECT_NEAR(std::hypot(0.8, input.notes.smoothing_voxels), input.notes.blur_voxels, 0.12);
        EXPECT_TRUE(input.notes.tube_removed);
        EXPECT_NEAR(packing::porosity(*input.solid, tube, {0.0, 0.04}).value, exact, 0.002) << noise;
        const Tube found = find_tube(scan_of(image, 40.0, 180.0), PoreSide::below, "scan");
        EXPECT_NEAR(found.radius_voxels, 50.0, 0.15);
        EXPECT_NEAR(found.x_voxels, 56.0, 0.1);
        EXPECT_NEAR(found.y_voxels, 56.0, 0.1);
    }
}

// Detector pixels of wrong gain make rings about the axis, the same in all layers: 5 % of the contrast is 15 times those of the simulated
// scanner.
TEST(GrayWalls, RingsHardlyChangeThePorosity) {
    const vessels::Container tube = vessels::parse_container("cylinder:0.04,0.04");
    packing::Packing packing{.container = tube, .shapes = {shapes::make_preset(shapes::ShapeKind::sphere, 0.008, 0.0)}, .bodies = {}};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int i = 0; i < 60; ++i) {
        const double angle = 2.0 * std::numbers::pi * unit(random), r = 0.0155 * std::sqrt(unit(random));
        packing.bodies.push_back(
            {.shape = 0, .position_m = shapes::Vec3(r * std::cos(angle), r * std::sin(angle), 0.004 + 0.032 * unit(random))});
    }
    const packing::Grains solid(packing);
    const double exact = packing::porosity(solid, tube, {0.0, 0.04}).value;
    geometry::GrayImage image = test::simulated_scan(solid, tube, 4e-4, {.blur_voxels = 0.7, .noise = 0.02, .seed = 7, .tube = true});
    std::normal_distribution<double> gain(0.0, 0.05);
    std::vector<double> ring(200);
    for (double& value : ring) value = gain(random);
    const auto& grid = image.grid;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            const auto radius = static_cast<std::size_t>(std::hypot(i + 0.5 - 0.5 * grid.cells[0], j + 0.5 - 0.5 * grid.cells[1]));
            for (int k = 0; k < grid.cells[2]; ++k) {
                const std::size_t cell = grid.index(i, j, k);
                image.packed[cell] = geometry::GrayImage::pack(image.at(cell) + ring[radius]);
            }
        }
    const scans::GrayInput input =
        scans::read_gray(scan_of(image, 40.0, 180.0), {.threshold = imaging::ThresholdRule::volume}, tube, "scan");
    EXPECT_NEAR(packing::porosity(*input.solid, tube, {0.0, 0.04}).value, exact,
                0.003);  // 0.002 as without rings, and half of that for them
    const Tube found = find_tube(scan_of(image, 40.0, 180.0), PoreSide::below, "scan");
    EXPECT_NEAR(found.radius_voxels, 50.0, 0.3);
}

TEST(GrayWalls, WhatCannotBeRightIsRefused) {
    geometry::GrayImage image;
    image.grid = {.cells = {20, 20, 20}, .origin_m = {0, 0, 0}, .spacing_m = {1e-3, 1e-3, 1e-3}};
    image.packed.assign(8000, geometry::GrayImage::pack(0.0));
    const vessels::Container box = vessels::make_box({0.02, 0.02, 0.02});
    const auto message = [&](const ImageConfig& config) -> std::string {
        try {
            (void)scans::read_gray(scan_of(image, 10.0, 90.0), config, box, "scan");
        } catch (const UserError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_TRUE(test::has(message({.threshold = imaging::ThresholdRule::volume}), "all values of the image are 10"));
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0.3, 0.05);  // one phase
    for (std::size_t i = 0; i < image.packed.size(); ++i) image.packed[i] = geometry::GrayImage::pack(noise(random));
    EXPECT_TRUE(test::has(message({.threshold = imaging::ThresholdRule::volume}), "not two peaks"));
    for (std::size_t i = 0; i < 4000; ++i) image.packed[i] = geometry::GrayImage::pack(1.0);
    EXPECT_TRUE(test::has(message({}), "gray walls need a threshold"));
    EXPECT_TRUE(test::has(message({.threshold = 500.0}), "not between the gray levels"));
    EXPECT_TRUE(test::has(message({.threshold = imaging::ThresholdRule::volume, .gray_levels = {90.0, 10.0}}), "do not fit pore_side"));
    EXPECT_EQ(message({.threshold = 50.0}), "accepted");
    // Notes of an image that PorePack wrote: edited ones contradict each other.
    const auto read_own = [&](const core::Json& changed) -> std::string {
        core::Json notes = core::json_of(scans::read_gray(scan_of(image, 10.0, 90.0), {.threshold = 50.0}, box, "scan").notes);
        notes.update(changed);
        VolumeSource source = scan_of(image, 0.0, 1.0);
        source.header.notes["gray"] = notes.dump();
        try {
            (void)scans::read_own_gray(source, box, "gray.vti");
        } catch (const UserError& error) {
            return error.what();
        }
        return "accepted";
    };
    EXPECT_EQ(read_own(core::Json::object()), "accepted");
    for (const core::Json& changed :
         {core::Json{{"level", 0.9}}, core::Json{{"blur_voxels", 1e9}}, core::Json{{"solid_fraction_error", -5}}})
        EXPECT_TRUE(test::has(read_own(changed), "contradicts itself")) << changed.dump();
    EXPECT_TRUE(test::has(read_own({{"level", "x"}}), "not the expected content"));
}

}  // namespace
}  // namespace porepack
