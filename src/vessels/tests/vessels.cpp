// Containers as they are read and written, and the geometry of the vessels.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "geometry/solid.hpp"
#include "support/basics.hpp"
#include "vessels/box.hpp"
#include "vessels/config.hpp"

namespace porepack::vessels {
namespace {

using test::has;
using test::message_of;

TEST(Containers, AreReadAsTheyAreWritten) {
    for (const char* text : {"cylinder:0.1,0.7", "annulus:0.04,0.1,0.7", "cone:0.1,0.2,0.7", "box:1,2,3", "box:1,2,3:periodic"}) {
        const Container container = parse_container(text);
        const Container again = container_from_json(to_json(container), "here");
        EXPECT_EQ(to_json(again), to_json(container)) << text;
        EXPECT_EQ(again.periodic(), container.periodic()) << text;
    }
    EXPECT_TRUE(container_from_json(to_json(make_cylinder(0.1, 0.2).with_cut_ends()), "here").cut_ends());
}

TEST(Containers, SayWhatIsWrongWithThem) {
    const auto fault = [](const char* json) {
        return message_of<UserError>([&] { (void)container_from_json(Json::parse(json), "here"); });
    };
    EXPECT_TRUE(has(fault(R"({"diameter_m":1})"), "`kind` is missing"));
    EXPECT_TRUE(has(fault(R"({"kind":"sphere"})"), "unknown kind of container: sphere"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1})"), "`height_m` is missing"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1,"height_m":-1})"), "`height_m` must be a number"));
    EXPECT_TRUE(has(fault(R"({"kind":"cylinder","diameter_m":1,"height_m":1,"size_m":[1,1,1]})"), "unknown key `size_m`"));
    EXPECT_TRUE(has(fault(R"({"kind":"box","size_m":[1,1]})"), "`size_m` must be a list of 3 numbers"));
    EXPECT_TRUE(has(fault(R"({"kind":"box","size_m":[1,1,1],"periodic":[1,0,0]})"), "`periodic` must be a list of 3 values"));
    EXPECT_TRUE(has(fault(R"({"kind":"box","size_m":[1,1,1],"ends":"open"})"), "`ends` must be"));
    EXPECT_TRUE(has(fault(R"({"kind":"box","size_m":[1,1,1],"periodic":[true,true,true],"ends":"cut"})"), "no cut ends"));
    const auto of_case = [](const ContainerConfig& config) { return message_of<UserError>([&] { (void)make_container(config); }); };
    EXPECT_TRUE(has(of_case({.kind = "box", .diameter_m = 1.0, .size_m = {1, 1, 1}}),
                    "belongs to kind = \"cylinder\" and kind = \"annulus\" and kind = \"cone\""));
    EXPECT_TRUE(has(of_case({.kind = "cylinder", .diameter_m = 1.0}), "a cylinder needs diameter_m and height_m"));
    EXPECT_TRUE(has(of_case({.kind = "annulus", .diameter_m = 1.0, .height_m = 1.0}), "an annulus needs inner_diameter_m"));
    EXPECT_TRUE(
        has(of_case({.kind = "annulus", .diameter_m = 1.0, .inner_diameter_m = 1.5, .height_m = 1.0}), "is not below its outer one"));
    EXPECT_TRUE(has(of_case({.kind = "cone", .diameter_m = 1.0, .top_diameter_m = 1.0, .height_m = 1.0}), "are equal"));
    EXPECT_TRUE(has(of_case({.kind = "cone", .diameter_m = 1.0, .inner_diameter_m = 0.5, .top_diameter_m = 2.0, .height_m = 1.0}),
                    "has no effect here"));
    EXPECT_TRUE(has(message_of<UserError>([] { (void)make_cylinder(1.0, 1.0).resized({1.0, 2.0, 1.0}); }), "cannot be 1 x 2 x 1 m"));
}

TEST(Containers, AreParsed) {
    EXPECT_NEAR(parse_container("cylinder:0.1,0.7").inner_area_m2(), std::numbers::pi * 0.0025, 1e-12);
    EXPECT_TRUE(parse_container("box:1,2,3:periodic").periodic()[2]);
    for (const char* bad : {"", "box", "box:1,2", "cylinder:1", "cylinder:0,1", "box:1,2,nan", "box:1,2,3:open", "cylinder:1,2x"})
        EXPECT_TRUE(has(message_of<UserError>([&] { (void)parse_container(bad); }), "container")) << bad;
}

