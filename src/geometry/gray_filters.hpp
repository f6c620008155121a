// Gray images rescaled, averaged and smoothed.
#pragma once

#include <array>

#include "geometry/gray_image.hpp"

namespace porepack::inline geometry {

/// The same image in which `pores` becomes 0 and `solid` becomes 1.
void rescale(GrayImage& image, double pores, double solid);

/// Means of factor x factor x factor voxels; what is left over at the far sides is dropped. In the same place.
[[nodiscard]] GrayImage averaged(const GrayImage& image, int factor);

/// Smooths the values by a Gaussian of this standard deviation. In periodic directions they continue at the other side, else the outermost
/// ones stay.
void smooth(GrayImage& image, double sigma_voxels, const std::array<bool, 3>& periodic);

}  // namespace porepack::inline geometry
