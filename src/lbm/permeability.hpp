// Permeability of a pore space by lattice Boltzmann, in SI units, on a sequence of grids from coarse to fine.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include "converters/voxels.hpp"
#include "lbm/config.hpp"
#include "lbm/solver.hpp"

namespace porepack {

struct LbmGridResult {
    double voxel_size_m = 0.0;
    std::array<int, 3> cells = {0, 0, 0};
    std::size_t nodes = 0;
    std::int64_t isolated_cells = 0;
    std::size_t wall_links = 0;
    double narrow_share = 0.0;  ///< of the wall links, those in a gap of one node
    double bytes_per_node = 0.0;
    double set_up_seconds = 0.0;
    double relaxation_time = 0.0;
    double permeability_m2 = 0.0;         ///< by flow rate
    double permeability_volume_m2 = 0.0;  ///< by volume average; the difference checks the mass balance
    bool by_pressure = false;             ///< between end planes, else periodic and driven by a body force
    StokesRun run = {};                   ///< of a grid that a checkpoint had finished, without layers and history
};
[[nodiscard]] Json to_json(const LbmGridResult& grid);
[[nodiscard]] LbmGridResult grid_from_json(const Json& json);

/// Half widths of the parts of k's interval; they are added.
struct IntervalParts {
    double grid_m2 = 0.0;       ///< what finer grids would change
    double iteration_m2 = 0.0;  ///< what more steps would change
    double ends_m2 = 0.0;       ///< half the difference between k by the end planes' flow rate and by volume average
    double precision_m2 = 0.0;  ///< rounding
    [[nodiscard]] double sum() const { return grid_m2 + iteration_m2 + ends_m2 + precision_m2; }
};

/// A part of the section along z.
struct SubsectionResult {
    double z0_m, z1_m, permeability_m2;
};

struct LbmResult {
    double permeability_m2 = 0.0;             ///< extrapolated if there are three grids, else the finest one's
    std::vector<LbmGridResult> grids;         ///< coarse to fine
    std::optional<IntervalParts> half_width;  ///< of the interval; needs three grids (bounce-back: two)
    std::string stopped_by;                   ///< what kept a tolerance from being reached; empty when nothing did
    std::vector<SubsectionResult> subsections;
    FlowImage flow;  ///< empty unless asked for
    [[nodiscard]] const LbmGridResult& fine() const { return grids.back(); }
    [[nodiscard]] std::optional<Interval> interval_m2() const;
};

/// What is solved. The pore space comes as an image at about the voxel size given; `solid`, if there is one, gives the exact
/// distances of its walls, else walls lie half-way between nodes. `section` lies in the image.
struct LbmScene {
    std::function<PhaseImage(double voxel_size_m)> voxels;
    const Solid* solid = nullptr;
    Container container;
    Section section;
    double grain_size_m = std::numeric_limits<double>::infinity();  ///< diameter of the thinnest part of a grain, if it is known
    Path checkpoint = {};                                           ///< file to go on from and to keep; none when empty
};

[[nodiscard]] Scheme scheme_of(const LbmConfig& config, bool exact_walls, const Drive& drive);

/// k with its interval from the values on three grids of `nodes` per grain diameter. Calibrated on arrays and ducts whose answer is known
/// (`porepack benchmark coverage`): k goes half of the way to Richardson's value of order 2 over the three grids (coarse grids have
/// higher orders too, of either sign); the half width is 0.8 times the larger of the two Richardson estimates of order 1.5, plus
/// 0.3 nodes^-1.5 of k, which keeps a chance agreement of coarse grids from passing for accuracy.
struct Extrapolation {
    double value, half_width;
};
[[nodiscard]] Extrapolation extrapolate(std::span<const double> nodes, std::span<const double> values);

/// Solves on config.grids grids, the finest of them with `voxel_size_m`, each started from the one before; with config.tolerance
/// from 6 nodes a grain diameter on until the interval is narrow enough, or memory or time forbids. Throws NumericalError when
/// the pore space does not percolate or a gate is not passed: no k then.
[[nodiscard]] LbmResult lbm_permeability(const LbmScene& scene, double voxel_size_m, const LbmConfig& config, bool with_flow);

/// The whole tensor of a box that is periodic in x, y and z: column j is the flow that a gradient along j drives. Each by
/// lbm_permeability; `runs` holds the three results.
struct TensorResult {
    std::array<LbmResult, 3> runs;
    std::array<std::array<double, 3>, 3> permeability_m2;
};
[[nodiscard]] TensorResult lbm_tensor(const LbmScene& scene, double voxel_size_m, const LbmConfig& config);

}  // namespace porepack
