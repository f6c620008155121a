// Axes and handedness in every file.
#include <cstdint>
#include <string>
#include <vector>

#include "converters/slices.hpp"
#include "converters/surface.hpp"
#include "io/image.hpp"
#include "pore_space/voxels.hpp"
#include "scans/phases.hpp"
#include "support/helpers.hpp"
#include "support/l_shaped.hpp"

namespace porepack {
namespace {

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

TEST(Axes, TheLStandsRightInEveryFile) {
    const test::Folder folder;
    write_packing(folder.path() / "packing.json", test::l_shaped());
    const Packing packing = read_packing(folder.path() / "packing.json");
    const Grains grains(packing);
    const Section whole{0.0, 0.04};

    const VoxelPlan plan = plan_voxels(packing.container, whole, 1e-3, {}, 0.006);
    write_phase_image(folder.path() / "pore.vti", voxelise(grains, packing.container, whole, plan.grid));
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
    std::string bytes;
    for (const int parts : {1, 3}) {
        run_parts(parts, [&](const Communicator& slabs) {
            LayeredFlow layered = test::as_layers(flow);
            const int layers = flow.grid.cells[2];
            layered.own = {layers * slabs.part() / parts, layers * (slabs.part() + 1) / parts};
            write_flow_image(folder.path() / "flow.vti", layered, slabs);
        });
        const FlowImage back = read_flow_image(folder.path() / "flow.vti");
        EXPECT_EQ(back.velocity_m_per_s, flow.velocity_m_per_s);
        EXPECT_EQ(back.phase, image.phase);
        EXPECT_EQ(back.notes.at("unit"), "metre");
        EXPECT_EQ(back.grid.cells, flow.grid.cells);
        EXPECT_EQ(back.grid.origin_m, flow.grid.origin_m);
        const std::string text = read_text(folder.path() / "flow.vti");
        if (parts == 1) bytes = text;
        EXPECT_TRUE(text == bytes);
    }

    // The columns of the surface give the same voxels, except for those that its facets cross.
    const PhaseImage from_stl = voxelise(SurfaceSolid(surface, packing.container), packing.container, whole, plan.grid);
    std::size_t different = 0, solid = 0;
    for (std::size_t cell = 0; cell < image.phase.size(); ++cell) {
        different += image.phase[cell] != from_stl.phase[cell] ? 1 : 0;
        solid += image.phase[cell] == Phase::grain ? 1 : 0;
    }
    EXPECT_LT(different, solid / 20);
}

}  // namespace
}  // namespace porepack
