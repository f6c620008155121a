// Containers, packings, voxels, slices, surfaces: axes, handedness, faults.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "converters/slices.hpp"
#include "converters/surface.hpp"
#include "io/image.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/voxels.hpp"
#include "scans/phases.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using test::has;
using test::message_of;

// A body without symmetry: a long arm along +x, a shorter one along +y, an arm along +z, in a corner of the box.
Packing l_shaped() {
    Packing packing;
    packing.container.kind = Container::Kind::box;
    packing.container.size_m = Vec3(0.06, 0.05, 0.04);
    packing.shapes.push_back(
        {.id = "L",
         .capsules = {
             {Vec3::Zero(), Vec3(0.03, 0, 0), 0.003}, {Vec3::Zero(), Vec3(0, 0.02, 0), 0.003}, {Vec3::Zero(), Vec3(0, 0, 0.012), 0.003}}});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3(0.01, 0.012, 0.014)});
    return packing;
}

struct Extent {
    Vec3 low = Vec3::Constant(1e300), high = Vec3::Constant(-1e300);
    void add(const Vec3& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    void expect_l(double slack) const {
        EXPECT_NEAR(low.x(), 0.007, slack);
        EXPECT_NEAR(high.x(), 0.043, slack);
        EXPECT_NEAR(low.y(), 0.009, slack);
        EXPECT_NEAR(high.y(), 0.035, slack);
        EXPECT_NEAR(low.z(), 0.011, slack);
        EXPECT_NEAR(high.z(), 0.029, slack);
    }
};

Extent extent_of(const Grid& grid, const std::vector<std::uint8_t>& phase) {
    Extent extent;
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i)
                if (phase[grid.index(i, j, k)] == Phase::grain) extent.add(Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)));
    return extent;
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

TEST(Axes, TheLStandsRightInEveryFile) {
    const test::Folder folder;
    write_packing(folder.path() / "packing.json", l_shaped());
    const Packing packing = read_packing(folder.path() / "packing.json");
    const Grains grains(packing);
    const Section whole{0.0, 0.04};

    const VoxelPlan plan = plan_voxels(packing.container, whole, 1e-3, {}, 0.006);
    write_phase_image(folder.path() / "pore.vti", voxelise(grains, packing.container, whole, plan));
    const PhaseImage image = scans::segmented(imaging::open_volume(folder.path() / "pore.vti"), {}, "pore.vti").image;
    extent_of(image.grid, image.phase).expect_l(1.1e-3);

    write_slices(folder.path() / "slices", grains, packing.container, whole, 1e-3, 1e-3);
    const SliceStack stack = read_slices(folder.path() / "slices");
    extent_of(stack.grid, stack.phase).expect_l(1.1e-3);

    write_stl(folder.path() / "solid.stl", make_surface(packing, {}).surface);
    const TriangleSurface surface = read_stl(folder.path() / "solid.stl");
    Extent corners;
    for (const auto& p : surface.points) corners.add(Vec3(p[0], p[1], p[2]));
    corners.expect_l(2e-4);
    const SurfaceCheck check = check_surface(surface);
    EXPECT_EQ(check.fault, "");
    EXPECT_TRUE(check.closed && check.outward && !check.self_intersecting);

    FlowImage flow{.grid = image.grid,
                   .velocity_m_per_s = std::vector<float>(3 * image.grid.size()),
                   .pressure_Pa = std::vector<float>(image.grid.size()),
                   .phase = image.phase,
                   .notes = image.notes};
    for (std::size_t cell = 0; cell < image.grid.size(); ++cell)
        if (image.phase[cell] == Phase::pore) flow.velocity_m_per_s[3 * cell + 2] = static_cast<float>(cell);
    for (const std::size_t pieces : {1U, 5U}) {
        write_flow_image(folder.path() / "flow.vti", test::as_layers(flow), flow.grid.size() / pieces);
        const FlowImage back = read_flow_image(folder.path() / "flow.vti");
        EXPECT_EQ(back.velocity_m_per_s, flow.velocity_m_per_s);
        EXPECT_EQ(back.phase, image.phase);
        EXPECT_EQ(back.notes.at("unit"), "metre");
        EXPECT_EQ(back.grid.cells, flow.grid.cells);
        EXPECT_EQ(back.grid.origin_m, flow.grid.origin_m);
        std::size_t found = 0;
        const std::string text = read_text(folder.path() / "flow.vti");
        for (std::size_t at = 0; (at = text.find("<Piece ", at)) != std::string::npos; ++at) ++found;
        EXPECT_EQ(found, pieces);
    }

    // The columns of the surface give the same voxels, except for those that its facets cross.
    const PhaseImage from_stl = voxelise(SurfaceSolid(surface, packing.container), packing.container, whole, plan);
    std::size_t different = 0, solid = 0;
    for (std::size_t cell = 0; cell < image.phase.size(); ++cell) {
        different += image.phase[cell] != from_stl.phase[cell] ? 1 : 0;
        solid += image.phase[cell] == Phase::grain ? 1 : 0;
    }
    EXPECT_LT(different, solid / 20);
}