TEST(Containers, AreNamedInTexts) {
    for (const char* form : {"cylinder:D,H", "annulus:DI,D,H", "cone:D,DT,H", "box:X,Y,Z[:periodic]"})
        EXPECT_TRUE(has(container_forms(), form));
    EXPECT_TRUE(has(container_frames(), "a cylinder, an annulus or a cone has its axis at x = y = 0, a box has its corner at the origin"));
    const auto text = [](const char* form) {
        return container_text(to_json(parse_container(form)), [](double x) { return fmt::format("{:g} m", x); });
    };
    EXPECT_EQ(text("cylinder:0.1,0.7"), "a cylinder 0.1 m wide and 0.7 m high");
    EXPECT_EQ(text("box:1,2,3"), "a box of 1 m x 2 m x 3 m");
    EXPECT_EQ(container_text(Json::object(), [](double) { return ""; }), "its container");
    EXPECT_EQ(container_text({{"kind", "cylinder"}, {"diameter_m", 0.0}}, [](double) { return ""; }), "its container");
}

// A corner of a box, cut off by a slanted side: its bounds' middle lies on that side.
class CutCorner : public Box {
public:
    CutCorner() : Box({1.0, 1.0, 1.0}) {}
    [[nodiscard]] bool fills_bounds() const override { return false; }
    [[nodiscard]] double distance(const Vec3& point) const override {
        return std::min(Box::distance(point), (1.0 - point.x() - point.y()) / std::sqrt(2.0));
    }
};

TEST(Vessels, TheWidestPlaceHoldsTheLargestSphere) {
    EXPECT_EQ(make_cylinder(0.1, 0.7).widest_place().width_m, 0.1);
    EXPECT_EQ(make_cylinder(0.1, 0.7).widest_place().at, Vec3(0, 0, 0.35));
    EXPECT_EQ(make_box({0.3, 0.2, 0.1}).widest_place().width_m, 0.2);
    EXPECT_EQ(make_box({0.1, 0.2, 0.3}, {true, false, false}).widest_place().width_m, 0.1);
    const auto corner = Container(std::make_shared<const CutCorner>()).widest_place();
    EXPECT_NEAR(corner.width_m, 2.0 - std::sqrt(2.0), 0.02);  // twice the radius of the inscribed circle
    EXPECT_NEAR(corner.at.x(), 1.0 - std::sqrt(0.5), 0.02);
}

// Along any segment from inside, the distance is 0 at the hit and the sides that are crossed are those of the column.
TEST(Vessels, DistanceHitAndColumnAgree) {
    for (const Container& container :
         {make_cylinder(0.1, 0.2), make_box({0.1, 0.15, 0.2}), make_box({0.1, 0.15, 0.2}, {true, false, false}),
          parse_container("annulus:0.04,0.1,0.2"), parse_container("cone:0.1,0.16,0.2"), parse_container("cone:0.12,0.1,0.2")})
        for (int i = 0; i < 50; ++i) {
            Vec3 inside = container.low() + Vec3(0.3 + 0.008 * i, 0.71 - 0.008 * i, 0.5).cwiseProduct(container.size());
            if (container.wall_distance(inside) <= 0.0)  // between an annulus's walls
                inside.head<2>() = 0.03 * Eigen::Vector2d(std::cos(2.1 * i), std::sin(2.1 * i));
            const double angle = 0.37 * i;
            const Vec3 step = 0.2 * Vec3(std::cos(angle), std::sin(angle), 0.3);
            const auto hit = container.vessel().first_hit(inside, step);
            if (!hit) {  // along the periodic axis only
                EXPECT_TRUE(container.periodic()[0]);
                continue;
            }
            EXPECT_NEAR(container.wall_distance(inside + *hit * step), 0.0, 1e-15);
            const auto contained = [&](double part) {
                const Vec3 point = inside + part * *hit * step;
                std::vector<Interval> parts;
                container.vessel().column(container.periodic()[0] ? 0.05 : point.x(), point.y(), parts);
                return geometry::contains(parts, point.z());
            };
            EXPECT_TRUE(contained(1.0 - 1e-9)) << to_json(container) << i;
            EXPECT_FALSE(contained(1.0 + 1e-9)) << to_json(container) << ' ' << i << ' ' << *hit;
        }
}

