// A gray image as solid fractions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geometry/grid.hpp"

namespace porepack::inline geometry {

/// A gray image of cubic voxels as solid fractions: 0 is the mean of the pores, 1 that of the solid. Two bytes per voxel: fractions from
/// -0.5 to 1.5, others are cut there.
struct GrayImage {
    Grid grid;
    std::vector<std::uint16_t> packed;
    double level = 0.5;                        ///< between pores and solid
    std::map<std::string, std::string> notes;  ///< for instance the container

    static constexpr double lowest = -0.5, highest = 1.5;
    [[nodiscard]] static std::uint16_t pack(double fraction) {
        return static_cast<std::uint16_t>(std::lround(65535.0 * (std::clamp(fraction, lowest, highest) - lowest) / (highest - lowest)));
    }
    [[nodiscard]] static double unpack(std::uint16_t value) { return lowest + (highest - lowest) / 65535.0 * value; }
    [[nodiscard]] double at(std::size_t cell) const { return unpack(packed[cell]); }
};

}  // namespace porepack::inline geometry
