// CGAL's surfaces against the exact capsules: order of convergence, contacts, regions, and a user's surfaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "core/data_file.hpp"
#include "shapes/config.hpp"
#include "shapes/distance.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

Packing pair_of(const Shape& shape, const Vec3& second, const Quaternion& turn = Quaternion::Identity()) {
    Packing packing{.container = parse_container("box:10,10,10"), .shapes = {shape}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(5, 5, 5)});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(5, 5, 5) + second, .orientation = turn});
    return packing;
}

Packing alone(const Shape& shape) {
    Packing packing = pair_of(shape, Vec3::Zero());
    packing.bodies.pop_back();
    return packing;
}

// The deviation falls with the square of the edge, so volume and area must fall with the first power of the deviation.
TEST(Surface, ErrorFallsWithTheSquareOfTheEdge) {
    for (const ShapeKind kind : {ShapeKind::tetrapod, ShapeKind::dolos, ShapeKind::tetrahedron}) {
        Shape shape = make_preset(kind, 1.0, 2.8);
        shape.cavity = Cavity::open;
        const ShapeMeasures exact = measure(shape);
        std::vector<double> volume, area, edge2;
        for (const double deviation : {0.04, 0.02, 0.01, 0.005}) {
            const SurfaceResult result = make_surface(alone(shape), {.deviation_m = deviation, .max_volume_error = 0.1});
            const SurfaceMeasures m = measure_surface(result.surface);
            EXPECT_LE(result.deviation_m, deviation) << name_of(kind);
            // Triangles over a fixed area: their number is the inverse square of the edge.
            edge2.push_back(1.0 / static_cast<double>(result.surface.triangles.size()));
            volume.push_back(std::abs(m.volume_m3 / exact.volume_m3 - 1.0));
            area.push_back(std::abs(m.area_m2 / exact.surface_area_m2 - 1.0));
        }
        // From the coarsest to the finest: the order in the edge is twice the slope against its square.
        const double order_volume = 2.0 * std::log(volume[0] / volume[3]) / std::log(edge2[0] / edge2[3]);
        const double order_area = 2.0 * std::log(area[0] / area[3]) / std::log(edge2[0] / edge2[3]);
        EXPECT_GT(order_volume, 1.5) << name_of(kind);
        EXPECT_GT(order_area, 1.5) << name_of(kind);
        EXPECT_LT(volume[3], 2e-3) << name_of(kind);
        EXPECT_LT(area[3], 6e-3) << name_of(kind);
    }
}

// A gap of 1e-3 d: two bodies; contact or an overlap of 1e-3 d: one body, independent of the facets.
TEST(Surface, ContactsComeOutAsTheGeometrySays) {
    const Shape rod = make_preset(ShapeKind::rod, 1.0, 3.0);
    const Quaternion crossing(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vec3::UnitX())), skew(Eigen::AngleAxisd(0.3, Vec3::UnitX())),
        nearly_parallel(Eigen::AngleAxisd(0.03, Vec3::UnitX()));
    const Shape sphere = make_preset(ShapeKind::sphere, 1.0, 0.0);
    for (const double gap : {1e-3, 0.0, -1e-3}) {
        const long bodies = gap > 0.0 ? 2 : 1;
        const auto shells = [&](const Shape& shape, const Vec3& direction, const Quaternion& turn) {
            const SurfaceResult result =
                make_surface(pair_of(shape, (1.0 + gap) * direction, turn), {.deviation_m = 0.02, .max_volume_error = 0.03});
            const SurfaceCheck check = check_surface(result.surface);
            EXPECT_EQ(check.fault, "");
            EXPECT_NEAR(check.volume_m3 / (2.0 * measure(shape).volume_m3), 1.0, 0.03);
            return check.shells;
        };
        EXPECT_EQ(shells(sphere, Vec3(0.48, 0.6, 0.64), Quaternion::Identity()), bodies) << gap;
        EXPECT_EQ(shells(rod, Vec3::UnitX(), crossing), bodies) << gap;
        EXPECT_EQ(shells(rod, Vec3::UnitX(), skew), bodies) << gap;
        EXPECT_EQ(shells(rod, Vec3::UnitX(), nearly_parallel), bodies) << gap;
        EXPECT_EQ(shells(rod, Vec3::UnitX(), Quaternion::Identity()), bodies) << gap;                    // parallel, all along
        EXPECT_EQ(shells(rod, Vec3(1, 0, 0) + Vec3(0, 0, 1.3), Quaternion::Identity()), bodies) << gap;  // parallel, half
    }
    // A larger contact gap joins grains with smaller gaps.
    const SurfaceResult joined =
        make_surface(pair_of(sphere, Vec3(1.001, 0, 0)), {.deviation_m = 0.02, .contact_gap_m = 0.01, .max_volume_error = 0.05});
    EXPECT_EQ(check_surface(joined.surface).shells, 1);
    EXPECT_EQ(joined.bridges, 1);
}

