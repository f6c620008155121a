// Grains of a poured bed, moved at random by as much as a fit's errors, and brought to rest again.
#include "pouring/dem/relax.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "analysis/relax.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"
#include "packing/structure.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using test::has;
using test::message_of;

constexpr double d = 0.004;

// The pour of the tests below; its grains are at rest.
const Packing& poured() {
    static const test::Folder folder;
    static const Packing bed =
        pour_with_capsules({{.shape = make_preset(ShapeKind::tetrapod, d, 0.008)}}, parse_container("cylinder:0.045,0.09"),
                           {.grains = 40, .settle_time_s = 10.0}, folder.path())
            .packing;
    return bed;
}

Packing displaced(Packing packing, double by_m) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0.0, by_m);
    for (Body& body : packing.bodies) {
        for (int axis = 0; axis < 3; ++axis) body.position_m[axis] += normal(random);
        const Vec3 turn(normal(random), normal(random), normal(random));
        body.orientation = (Quaternion(1.0, turn.x() / 0.016, turn.y() / 0.016, turn.z() / 0.016) * body.orientation).normalized();
    }
    return packing;
}

double mean_neighbours(const Packing& packing, double gap_m = 0.0) {
    return structure_of(packing, gap_m, d, 1).mean_neighbours;
}

TEST(Relax, BringsBackContactsThatErrorsOfAFitTookAway) {
    constexpr double error = 1e-5;  // 0.03 voxels of 0.33 mm
    const Packing bed = displaced(poured(), error);
    const double truth = mean_neighbours(poured());
    ASSERT_LT(mean_neighbours(bed), 0.8 * truth);
    const Relaxed found = relax(bed, {});
    EXPECT_NEAR(mean_neighbours(found.packing), truth, 0.06 * truth);
    EXPECT_GT(found.overlap_before_m, 2e-5);
    EXPECT_LT(found.overlap_after_m, 1.5 * find_overlaps(poured()).largest_between_grains_m);
    std::vector<double> moved = found.moved_m;
    std::nth_element(moved.begin(), moved.begin() + 20, moved.end());
    EXPECT_LT(moved[20], 5.0 * error);
    EXPECT_GT(moved[20], 0.5 * error);
    EXPECT_LT(found.mean_force_over_weight, 0.02);
}

// A part cut out of the bed: what reaches through the floor carries the others and stays where it is.
TEST(Relax, HoldsWhatReachesThroughACutFloor) {
    const Packing part = cut_out(poured(), {0.014, 0.044});
    const Relaxed found = relax(displaced(part, 5e-6), {});
    const auto held = std::count(found.held.begin(), found.held.end(), true);
    EXPECT_GT(held, 2);
    EXPECT_LT(held, static_cast<long>(part.bodies.size()) - 5);
    for (std::size_t i = 0; i < part.bodies.size(); ++i)
        if (found.held[i]) EXPECT_LT(found.moved_m[i], 1e-4) << i;  // overlaps were removed before it was held
    // The bed does not fall: without the held grains all of it would.
    EXPECT_LT(*std::max_element(found.moved_m.begin(), found.moved_m.end()), 0.5 * d);
}

TEST(Relax, RefusesWhatItCannotDo) {
    Packing two{.container = parse_container("box:0.05,0.05,0.05"), .shapes = {make_preset(ShapeKind::sphere, d, 0.0)}, .bodies = {}};
    two.bodies = {{.position_m = {0.02, 0.02, 0.01}}, {.position_m = {0.0215, 0.02, 0.01}}};
    EXPECT_TRUE(has(message_of<core::UserError>([&] { (void)relax(two, {}); }), "grains 0 and 1 overlap by 0.63"));
    const Packing given = displaced(poured(), 0.0);
    EXPECT_TRUE(has(message_of<core::UserError>([&] { (void)relax_packing(given, {.seed = 7}); }), "`seed` has no effect"));
    EXPECT_TRUE(has(message_of<core::UserError>([&] { (void)relax_packing(given, {.engine = Engine::liggghts}); }), "DEM of exact shapes"));
}

}  // namespace
}  // namespace porepack
