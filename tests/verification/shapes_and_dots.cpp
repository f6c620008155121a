// The shapes of the paper against independent values, and the dot method against its analytic limit.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "shapes/shape.hpp"
#include "support/helpers.hpp"
#include "tortuosity/tortuosity.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

using enum ShapeKind;

struct Row {
    ShapeKind kind;
    double sphericity, d_mm, L_mm, convexity;
};

// Independent values, cavity open, 733 mm3.
constexpr Row rows[] = {
    {tetrapod, 0.99, 9.6047, 1.1276, .9956},  {dolos, 0.99, 9.557, 1.660, .9964},    {tetrahedron, 0.99, 9.2743, 2.2255, .9999},
    {tetrapod, 0.92, 7.8431, 2.7074, .9334},  {dolos, 0.92, 7.6626, 4.0553, .9424},  {tetrahedron, 0.92, 6.1647, 6.5422, .9899},
    {tetrapod, 0.87, 7.2094, 3.4912, .8669},  {dolos, 0.87, 7.1181, 4.9855, .8925},  {tetrahedron, 0.87, 5.3064, 7.9838, .9731},
    {tetrapod, 0.81, 6.5426, 4.5451, .7618},  {dolos, 0.81, 6.4644, 6.4005, .7971},  {tetrahedron, 0.81, 4.9423, 8.6843, .9555},
    {tetrapod, 0.74, 5.8458, 6.0185, .6176},  {dolos, 0.74, 5.7980, 8.3178, .6635},  {tetrahedron, 0.74, 4.6713, 9.3175, .9264},
    {tetrapod, 0.53, 4.0293, 13.8134, .1988}, {dolos, 0.53, 4.0192, 18.6085, .2322}, {tetrahedron, 0.53, 3.6606, 13.3238, .6527},
    {tetrapod, 0.47, 3.5517, 18.0041, .1181}, {dolos, 0.47, 3.5457, 24.1721, .1412}, {tetrahedron, 0.47, 3.3131, 15.7232, .5112},
    {tetrapod, 0.43, 3.2392, 21.7891, .0779}, {dolos, 0.43, 3.2350, 29.2034, .0945}, {tetrahedron, 0.43, 3.0674, 17.9692, .4075},
};

TEST(PaperShapes, MeasuresOfTheTable) {
    for (const Row& row : rows) {
        Shape shape = make_preset(row.kind, row.d_mm, row.L_mm);
        shape.cavity = Cavity::open;
        const ShapeMeasures m = measure(shape);
        // The rounding of the table's digits (5e-5 mm, 5e-4 for the dolos of 0.99).
        const double digits = row.kind == ShapeKind::dolos && row.sphericity == 0.99 ? 5e-4 : 5e-5;
        EXPECT_NEAR(m.volume_m3 / 733.0, 1.0, 3.0 * digits / row.d_mm + 1.5 * 1.1e-5) << name_of(row.kind) << row.sphericity;
        EXPECT_NEAR(m.sphericity / row.sphericity, 1.0, 1.1e-5) << name_of(row.kind) << row.sphericity;
        EXPECT_NEAR(m.volume_m3 / hull(shape).volume_m3, row.convexity, 6e-5 + 2.0 * digits / row.d_mm)
            << name_of(row.kind) << row.sphericity;
    }
}

TEST(PaperShapes, TheInverseFindsDiameterAndLength) {
    for (const Row& row : rows) {
        const Dimensions size = dimensions_for(row.kind, row.sphericity, 733.0, Cavity::open);
        const double digits =
            row.kind == ShapeKind::dolos && row.sphericity > 0.9 ? 5.1e-4 : 1.2e-4;  // the table has four digits in volume and area
        EXPECT_NEAR(size.diameter_m, row.d_mm, digits) << name_of(row.kind) << row.sphericity;
        EXPECT_NEAR(size.length_m, row.L_mm, digits) << name_of(row.kind) << row.sphericity;
    }
    const Dimensions filled = dimensions_for(ShapeKind::tetrahedron, 0.87, 733.0, Cavity::filled);
    EXPECT_NEAR(filled.diameter_m, 5.2884, 1e-4);
    EXPECT_NEAR(filled.length_m, 8.0159, 3e-4);
}