TEST(Packing, IsReadBackAsWritten) {
    const test::Folder folder;
    Packing packing = l_shaped();
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

TEST(Container, IsParsed) {
    EXPECT_NEAR(parse_container("cylinder:0.1,0.7").inner_area_m2(), std::numbers::pi * 0.0025, 1e-12);
    EXPECT_TRUE(parse_container("box:1,2,3:periodic").periodic[2]);
    for (const char* bad : {"", "box", "box:1,2", "cylinder:1", "cylinder:0,1", "box:1,2,nan", "box:1,2,3:open", "cylinder:1,2x"})
        EXPECT_TRUE(has(message_of<UserError>([&] { (void)parse_container(bad); }), "container")) << bad;
}

TEST(Porosity, OneSphereInABoxAndAcrossAPeriodicCorner) {
    Packing packing;
    packing.container.kind = Container::Kind::box;
    packing.container.size_m = Vec3::Ones();
    packing.shapes.push_back({.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), 0.4}}});
    packing.bodies.push_back({.shape = 0, .position_m = Vec3::Constant(0.5)});
    const double exact = 1.0 - 4.0 / 3.0 * std::numbers::pi * 0.064;
    const Porosity middle = porosity(Grains(packing), packing.container, {0.0, 1.0});
    EXPECT_NEAR(middle.value, exact, 1e-4);
    EXPECT_LT(middle.uncertainty, 1e-3);
    packing.container.periodic = {true, true, true};
    packing.bodies[0].position_m = Vec3::Zero();
    EXPECT_NEAR(porosity(Grains(packing), packing.container, {0.0, 1.0}).value, exact, 1e-4);
}

TEST(Porosity, AFilledCavityIsSolid) {
    for (const Cavity cavity : {Cavity::filled, Cavity::open}) {
        Packing packing;
        packing.container.kind = Container::Kind::box;
        packing.container.size_m = Vec3::Constant(8.0);
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

TEST(Section, DefaultsTrimAndTheEmptyOneIsNamed) {
    const Container container = parse_container("cylinder:0.1,0.7");
    const Section section = choose_section(container, {}, {0.0, 0.35}, 0.05);
    EXPECT_EQ(section.z0, 0.03);
    EXPECT_NEAR(section.z1, 0.32, 1e-15);
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)choose_section(container, {}, {0.0, 0.04}, 0.03); }), "it is 0.04 m high"));
    EXPECT_TRUE(has(message_of<UserError>([&] {
                        (void)choose_section(container, {.section_m = {0.3, 0.2}}, {0.0, 0.35}, 0.03);
                    }),
                    "0 <= z0 < z1"));
}

