// Streamlines of flows whose paths are known.
#include "analysis/streamlines.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "support/helpers.hpp"

namespace porepack {
namespace {

using analysis::Streamline;
using analysis::streamlines;

FlowImage flow_of(int cells, const std::function<std::array<double, 3>(double x, double y, double z)>& velocity) {
    FlowImage flow{.grid = {.cells = {cells, cells, cells}}, .velocity_m_per_s = {}, .pressure_Pa = {}, .phase = {}, .notes = {}};
    flow.grid.spacing_m = {2.0 / cells, 2.0 / cells, 2.0 / cells};
    flow.grid.origin_m = {-1.0, -1.0, 0.0};
    for (std::size_t cell = 0; cell < flow.grid.size(); ++cell) {
        const auto at = flow.grid.place(cell);
        for (const double u : velocity(flow.grid.centre(0, at[0]), flow.grid.centre(1, at[1]), flow.grid.centre(2, at[2])))
            flow.velocity_m_per_s.push_back(static_cast<float>(u));
    }
    return flow;
}

// Linear in space, so that the interpolation is exact: a helix of constant radius, one radian per unit of height.
TEST(Streamlines, FollowAHelix) {
    const FlowImage flow = flow_of(40, [](double x, double y, double) { return std::array{-0.3 * y, 0.3 * x, 0.3}; });
    const std::vector<Streamline> lines = streamlines(flow, 2, 30);
    ASSERT_GT(lines.size(), 25U);  // some leave through a side at once
    int whole = 0;
    for (const Streamline& line : lines) {
        const auto &p = line.points_m.front(), &q = line.points_m.back();
        const double radius = std::hypot(p[0], p[1]);
        if (radius > 0.9) continue;  // it may leave through a side
        ++whole;
        EXPECT_NEAR(std::hypot(q[0], q[1]), radius, 1e-3);
        EXPECT_GT(q[2], 1.85);
        const double turned = std::remainder(std::atan2(q[1], q[0]) - std::atan2(p[1], p[0]) - (q[2] - p[2]), 2.0 * std::acos(-1.0));
        EXPECT_NEAR(turned, 0.0, 0.01);
        EXPECT_NEAR(line.speeds_m_per_s.back(), 0.3 * std::sqrt(1.0 + radius * radius), 1e-3);
    }
    EXPECT_GT(whole, 15);
}

// As many start in the fast half as its part of the flow rate; none where the fluid rests, and none enters it.
TEST(Streamlines, StartByTheFlowRate) {
    const FlowImage flow = flow_of(20, [](double x, double y, double) {
        return std::array{0.0, 0.0, y > 0.8 ? 0.0 : x > 0.0 ? 3.0 : 1.0};
    });
    const std::vector<Streamline> lines = streamlines(flow, 2, 40);
    ASSERT_EQ(lines.size(), 40U);
    int fast = 0;
    for (const Streamline& line : lines) {
        fast += line.points_m.front()[0] > 0.0 ? 1 : 0;
        EXPECT_LT(line.points_m.front()[1], 0.8);
        EXPECT_GT(line.points_m.back()[2], 1.8);
    }
    EXPECT_NEAR(fast, 30, 1);
    EXPECT_TRUE(streamlines(flow_of(4, [](double, double, double) { return std::array{0.0, 0.0, 0.0}; }), 2, 5).empty());
}

}  // namespace
}  // namespace porepack
