// The stages of a case, one source file each: a stage reads, calls a function of src/analysis, and writes.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "converters/config.hpp"
#include "core/files.hpp"
#include "pipeline/stage.hpp"
#include "pore_space/pore_space.hpp"
#include "results/results.hpp"
#include "stages/case.hpp"
#include "uncertainty/section_scatter.hpp"

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

// ---- the work of a stage, for loose files too: computes, writes its files into `folder`, returns the result

[[nodiscard]] results::Voxelise write_voxels(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                             const core::Path& folder);
[[nodiscard]] results::Slices write_slice_images(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                 const core::Path& folder);
[[nodiscard]] results::Lbm run_lbm(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                   const lbm::LbmConfig& config, const core::Path& folder, const core::Path& checkpoint = {});

// ---- shared by the stages of a case

/// [falling_head] of a case, with the inertia coefficient m of its sample if that is known.
[[nodiscard]] falling_head::FallingHeadConfig apparatus_of(const Case& c);
/// The pore space of the geometry and flow stages. With `with_surface` it includes the surface of the stl stage.
[[nodiscard]] pore_space::PoreSpace case_pore_space(const Case& c, bool with_surface = false);
/// The packing of this configuration has been made.
[[nodiscard]] bool has_packing(const Case& c);
/// The same before a packing exists: the expected container and section, for dry runs. Its porosity is
/// expected_porosity().
[[nodiscard]] pore_space::PoreSpace expected_pore_space(const Case& c);
[[nodiscard]] double expected_porosity(const Case& c);
/// Scatter of k of sections of this length, from the gradient along z of the lbm stage; none without one.
[[nodiscard]] std::optional<uncertainty::SectionScatter> section_scatter_of(const Case& c);
/// That of [container]; of a packing found in a scan its own, and before the fit the box of the scan.
[[nodiscard]] packing::Container case_container(const Case& c);
/// [container] of a case with an image; none if the image names it, or fills a box.
[[nodiscard]] std::optional<packing::Container> container_of_image(const Case& c);
/// Name of the file that stage `image` writes: gray.vti with gray walls, else pore.vti.
[[nodiscard]] std::string image_file(const Case& c);
/// The stage that makes the solid: "pack", "stl" of a user's surface, or "image".
[[nodiscard]] std::string solid_stage(const Case& c);
/// Whole tables, and of [geometry] only the keys that determine a stage's result: slices do not become stale when the voxel size changes.
[[nodiscard]] core::Json deciding_keys(const Case& c, const std::vector<std::string>& tables, std::set<std::string> geometry_keys,
                                       bool with_section);

}  // namespace porepack::stages