// A section whose buffer ends at the floor: whole voxels may begin half a voxel below it, and rounding must not matter.
TEST(Voxels, MayBeginHalfAVoxelBelowTheFloor) {
    const Container container = parse_container("box:0.03,0.03,0.1");
    core::Grid grid{.cells = {30, 30, 60}, .origin_m = {0.0, 0.0, 0.0}, .spacing_m = {1e-3, 1e-3, 1e-3}};
    const auto check = [&](double bottom_m) {
        grid.origin_m[2] = bottom_m;
        pore_space::require_fit(grid, container, {0.02, 0.04}, "here", false);
    };
    EXPECT_NO_THROW(check(std::nextafter(-0.5e-3, -1.0)));
    EXPECT_TRUE(has(message_of<core::UserError>([&] { check(-2e-3); }), "the image reaches from -0.002 to 0.058 m"));
}

TEST(Voxels, RefusesWhatCannotBe) {
    const Container box = parse_container("box:1,1,1:periodic");
    EXPECT_TRUE(has(message_of<UserError>([&] {
                        (void)plan_voxels(parse_container("box:1,0.73,1:periodic"), {0, 1}, 0.7, {}, 1.0);
                    }),
                    "no whole numbers of voxels of about 0.7 m"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)plan_voxels(box, {0, 1}, 0.5, {}, 0.3); }), "larger than the grain"));
    EXPECT_TRUE(has(message_of<UserError>([&] { (void)plan_voxels(box, {0, 1}, 1e-5, {}, 1.0); }), "cells"));
    EXPECT_EQ(plan_voxels(parse_container("cylinder:0.05,0.2"), {0.02, 0.06}, 3e-4, {}, 1.0).grid.cells[2], 133);
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

TEST(Stl, FaultsAreNamed) {
    const test::Folder folder;
    Packing packing = l_shaped();
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
    const TriangleSurface surface = make_surface(l_shaped(), {}).surface;
    const SurfaceSolid closed(surface, l_shaped().container);
    const double whole = closed.volume_between(-1.0, 1.0).value();
    EXPECT_NEAR(whole / check_surface(surface).volume_m3, 1.0, 1e-9);
    const double low = closed.bounds().low.z(), high = closed.bounds().high.z();
    double sum = 0.0;
    for (int part = 0; part < 7; ++part)
        sum += closed.volume_between(low + (high - low) * part / 7, low + (high - low) * (part + 1) / 7).value();
    EXPECT_NEAR(sum / whole, 1.0, 1e-9);
}

TEST(CellSet, NumbersItsCells) {
    const Grid grid{.cells = {37, 11, 9}};
    CellSet set(grid);
    std::vector<std::size_t> expected;
    std::mt19937 random(5);
    for (int k = 0; k < 9; ++k)
        for (int j = 0; j < 11; ++j) {
            const std::size_t row = grid.index(0, j, k);
            for (int first = static_cast<int>(random() % 9); first < 37; first += 3 + static_cast<int>(random() % 12)) {
                const int last = std::min<int>(36, first + static_cast<int>(random() % 30));
                set.insert_run(row, first, last);
                for (int i = first; i <= last; ++i) expected.push_back(row + static_cast<std::size_t>(i));
                first = last + 1;
            }
        }
    set.insert_run(grid.index(0, 10, 8), 0, 36);  // words may be filled to their last bit
    for (int i = 0; i < 37; ++i) expected.push_back(grid.index(i, 10, 8));
    std::sort(expected.begin(), expected.end());
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    set.finish();
    ASSERT_EQ(set.size(), static_cast<std::int64_t>(expected.size()));
    std::vector<std::size_t> listed;
    set.for_each([&](std::size_t cell) { listed.push_back(cell); });
    EXPECT_EQ(listed, expected);
    for (std::size_t member = 0; member < expected.size(); ++member) {
        ASSERT_EQ(set.cell(member), expected[member]);
        ASSERT_EQ(set.find(expected[member]), static_cast<std::int64_t>(member));
    }
    for (std::size_t first = 0; first < expected.size(); first += 128) {
        std::vector<std::size_t> part(std::min<std::size_t>(128, expected.size() - first));
        set.list(first, part);
        ASSERT_TRUE(std::equal(part.begin(), part.end(), expected.begin() + static_cast<std::ptrdiff_t>(first)));
    }
    std::size_t missing = 0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell)
        if (set.find(cell) < 0) ++missing;
    EXPECT_EQ(missing, grid.size() - expected.size());
}