// Two grains side by side along x, with this gap between their exact surfaces.
Packing with_gap(const Shape& first, const Shape& second, const Quaternion& one, const Quaternion& other, double gap) {
    Packing packing{.container = parse_container("box:4,2.6,2.6"), .shapes = {first, second}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(1, 1.3, 1.3), .orientation = one});
    packing.bodies.push_back({.shape = 1, .position_m = Vec3(1, 1.37, 1.26), .orientation = other});
    double low = 0.3, high = 2.4;
    for (int step = 0; step < 60; ++step) {
        packing.bodies[1].position_m.x() = 1.0 + 0.5 * (low + high);
        const Nearest found = nearest(placed(packing, packing.bodies[0]), placed(packing, packing.bodies[1]), 5.0);
        (found.gap_m > gap ? high : low) = 0.5 * (low + high);
    }
    return packing;
}

TEST(Surface, ContactsOfGrainsWithFacesComeOutAsTheGeometrySays) {
    const Shape cube = make_shape({.kind = ShapeKind::cube, .side_m = 1.0}),
                cylinder = make_shape({.kind = ShapeKind::cylinder, .diameter_m = 1.0, .height_m = 1.2}),
                ring = make_shape({.kind = ShapeKind::ring, .diameter_m = 1.2, .height_m = 1.0, .inner_diameter_m = 0.8}),
                lobed = make_shape({.kind = ShapeKind::lobed, .diameter_m = 1.0, .height_m = 1.2, .lobe_diameter_m = 0.55}),
                tetrapod = make_preset(ShapeKind::tetrapod, 0.5, 0.6);
    const auto turned = [](const Vec3& axis, double degrees) {
        return Quaternion(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis.normalized()));
    };
    const Quaternion as_it_is = Quaternion::Identity(), lying = turned(Vec3::UnitY(), 90.0);
    struct Case {
        const char* name;
        const Shape &first, &second;
        Quaternion one, other;
    };
    const std::vector<Case> cases = {{"face to face", cube, cube, as_it_is, as_it_is},
                                     {"face to face, turned", cube, cube, as_it_is, turned(Vec3::UnitX(), 31.0)},
                                     {"corner to face", cube, cube, as_it_is, turned(Vec3(1, 2, 3), 50.0)},
                                     {"edge to face", cube, cube, as_it_is, turned(Vec3::UnitZ(), 40.0)},
                                     {"edge to edge", cube, cube, turned(Vec3::UnitZ(), 45.0), turned(Vec3::UnitY(), 45.0)},
                                     {"sides, parallel", cylinder, cylinder, as_it_is, as_it_is},
                                     {"sides, crossing", cylinder, cylinder, as_it_is, turned(Vec3::UnitX(), 70.0)},
                                     {"end to end", cylinder, cylinder, lying, lying},
                                     {"end to side", cylinder, cylinder, as_it_is, lying},
                                     {"rim to side", cylinder, cylinder, as_it_is, turned(Vec3(0.3, 1, 0.2), 60.0)},
                                     {"rings, crossing", ring, ring, turned(Vec3(0.2, 1, 0), 20.0), lying},
                                     {"ring on cube", ring, cube, as_it_is, turned(Vec3(1, 2, 3), 33.0)},
                                     {"lobes", lobed, lobed, as_it_is, turned(Vec3(1, 0, 0.2), 80.0)},
                                     {"tetrapod on cylinder", tetrapod, cylinder, turned(Vec3(1, 2, 3), 20.0), as_it_is}};
    for (const Case& one : cases)
        for (const double gap : {2e-3, 0.0, -1e-3, -1e-2}) {
            const Packing packing = with_gap(one.first, one.second, one.one, one.other, gap);
            const SurfaceResult result = make_surface(packing, {.max_volume_error = 0.1});
            std::printf("  %-22s %+.0e: %ld shells, %ld thinned, deviation %.4f\n", one.name, gap, result.check.shells,
                        result.shrunk_grains, result.deviation_m);
            EXPECT_EQ(result.check.fault, "") << one.name << gap;
            EXPECT_EQ(result.check.shells, gap > 0.0 ? 2 : 1) << one.name << gap;
            const double exact = measure(one.first).volume_m3 + measure(one.second).volume_m3;
            EXPECT_NEAR(result.check.volume_m3 / exact, 1.0, 0.01) << one.name << gap;
        }
}

