// STL, PLY and OBJ files of users.
#include <cstring>
#include <string>

#include "converters/surface.hpp"
#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "support/basics.hpp"

namespace porepack {
using namespace converters;
namespace {

using test::has;
using test::message_of;

const std::string corners = "0 0 0\n2 0 0\n0 3 0\n2 3 0\n0 0 4\n2 0 4\n0 3 4\n2 3 4\n";
// A box of 2 x 3 x 4 with sides of four corners.
const std::string ply =
    "ply\nformat ascii 1.0\ncomment a box\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\nelement face "
    "6\nproperty list uchar int vertex_indices\nend_header\n" +
    corners + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n";

std::string obj() {
    std::string text = "# a box\nmtllib none.mtl\no box\n";
    for (std::size_t at = 0; at < corners.size();) {
        const std::size_t end = corners.find('\n', at);
        text += "v " + corners.substr(at, end - at) + "\n";
        at = end + 1;
    }
    return text + "vt 0 0\nvn 0 0 1\ns off\nf 1/1/1 3/1/1 4/1/1 2/1/1\nf 5 6 8 7\nf 1//1 2//1 6//1 5//1\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

TEST(SurfaceFiles, PlyAndObjHoldTheSameBox) {
    const test::Folder folder;
    EXPECT_TRUE(is_surface_file("a.PLY") && is_surface_file("a.obj") && is_surface_file("a.stl") && !is_surface_file("a.json"));
    for (const Path& file : {folder.write("a.ply", ply), folder.write("a.OBJ", obj())}) {
        const geometry::TriangleSurface box = read_surface(file, 0.01);
        EXPECT_EQ(box.points.size(), 8U);
        EXPECT_EQ(box.triangles.size(), 12U);
        const SurfaceCheck check = check_surface(box);
        EXPECT_EQ(check.fault, "") << file;
        EXPECT_NEAR(check.volume_m3, 24e-6, 1e-15);
    }
}

TEST(SurfaceFiles, FaultsAreNamed) {
    const test::Folder folder;
    const auto fault = [&](const char* name, const std::string& text) {
        return message_of<UserError>([&] { (void)read_surface(folder.write(name, text)); });
    };
    EXPECT_TRUE(has(fault("a.ply", ""), "empty"));
    EXPECT_TRUE(has(fault("a.ply", "hello"), "not a PLY file"));
    EXPECT_TRUE(has(fault("a.ply", obj()), "not a PLY file"));
    EXPECT_TRUE(has(fault("a.obj", "hello"), "not an OBJ file"));
    EXPECT_TRUE(has(fault("a.ply", ply.substr(0, ply.size() - 30)), "incomplete"));
    std::string outside = ply;
    outside.replace(outside.rfind("4 1 3 7 5"), 9, "4 1 3 9 5");
    EXPECT_TRUE(has(fault("a.ply", outside), "face 6 has a corner 10, but there are 8 points"));
    std::string no_number = ply;
    no_number.replace(no_number.find("2 0 4"), 5, "2 nan 4");
    EXPECT_NE(fault("a.ply", no_number), "");
    std::string huge = ply;
    huge.replace(huge.find("vertex 8"), 8, "vertex 99999999999");
    EXPECT_NE(fault("a.ply", huge), "");
    EXPECT_TRUE(has(fault("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"), "incomplete one"));
}

}  // namespace
}  // namespace porepack
