// packing.json, containers, porosity, sections, structure.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <random>
#include <string>

#include "core/error.hpp"
#include "packing/film.hpp"
#include "packing/grains.hpp"
#include "packing/packing.hpp"
#include "packing/porosity.hpp"
#include "packing/structure.hpp"
#include "support/basics.hpp"
#include "support/l_shaped.hpp"
#include "vessels/config.hpp"
#include "vessels/cylinder.hpp"

namespace porepack {
using namespace shapes;
using namespace packing;
using namespace vessels;
namespace {

using test::has;
using test::message_of;

TEST(Packing, IsReadBackAsWritten) {
    const test::Folder folder;
    Packing packing = test::l_shaped();
    packing.overlap_allowed = true;  // it reaches through the wall
    packing.bodies[0].orientation = Quaternion(0.5, 0.5, -0.5, 0.5);
    write_packing(folder.path() / "a.json", packing);
    write_packing(folder.path() / "b.json", read_packing(folder.path() / "a.json"));
    EXPECT_EQ(read_text(folder.path() / "a.json"), read_text(folder.path() / "b.json"));
    ASSERT_EQ(std::system(("cd " + test::quoted(folder.path()) + " && gzip -k a.json").c_str()), 0);
    EXPECT_EQ(read_packing(folder.path() / "a.json.gz").bodies.size(), 1U);
}

TEST(Packing, FaultsAreNamedWithTheirPlace) {
    const test::Folder folder;
    const auto fault = [&](const std::string& text) {
        return message_of<UserError>([&] { (void)read_packing(folder.write("p.json", text)); });
    };
    const std::string head =
        R"({"format":"porepack-packing","version":1,"container":{"kind":"cylinder","diameter_m":0.1,"height_m":0.2},"shapes":[{"id":"s","capsules":[{"a_m":[0,0,0],"b_m":[0,0,0],"radius_m":0.01}]}],"bodies":[)";
    EXPECT_TRUE(has(fault(""), "the file is empty"));
    EXPECT_TRUE(has(fault("{"), "not valid JSON"));
    EXPECT_TRUE(has(fault("{}"), "`format` is missing"));
    EXPECT_TRUE(has(fault(head + R"({"shape":"t","position_m":[0,0,0.1],"orientation":[1,0,0,0]}]})"), "no such shape in this file: t"));
    EXPECT_TRUE(has(fault(head + R"({"shape":"s","position_m":[0,0,100],"orientation":[1,0,0,0]}]})"), "outside the container"));
    EXPECT_TRUE(has(fault(head + R"({"shape":"s","position_m":[0,0,0.1],"orientation":[2,0,0,0]}]})"), "not a unit quaternion"));
    EXPECT_TRUE(has(fault(head + R"({"shape":"s","position_m":[0,null,0.1],"orientation":[1,0,0,0]}]})"), "/bodies[0]/position_m[1]"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)read_packing(folder.path()); }), "is a folder"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)read_packing(folder.path() / "none.json"); }), "no such file"));
}

// Two spheres that touch, in a box whose floor cuts the film of one.
TEST(Film, IsTheShapeWithALargerRadius) {
    Packing packing{.container = vessels::make_box({1.0, 1.0, 2.0}),
                    .shapes = {{.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), 0.2}}}},
                    .bodies = {{.position_m = Vec3(0.5, 0.5, 0.2)}, {.position_m = Vec3(0.5, 0.5, 0.6)}}};
    const double r = 0.25;
    const auto ball = [](double radius) { return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius; };
    const auto cap = [](double radius, double height) { return std::numbers::pi * height * height * (radius - height / 3.0); };
    const double exact = 1.0 - (2.0 * ball(r) - cap(r, 0.05) - 2.0 * cap(r, 0.05)) / 2.0;
    const Packing wet = coated(packing, 0.05);
    EXPECT_TRUE(wet.overlap_allowed);
    const Porosity found = porosity(Grains(wet), wet.container, {0.0, 2.0}, 200000);
    EXPECT_NEAR(found.value, exact, 2e-5);
    const double filled = 1.0 - 2.0 * ball(0.2) / 2.0 - exact;
    EXPECT_NEAR(film_thickness(packing, {0.0, 2.0}, filled), 0.05, 1e-4);
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)film_thickness(packing, {0.0, 2.0}, 0.99); }), "less than the porosity"));
    packing.shapes[0] = {.id = "ring", .body = make_ring({0.4, 0.1, 0.2, 0.02})};
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)coated(packing, 0.06); }), "closes the hole of the grain `ring`"));
    EXPECT_EQ(coated(packing, 0.04).shapes[0].body->to_json().at("inner_diameter_m").get<double>(), 2.0 * (0.05 + 0.02 - 0.06));
}

TEST(Porosity, OneSphereInABoxAndAcrossAPeriodicCorner) {
    Packing packing;
    packing.container = vessels::make_box(Vec3::Ones());
    packing.shapes.push_back({.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), 0.4}}});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3::Constant(0.5)});
    const double exact = 1.0 - 4.0 / 3.0 * std::numbers::pi * 0.064;
    const Porosity middle = porosity(Grains(packing), packing.container, {0.0, 1.0});
    EXPECT_NEAR(middle.value, exact, 1e-4);
    EXPECT_LT(middle.uncertainty, 1e-3);
    packing.container = vessels::make_box(Vec3::Ones(), {true, true, true});
    packing.bodies[0].position_m = Vec3::Zero();
    EXPECT_NEAR(porosity(Grains(packing), packing.container, {0.0, 1.0}).value, exact, 1e-4);
}

