// What `porepack design` predicts by, and the grains among which it chooses.
#include "design/surrogate.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "design/candidates.hpp"
#include "support/basics.hpp"

namespace porepack {
namespace {

using namespace design;
using namespace shapes;
using vessels::Container;

double smooth(double x, double y) {
    return std::sin(3.0 * x) + 0.5 * y * y;
}

struct Observations {
    Eigen::MatrixXd x;
    Eigen::VectorXd y;
};
Observations observe(Eigen::Index number, double noise, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(0.0, 1.0);
    std::normal_distribution<double> error(0.0, 1.0);
    Observations all{Eigen::MatrixXd(number, 2), Eigen::VectorXd(number)};
    for (Eigen::Index i = 0; i < number; ++i) {
        all.x(i, 0) = place(random);
        all.x(i, 1) = 40.0 * place(random);  // the coordinates may have any units
        all.y[i] = smooth(all.x(i, 0), all.x(i, 1) / 40.0) + noise * error(random);
    }
    return all;
}

TEST(GaussianProcess, ErrorsFallWithTheNumberOfObservations) {
    const Observations test = observe(200, 0.0, 99);
    double before = 1e9;
    for (const Eigen::Index number : {10, 20, 40}) {
        const Observations known = observe(number, 0.0, 5);
        const GaussianProcess process(known.x, known.y);
        double sum = 0.0;
        for (Eigen::Index i = 0; i < test.y.size(); ++i) sum += std::pow(process.at(test.x.row(i)).value - test.y[i], 2);
        const double rms = std::sqrt(sum / 200.0);
        EXPECT_LT(rms, before / 3.0) << number << " observations of a smooth function";
        before = rms;
    }
    EXPECT_LT(before, 2e-3);
}

TEST(GaussianProcess, StandardDeviationsAreThoseOfNewObservations) {
    const Observations known = observe(60, 0.1, 1), test = observe(400, 0.1, 2);
    const GaussianProcess process(known.x, known.y);
    EXPECT_NEAR(process.noise(), 0.1, 0.03) << "sixty observations tell a standard deviation within 10 %";
    double sum = 0.0;
    for (Eigen::Index i = 0; i < test.y.size(); ++i) {
        const design::Estimate e = process.at(test.x.row(i));
        sum += std::pow((test.y[i] - e.value) / e.standard_deviation, 2);
    }
    EXPECT_NEAR(std::sqrt(sum / 400.0), 1.0, 0.15);
    EXPECT_GT(process.at(Eigen::Vector2d(5.0, 300.0)).standard_deviation, 3.0 * process.at(Eigen::Vector2d(0.5, 20.0)).standard_deviation)
        << "far from all observations";
}

TEST(GaussianProcess, LeavingOneOutIsAFitWithoutIt) {
    const Observations known = observe(25, 0.02, 3);
    const GaussianProcess all(known.x, known.y);
    for (const Eigen::Index i : {0, 7, 24}) {
        Observations others{Eigen::MatrixXd(24, 2), Eigen::VectorXd(24)};
        for (Eigen::Index from = 0, to = 0; from < 25; ++from)
            if (from != i) others.x.row(to) = known.x.row(from), others.y[to++] = known.y[from];
        // Its own s and l_j differ a little from those of all observations.
        const design::Estimate quick = all.leave_one_out(i), fitted = GaussianProcess(others.x, others.y).at(known.x.row(i));
        EXPECT_NEAR(quick.value, fitted.value, 0.5 * fitted.standard_deviation);
        EXPECT_NEAR(quick.standard_deviation / fitted.standard_deviation, 1.0, 0.25);
    }
}

TEST(GaussianProcess, ACoordinateThatNeverChangesDoesNotMatter) {
    const Observations known = observe(20, 0.0, 4);
    Eigen::MatrixXd wider(20, 3);
    wider << known.x, Eigen::VectorXd::Constant(20, 7.0);
    const design::Estimate two = GaussianProcess(known.x, known.y).at(Eigen::Vector2d(0.4, 15.0));
    const design::Estimate three = GaussianProcess(wider, known.y).at(Eigen::Vector3d(0.4, 15.0, 7.0));
    EXPECT_NEAR(two.value, three.value, 1e-6);
}

// Beds whose porosity is a function of the convexity, and whose Kozeny constant is 5.
double porosity_in_theory(double convexity) {
    return 0.35 + 0.45 * (1.0 - convexity) * (1.0 - convexity);
}
double permeability_in_theory(const GrainForm& form) {
    const double eps = porosity_in_theory(form.convexity), s = 6.0 * (1.0 - eps) / form.sphericity;
    return eps * eps * eps / (5.0 * s * s);
}
GrainForm form_at(double t) {
    return {.sphericity = 0.45 + 0.5 * t, .convexity = 0.15 + 0.8 * t * t, .thickness = 0.3 + 0.5 * t, .feret = 3.0 - 1.8 * t};
}

TEST(Surrogate, FindsTheKozenyConstant) {
    std::vector<KnownBed> beds;
    for (int i = 0; i <= 8; ++i) {
        const GrainForm form = form_at(i / 8.0);
        beds.push_back({.name = "bed",
                        .form = form,
                        .wall = 0.11,
                        .packings = 3,
                        .porosity = porosity_in_theory(form.convexity),
                        .permeability = permeability_in_theory(form)});
    }
    const Surrogate surrogate(beds);
    for (const double t : {0.31, 0.55, 0.82}) {
        const Prediction p = surrogate.at(form_at(t), 0.11);
        EXPECT_NEAR(p.porosity.value, porosity_in_theory(form_at(t).convexity), 0.005);
        EXPECT_NEAR(p.log_permeability.value, std::log(permeability_in_theory(form_at(t))), 0.05);
        EXPECT_FALSE(p.extrapolated);
    }
    EXPECT_TRUE(surrogate.at(form_at(1.3), 0.11).extrapolated);
    EXPECT_TRUE(surrogate.at(form_at(0.5), 0.2).extrapolated) << "a narrower container";
    EXPECT_GT(surrogate.at(form_at(1.3), 0.11).porosity.standard_deviation, surrogate.at(form_at(0.5), 0.11).porosity.standard_deviation);
}

TEST(Surrogate, WallRatios) {
    const auto box = [](bool x, bool y) { return vessels::make_box({0.1, 0.2, 0.5}, {x, y, false}); };
    EXPECT_NEAR(wall_ratio(0.01, vessels::make_cylinder(0.1, 1.0)), 0.1, 1e-15);
    EXPECT_NEAR(wall_ratio(0.01, box(false, false)), 0.01 * 0.6 / 0.08, 1e-15);
    EXPECT_NEAR(wall_ratio(0.01, box(true, false)), 0.01 * 0.2 / 0.08, 1e-15);
    EXPECT_EQ(wall_ratio(0.01, box(true, true)), 0.0);
}

TEST(Candidates, PresetsHaveUnitSizeAndTheirSphericity) {
    const std::vector<Candidate> all = preset_candidates(ShapeKind::tetrapod, {0.5, 0.9});
    ASSERT_GT(all.size(), 30U);
    for (const Candidate& one : {all.front(), all.back()}) {
        const ShapeMeasures m = measure(make_shape(one.shape));
        EXPECT_NEAR(m.volume_m3, std::numbers::pi / 6.0, 1e-4);
        EXPECT_NEAR(m.sphericity, one.form.sphericity, 1e-4);
        EXPECT_GE(one.form.sphericity, 0.5);
        EXPECT_LE(one.form.sphericity, 0.9);
    }
    const Dimensions known = dimensions_for(ShapeKind::tetrapod, 0.7, 1.0, Cavity::filled);
    const double size = std::cbrt(6.0 / std::numbers::pi);
    const auto nearest = std::min_element(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
        return std::abs(a.form.sphericity - 0.7) < std::abs(b.form.sphericity - 0.7);
    });
    EXPECT_NEAR(nearest->form.thickness, known.diameter_m / size, 0.02) << "grains are 0.01 of sphericity apart";
}

TEST(Candidates, OfAUsersShape) {
    const ShapeConfig ell{.kind = ShapeKind::capsules,
                          .capsule = {{.a = Vec3(0, 0, 0), .b = Vec3(0.01, 0, 0), .radius = 0.002},
                                      {.a = Vec3(0, 0, 0), .b = Vec3(0, 0.01, 0), .radius = 0.002}}};
    EXPECT_EQ(own_candidates("ell", ell, {}).size(), 1U);
    const std::vector<Candidate> longer = own_candidates("ell", ell, {parse_free_parameter("capsule.2.length_m=0.005,0.02")});
    ASSERT_EQ(longer.size(), 100U);
    EXPECT_NEAR(longer.back().shape.capsule[1].b.norm() / longer.back().shape.capsule[0].b.norm(), 2.0, 1e-12);
    EXPECT_LT(longer.back().form.sphericity, longer.front().form.sphericity);
    EXPECT_EQ(
        own_candidates("ell", ell, {parse_free_parameter("radius_m=0.001,0.002"), parse_free_parameter("capsule.1.length_m=0.01,0.02")})
            .size(),
        100U);
    EXPECT_THROW((void)own_candidates("ell", ell, {parse_free_parameter("capsule.3.radius_m=1,2")}), core::UserError);
    for (const char* text : {"radius_m", "radius_m=2,1", "radius_m=1", "radius_m=1,2,3", "radius_m=0,1", "radius_m=1,nan"})
        EXPECT_THROW((void)parse_free_parameter(text), core::UserError) << text;
}

// The wall of a ring is free.
TEST(Candidates, OfAGrainWithFaces) {
    const ShapeConfig ring{.kind = ShapeKind::ring, .diameter_m = 0.01, .height_m = 0.01, .inner_diameter_m = 0.006};
    const std::vector<Candidate> walls = own_candidates("ring", ring, {parse_free_parameter("inner_diameter_m=0.002,0.008")});
    ASSERT_EQ(walls.size(), 100U);
    EXPECT_LT(walls.back().form.thickness, 0.4 * walls.front().form.thickness);
    EXPECT_LT(walls.back().form.convexity, walls.front().form.convexity);
    const double size = std::cbrt(6.0 * measure(make_shape(walls.back().shape)).volume_m3 / std::numbers::pi);
    EXPECT_NEAR(size, 1.0, 1e-9) << "in units of d_v";
    EXPECT_NEAR(walls.back().shape.inner_diameter_m / walls.back().shape.diameter_m, 0.8, 1e-12);
    EXPECT_THROW((void)own_candidates("ring", ring, {parse_free_parameter("side_m=1,2")}), core::UserError);
    const std::vector<Candidate> cylinders = preset_candidates(ShapeKind::cylinder, {0.7, 0.99});
    ASSERT_GT(cylinders.size(), 20U);
    for (const Candidate& one : cylinders) EXPECT_LE(one.form.sphericity, 0.9);
    EXPECT_EQ(preset_candidates(ShapeKind::cube, {0.0, 1.0}).size(), 1U);
}

}  // namespace
}  // namespace porepack
