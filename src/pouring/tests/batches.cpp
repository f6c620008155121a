// The grains of a pour as they are created.
#include "pouring/batches.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "pouring/uses.hpp"
#include "shapes/distance.hpp"
#include "support/helpers.hpp"
#include "vessels/container.hpp"

namespace porepack {
namespace {

// In a narrow box without side walls, many pairs touch across its sides.
TEST(Batches, GrainsDoNotOverlapAcrossPeriodicSides) {
    const double width = 0.03;
    const vessels::Container box = make_box({width, width, 0.2}, {true, true, false});
    for (const ShapeConfig& config :
         {ShapeConfig{.kind = ShapeKind::ring, .diameter_m = 0.008, .height_m = 0.008, .inner_diameter_m = 0.0032},
          ShapeConfig{.kind = ShapeKind::rod, .diameter_m = 0.006, .length_m = 0.006}}) {
        const std::vector<ShapeShare> shapes = make_shapes(config);
        const pouring::Pour pour = pouring::make_batches(shapes, box, {.seed = 1, .batch_grains = 9}, 0.15, 90);
        double smallest_gap = 1.0;
        for (const pouring::Batch& batch : pour.batches)
            for (std::size_t i = 0; i < batch.size(); ++i)
                for (std::size_t j = 0; j < i; ++j)
                    for (const double x : {-width, 0.0, width})
                        for (const double y : {-width, 0.0, width}) {
                            const PlacedShape one{shapes[0].shape, batch[i].position_m + Vec3(x, y, 0.0), batch[i].orientation},
                                other{shapes[0].shape, batch[j].position_m, batch[j].orientation};
                            smallest_gap = std::min(smallest_gap, nearest(one, other, 0.01).gap_m);
                        }
        EXPECT_GE(smallest_gap, 0.02 * pouring::finest_diameter(shapes) - 1e-9);
    }
}

}  // namespace
}  // namespace porepack