TEST(PaperShapes, MomentsAgreeWithMonteCarlo) {
    const Shape shape = make_preset(ShapeKind::dolos, 1.0, 2.4);
    const ShapeMeasures m = measure(shape);
    const Bounds box = bounds_of(shape.capsules);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const int points = 2000000;
    double inside = 0.0, second = 0.0;
    for (int i = 0; i < points; ++i) {
        const Vec3 x = box.low + (box.high - box.low).cwiseProduct(Vec3(uniform(random), uniform(random), uniform(random)));
        if (signed_distance(shape.capsules, x) >= 0.0) continue;
        inside += 1.0;
        second += x.y() * x.y() + x.z() * x.z();
    }
    const double cell = (box.high - box.low).prod() / points;
    // Three standard errors of the counts.
    EXPECT_NEAR(m.volume_m3 / (inside * cell), 1.0, 3.0 / std::sqrt(inside));
    EXPECT_NEAR(m.inertia_per_density_m5(0, 0) / (second * cell), 1.0, 6.0 / std::sqrt(inside));
}

// Spheres without contacts, at random in a wide box.
Packing separate_spheres(double porosity_target, long& count) {
    Packing packing;
    packing.container = parse_container("box:0.1,0.1,0.1:periodic");
    const double r = 0.006;
    packing.shapes.push_back({.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), r}}});
    count = std::lround((1.0 - porosity_target) * 1e-3 / (4.0 / 3.0 * std::numbers::pi * r * r * r));
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(0.0, 0.1);
    for (long tries = 0; static_cast<long>(packing.bodies.size()) < count && tries < 2000000; ++tries) {
        const Vec3 x(uniform(random), uniform(random), uniform(random));
        bool free = true;
        for (const auto& other : packing.bodies) {
            Vec3 d = x - other.position_m;
            for (int a = 0; a < 3; ++a) d[a] -= 0.1 * std::round(d[a] / 0.1);
            free = free && d.norm() > 2.0 * r;
        }
        if (free) packing.bodies.push_back({.shape = 0, .position_m = x});
    }
    return packing;
}

// Separate spheres inside a cylinder, at 30 places: the exact porosity is known.
TEST(Porosity, ItsUncertaintyHoldsTheError) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(-0.012, 0.012);
    Packing packing{
        .container = parse_container("cylinder:0.05,0.06"), .shapes = {make_preset(ShapeKind::sphere, 0.016, 0.0)}, .bodies = {}};
    const double exact = 1.0 - 3.0 * std::numbers::pi / 6.0 * std::pow(0.016, 3.0) / (packing.container.inner_area_m2() * 0.06);
    int held = 0;
    for (int i = 0; i < 30; ++i) {
        packing.bodies.clear();
        for (const double z : {0.01, 0.03, 0.05})
            packing.bodies.push_back({.shape = 0, .position_m = Vec3(uniform(random), uniform(random), z)});
        const Porosity found = porosity(Grains(packing), packing.container, {0.0, 0.06}, 2000);
        held += std::abs(found.value - exact) <= 3.0 * found.uncertainty ? 1 : 0;
    }
    std::printf("  three uncertainties hold the error in %d of 30 packings\n", held);
    EXPECT_GE(held, 27);  // nine of ten
}

