// The stages of a case, one source file each: what they do on a pore space (for loose files too), and how they stand in a case.
// Each function writes its files into `folder` and returns the result as JSON (docs/files.md).
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "converters/pore_space.hpp"
#include "converters/surface.hpp"
#include "pipeline/stage.hpp"
#include "stages/case.hpp"
#include "stages/inputs.hpp"

namespace porepack {

struct Expectation;

// ---- on a shape, a pore space, or measured curves

[[nodiscard]] Json measure_shape(const ShapeConfig& config, double density_kg_per_m3);
/// Of a closed STL surface.
[[nodiscard]] Json measure_surface_shape(const Path& stl, double unit_m, double density_kg_per_m3);
/// solid.stl of grains or of a user's surface, and what `extras` asks for.
[[nodiscard]] Json write_surfaces(const PoreSpace& space, const GeometryConfig& geometry, const StlConfig& extras, const Path& folder);
[[nodiscard]] Json write_voxels(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder);
[[nodiscard]] Json write_slice_images(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder);
/// Resumes from the file `checkpoint` where it is there, and keeps one in it until the end.
[[nodiscard]] Json run_lbm(const PoreSpace& space, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder,
                           const Path& checkpoint = {});
[[nodiscard]] Expectation expect_lbm(const PoreSpace& space, const GeometryConfig& geometry, const LbmConfig& config);
[[nodiscard]] Json run_foam(const PoreSpace& space, const GeometryConfig& geometry, const FoamConfig& config, const Path& folder);
[[nodiscard]] Expectation expect_foam(const PoreSpace& space, const FoamConfig& config);
/// Permeability against the Reynolds number by both solvers, of the section between two depths of free water.
[[nodiscard]] Json run_forchheimer(const PoreSpace& space, const GeometryConfig& geometry, const ForchheimerConfig& config,
                                   const Path& folder);
[[nodiscard]] Expectation expect_forchheimer(const PoreSpace& space, const ForchheimerConfig& config);

enum class TortuosityKind { geometric_paper, shortest_path, hydraulic, diffusive };
constexpr std::array<Choice<TortuosityKind>, 4> choices_of(TortuosityKind) {
    return {{{TortuosityKind::geometric_paper, "geometric_paper"},
             {TortuosityKind::shortest_path, "shortest_path"},
             {TortuosityKind::hydraulic, "hydraulic"},
             {TortuosityKind::diffusive, "diffusive"}}};
}
/// Any kind but the hydraulic one, which belongs to a flow.
[[nodiscard]] Json run_tortuosity(TortuosityKind kind, const PoreSpace& space, const GeometryConfig& geometry,
                                  const TortuosityConfig& config, const Path& folder);
[[nodiscard]] Expectation expect_tortuosity(TortuosityKind kind, double cells);
/// The paper's dot method on the images of a folder of slices.
[[nodiscard]] Json geometric_paper_of_slices(const Path& slices, const TortuosityConfig& config, const Path& folder);
/// Of flow.vti, or of an OpenFOAM case that has run.
[[nodiscard]] Json hydraulic_tortuosity_of(const Path& flow, const std::vector<double>& section_m);

/// A simulated test: times by Eq. 18 and by the full equation, and falling_head.csv in `folder` if there is one.
[[nodiscard]] Json simulate_falling_head(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                                         const Path* folder);
/// Measured curves evaluated as in the paper and by least squares; analysis.csv and analysis.svg.
[[nodiscard]] Json analyse_falling_head(const std::vector<Path>& curves, const FallingHeadConfig& config, const Path& folder);
/// [falling_head] of a case, with the inertia coefficient of its sample where that is known.
[[nodiscard]] FallingHeadConfig apparatus_of(const Case& c);

// ---- of a case

[[nodiscard]] Stage make_shape_stage(const Case& c);
[[nodiscard]] Stage make_pack_stage(const Case& c);
[[nodiscard]] Stage make_stl_stage(const Case& c);
[[nodiscard]] Stage make_voxelise_stage(const Case& c);
[[nodiscard]] Stage make_slices_stage(const Case& c);
[[nodiscard]] Stage make_lbm_stage(const Case& c);
[[nodiscard]] Stage make_foam_stage(const Case& c);
[[nodiscard]] Stage make_tortuosity_stage(const Case& c);
[[nodiscard]] Stage make_forchheimer_stage(const Case& c);
[[nodiscard]] Stage make_falling_head_stage(const Case& c);
[[nodiscard]] Stage make_causes_stage(const Case& c);
/// It shows the results of the stages `shown`, in their order, as far as they are there; it needs those in `needs`.
[[nodiscard]] Stage make_report_stage(const Case& c, const std::vector<std::string>& needs, const std::vector<std::string>& shown);

/// All stages that a case asks for, in order. `studies` (src/study) come before the report, which shows them.
[[nodiscard]] std::vector<Stage> case_stages(const Case& c, std::vector<Stage> studies = {});

// ---- what the stages of a case share

/// What the geometry and flow stages work on. With `with_surface` the surface of the stl stage comes along.
[[nodiscard]] PoreSpace case_pore_space(const Case& c, bool with_surface = false);
/// The same before there is a packing: the container and the section that are expected, for dry runs. Its porosity is
/// expected_porosity().
[[nodiscard]] PoreSpace expected_pore_space(const Case& c);
[[nodiscard]] double expected_porosity(const Case& c);
/// The stage that makes the solid: "pack", or "stl" of a user's surface.
[[nodiscard]] std::string solid_stage(const Case& c);
/// Whole tables, and of [geometry] only the keys that decide a stage's result: slices do not become stale when the voxel size changes.
[[nodiscard]] Json deciding_keys(const Case& c, const std::vector<std::string>& tables, std::set<std::string> geometry_keys,
                                 bool with_section);
[[nodiscard]] SurfaceOptions surface_options(const GeometryConfig& geometry);
void add_bed_porosity(Json& json, const PoreSpace& bed);
/// Renders an STL file by the program `porepack picture` beside this program or on PATH. False, with log.picture beside the image, when it
/// could not.
bool draw_picture(const Path& stl, const Path& png, const std::vector<std::string>& more = {});
/// Versions of the engines, for manifests and --version; empty text for one that is missing.
[[nodiscard]] Json engine_versions();

}  // namespace porepack
