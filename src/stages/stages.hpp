// The stages of a case, one source file each: a stage reads, calls a function of src/analysis, and writes.
#pragma once

#include <string>
#include <vector>

#include "pipeline/stage.hpp"
#include "stages/case.hpp"

namespace porepack::stages {

[[nodiscard]] pipeline::Stage make_shape_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_image_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_pack_stage(const Case& c);
/// That of grains found in a scan.
[[nodiscard]] pipeline::Stage make_fit_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_stl_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_voxelise_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_slices_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_lbm_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_foam_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_tortuosity_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_forchheimer_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_falling_head_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_causes_stage(const Case& c);
/// Dimensionless numbers, friction factor, the part of the wall.
[[nodiscard]] pipeline::Stage make_descriptors_stage(const Case& c);
/// Uncertainty budget and statements, from those of `stages` that it uses.
[[nodiscard]] pipeline::Stage make_uncertainty_stage(const Case& c, const std::vector<std::string>& stages);
/// It shows the results of the stages `shown`, in their order, as far as they exist; it needs those in `needs`.
[[nodiscard]] pipeline::Stage make_report_stage(const Case& c, const std::vector<std::string>& needs,
                                                const std::vector<std::string>& shown);

/// All stages that a case enables, in order. `studies` (src/study) run after the solvers.
[[nodiscard]] std::vector<pipeline::Stage> case_stages(const Case& c, std::vector<pipeline::Stage> studies = {});

}  // namespace porepack::stages
