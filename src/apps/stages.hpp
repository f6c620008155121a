// The stages as functions: inputs and settings in, files into `folder`, the result as JSON (docs/files.md).
#pragma once

#include <optional>

#include "apps/case.hpp"
#include "apps/scene.hpp"
#include "openfoam/foam.hpp"

namespace porepack {

[[nodiscard]] Json shape_stage(const ShapeConfig& config, double density_kg_per_m3);
[[nodiscard]] Json surface_shape_stage(const Path& stl, double unit_m, double density_kg_per_m3);
[[nodiscard]] Json pack_stage(const Case& the_case, const Path& folder);
[[nodiscard]] Json stl_stage(const Scene& scene, const GeometryConfig& geometry, const StlConfig& extras, const Path& folder);
[[nodiscard]] Json voxelise_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder);
[[nodiscard]] Json slices_stage(const Scene& scene, const GeometryConfig& geometry, const Path& folder);
/// Goes on from the file `checkpoint` if it is there, and keeps one in it until the end.
[[nodiscard]] Json lbm_stage(const Scene& scene, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder,
                             const Path& checkpoint);
[[nodiscard]] Json lbm_image_stage(const Path& pore_vti, const std::optional<Container>& container, const std::vector<double>& section_m,
                                   const LbmConfig& config, const Path& folder);
[[nodiscard]] Json foam_stage(const Scene& scene, const GeometryConfig& geometry, const FoamConfig& config, const Path& folder);
/// What OpenFOAM meshes; `scene` must outlive it.
[[nodiscard]] FoamScene foam_scene(const Scene& scene, const GeometryConfig& geometry, double coarsest_cell_m);
/// Permeability against the Reynolds number by both solvers, and what follows from it of the section between
/// two depths of free water.
[[nodiscard]] Json forchheimer_stage(const Scene& scene, const GeometryConfig& geometry, const ForchheimerConfig& config,
                                     const Path& folder);
[[nodiscard]] Json geometric_paper_stage(const Scene& scene, const TortuosityConfig& config, const Path& folder);
[[nodiscard]] Json geometric_paper_slices_stage(const Path& slices, const TortuosityConfig& config, const Path& folder);
/// Of flow.vti, or of an OpenFOAM case that has run.
[[nodiscard]] Json hydraulic_stage(const Path& flow_vti, const std::vector<double>& section_m);
[[nodiscard]] Json shortest_path_stage(const Scene& scene, const GeometryConfig& geometry, const TortuosityConfig& config,
                                       const Path& folder);
/// Of pore.vti or a folder of slices.
[[nodiscard]] Json shortest_path_image_stage(const Path& input, const std::optional<Container>& container,
                                             const std::vector<double>& section_m, const TortuosityConfig& config, const Path& folder);
/// On three grids, extrapolated with an interval.
[[nodiscard]] Json diffusive_stage(const Scene& scene, const GeometryConfig& geometry, const TortuosityConfig& config);
/// On the image as it is, without an interval.
[[nodiscard]] Json diffusive_image_stage(const Path& input, const std::optional<Container>& container, const std::vector<double>& section_m,
                                         const TortuosityConfig& config);
/// A simulated test: times by Eq. 18 and by the full equation, and falling_head.csv in `folder` if there is one.
[[nodiscard]] Json falling_head_stage(double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                                      const Path* folder);
/// [falling_head] of a case, with the sample's inertia from its porosity where that is known.
[[nodiscard]] FallingHeadConfig apparatus_of_case(const Case& the_case);
/// Measured curves evaluated as in the paper and by least squares; analysis.csv and analysis.svg.
[[nodiscard]] Json analyse_stage(const std::vector<Path>& curves, const FallingHeadConfig& config, const Path& folder);
/// How much each cause changes the k of the paper's evaluation, for the sample that lies at the bottom of this packing; causes.csv and
/// figures.
[[nodiscard]] Json causes_stage(const Scene& scene, double permeability_m2, double inertial_permeability_m, const FallingHeadConfig& config,
                                const Path& folder);

/// Renders an STL file by this program's own command `picture`. False when it could not.
bool draw_picture(const Path& stl, const Path& png, const std::vector<std::string>& more = {});

/// What a stage will take on this scene.
struct Expectation {
    std::string text = {};
    double memory_bytes = 0.0;
    double wall_time_s = 0.0;
};
[[nodiscard]] Expectation expect_lbm(const Container& container, const Section& section, double voxel_size_m, double grain_size_m,
                                     double porosity, const GeometryConfig& geometry, const LbmConfig& config);
[[nodiscard]] Expectation expect_foam(const Container& container, const Section& section, double cell_size_m, double porosity,
                                      const FoamConfig& config);

[[nodiscard]] Expectation expect_forchheimer(const Scene& scene, const ForchheimerConfig& config);
[[nodiscard]] Expectation expect_tortuosity(const std::string& kind, double cells);

[[nodiscard]] std::string expect_text(const Expectation& expected);

/// Where the templates and cases lie: POREPACK_HOME, else beside the sources this program was built from.
[[nodiscard]] Path home_folder();

}  // namespace porepack
