// Layers of an image that are kept.
#include "geometry/known_layers.hpp"

#include <gtest/gtest.h>

namespace porepack::geometry {
namespace {

const Grid column = {.cells = {1, 1, 10}, .origin_m = {0.0, 0.0, 2.0}, .spacing_m = {0.5, 0.5, 0.5}};

std::vector<int> kept(const KnownLayers& layers) {
    std::vector<int> found;
    for (int layer = 0; layer < column.cells[2]; ++layer)
        if (layers.has(layer)) found.push_back(layer);
    return found;
}

TEST(KnownLayers, AreThoseBetweenTheHeightsAndTwoBeyond) {
    EXPECT_EQ(kept(KnownLayers(column, {{4.1, 4.4}})), (std::vector{2, 3, 4, 5, 6}));
    EXPECT_EQ(kept(KnownLayers(column, {{4.1, 4.4}, {5.6, 5.7}})), (std::vector{2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(KnownLayers(column, {{2.0, 7.0}}).number(), 10);
    EXPECT_EQ(KnownLayers(column, {{-50.0, 70.0}}).number(), 10);
}

TEST(KnownLayers, OfHeightsBeyondAPeriodicSideLieAtTheOther) {
    EXPECT_EQ(kept(KnownLayers(column, {{1.8, 2.1}})), (std::vector{0, 1, 2, 7, 8, 9}));
    EXPECT_EQ(kept(KnownLayers(column, {{7.1, 7.2}})), (std::vector{0, 1, 2, 8, 9}));
}

TEST(KnownLayers, KeepTheirValues) {
    const std::vector<int> all = {0, 10, 20, 30, 40, 50, 60, 70, 80, 90};
    const KnownLayers whole(column), part(column, {{4.1, 4.4}}), less(column, {{4.1, 4.4}, {2.1, 2.2}});
    EXPECT_EQ(part.values(column, whole, all), (std::vector{20, 30, 40, 50, 60}));
    EXPECT_EQ(part.place(4), 2);
    EXPECT_EQ(part.values(column, less, less.values(column, whole, all)), (std::vector{20, 30, 40, 50, 60}));
}

}  // namespace
}  // namespace porepack::geometry
