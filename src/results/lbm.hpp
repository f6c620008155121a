// Permeability by lattice Boltzmann: results/lbm/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/interval.hpp"
#include "core/members.hpp"
#include "lbm/grid_result.hpp"
#include "results/permeability.hpp"
#include "results/tensor.hpp"

namespace porepack::results {

/// Half widths of the contributions to the interval of k, in m2; they are added (lbm::IntervalParts).
struct HalfWidthParts {
    double grid = 0.0, iteration = 0.0, mass_balance = 0.0, precision = 0.0;
    core::OptionalKey<double> stretch = {};               ///< of a periodic box that is not a whole number of voxels
    core::OptionalKey<double> threshold = {}, blur = {};  ///< of a gray image
};
template <core::MembersOf<HalfWidthParts> Self, typename Visit>
void visit_members(Self& parts, const Visit& visit) {
    visit("grid", parts.grid);
    visit("iteration", parts.iteration);
    visit("mass_balance", parts.mass_balance);
    visit("precision", parts.precision);
    visit("stretch", parts.stretch);
    visit("threshold", parts.threshold);
    visit("blur", parts.blur);
}

/// Of a run with a tolerance of k.
struct ReachedTolerance {
    double tolerance = 0.0;
    bool tolerance_reached = false;
    std::optional<std::string> stopped_by{};  ///< where it was not reached
};
template <core::MembersOf<ReachedTolerance> Self, typename Visit>
void visit_members(Self& reached, const Visit& visit) {
    visit("tolerance", reached.tolerance);
    visit("tolerance_reached", reached.tolerance_reached);
    visit("stopped_by", reached.stopped_by);
}

struct Lbm {
    static constexpr const char* stage = "lbm";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 10;
    Permeability permeability;
    core::OptionalKey<double> conductance_m3 =
        {};  ///< flow rate times viscosity over pressure drop, along z: k times mean area over length
    std::optional<HalfWidthParts> half_width_parts_m2{};
    core::OptionalKey<double> averaged_image_change = {};  ///< of a gray image: see lbm::LbmResult
    std::string interval_meaning;
    core::OptionalKey<ReachedTolerance> reached = {};
    core::OptionalKey<double> permeability_bed_m2 = {};  ///< of the whole bed with its free ends, where the flow goes through all of it
    double permeability_by_volume_average_m2 = 0.0;
    std::string method;  ///< lattice, collision, walls and precision in words, for the report
    std::string device;  ///< "cpu", or "opencl:0 (its name)"
    core::Axis direction = core::Axis::z;
    std::string driven_by;  ///< "body force", "pressure planes" or "the inlet's flow rate"
    core::Interval section_m;
    double porosity = 0.0;                                  ///< of the section
    std::string ends;                                       ///< "periodic", "in_situ", "planes" or "paper"
    std::array<double, 2> buffers_m{};                      ///< of the bed below and above the section that are computed with it
    core::OptionalKey<double> permeability_planes_m2 = {};  ///< with planes of constant pressure at the section
    bool converged = false;
    double iteration_error = 0.0, iteration_tolerance = 0.0;  ///< relative, of k
    double flow_imbalance = 0.0;                              ///< maximum relative difference of the flow rate between layers
    double hydraulic_tortuosity = 0.0;
    double inertia_coefficient_quasi_steady = 0.0;
    double magic_parameter = 0.0;
    long steps = 0;
    double updates_per_second = 0.0;
    lbm::LbmGridResult fine = {};
    std::vector<lbm::LbmGridResult> grids;  ///< coarse to fine
    std::vector<lbm::SubsectionResult> subsections;
    double peak_memory_bytes = 0.0;
    core::OptionalKey<Tensor> permeability_tensor_m2 = {};
    double expected_memory_bytes = 0.0;
};
template <core::MembersOf<Lbm> Self, typename Visit>
void visit_members(Self& lbm, const Visit& visit) {
    visit("", lbm.permeability);
    visit("conductance_m3", lbm.conductance_m3);
    visit("half_width_parts_m2", lbm.half_width_parts_m2);
    visit("averaged_image_change", lbm.averaged_image_change);
    visit("interval_meaning", lbm.interval_meaning);
    visit("", lbm.reached);
    visit("permeability_bed_m2", lbm.permeability_bed_m2);
    visit("permeability_by_volume_average_m2", lbm.permeability_by_volume_average_m2);
    visit("method", lbm.method);
    visit("device", lbm.device);
    visit("direction", lbm.direction);
    visit("driven_by", lbm.driven_by);
    visit("section_m", lbm.section_m);
    visit("porosity", lbm.porosity);
    visit("ends", lbm.ends);
    visit("buffers_m", lbm.buffers_m);
    visit("permeability_planes_m2", lbm.permeability_planes_m2);
    visit("converged", lbm.converged);
    visit("iteration_error", lbm.iteration_error);
    visit("iteration_tolerance", lbm.iteration_tolerance);
    visit("flow_imbalance", lbm.flow_imbalance);
    visit("hydraulic_tortuosity", lbm.hydraulic_tortuosity);
    visit("inertia_coefficient_quasi_steady", lbm.inertia_coefficient_quasi_steady);
    visit("magic_parameter", lbm.magic_parameter);
    visit("steps", lbm.steps);
    visit("updates_per_second", lbm.updates_per_second);
    visit("fine", lbm.fine);
    visit("grids", lbm.grids);
    visit("subsections", lbm.subsections);
    visit("peak_memory_bytes", lbm.peak_memory_bytes);
    visit("permeability_tensor_m2", lbm.permeability_tensor_m2);
    visit("expected_memory_bytes", lbm.expected_memory_bytes);
}

}  // namespace porepack::results