TEST(Section, DefaultsTrimAndTheEmptyOneIsNamed) {
    const Container container = parse_container("cylinder:0.1,0.7");
    const Section section = choose_section(container, {}, {0.0, 0.35}, 0.05);
    EXPECT_EQ(section.z0_m, 0.03);
    EXPECT_NEAR(section.z1_m, 0.32, 1e-15);
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)choose_section(container, {}, {0.0, 0.04}, 0.03); }), "it is 0.04 m high"));
    EXPECT_TRUE(has(message_of<UserError>([&] {
                        (void)choose_section(container, {.section_m = {0.3, 0.2}}, {0.0, 0.35}, 0.03);
                    }),
                    "0 <= z0 < z1"));
}

// One half of a tube: its round wall is no whole circle.
class HalfTube : public Cylinder {
public:
    HalfTube() : Cylinder(2.0, 3.0) {}
    [[nodiscard]] double distance(const Vec3& point) const override { return std::min(Cylinder::distance(point), point.x()); }
};

// Random places in it are as far from each other as random places are.
TEST(Structure, OfRandomPlacesInHalfATubeHasNoOrder) {
    Packing packing{
        .container = Container(std::make_shared<const HalfTube>()), .shapes = {make_preset(ShapeKind::sphere, 1e-3, 0.0)}, .bodies = {}};
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> side(-1.0, 1.0);
    while (packing.bodies.size() < 1000) {
        const Vec3 at(side(random), side(random), 1.5 + 1.4 * side(random));
        if (packing.container.wall_distance(at) > 0.01) packing.bodies.push_back({.shape = 0, .position_m = at});
    }
    const Structure found = structure_of(packing, 1e-6, 1.2, 6);
    for (std::size_t bin = 1; bin < 6; ++bin)  // 7000 pairs or more: 1 to 3 %
        EXPECT_NEAR(found.radial_distribution[bin].distribution, 1.0, 0.06) << bin;
}

// A cubic lattice of touching spheres in a periodic box, and rods that all lie along z.
TEST(Structure, OfALatticeAndOfParallelRods) {
    using namespace packing;
    using namespace vessels;
    using shapes::Vec3;
    Packing lattice{.container = parse_container("box:4,4,4:periodic"),
                    .shapes = {shapes::make_preset(shapes::ShapeKind::sphere, 1.0, 0.0)},
                    .bodies = {}};
    for (int i = 0; i < 64; ++i) lattice.bodies.push_back({.shape = 0, .position_m = Vec3(i % 4, i / 4 % 4, i / 16) + Vec3::Constant(0.3)});
    const Structure cubic = structure_of(lattice, 1e-6, 1.95, 13);
    EXPECT_EQ(cubic.grains_with_neighbours.size(), 7U);
    EXPECT_EQ(cubic.grains_with_neighbours[6], 64);
    EXPECT_NEAR(cubic.mean_neighbours, 6.0, 1e-12);
    EXPECT_EQ(cubic.contact_points, 192);
    EXPECT_LT((cubic.contact_orientation - Eigen::Matrix3d::Identity() / 3.0).norm(), 1e-9);
    EXPECT_TRUE(cubic.orientation.isZero()) << "spheres have no axis";
    // Six neighbours at 1, twelve at 1.414: pairs over those of random points, in bins of 0.15 that begin at 0.9 and 1.35. Of all pairs of
    // the random points, 63 per point in 64 unit cells, the bin holds the volume of its shell.
    const auto expected = [](double neighbours, double r) {
        return neighbours / 63.0 * 64.0 / (4.0 / 3.0 * 3.14159265 * (std::pow(r + 0.15, 3.0) - r * r * r));
    };
    EXPECT_NEAR(cubic.radial_distribution[6].distribution / expected(6.0, 0.9), 1.0, 0.02);  // 4000 random points: 0.4 % per bin
    EXPECT_NEAR(cubic.radial_distribution[9].distribution / expected(12.0, 1.35), 1.0, 0.02);
    EXPECT_EQ(cubic.radial_distribution[5].distribution, 0.0);
    Packing rods{
        .container = parse_container("cylinder:10,10"), .shapes = {shapes::make_preset(shapes::ShapeKind::rod, 1.0, 3.0)}, .bodies = {}};
    const Vec3 axis = rods.shapes[0].capsules[0].b - rods.shapes[0].capsules[0].a;
    const auto upright = shapes::Quaternion::FromTwoVectors(axis, Vec3::UnitZ());
    rods.bodies = {{.shape = 0, .position_m = {0, 0, 3}, .orientation = upright},
                   {.shape = 0, .position_m = {1, 0, 4}, .orientation = upright}};
    const Structure parallel = structure_of(rods, 1e-6, 4.0, 4);
    EXPECT_NEAR(parallel.orientation(2, 2), 1.0, 1e-12);
    EXPECT_NEAR(parallel.contact_orientation(0, 0), 1.0, 1e-12);
    EXPECT_EQ(parallel.contact_points, 1);
}

}  // namespace
}  // namespace porepack