TEST(Surface, PoresAndClipAgreeWithTheColumns) {
    Packing packing{.container = parse_container("cylinder:4,6"), .shapes = {make_preset(ShapeKind::tetrapod, 0.8, 1.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.2, 0.1, 2.0)});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(-0.3, 0.2, 4.1)});
    const SurfaceResult grains = make_surface(packing, {.deviation_m = 0.004});
    const Section section{1.5, 4.4};
    const PoreSurface pores = make_pore_surface(grains.surface, packing.container, section, 0.004);
    const SurfaceCheck check = check_surface(pores.surface);
    EXPECT_EQ(check.fault, "");
    const double whole = packing.container.inner_area_m2() * section.length();
    const double solid = (1.0 - porosity(Grains(packing), packing.container, section).value) * whole;
    EXPECT_NEAR((whole - check.volume_m3) / solid, 1.0, 0.01);
    EXPECT_NEAR(measure_surface(clip_surface(grains.surface, section)).volume_m3 / solid, 1.0, 0.01);
    std::array<double, 4> area{};
    for (std::size_t t = 0; t < pores.surface.triangles.size(); ++t) {
        Vec3 p[3];
        for (std::size_t c = 0; c < 3; ++c) {
            const auto& x = pores.surface.points[static_cast<std::size_t>(pores.surface.triangles[t][c])];
            p[c] = Vec3(x[0], x[1], x[2]);
        }
        area[static_cast<std::size_t>(pores.region[t])] += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
    }
    EXPECT_NEAR(area[2] / (std::numbers::pi * 4.0 * section.length()), 1.0, 0.01);  // the whole wall
    for (const std::size_t end : {0U, 1U}) {
        EXPECT_LT(area[end], packing.container.inner_area_m2());  // grains are cut there
        EXPECT_GT(area[end], 0.5 * packing.container.inner_area_m2());
    }
    EXPECT_GT(area[3], 0.5 * 2.0 * measure(packing.shapes[0]).surface_area_m2);
}

