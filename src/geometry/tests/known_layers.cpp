// Layers of an image that are kept.
#include "geometry/known_layers.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace porepack::inline geometry {
namespace {

const Grid column = {.cells = {1, 1, 10}, .origin_m = {0.0, 0.0, 2.0}, .spacing_m = {0.5, 0.5, 0.5}};

std::vector<int> kept(const KnownLayers& layers) {
    std::vector<int> found;
    for (int layer = 0; layer < column.cells[2]; ++layer)
        if (layers.has(layer)) found.push_back(layer);
    return found;
}

TEST(KnownLayers, AreThoseBetweenTheHeightsAndTwoBeyond) {
    EXPECT_EQ(kept(KnownLayers(column, {{4.1, 4.4}}, false)), (std::vector{2, 3, 4, 5, 6}));
    EXPECT_EQ(kept(KnownLayers(column, {{4.1, 4.4}, {5.6, 5.7}}, false)), (std::vector{2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(KnownLayers(column, {{2.0, 7.0}}, false).number(), 10);
    EXPECT_EQ(KnownLayers(column, {{-50.0, 70.0}}, true).number(), 10);
}

TEST(KnownLayers, OfHeightsBeyondAPeriodicSideLieAtTheOther) {
    EXPECT_EQ(kept(KnownLayers(column, {{1.8, 2.1}}, true)), (std::vector{0, 1, 2, 7, 8, 9}));
    EXPECT_EQ(kept(KnownLayers(column, {{7.1, 7.2}}, true)), (std::vector{0, 1, 2, 8, 9}));
}

TEST(KnownLayers, OfHeightsBeyondAWallAreTheOutermost) {
    EXPECT_EQ(kept(KnownLayers(column, {{1.8, 2.1}}, false)), (std::vector{0, 1, 2}));
    EXPECT_EQ(kept(KnownLayers(column, {{20.0, 30.0}}, false)), (std::vector{9}));
    EXPECT_EQ(kept(KnownLayers(column, {{-9.0, -8.0}}, false)), (std::vector{0}));
}

TEST(KnownLayers, KeepTheirValues) {
    const std::vector<int> all = {0, 10, 20, 30, 40, 50, 60, 70, 80, 90};
    const KnownLayers whole(column), part(column, {{4.1, 4.4}}, false), less(column, {{4.1, 4.4}, {2.1, 2.2}}, false);
    EXPECT_EQ(part.values(column, whole, all), (std::vector{20, 30, 40, 50, 60}));
    EXPECT_EQ(part.place(4), 2);
    EXPECT_EQ(part.values(column, less, less.values(column, whole, all)), (std::vector{20, 30, 40, 50, 60}));
}

}  // namespace
}  // namespace porepack::inline geometry
