// What gray levels and blur of a scan do to k.
#pragma once

#include <optional>

#include "lbm/permeability.hpp"
#include "scans/gray_input.hpp"

namespace porepack::analysis {

/// Adds to the interval what gray levels and blur do to k: two more runs on the second finest grid, one with the solid fraction moved by
/// two standard errors, one with twice the variance of the blur, its gray levels and its threshold found anew. Constants: fitted to spheres
/// (`porepack_benchmark gray`). A third run is on the means of 2 x 2 x 2 voxels, where their numbers are even: not in the interval. Where
/// `space` keeps what a part of the computation needs of an image, `run` has its cuts, and `variants` the same of those of the whole image.
void add_gray_parts(lbm::LbmResult& result, const pore_space::PoreSpace& space, const lbm::LbmConfig& config, const lbm::LbmRun& run = {},
                    std::optional<scans::GrayVariants> variants = std::nullopt);

/// Each part of a computation drops what only the others need of an image; `run` gets the cuts. Variants of a gray image are made from the
/// whole one, if add_gray_parts() will need them. `porosity` is that of the whole. Nothing changes in one part, or without an image.
void keep_own_part(pore_space::PoreSpace& space, std::optional<scans::GrayVariants>& variants, lbm::LbmRun& run, double voxel_size_m,
                   const lbm::LbmConfig& config, double porosity);

}  // namespace porepack::analysis
