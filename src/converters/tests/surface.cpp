// Surfaces of grains and of users, and slices.
#include <fmt/format.h>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "converters/slices.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "support/basics.hpp"
#include "support/l_shaped.hpp"
#include "vessels/config.hpp"

namespace porepack {
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
using namespace converters;
namespace {

using test::has;
using test::message_of;

// Two triangles on each side, in millimetres.
std::string block_stl(const std::string& name, const std::array<double, 6>& box, const std::string& first_number = {}) {
    constexpr int faces[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                  {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
    std::string text = "solid " + name + "\n";
    for (const auto& face : faces) {
        text += "facet normal 0 0 0\nouter loop\n";
        for (const int corner : face) {
            const bool east = corner == 1 || corner == 2 || corner == 5 || corner == 6, north = corner % 4 >= 2, top = corner >= 4;
            const double x = box[east ? 3 : 0];
            text += fmt::format("vertex {} {} {}\n", x == 0.0 && !first_number.empty() ? first_number : fmt::format("{}", x),
                                box[north ? 4 : 1], box[top ? 5 : 2]);
        }
        text += "endloop\nendfacet\n";
    }
    return text + "endsolid " + name + "\n";
}

TEST(Slices, OutsideTheCylinderIsNeitherGrainNorPore) {
    const test::Folder folder;
    Packing packing{
        .container = parse_container("cylinder:0.02,0.02"), .shapes = {make_preset(ShapeKind::sphere, 0.01, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.0, 0.0, 0.01)});
    write_slices(folder.path(), Grains(packing), packing.container, {0.0099, 0.0101}, 2e-4, 2e-4);
    const SliceStack stack = read_slices(folder.path());
    std::map<int, double> share;
    for (const auto phase : stack.phase) share[phase] += 1.0 / static_cast<double>(stack.phase.size());
    EXPECT_NEAR(share[Phase::outside], 1.0 - std::numbers::pi / 4.0, 0.01);
    EXPECT_NEAR(share[Phase::grain], std::numbers::pi / 16.0, 0.01);
    EXPECT_NEAR(share[Phase::pore], 3.0 * std::numbers::pi / 16.0, 0.01);
}

TEST(Surface, TouchingOverlappingAndParallelGrainsBecomeOneSoundSurface) {
    for (const double distance : {2.0001, 2.0, 1.998, 1.5, 1.9999999}) {
        Packing packing;
        packing.container = parse_container("box:20,20,20");
        packing.shapes.push_back(make_preset(ShapeKind::rod, 2.0, 5.0));
        packing.bodies.push_back({.shape = 0, .position_m = Vec3(5, 5, 6)});
        packing.bodies.push_back({.shape = 0, .position_m = Vec3(5 + distance, 5, 6.5)});
        const SurfaceResult result = make_surface(packing, {});
        EXPECT_EQ(check_surface(result.surface).fault, "") << distance;
        EXPECT_LT(result.deviation_m, 0.045) << distance;
    }
}

// Three rings of a poured bed, one of them with both rims in the others: eight rounds of repair with the smallest gap leave crossings.
TEST(Surface, IsMadeAgainWithALargerContactGapWhereFaultsRemain) {
    Packing packing;
    packing.container = parse_container("box:0.3,0.3,0.3");
    packing.shapes.push_back({.id = "ring",
                              .body = make_ring({.diameter_m = 0.01000639052734979,
                                                 .inner_diameter_m = 0.0070044733691448525,
                                                 .height_m = 0.01000639052734979,
                                                 .rounding_m = 0.00018303237811667975})});
    packing.bodies = {{.position_m = {0.118503099091153025, 0.134030797542335873, 0.062054444562331096},
                       .orientation = {0.14354838315439189, -0.15888612406492833, -0.28218768444275844, -0.93515729801045688}},
                      {.position_m = {0.118165354930025329, 0.126405536506058306, 0.054993942054247864},
                       .orientation = {0.63740089937929523, 0.70206976034905766, 0.084040611626208114, 0.3061949063445949}},
                      {.position_m = {0.111045072411421664, 0.135953864530658160, 0.068584261715010167},
                       .orientation = {-0.29469408448144352, 0.66297529198842275, -0.55769008302960421, 0.4032380563326613}}};
    const double smallest = 1e-4 * finest_diameter(packing);
    const auto error = message_of<NumericalError>([&] { (void)make_surface(packing, {.contact_gap_m = smallest}); });
    EXPECT_TRUE(has(error, "the surface still has faults")) << error;
    const SurfaceResult result = make_surface(packing, {});
    EXPECT_EQ(check_surface(result.surface).fault, "");
    EXPECT_GT(result.contact_gap_m, 5.0 * smallest);
}

TEST(Surface, FaultsOfSeveralBodiesNameTheirKindAndPlace) {
    const test::Folder folder;
    const auto fault = [&](const std::string& text) { return check_surface(read_stl(folder.write("a.stl", text), 1e-3)).fault; };
    const std::string block = block_stl("a", {2, 2, 2, 5, 5, 5});
    EXPECT_EQ(fault(block + block_stl("b", {6, 6, 6, 8, 8, 8})), "");
    EXPECT_TRUE(has(fault(block + block), "12 triangles lie on another with the same corners, the first near (0.002, 0.002, 0.002) m"));
    EXPECT_TRUE(has(fault(block + block_stl("b", {5, 5, 5, 8, 8, 8})), "meet in 1 points, the first near (0.005, 0.005, 0.005) m"));
    EXPECT_TRUE(has(fault(block + block_stl("b", {5, 5, 2, 8, 8, 5})),
                    "more than two triangles share an edge at 1 edges, the first near (0.005, 0.005"));
    EXPECT_TRUE(has(fault(block + block_stl("b", {3, 3, 3, 4, 4, 4})), "turned outward although 1 shells enclose it"));
    EXPECT_TRUE(has(fault(block + block_stl("b", {4, 4, 4, 8, 8, 8})), "crosses itself"));
}

TEST(Surface, PorosityOfABlockIsExact) {
    const test::Folder folder;
    const Container box = parse_container("box:0.01,0.01,0.01");
    for (const auto& [sides, section, exact] :
         {std::tuple(std::array<double, 6>{1, 1, 0, 9, 9, 10}, Section{0, 0.01}, 0.36),
          std::tuple(std::array<double, 6>{1, 1, 3, 9, 9, 10}, Section{0.002, 0.007}, 1 - 0.64 * 0.8),
          std::tuple(std::array<double, 6>{1.27, 1.52, 0, 8.73, 8.48, 10}, Section{0, 0.01}, 0.480784)}) {
        PoreSpace space = pore_space_of(read_stl(folder.write("a.stl", block_stl("a", sides)), 1e-3), box, "a.stl");
        space.section = section;
        const Porosity found = space.porosity();
        EXPECT_LE(std::abs(found.value - exact), found.uncertainty);
        EXPECT_LT(found.uncertainty, 3e-7);
    }
    // Against lines, of a surface with facets in all directions.
    const TriangleSurface surface = make_surface(test::l_shaped(), {}).surface;
    const SurfaceSolid closed(surface, test::l_shaped().container);
    const double whole = closed.volume_between(-1.0, 1.0).value();
    EXPECT_NEAR(whole / check_surface(surface).volume_m3, 1.0, 1e-9);
    const double low = closed.bounds().low.z(), high = closed.bounds().high.z();
    double sum = 0.0;
    for (int part = 0; part < 7; ++part)
        sum += closed.volume_between(low + (high - low) * part / 7, low + (high - low) * (part + 1) / 7).value();
    EXPECT_NEAR(sum / whole, 1.0, 1e-9);
}

TEST(Stl, FaultsAreNamed) {
    const test::Folder folder;
    Packing packing = test::l_shaped();
    const TriangleSurface surface = make_surface(packing, {}).surface;
    const Path good = folder.path() / "good.stl";
    write_stl(good, surface);
    const std::string bytes = read_text(good);
    const auto fault = [&](const std::string& content) {
        return message_of<UserError>([&] { (void)read_stl(folder.write("bad.stl", content)); });
    };
    EXPECT_TRUE(has(fault(""), "empty"));
    EXPECT_TRUE(has(fault(bytes.substr(0, bytes.size() / 2)), "the STL file is incomplete"));
    EXPECT_TRUE(has(fault("hello"), "not an STL"));
    EXPECT_TRUE(has(fault("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0"), "is incomplete"));
    EXPECT_TRUE(has(fault("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0,5 0"), "`0,5` is not a number in triangle 1"));
    EXPECT_TRUE(has(fault("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nnormal"), "\"normal\" is not expected in line 5"));
    std::string nan = bytes;
    const float value = std::nanf("");
    std::memcpy(nan.data() + 84 + 50 * 7 + 12, &value, 4);
    EXPECT_TRUE(has(fault(nan), "triangle 8"));
    TriangleSurface open = surface;
    open.triangles.pop_back();
    EXPECT_TRUE(has(check_surface(open).fault, "the surface is open: 3 edges"));
    TriangleSurface inside_out = surface;
    for (auto& triangle : inside_out.triangles) std::swap(triangle[0], triangle[1]);
    EXPECT_TRUE(has(check_surface(inside_out).fault, "inside out"));
    TriangleSurface crossing = surface;
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
        auto p = surface.points[i];
        p[0] += 0.002;
        crossing.points.push_back(p);
    }
    const int shift = static_cast<int>(surface.points.size());
    for (const auto& t : surface.triangles) crossing.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    EXPECT_TRUE(has(check_surface(crossing).fault, "crosses itself"));
    TriangleSurface millimetres = surface;
    for (auto& p : millimetres.points)
        for (double& x : p) x *= 1000.0;
    EXPECT_TRUE(
        has(message_of<UserError>([&] { require_plausible_size(check_surface(millimetres), packing.container, "x.stl"); }), "millimetres"));
}

TEST(Stl, IsReadAsWritersLeaveIt) {
    const test::Folder folder;
    const auto volume = [&](const std::string& text) { return check_surface(read_stl(folder.write("a.stl", text), 1e-3)).volume_m3; };
    const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
        for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) text.replace(at, from.size(), to);
        return text;
    };
    const std::string block = block_stl("part", {1, 2, 3, 5, 5, 5});
    for (const std::string& text :
         {block, block_stl("vertex group solid", {1, 2, 3, 5, 5, 5}), replaced(block, "endsolid", "end solid"),
          replaced(block, "endloop", "end loop"), replaced(block, "\n", "\r\n"), replaced(block, "0 0 0\nouter", "nan nan nan\nouter"),
          replaced(block, "facet normal", "FACET NORMAL"),
          replaced(block, "solid part\nfacet",
                   "solid part\nfacet normal 0 0 0 outer loop vertex 1 1 1 vertex 1 1 1 vertex 2 2 2 endloop endfacet facet")})
        EXPECT_NEAR(volume(text), 24e-9, 1e-15);
    for (const char* tiny : {"3e-46", "-1e-170", "4.9e-324", "1e-400", "-0.0"})
        EXPECT_NEAR(volume(block_stl("part", {0, 2, 3, 5, 5, 5}, tiny)), 30e-9, 1e-15) << tiny;
}

TEST(Porosity, AFilledCavityIsSolid) {
    for (const Cavity cavity : {Cavity::filled, Cavity::open}) {
        Packing packing;
        packing.container = vessels::make_box(Vec3::Constant(8.0));
        packing.shapes.push_back(make_preset(ShapeKind::tetrahedron, 2.0, 3.3));
        packing.shapes[0].cavity = cavity;
        find_cavities(packing.shapes[0]);
        packing.bodies.push_back({.shape = 0, .position_m = Vec3::Constant(4.0), .orientation = Quaternion(0.5, 0.5, 0.5, 0.5)});
        const double solid = (1.0 - porosity(Grains(packing), packing.container, {0.0, 8.0}, 200000).value) * 512.0;
        EXPECT_NEAR(solid, measure(packing.shapes[0]).volume_m3, 2e-3 * solid);
        const SurfaceCheck check = check_surface(make_surface(packing, {.deviation_m = 0.02}).surface);
        EXPECT_EQ(check.shells, cavity == Cavity::filled ? 1 : 2);
        EXPECT_NEAR(check.volume_m3, solid, 0.01 * solid);
    }
}

}  // namespace
}  // namespace porepack
