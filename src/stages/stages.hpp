// The stages of a case, one source file each: their work on a pore space (also for loose files), and their place in a case.
// Each function writes its files into `folder` and returns the result (src/results).
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "converters/surface.hpp"
#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "pipeline/stage.hpp"
#include "pore_space/pore_space.hpp"
#include "results/falling_head_tests.hpp"
#include "results/pores.hpp"
#include "results/results.hpp"
#include "stages/case.hpp"
#include "stages/inputs.hpp"
#include "uncertainty/section_scatter.hpp"

namespace porepack::stages {

using pipeline::Expectation;

// ---- on a shape, a pore space, or measured curves

[[nodiscard]] results::Shape measure_shape(const shapes::ShapeConfig& config, double density_kg_per_m3);
/// Measures of a closed STL surface.
[[nodiscard]] results::Shape measure_surface_shape(const core::Path& stl, double unit_m, double density_kg_per_m3);
/// solid.stl of grains or of a user's surface, and the files requested by `extras`.
[[nodiscard]] results::Stl write_surfaces(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                          const converters::StlConfig& extras, const core::Path& folder);
[[nodiscard]] results::Voxelise write_voxels(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                             const core::Path& folder);
[[nodiscard]] results::Slices write_slice_images(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                 const core::Path& folder);
/// Resumes from the file `checkpoint` if it exists, and updates it until the end.
[[nodiscard]] results::Lbm run_lbm(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                   const lbm::LbmConfig& config, const core::Path& folder, const core::Path& checkpoint = {});
[[nodiscard]] Expectation expect_lbm(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                     const lbm::LbmConfig& config);
[[nodiscard]] results::Foam run_foam(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                     const openfoam::FoamConfig& config, const core::Path& folder);
[[nodiscard]] Expectation expect_foam(const pore_space::PoreSpace& space, const openfoam::FoamConfig& config);
/// Permeability against the Reynolds number by both solvers, of the section between two layers of free water.
[[nodiscard]] results::Forchheimer run_forchheimer(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                   const permeability::ForchheimerConfig& config, const core::Path& folder);
[[nodiscard]] Expectation expect_forchheimer(const pore_space::PoreSpace& space, const permeability::ForchheimerConfig& config);

enum class TortuosityKind { geometric_paper, shortest_path, hydraulic, diffusive };
constexpr std::array<core::Choice<TortuosityKind>, 4> choices_of(TortuosityKind) {
    return {{{TortuosityKind::geometric_paper, "geometric_paper"},
             {TortuosityKind::shortest_path, "shortest_path"},
             {TortuosityKind::hydraulic, "hydraulic"},
             {TortuosityKind::diffusive, "diffusive"}}};
}
[[nodiscard]] results::Diffusive run_diffusive(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                               core::Axis direction);
[[nodiscard]] results::ShortestPath run_shortest_path(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                                      core::Axis direction, const core::Path& folder);
/// The paper's dots: in exact grains, or on the layers of an image.
[[nodiscard]] results::GeometricPaper run_geometric_paper(const pore_space::PoreSpace& space, const tortuosity::TortuosityConfig& config,
                                                          const core::Path& folder);
/// Any of these kinds, as JSON; not the hydraulic one, which needs a flow.
[[nodiscard]] core::Json run_tortuosity(TortuosityKind kind, const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                        const tortuosity::TortuosityConfig& config, const core::Path& folder);
[[nodiscard]] Expectation expect_tortuosity(TortuosityKind kind, double cells);
/// The paper's dot method on the images of a folder of slices.
[[nodiscard]] results::GeometricPaper geometric_paper_of_slices(const core::Path& slices, const tortuosity::TortuosityConfig& config,
                                                                const core::Path& folder);
/// Hydraulic tortuosity of flow.vti, or of an OpenFOAM case that has run.
[[nodiscard]] results::HydraulicTortuosity hydraulic_tortuosity_of(const core::Path& flow, const std::vector<double>& section_m);

/// The pore space of the section described: chords, pore sizes, critical diameter, correlation; CSV files and pores.svg.
[[nodiscard]] results::Pores run_pores(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                       const core::Path& folder);
[[nodiscard]] Expectation expect_pores(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry);

/// A simulated test: times by Eq. 18 and by the full equation, and falling_head.csv in `folder` if there is one.
[[nodiscard]] results::FallingHead simulate_falling_head(double permeability_m2, double inertial_permeability_m,
                                                         const falling_head::FallingHeadConfig& config, const core::Path* folder);
/// Measured curves evaluated as in the paper and by least squares; analysis.csv and analysis.svg.
[[nodiscard]] results::FallingHeadAnalysis analyse_falling_head(const std::vector<core::Path>& curves,
                                                                const falling_head::FallingHeadConfig& config, const core::Path& folder);
/// [falling_head] of a case, with the inertia coefficient m of its sample if that is known.
[[nodiscard]] falling_head::FallingHeadConfig apparatus_of(const Case& c);

// ---- of a case

[[nodiscard]] pipeline::Stage make_shape_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_image_stage(const Case& c);
[[nodiscard]] pipeline::Stage make_pack_stage(const Case& c);
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

// ---- shared by the stages of a case

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
[[nodiscard]] converters::SurfaceOptions surface_options(const converters::GeometryConfig& geometry);
[[nodiscard]] results::BedPorosity bed_porosity(const pore_space::PoreSpace& bed);
/// Renders an STL file by the program `porepack picture` beside this program or on PATH. False, with log.picture next to the image, when it
/// could not.
bool draw_picture(const core::Path& stl, const core::Path& png, const std::vector<std::string>& more = {});
/// Versions of the engines, for manifests and --version; empty text for a missing one.
[[nodiscard]] core::Json engine_versions();

}  // namespace porepack::stages