TEST(Surface, AUsersBoxIsMeasuredExactlyHoweverFarAway) {
    for (const double shift : {0.0, 100.0}) {
        TriangleSurface box;
        const double a = 1.0, b = 2.0, c = 3.0;
        for (int k = 0; k < 8; ++k) box.points.push_back({shift + a * (k & 1), shift + b * (k >> 1 & 1), shift + c * (k >> 2 & 1)});
        for (const auto& q : {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
            box.triangles.push_back({q[0], q[1], q[2]});
            box.triangles.push_back({q[0], q[2], q[3]});
        }
        const SurfaceMeasures m = measure_surface(box);
        EXPECT_NEAR(m.volume_m3, 6.0, 1e-10);
        EXPECT_NEAR(m.area_m2, 22.0, 1e-10);
        EXPECT_NEAR(m.hull_volume_m3, 6.0, 1e-10);
        EXPECT_NEAR(m.maximum_feret_diameter_m, std::sqrt(14.0), 1e-10);
        EXPECT_NEAR(m.inertia_per_density_m5(0, 0), 6.0 * (b * b + c * c) / 12.0, 1e-8);
        EXPECT_NEAR(m.inertia_per_density_m5(0, 1), 0.0, 1e-8);
        EXPECT_NEAR(m.centre_of_mass_m.x(), shift + 0.5, 1e-10);
        EXPECT_EQ(check_surface(box).fault, "");
        TriangleSurface twice = box;
        twice.triangles.push_back(box.triangles.front());
        EXPECT_NE(check_surface(twice).fault, "");
    }
}

// A rod through the faces of a periodic box overlaps its own images on one line: their facets must not coincide.
TEST(Surface, ARodThroughPeriodicFacesIsOneCylinder) {
    for (const double half : {0.1, 0.2, 0.3}) {
        Packing packing{.container = parse_container("box:0.25,1,1:periodic"), .shapes = {}, .bodies = {}};
        Shape rod = make_preset(ShapeKind::sphere, 0.6, 0.0);
        rod.capsules = {{Vec3(-half, 0, 0), Vec3(half, 0, 0), 0.3}};
        packing.shapes.push_back(rod);
        packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.125, 0.5, 0.5)});
        const SurfaceResult result = make_surface(packing, {.deviation_m = 0.003});
        const SurfaceCheck check = check_surface(result.surface);
        EXPECT_TRUE(check.fault.empty()) << check.fault;
        EXPECT_EQ(check.shells, 1);
        EXPECT_LT(check.low.x(), 0.0);
        EXPECT_GT(check.high.x(), 0.25);
        EXPECT_LT(result.deviation_m, 0.004);
    }
}

// The file is the same for any number of threads, so later stages stay up to date.
TEST(Surface, TheOrderOfTrianglesDoesNotDependOnThreads) {
    Packing packing = pair_of(make_preset(ShapeKind::tetrapod, 1.0, 3.0), Vec3(0.9, 0.2, 0.1));
    for (int i = 0; i < 6; ++i)
        packing.bodies.push_back({.shape = 0,
                                  .position_m = Vec3(2.0 + 0.9 * i, 3.0, 3.0),
                                  .orientation = Quaternion(Eigen::AngleAxisd(0.4 * i, Vec3::UnitZ()))});
    const TriangleSurface first = make_surface(packing, {}).surface;
    for (int round = 0; round < 3; ++round) {
        const TriangleSurface other = make_surface(packing, {}).surface;
        EXPECT_EQ(first.points, other.points);
        EXPECT_EQ(first.triangles, other.triangles);
    }
}

Packing settled(std::vector<Body> bodies, double arm, double radius) {
    Shape tetrapod = make_preset(ShapeKind::tetrapod, 2.0, 3.0);
    tetrapod.capsules.clear();
    for (const Vec3& tip : {Vec3(1, 1, 1), Vec3(1, -1, -1), Vec3(-1, 1, -1), Vec3(-1, -1, 1)})
        tetrapod.capsules.push_back({Vec3::Zero(), arm * tip, radius});
    return {.container = parse_container("cylinder:0.1,0.7"), .shapes = {tetrapod}, .bodies = std::move(bodies)};
}