TEST(GeometricPaper, ReachesItsLimitForSeparateSpheres) {
    long count = 0;
    const Packing packing = separate_spheres(0.75, count);
    ASSERT_EQ(static_cast<long>(packing.bodies.size()), count);
    const Grains grains(packing);
    // The limit 1 + (1 - eps)(3 pi/8 - 1) is for infinitely thin slices and no angle rule.
    const double eps = porosity(grains, packing.container, {0.0, 0.1}).value;
    const double limit = 1.0 + (1.0 - eps) * (3.0 * std::numbers::pi / 8.0 - 1.0);
    double error[3];
    int i = 0;
    for (const double slice : {8e-4, 2e-4, 5e-5}) {
        const GeometricPaperResult result = geometric_paper_exact(
            grains, packing.container, {0.0, 0.1}, {.dot_spacing_m = 0.0025, .slice_spacing_m = slice, .largest_angle_deg = 180.0});
        EXPECT_EQ(result.paths, 1600);
        error[i++] = std::abs(result.value - limit);
        std::printf("  slices of %g m: %.4f +- %.4f, limit %.4f\n", slice, result.value, result.standard_error, limit);
        // The excess over 1 within 5 % at the finest: three standard errors of the paths plus the remaining error of the steps.
        if (slice == 5e-5) {
            EXPECT_NEAR(result.value, limit, 3.0 * result.standard_error + 0.02 * (limit - 1.0));
        }
    }
    EXPECT_LE(error[2], error[0] + 1e-3);
}

// Dots above a sphere move radially to its horizontal circles: every path is known, slice by slice.
TEST(GeometricPaper, OneSphereHasThePathsOfItsCircles) {
    const double r = 0.02, spacing = 1e-3;
    Packing packing{
        .container = parse_container("box:0.1,0.1,0.1"), .shapes = {make_preset(ShapeKind::sphere, 2.0 * r, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.05, 0.05, 0.05)});
    const auto length_of = [&](double distance) {
        double length = 0.0, before = distance;
        for (int s = 1; s <= 100; ++s) {
            const double z = s * spacing - 0.05, now = std::max(distance, std::sqrt(std::max(0.0, r * r - z * z)));
            length += std::hypot(now - before, spacing);
            before = now;
        }
        return length;
    };
    double mean = 0.0;
    for (int i = 0; i < 10; ++i)
        for (int j = 0; j < 10; ++j) mean += 0.01 * length_of(std::hypot(0.01 * i - 0.045, 0.01 * j - 0.045)) / 0.1;
    const GeometricPaperResult result = geometric_paper_exact(
        Grains(packing), packing.container, {0.0, 0.1}, {.dot_spacing_m = 0.01, .slice_spacing_m = spacing, .largest_angle_deg = 180.0});
    EXPECT_EQ(result.paths, 100);
    EXPECT_GT(mean, 1.005);
    EXPECT_NEAR((result.value - 1.0) / (mean - 1.0), 1.0, 1e-4);
}

TEST(GeometricPaper, PixelsRaiseIt) {
    const test::Folder folder;
    long count = 0;
    const Packing packing = separate_spheres(0.75, count);
    const Grains grains(packing);
    double before = geometric_paper_exact(grains, packing.container, {0.0, 0.1}, {}).value;
    for (const double pixel : {1e-4, 2e-4, 4e-4}) {
        const Path slices = folder.path() / std::to_string(pixel);
        write_slices(slices, grains, packing.container, {0.0, 0.02}, 2e-4, pixel);
        const double value = geometric_paper_on_slices(read_slices(slices), {}).value;
        EXPECT_GT(value, before) << pixel;
        before = value;
        // The same without image files: the pixels are evaluated directly from the grains.
        const double laid = geometric_paper_exact(grains, packing.container, {0.0, 0.02}, {.dot_pixel_m = pixel}).value;
        EXPECT_NEAR((laid - 1.0) / (value - 1.0), 1.0, 0.1) << pixel;
    }
}

TEST(GeometricPaper, AnEmptyBoxGivesExactlyOne) {
    const Packing packing{.container = parse_container("cylinder:0.1,0.1"), .shapes = {}, .bodies = {}};
    const GeometricPaperResult result = geometric_paper_exact(Grains(packing), packing.container, {0.0, 0.1}, {});
    EXPECT_EQ(result.value, 1.0);
    EXPECT_EQ(result.rejections_per_point, 0.0);
}

}  // namespace
}  // namespace porepack
