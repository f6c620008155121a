// Permeability of a pore space by lattice Boltzmann, in SI units, on a sequence of grids from coarse to fine.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/communicator.hpp"
#include "core/files.hpp"
#include "core/interval.hpp"
#include "lbm/config.hpp"
#include "lbm/grid_result.hpp"
#include "lbm/slabs.hpp"
#include "lbm/solver.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::devices {
class Device;
}

namespace porepack::lbm {

/// Half widths of the contributions to the interval of k; they are added.
struct IntervalParts {
    double grid_m2 = 0.0;          ///< estimated change on finer grids
    double iteration_m2 = 0.0;     ///< estimated change with more steps
    double mass_balance_m2 = 0.0;  ///< half the difference between k by the end planes' flow rate and by volume average
    double precision_m2 = 0.0;     ///< rounding
    double stretch_m2 = 0.0;       ///< of a periodic box, to whole numbers of voxels
    double threshold_m2 = 0.0;     ///< of a gray image: uncertainty of its gray levels
    double blur_m2 = 0.0;          ///< of a gray image: by how much k may be too large; it widens the interval downwards only
    [[nodiscard]] double sum() const {
        return grid_m2 + iteration_m2 + mass_balance_m2 + precision_m2 + stretch_m2 + threshold_m2 + blur_m2;
    }
};
/// A layer of voxels of the finest grid: its pressure gradient over that of the section, which is its resistance over the mean resistance.
struct LayerGradient {
    double z0_m, z1_m, relative_gradient;
};

struct LbmResult {
    double permeability_m2 = 0.0;                      ///< extrapolated if there are three grids, else the finest one's
    std::vector<LbmGridResult> grids;                  ///< coarse to fine
    std::optional<IntervalParts> half_width;           ///< of the interval; needs three grids (bounce-back: two)
    std::optional<double> averaged_image_change = {};  ///< of a gray image: change of k, relative, with means of 2 x 2 x 2 of its voxels
    std::string stopped_by;                            ///< why a tolerance was not reached; empty if it was
    std::vector<SubsectionResult> subsections;
    std::vector<LayerGradient> gradients;  ///< of the section's layers, for a flow along z
    geometry::LayeredFlow flow;            ///< empty unless requested
    std::string device = "cpu";            ///< or "opencl:0 (its name)"
    [[nodiscard]] const LbmGridResult& fine() const { return grids.back(); }
    /// Of the whole bed, corrected by the same factor as that of the section; nothing if the flow does not go through all of it.
    [[nodiscard]] std::optional<double> bed_permeability_m2() const;
    [[nodiscard]] std::optional<core::Interval> interval_m2() const;
};

/// Options of a run besides solving.
struct LbmRun {
    bool with_flow = false;      ///< keep the flow field of the finest grid, unless the configuration disables it
    core::Path checkpoint = {};  ///< file to resume from and to update during the run; none if empty
    /// Each part computes a slab of the grids, and all have the result: its k and steps do not depend on their number. What some parts
    /// have saved, another number of them can resume from.
    const core::Communicator* parts = &core::ranks();
    /// Where the pore space holds what this part needs (space_of_part): the cuts with which it was made.
    std::optional<SlabCuts> cuts = {};
    /// That of config.device if there is none here; of config.device "cpu", the processor.
    std::shared_ptr<devices::Device> device = nullptr;
};

/// Driven by a body force along `drive`.
[[nodiscard]] Scheme scheme_of(const LbmConfig& config, bool exact_walls, const pore_space::Drive& drive);

/// From the values on three grids of `nodes` nodes per grain diameter: k is half of the way from the finest grid to the Richardson value of
/// order 2 over the three grids (coarse grids have higher orders as well, of either sign).
struct Extrapolation {
    double value;
    double change;  ///< the larger of the two Richardson estimates of order 1.5 of what finer grids change
};
[[nodiscard]] Extrapolation extrapolate(std::span<const double> nodes, std::span<const double> values);

/// Half width of the interval of an extrapolated k. Of one grain: of_change times the change, plus floor nodes^-1.5 of k, so that a chance
/// agreement of coarse grids is not taken for accuracy. Of many grains: of_change_many times the change, at least floor_many / nodes of k;
/// the rest depends on where the grid cuts the grains, and averages out as 1 / sqrt(grains). `grains` is the volume of the solid over the
/// cube of the grain diameter; 1 where that is unknown, and with walls from gray values. Regular arrays of several cells, and rods along an
/// axis, average less than this number says. Calibrated on arrays and ducts of known answer and on 40 random packings, judged on others
/// (`porepack_benchmark coverage`).
struct GridErrorConstants {
    double of_change = 0.8, floor = 0.3, of_change_many = 0.45, floor_many = 0.04;
};
[[nodiscard]] double grid_half_width(const Extrapolation& found, double nodes, double grains, const GridErrorConstants& constants = {});

/// Volume of the solid on this grid over the cube of the grain diameter; 1 where that is unknown, and with walls from gray values.
[[nodiscard]] double grains_of(const pore_space::PoreSpace& space, const LbmGridResult& grid);

/// Solves on config.grids grids, the finest with `voxel_size_m`, each started from the previous one. With config.tolerance, grids are
/// refined until the interval is narrow enough or a memory or time limit is reached; the first has 6 nodes per grain diameter (2 to 6
/// with a time limit; more if no path leads through that grid). NumericalError when
/// the pore space does not percolate or a run does not become steady (no k). The walls are at their exact distances where the pore
/// space provides them, else half-way between nodes; an image has one grid, its own. UserError for a tolerance that cannot be reached.
[[nodiscard]] LbmResult lbm_permeability(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config,
                                         const LbmRun& run = {});

/// Number of parts into which all grids of lbm_permeability() can be cut.
[[nodiscard]] long max_parts(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config);
/// The largest slab of the finest grid with the layers that it shares, over the whole grid: its voxels or, if more, its nodes. Of a pore
/// space without a solid yet, equal slabs. All of `counted_by` call it.
[[nodiscard]] double largest_slab(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config, long parts,
                                  const core::Communicator& counted_by = core::no_communicator());

/// The whole tensor of a box that is periodic in x, y and z: column j is the flow that a gradient along j drives. Each by
/// lbm_permeability; `runs` holds the three results.
struct TensorResult {
    std::array<LbmResult, 3> runs;
    std::array<std::array<double, 3>, 3> permeability_m2;
};
[[nodiscard]] TensorResult lbm_tensor(const pore_space::PoreSpace& space, double voxel_size_m, const LbmConfig& config,
                                      const LbmRun& run = {});

}  // namespace porepack::lbm
