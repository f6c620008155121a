// The work of some stages, for loose files too: computes, writes its files into `folder`, returns the result.
#pragma once

#include <string>
#include <vector>

#include "converters/config.hpp"
#include "core/files.hpp"
#include "lbm/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/geometry.hpp"
#include "results/lbm.hpp"
#include "stages/case.hpp"

namespace porepack::stages {

[[nodiscard]] results::Voxelise write_voxels(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                             const core::Path& folder);
[[nodiscard]] results::Slices write_slice_images(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                 const core::Path& folder);
/// Called by all ranks, of which the first writes.
[[nodiscard]] results::Lbm run_lbm(pore_space::PoreSpace space, const converters::GeometryConfig& geometry, const lbm::LbmConfig& config,
                                   const core::Path& folder, const core::Path& checkpoint = {});
/// On the ranks of [parallel].
[[nodiscard]] results::Lbm run_lbm(const Case& c, const core::Path& folder);

/// Arguments of the ranks that a stage starts, which works in `folder`; the command `stage` calls the function below for each of them.
[[nodiscard]] std::vector<std::string> rank_arguments(const std::string& stage, const Case& c, const core::Path& folder);
/// What a rank does; the stage reads in `folder` what the first leaves.
void run_lbm_rank(const Case& c, const core::Path& folder);
void run_forchheimer_rank(const Case& c, const core::Path& folder);

}  // namespace porepack::stages
