// Tortuosities. Each has its own name, because they are different quantities (docs/theory.md).
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "converters/slices.hpp"
#include "core/choice.hpp"
#include "core/interval.hpp"
#include "pore_space/pore_space.hpp"
#include "tortuosity/config.hpp"

namespace porepack::tortuosity {

/// The paper's dot method (2.1.3): dots on a square grid, the same on every slice; a dot inside a grain moves to the
/// closest void point of its slice; a path joins its points from slice to slice.
struct GeometricPaperResult {
    double value = 0.0;           ///< mean over the paths of path length / straight length
    double standard_error = 0.0;  ///< of the mean, from the scatter between paths
    double standard_deviation = 0.0;
    long paths = 0;
    long slices = 0;
    double rejections_per_point = 0.0;
    std::vector<std::vector<shapes::Vec3>> paths_m;  ///< the paths
};

/// With exact geometry: the closest void point is found on rays in the slice's plane (exact intervals), minimised over the
/// direction to 1e-7. With `dot_pixel_m` it is the centre of the closest void pixel, as on images of that pixel size.
[[nodiscard]] GeometricPaperResult geometric_paper_exact(const packing::Grains& grains, const vessels::Container& container,
                                                         const packing::Section& section, const TortuosityConfig& config);
/// On images: the centre of the closest void pixel. The result increases with the pixel size.
[[nodiscard]] GeometricPaperResult geometric_paper_on_slices(const converters::SliceStack& slices, const TortuosityConfig& config);

/// <|u|> / <u_axis> over the section's fluid (Duda, Koza & Matyka 2011). Throws NumericalError when nothing flows along the axis.
[[nodiscard]] double hydraulic_tortuosity(const geometry::FlowImage& flow, const packing::Section& section, int axis);

/// Length of the shortest path through the pores from a point of the first end plane to the other plane / the section's length: the mean
/// over starting points evenly distributed on the pores of the first plane, and the minimum. Exactly 1 without grains, never below.
struct ShortestPathResult {
    double value = 0.0;               ///< mean
    double minimum = 0.0;             ///< minimum over all starting points
    double maximum = 0.0;             ///< maximum over all starting points
    double standard_deviation = 0.0;  ///< between starting points
    long starts = 0;
    long blocked_starts = 0;                         ///< starting points without a path to the other plane
    std::vector<std::vector<shapes::Vec3>> paths_m;  ///< about a hundred of the paths, the shortest first
};
/// Through a pore space on voxels of this size, across its periodic sides. Between exact grains the voxels only determine which path round
/// the grains is short; up to `max_starts` evenly chosen paths are then pulled taut around the capsules. Other walls are those of the
/// voxels. Throws DoesNotPercolate when no path crosses the section.
[[nodiscard]] ShortestPathResult shortest_path(const pore_space::PoreSpace& space, double voxel_size_m, core::Axis axis,
                                               long max_starts = 1000);
/// Between voxels treated as cubes: round surfaces become staircases, and the path is somewhat longer.
[[nodiscard]] ShortestPathResult shortest_path(const geometry::PhaseImage& image, int axis, std::array<bool, 3> periodic);
[[nodiscard]] double shortest_path_memory_bytes(double cells);

/// Tortuosity factor eps D0/D_eff: ratio of the diffusivity in straight pores of the same porosity to that along the axis. Never below 1
/// (Wiener 1912). Concentrations are prescribed at the end planes, or the axis is periodic. An inclined duct has 1/cos^2 of its angle.
struct DiffusiveResult {
    double value = 0.0;
    double relative_diffusivity = 0.0;              ///< D_eff/D0, of the whole cross-section
    double porosity = 0.0, porosity_flowing = 0.0;  ///< of the voxels; of the voxels that tracer passes through
    long iterations = 0;
    double residual = 0.0, flux_imbalance = 0.0;
    bool converged = false;             ///< the residual is below the tolerance
    double thin_solid = 0.0;            ///< of the cells at exact walls, the share where the solid is thinner than a cell
    std::vector<double> concentration;  ///< of each voxel: 1 at the first plane, 0 at the last; on a periodic axis minus its mean slope
};
struct DiffusiveOptions {
    double tolerance = 1e-6;    ///< of the residual over the right-hand side, see ConjugateGradientOptions
    long max_iterations = 500;  ///< of the conjugate gradients; then the solver has failed
    double porosity = 0.0;      ///< of the exact solid in the section, if it is known already; 0: computed
    bool one_grid = false;      ///< no coarser grids, and so no limit
};
/// Finite volumes on the pore voxels, conjugate gradients with a multigrid preconditioner. Throws DoesNotPercolate when the pores do not
/// percolate, NumericalError when the tolerance is not reached in `max_iterations`. Nothing passes the links of `cuts`.
[[nodiscard]] DiffusiveResult diffusive_tortuosity(const geometry::PhaseImage& image, int axis, std::array<bool, 3> periodic,
                                                   const DiffusiveOptions& options = {}, const pore_space::LinkCuts& cuts = {});
[[nodiscard]] double diffusive_memory_bytes(double cells);
/// In a pore space on cells of this size. Where the solid is known exactly, the faces of the cells are cut by its walls (cut_cells.hpp):
/// second order. Of an image, as above. With buffers beyond the section, the flux is related to the drop of the mean concentration between
/// the section's planes. The porosity is that of the exact solid.
[[nodiscard]] DiffusiveResult diffusive_on_grid(const pore_space::PoreSpace& space, double voxel_size_m, core::Axis axis,
                                                const DiffusiveOptions& options = {});
/// Grids of three cell sizes, finest first, with exact walls: errors of second order. The limit is that of the finest and the coarsest
/// grid, at least 1. The half width is 0.7 of the correction, at least the change if the middle grid takes the coarsest one's place, and
/// 0.0002 for the porosity.
struct DiffusiveLimit {
    double value = 0.0, half_width = 0.0;
};
[[nodiscard]] DiffusiveLimit diffusive_limit(const std::array<double, 3>& sizes_m, const std::array<double, 3>& values);

struct DiffusiveGrid {
    double voxel_size_m, value;
};
struct DiffusiveEstimate {
    DiffusiveResult finest;
    std::vector<DiffusiveGrid> grids;     ///< finest first
    std::optional<DiffusiveLimit> limit;  ///< of three grids
    std::string no_limit_because;         ///< empty if there is a limit
    [[nodiscard]] double value() const { return limit ? limit->value : std::max(1.0, finest.value); }
    [[nodiscard]] std::optional<core::Interval> interval() const;
};
/// On three grids of 1, 1.5 and 2 times this voxel size, extrapolated; for an image on its own voxels, without a limit. Coarser grids whose
/// pores are closed, and solid thinner than a cell, also give no limit. Ends of the section along z as the pore space has them: planes, or
/// in situ. Throws DoesNotPercolate when the pores of the finest grid do not percolate, NumericalError when the solver fails on any of
/// them.
[[nodiscard]] DiffusiveEstimate diffusive_tortuosity(const pore_space::PoreSpace& space, double voxel_size_m, core::Axis axis,
                                                     const DiffusiveOptions& options = {});

}  // namespace porepack::tortuosity