// Settled pairs whose contacts are hard to join in single precision: a plain union of the first two has faulty edges or crosses itself. The
// gap of the third is just larger than contact_gap_m, beside a crease of one grain: only thinning this grain keeps them apart.
TEST(Surface, ContactsOfSettledGrainsAreOneSurface) {
    const std::vector<Packing> pairs = {
        settled({{.shape = 0,
                  .position_m = {-0.0012833683083520928, 0.028443185234581378, 0.17787221960869223},
                  .orientation = Quaternion(0.49295060609444796, 0.52399747655153, -0.30234993237371854, -0.6253086141357148)},
                 {.shape = 0,
                  .position_m = {-0.002849833911983717, 0.030349123886793703, 0.1925377439292981},
                  .orientation = Quaternion(0.49414235791790195, 0.7391304041339142, -0.3327472820624713, -0.3143068915506165)}},
                0.007975156236547463, 0.00201466333),
        settled({{.shape = 0,
                  .position_m = {-0.008750598913624768, -0.012520906529671307, 0.2760863163954991},
                  .orientation = Quaternion(-0.49480812392244716, 0.5802474078703832, 0.5756084251254072, 0.2952165427016207)},
                 {.shape = 0,
                  .position_m = {-0.009264022993878572, -0.022317553150472506, 0.2713243333007311},
                  .orientation = Quaternion(-0.014183314761671088, -0.08819872429886592, 0.6469080291045896, 0.7573175162997616)}},
                0.007975156236547463, 0.00201466333),
        settled({{.shape = 0,
                  .position_m = {-0.029106785166740243, 0.013419999715770271, 0.05940886602285369},
                  .orientation = Quaternion(-0.04542582210756299, -0.8219279797011096, 0.06378238574464533, -0.5641832132729808)},
                 {.shape = 0,
                  .position_m = {-0.030241892443397415, 0.023134719194362, 0.06327418166317814},
                  .orientation = Quaternion(0.33124690577033905, 0.87550738661316, 0.21255054106928967, 0.28032939712866944)}},
                0.0020156517549853497, 0.003604702375)};
    std::vector<long> thinned;
    for (const Packing& packing : pairs) {
        const SurfaceResult result = make_surface(packing, {});
        EXPECT_TRUE(result.check.fault.empty()) << result.check.fault;
        EXPECT_EQ(result.check.shells, 1);
        const double one = measure(packing.shapes.front(), 1e-6).volume_m3;
        EXPECT_NEAR(result.check.volume_m3 / (2.0 * one), 1.0, 0.002);                               // of 0.5 % facets
        EXPECT_LT(result.deviation_m, 0.02 * 2.0 * packing.shapes.front().capsules.front().radius);  // 0.5 % of facets, and the bridge
        thinned.push_back(result.shrunk_grains);
    }
    EXPECT_EQ(thinned, (std::vector<long>{0, 0, 1})) << "no longer hard cases: choose other pairs";
}

// A part of a settled bed. Each contact is joined on its own: no grain is thinned, and the volume is that of the grains.
TEST(Surface, ASettledBedIsOneSurface) {
    Packing packing = read_packing(data_file("cases") / "paper_packing" / "settled" / "tetrapod_053.json.gz");
    packing.bodies.resize(150);
    const SurfaceResult result = make_surface(packing, {});
    EXPECT_EQ(check_surface(result.surface).fault, "");
    EXPECT_GT(result.bridges, 300);  // a settled grain has at least four contacts, each shared by two
    EXPECT_EQ(result.shrunk_grains, 0);
    // A grain of this shape has 0.1 % of volume too much at 0.5 % of facets, where the facets of two arms overlap.
    EXPECT_NEAR(result.check.volume_m3 / (150.0 * measure(packing.shapes.front(), 1e-6).volume_m3), 1.0, 0.0015);
}

// A plane just beside a corner cuts its facets at points that single precision hardly holds apart: OpenFOAM merges them when it reads the
// file, and finds edges with more than two triangles.
TEST(Surface, PointsOfAClippedSurfaceAreApart) {
    Packing packing = alone(make_preset(ShapeKind::sphere, 1.0, 0.0));
    const TriangleSurface grain = make_surface(packing, {.deviation_m = 0.01}).surface;
    double corner = 0.0;  // the highest below the middle of the upper half
    for (const auto& p : grain.points)
        if (p[2] < 5.25) corner = std::max(corner, p[2]);
    for (const double beside : {1e-9, 1e-7, 3e-7, 1e-6}) {
        const TriangleSurface part = clip_surface(grain, {4.8, corner + beside});
        double nearest = 1e300;
        for (std::size_t i = 0; i < part.points.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                nearest = std::min(nearest, std::hypot(part.points[i][0] - part.points[j][0], part.points[i][1] - part.points[j][1],
                                                       part.points[i][2] - part.points[j][2]));
        EXPECT_GT(nearest, 5e-6) << beside;  // ten steps: coordinates of 5 have steps of 5e-7
        EXPECT_EQ(check_surface(part).fault, "") << beside;
    }
}

}  // namespace
}  // namespace porepack