TEST(Vessels, AreasAndOutlines) {
    const Container tube = make_cylinder(0.1, 0.7), box = make_box({0.1, 0.2, 0.3}, {true, false, false});
    EXPECT_NEAR(tube.inner_area_m2(), std::numbers::pi * 0.0025, 1e-17);
    EXPECT_NEAR(tube.vessel().side_per_volume(), 40.0, 1e-12);
    EXPECT_NEAR(box.vessel().side_per_volume(), 10.0, 1e-12);
    const Container annulus = parse_container("annulus:0.04,0.1,0.7"), cone = parse_container("cone:0.2,0.1,0.3");
    EXPECT_NEAR(annulus.vessel().side_per_volume(), 4.0 / 0.06, 1e-12);
    EXPECT_NEAR(cone.inner_area_m2(), std::numbers::pi * (0.01 + 0.005 + 0.0025) / 3.0, 1e-15);
    EXPECT_NEAR(cone.vessel().side_per_volume(), std::numbers::pi * 0.15 * std::hypot(0.3, 0.05) / (0.3 * cone.inner_area_m2()), 1e-12);
    EXPECT_TRUE(cone.vessel().outlines(1e-4).empty());
    for (const Container& container : {tube, box, annulus}) {
        double area = 0.0;
        for (const auto& corners : container.vessel().outlines(1e-4))
            for (std::size_t i = 0; i < corners.size(); ++i) {
                const auto [x, y] = corners[i];
                const auto [u, v] = corners[(i + 1) % corners.size()];
                area += 0.5 * (x * v - u * y);
            }
        EXPECT_NEAR(area / container.inner_area_m2(), 1.0, 1e-12);
    }
}

// A segment may come nearest to an inner wall between its ends.
TEST(Vessels, LeastDistanceAlongASegment) {
    const Container annulus = parse_container("annulus:0.04,0.1,0.7"), cone = parse_container("cone:0.2,0.1,0.3");
    for (int n = 0; n < 200; ++n) {
        const Vec3 a(0.03, 0.02 * std::sin(n), 0.1 + 0.001 * n),
            b = a + 0.05 * Vec3(std::cos(1.7 * n) - 0.6, std::sin(1.7 * n), std::cos(2.3 * n));
        for (const Container& container : {annulus, cone}) {
            double least = 1e300;
            for (int i = 0; i <= 2000; ++i) least = std::min(least, container.wall_distance(a + i / 2000.0 * (b - a)));
            EXPECT_NEAR(container.vessel().least_distance(a, b), least, 2e-6) << n;
            EXPECT_LE(container.vessel().least_distance(a, b), least + 1e-15) << n;
        }
    }
}

// The walls that engines see are those of the vessel.
TEST(Vessels, WallsForEngines) {
    for (const char* form : {"cylinder:0.1,0.7", "annulus:0.04,0.1,0.7", "cone:0.1,0.2,0.7", "cone:0.2,0.1,0.7", "box:0.1,0.2,0.3"}) {
        const Container container = parse_container(form);
        const auto walls = container.vessel().walls();
        ASSERT_TRUE(walls);
        for (int n = 1; n < 200; ++n) {
            const Vec3 x =
                container.low() +
                (Vec3::Constant(0.5) + 0.5 * Vec3(std::sin(n), std::sin(2.3 * n), std::sin(3.1 * n))).cwiseProduct(container.size());
            double least = 1e300;
            for (const auto& plane : walls->planes) least = std::min(least, plane.distance(x));
            for (const auto& wall : walls->round) {
                least = std::min(least, wall.distance(x));
                const double step = 1e-6;
                EXPECT_NEAR(wall.distance(x + step * wall.normal(x)), wall.distance(x) + step, 1e-15) << form;
                EXPECT_NEAR(wall.overlap(x, 0.01), 0.01 - wall.distance(x), 1e-15) << form;
            }
            EXPECT_NEAR(container.wall_distance(x), least, 1e-15) << form;
        }
    }
}

}  // namespace
}  // namespace porepack::vessels
