// The work of some stages, for loose files too: computes, writes its files into `folder`, returns the result.
#pragma once

#include "converters/config.hpp"
#include "core/files.hpp"
#include "lbm/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/geometry.hpp"
#include "results/lbm.hpp"

namespace porepack::stages {

[[nodiscard]] results::Voxelise write_voxels(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                             const core::Path& folder);
[[nodiscard]] results::Slices write_slice_images(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                 const core::Path& folder);
[[nodiscard]] results::Lbm run_lbm(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                   const lbm::LbmConfig& config, const core::Path& folder, const core::Path& checkpoint = {});

}  // namespace porepack::stages
