// Menisci between grains, against their exact volume.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "pore_space/closing.hpp"
#include "support/basics.hpp"
#include "vessels/config.hpp"

namespace porepack {
using namespace packing;
using namespace vessels;
using namespace pore_space;
namespace {

using test::has;
using test::message_of;

// Two balls of radius R that touch, upright in a wide box.
Packing two_balls(double R, const char* box) {
    Packing packing{
        .container = parse_container(box), .shapes = {{.id = "ball", .capsules = {{Vec3::Zero(), Vec3::Zero(), R}}}}, .bodies = {}};
    const Vec3 middle = 0.5 * (packing.container.low() + packing.container.high());
    for (const double side : {-1.0, 1.0}) packing.bodies.push_back({.shape = 0, .position_m = middle + Vec3(0.0, 0.0, side * R)});
    return packing;
}

// A ball of radius r that touches both rolls around them: its centre on a circle of radius rho, its surface the neck's. From the axis to
// the neck, less both caps.
double meniscus_volume(double R, double r) {
    const double rho = std::sqrt((R + r) * (R + r) - R * R), top = R * r / (R + r);
    double volume = 0.0;
    constexpr int parts = 20000;
    for (int n = 0; n < parts; ++n) {
        const double z = top * (n + 0.5) / parts, neck = rho - std::sqrt(r * r - z * z);
        volume += 2.0 * std::numbers::pi * (neck * neck - (R * R - (R - z) * (R - z))) * top / parts;
    }
    return volume;
}

// Volume of the solid of a signed distance: each cell by its wall's place.
double volume_of(const std::vector<float>& distance, const Grid& grid) {
    double volume = 0.0;
    for (const float d : distance) volume += std::clamp(0.5 - d / grid.spacing_m[0], 0.0, 1.0);
    return volume * std::pow(grid.spacing_m[0], 3);
}

TEST(Closing, AMeniscusHasItsExactVolume) {
    const double R = 1.0, r = 0.4;
    const Grains grains(two_balls(R, "box:3.6,3.6,4.8:periodic"));
    std::vector<double> errors;
    for (const int per_radius : {3, 6, 12}) {
        const double h = r / per_radius;
        const Grid grid{.cells = {static_cast<int>(std::lround(3.6 / h)), static_cast<int>(std::lround(3.6 / h)),
                                  static_cast<int>(std::lround(4.8 / h))},
                        .origin_m = {0.0, 0.0, 0.0},
                        .spacing_m = {h, h, h}};
        const double solid = volume_of(closed_distances(grains, grid, r, {true, true, true}), grid);
        errors.push_back(std::abs(solid - 2.0 * 4.0 / 3.0 * std::numbers::pi * R * R * R - meniscus_volume(R, r)) / meniscus_volume(R, r));
        std::printf("  %d cells per radius: %.2g of the meniscus's volume\n", per_radius, errors.back());
    }
    EXPECT_LT(errors[0], 0.2);
    EXPECT_LT(errors[2], 0.015);
    EXPECT_GT(std::log2(errors[0] / errors[2]) / 2.0, 1.5);  // order
}

TEST(Closing, IsPartOfThePoreSpace) {
    const double R = 1.0, r = 0.4;
    const PoreSpace dry = pore_space_of(two_balls(R, "box:3.6,3.6,4.8")).with_section({0.4, 4.4});
    const PoreSpace wet = closed(dry, r);
    // In the box's upright edges lie menisci, too: a ball leaves (1 - pi/4) r^2 of each.
    const double volume = 3.6 * 3.6 * 4.0, edges = (4.0 - std::numbers::pi) * r * r * 4.0,
                 menisci = (meniscus_volume(R, r) + edges) / volume;
    EXPECT_NEAR(dry.porosity().value - wet.porosity().value, menisci, 0.06 * menisci);
    EXPECT_EQ(wet.grains(), nullptr);
    // Through a periodic side: half of each ball lies beyond it.
    const PoreSpace middle = closed(pore_space_of(two_balls(R, "box:3.6,3.6,4.8:periodic")).with_section({0.4, 4.4}), r);
    Packing shifted = two_balls(R, "box:3.6,3.6,4.8:periodic");
    for (Body& body : shifted.bodies) body.position_m.x() -= 1.8;
    const PoreSpace beyond = closed(pore_space_of(std::move(shifted)).with_section({0.4, 4.4}), r);
    EXPECT_NEAR(beyond.porosity().value, middle.porosity().value, 2e-5);
    EXPECT_NEAR(dry.porosity().value - middle.porosity().value, meniscus_volume(R, r) / volume, 0.1 * meniscus_volume(R, r) / volume);
    // Two balls that touch a periodic side from within, at the same place: their meniscus lies on both sides of it.
    Packing touching = two_balls(R, "box:5.2,3.6,4.8:periodic");
    touching.bodies[0].position_m = Vec3(R, 1.8, 2.4);
    touching.bodies[1].position_m = Vec3(5.2 - R, 1.8, 2.4);
    const PoreSpace apart = pore_space_of(touching).with_section({0.4, 4.4}), across = closed(apart, r);
    const double share = meniscus_volume(R, r) / (5.2 * 3.6 * 4.0);
    EXPECT_NEAR(apart.porosity().value - across.porosity().value, share, 0.1 * share);
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)closed(wet, r); }), "menisci are made between the grains of a packing"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)closed(dry, 1e-4); }), "need an image of"));
}

}  // namespace
}  // namespace porepack
