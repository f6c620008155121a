// The estimated iteration error against the true one, and what keeps the iteration fast and sound.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "lbm/sequence.hpp"
#include "packing/packing.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"
#include "support/inertial_runs.hpp"
#include "support/slow_flows.hpp"

namespace porepack {
namespace {

using namespace test;

// Other seeds than those of the calibration; `porepack benchmark iteration` runs 200 flows.
TEST(IterationError, IsAtMostTheEstimateInSlowFlows) {
    const std::vector<SlowFlow> flows = random_slow_flows(7, 20);
    std::vector<SlowRun> runs(flows.size());
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < flows.size(); ++i) runs[i] = run_until_constant(flows[i], 12000);
    int cases = 0, within = 0;
    for (std::size_t i = 0; i < flows.size(); ++i)
        for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
            const auto stop = runs[i].stop(tolerance);
            if (!runs[i].constant || !stop) continue;
            ++cases;
            within += stop->error <= stop->estimate ? 1 : 0;
            EXPECT_LE(stop->error, 5.0 * stop->estimate) << flows[i].name << " " << i << ", tolerance " << tolerance;
        }
    std::printf("  %d of %d within the estimate\n", within, cases);
    EXPECT_GE(cases, 30);
    EXPECT_GE(within, 0.95 * cases);
}

// Theory: k plus the rate of (kinetic - elastic energy) over the power is exact to first order, so that its error falls faster. What
// remains is of second order, up to 0.05 of itself here, and the discretisation of the energies.
TEST(IterationError, TheEnergyRateIsTheRemainingChange) {
    // Periodic; between pressure planes; a section inside the flow.
    for (const int kind : {0, 1, 2}) {
        const Scene bed(random_bed(kind > 0 ? "box:1,1,2" : "box:1,1,2:periodic", 12, 0.08), {0.0, 2.0}, 1.0 / 16);
        const Scheme scheme{.tau = 0.9, .force = {0, 0, 1e-3}};
        const FlowSection section =
            flow_section(bed.image.grid, bed.packing.container, {kind == 2 ? 0.5 : 0.0, kind == 2 ? 1.5 : 2.0}, bed.drive);
        const auto flow = make_flow(Kernel::cpu_double, bed.domain, scheme);
        const StokesRun run = run_to_steady(*flow, bed.domain, scheme, section, {.tolerance = 1e-9});
        ASSERT_TRUE(run.converged);
        int compared = 0;
        for (const ConvergencePoint& point : run.history) {
            const double error = std::abs(point.permeability_volume_lu / run.permeability_volume_lu - 1.0);
            if (error < 1e-3 || error > 0.05) continue;
            EXPECT_LT(std::abs(point.expected_volume_lu / run.permeability_volume_lu - 1.0), 0.3 * error) << kind << " " << point.step;
            ++compared;
        }
        EXPECT_GE(compared, 2);
    }
}

// Other flows than those of the calibration; `porepack benchmark iteration` runs more and finer ones. The estimate for creeping flow is the
// control: a flow that starts from another one seems steady at first.
TEST(IterationError, IsAtMostTwiceTheEstimateWithInertia) {
    int cases = 0, within = 0, missed_without = 0;
    for (const InertialRun& flow : random_inertial_runs(5, 8, 10.0, 1e-5))
        for (const double tolerance : {1e-2, 1e-3}) {
            SlowRun other = flow.run;
            for (std::size_t i = 0; i < other.history.size(); ++i)
                other.history[i].iteration_error =
                    iteration_error({flow.run.history.begin(), flow.run.history.begin() + static_cast<long>(i) + 1});
            const auto stop = flow.run.stop(tolerance), without = other.stop(tolerance);
            if (!stop || !without) continue;
            ++cases;
            within += stop->error <= stop->estimate ? 1 : 0;
            missed_without += without->error > 5.0 * without->estimate ? 1 : 0;
            EXPECT_LE(stop->error, 2.0 * stop->estimate) << flow.name << ", Re " << flow.reynolds << ", tolerance " << tolerance;
        }
    std::printf("  %d of %d within the estimate; the one for creeping flow misses %d by a factor of five\n", within, cases, missed_without);
    EXPECT_GE(cases, 40);
    EXPECT_GE(within, 0.9 * cases);
    EXPECT_GE(missed_without, 2);
}