TEST(Percolation, FindsBlockedAndIsolatedPores) {
    PhaseImage image{.grid = {.cells = {5, 5, 6}}, .phase = std::vector<std::uint8_t>(150, Phase::grain), .notes = {}};
    const Drive drive{.axis = 2, .periodic = {false, false, false}};
    for (int k = 0; k < 6; ++k) image.phase[image.grid.index(1, 1, k)] = Phase::pore;
    image.phase[image.grid.index(3, 3, 3)] = Phase::pore;
    const Percolation open = find_percolating_cells(image, drive);
    EXPECT_EQ(open.isolated_cells, 1);
    EXPECT_EQ(open.cells.size(), 6);
    image.phase[image.grid.index(1, 1, 2)] = Phase::grain;
    EXPECT_TRUE(has(message_of<NumericalError>([&] { (void)find_percolating_cells(image, drive); }), "does not percolate"));
    // In a periodic box: a channel that returns to itself without passing round the box carries no flow.
    const Drive periodic{.axis = 2, .periodic = {true, true, true}};
    EXPECT_TRUE(has(message_of<NumericalError>([&] { (void)find_percolating_cells(image, periodic); }), "does not percolate"));
    image.phase[image.grid.index(1, 1, 2)] = Phase::pore;
    EXPECT_EQ(find_percolating_cells(image, periodic).isolated_cells, 1);
}

TEST(Percolation, AChannelThatTurnsBackThroughAFaceDoesNotWind) {
    // Up through the top face and down again beside it: two turns that cancel. With one more connection it winds round.
    PhaseImage image{.grid = {.cells = {6, 4, 6}}, .phase = std::vector<std::uint8_t>(144, Phase::grain), .notes = {}};
    const auto open = [&](int i, int j, int k) { image.phase[image.grid.index(i, j, k)] = Phase::pore; };
    for (const int k : {0, 1, 4, 5})
        for (const int i : {1, 3}) open(i, 1, k);
    open(2, 1, 1);
    open(2, 1, 4);
    const Drive periodic{.axis = 2, .periodic = {true, true, true}};
    EXPECT_THROW((void)find_percolating_cells(image, periodic), DoesNotPercolate);
    for (const int k : {2, 3}) open(3, 1, k);
    EXPECT_EQ(find_percolating_cells(image, periodic).cells.size(), 12);
    // The same along x and y, and between end planes.
    for (const int axis : {0, 1, 2}) {
        PhaseImage bar{.grid = {.cells = {4, 4, 4}}, .phase = std::vector<std::uint8_t>(64, Phase::grain), .notes = {}};
        for (int at = 0; at < 4; ++at) {
            std::array<int, 3> place = {2, 2, 2};
            place[static_cast<std::size_t>(axis)] = at;
            bar.phase[bar.grid.index(place[0], place[1], place[2])] = Phase::pore;
        }
        for (const int along : {0, 1, 2}) {
            const Drive drive{.axis = along, .periodic = {true, true, true}};
            if (along == axis)
                EXPECT_EQ(find_percolating_cells(bar, drive).cells.size(), 4);
            else
                EXPECT_THROW((void)find_percolating_cells(bar, drive), DoesNotPercolate);
        }
    }
}

TEST(Voxels, NarrowGapsAreThoseBetweenSolids) {
    // Along x: solid, a gap of two, solid, a gap of three, solid; open only at its ends along y and z.
    PhaseImage image{.grid = {.cells = {8, 3, 3}}, .phase = std::vector<std::uint8_t>(72, Phase::pore), .notes = {}};
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j)
            for (const int i : {0, 3, 7}) image.phase[image.grid.index(i, j, k)] = Phase::grain;
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 1), 0.0);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 2), 2.0 / 5.0);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 3), 1.0);
    std::fill(image.phase.begin(), image.phase.end(), Phase::grain);
    EXPECT_DOUBLE_EQ(narrow_fraction(image, 3), 0.0);
}

}  // namespace
}  // namespace porepack
