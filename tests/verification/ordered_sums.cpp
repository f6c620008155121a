// Sums over the nodes of a flow: the same bits on any number of threads.
#include <omp.h>

#include <array>
#include <optional>
#include <vector>

#include "lbm/layers.hpp"
#include "support/arrays.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

using namespace test;

// Along x and y each plane of cells adds to all layers; along z to its own.
TEST(Sums, AreTheSameOnAnyNumberOfThreads) {
    const int threads_before = omp_get_max_threads();
    for (const int axis : {0, 1, 2}) {
        // 160 x 160 cells per plane: two blocks.
        Scene bed(random_bed("box:1,1,0.1:periodic", 6, 0.04), {0.0, 0.1}, 1.0 / 160);
        bed.domain.drive.axis = axis;
        Scheme scheme;
        scheme.force = {};
        scheme.force[static_cast<std::size_t>(axis)] = 1e-3;
        const auto flow = make_flow(Kernel::cpu_double, bed.domain, scheme);
        for (int i = 0; i < 30; ++i) flow->advance_two_steps();
        std::optional<Layers> alone;
        std::array<double, 3> drag{};
        for (const int threads : {1, 2, 3, 5}) {
            omp_set_num_threads(threads);
            const Layers layers = flow->layers(bed.domain);
            if (!alone) {
                alone = layers;
                drag = flow->drag(bed.domain);
            }
            EXPECT_EQ(layers.flow, alone->flow) << axis << ' ' << threads;
            EXPECT_EQ(layers.power, alone->power) << axis << ' ' << threads;
            EXPECT_EQ(layers.density, alone->density) << axis << ' ' << threads;
            EXPECT_EQ(flow->drag(bed.domain), drag) << axis << ' ' << threads;
        }
        // Against one sum over all nodes: the number of nodes exactly, the flow to rounding.
        std::vector<Moments> all(bed.domain.nodes());
        flow->moments(0, all);
        double nodes = 0.0, along = 0.0, sum = 0.0;
        for (const Moments& one : all) sum += one.velocity[static_cast<std::size_t>(axis)];
        for (std::size_t l = 0; l < alone->nodes.size(); ++l) {
            nodes += alone->nodes[l];
            along += alone->flow[l];
        }
        EXPECT_EQ(nodes, static_cast<double>(all.size()));
        EXPECT_NEAR(along / sum, 1.0, 1e-12);
    }
    omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace porepack