// A wide gap and a narrow one, far apart: the pressure between them takes most of the steps.
TEST(IterationError, TellsTheShareOfTheSteps) {
    // An error that falls by a factor of ten in 200 steps, from 1 at step 100: below 1e-4 at step 900, and the run ends a check later.
    std::vector<ConvergencePoint> history;
    for (long step = 40; step <= 400; step += 40)
        history.push_back({.step = step, .iteration_error = std::min(1.0, std::pow(10.0, (100.0 - static_cast<double>(step)) / 200.0))});
    EXPECT_NEAR(share_of_steps(history, 1e-4).value(), 400.0 / 940.0, 1e-9);
    EXPECT_NEAR(share_of_steps(history, 0.1).value(), 400.0 / 440.0, 1e-9);  // met, and to be met once more
    EXPECT_FALSE(share_of_steps({history.begin(), history.begin() + 3}, 1e-4));
    for (ConvergencePoint& point : history) point.iteration_error = 1e-2;
    EXPECT_FALSE(share_of_steps(history, 1e-4));
}

TEST(IterationError, OfTwoLayersOfRodsIsCovered) {
    Packing packing{.container = vessels::make_box({1.0, 0.125, 6.0}, {true, true, false}), .shapes = {}, .bodies = {}};
    for (const auto& [gap, z] : {std::pair{0.36, 1.5}, {0.06, 4.5}}) {
        packing.bodies.push_back({.shape = packing.shapes.size(), .position_m = {0.5, 0.0625, z}});
        packing.shapes.push_back({.id = "rod", .capsules = {{Vec3(0, -1, 0), Vec3(0, 1, 0), 0.5 * (1.0 - gap)}}});
    }
    SlowFlow flow{.name = "two layers", .space = pore_space_of(packing).with_section({0.0, 6.0}), .voxel_size_m = 1.0 / 24};
    const SlowRun run = run_until_constant(flow, 40000);
    ASSERT_TRUE(run.constant);
    for (const double tolerance : {1e-2, 1e-3}) {
        const auto stop = run.stop(tolerance);
        ASSERT_TRUE(stop);
        std::printf("  tolerance %g: estimate %.1e, error %.1e after %ld steps\n", tolerance, stop->estimate, stop->error, stop->steps);
        EXPECT_LE(stop->error, stop->estimate);
    }
}

// Walls leak a little; in a closed cell the mean density, which would drift, stays zero, and it has no effect on the flow.
TEST(MassLeak, IsReportedAndItsDensityRemoved) {
    const KnownFlow array = sphere_array(0.6, 88.8734, body_centred(), Vec3(0.11, 0.07, 0.21));
    const PoreSpace space = array.space();
    const PhaseImage image = space.voxelise_at(1.0 / 20);
    const FlowWalls walls = *space.walls();
    const Drive drive = choose_drive(space.container, Axis::z);
    const Domain domain = build_domain(image, drive, &walls);
    const Scheme scheme{.tau = 1.2, .force = {0, 0, 1e-3}};
    const FlowSection section = flow_section(image.grid, space.container, space.section, drive);
    const auto flow = make_flow(Kernel::cpu_double, domain, scheme);
    StokesRun run = run_to_steady(*flow, domain, scheme, section, {.tolerance = 1e-8});
    ASSERT_TRUE(run.converged);
    EXPECT_GT(std::abs(run.mass_leak), 1e-9);
    EXPECT_LT(std::abs(run.mass_leak), 1e-4);
    const double mean = mean_density(run.layers.nodes, run.layers.density), drop = 3e-3 * 20;
    EXPECT_LT(std::abs(mean), 50.0 * std::abs(run.mass_leak) * drop) << "at most the leak of one check";
    // The same flow with a density that has drifted for many steps.
    flow->add_density(0, std::vector<double>(domain.nodes(), drop));
    for (int i = 0; i < 10; ++i) flow->advance_two_steps();
    const Layers layers = flow->layers(domain);
    for (std::size_t l = 0; l < layers.flow.size(); ++l) EXPECT_NEAR(layers.flow[l] / run.layers.flow[l], 1.0, 1e-6);
}

}  // namespace
}  // namespace porepack
