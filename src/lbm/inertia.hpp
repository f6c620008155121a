// Flows with inertia: the apparent permeability against the Reynolds number, by the full equilibrium.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "core/communicator.hpp"
#include "lbm/inertial_series.hpp"

namespace porepack::devices {
class Device;
}
namespace porepack::pore_space {
struct PoreSpace;
}

namespace porepack::lbm {

struct InertialCriterion {
    double tolerance = 1e-3;  ///< of the estimated relative iteration error of the apparent permeability; lower it to see
                              ///< differences of less than a per cent between flows
    long max_steps = 100000;  ///< per flow; a flow that is not steady then ends the series
    /// Means in time instead of steady flows, in a cell that is periodic along the flow.
    struct InTime {
        double tolerance = 0.02;     ///< relative half width of the 95 % interval of the mean velocity
        double max_turnovers = 800;  ///< a flow whose mean is not known then ends the series
        /// Two relaxation times, with their accurate walls, up to the first flow for which they are not stable; false: the recursive
        /// collision from the first flow on, to compare them.
        bool accurate_while_stable = true;
    };
    std::optional<InTime> in_time = {};
    std::shared_ptr<devices::Device> device = nullptr;  ///< none: the processor
};

/// Flows along z at increasing Reynolds numbers, each started from the previous one; the first that does not meet the criterion,
/// or that this grid cannot resolve, ends the series. The pressure is constant on the end planes, which should lie in free water beyond
/// the section or its buffers (reservoir_m). Throws NumericalError when not even creeping flow becomes steady. Without buffers, the cut
/// faces of the grains are walls, and the permeability follows from the drag (momentum exchange), because the fluxes of momentum
/// through the two planes differ. Means in time by the recursive collision end before the first Reynolds number at which its walls change k
/// by more than 25 %.
/// All parts call it, each for its slab.
[[nodiscard]] InertialSeries lbm_inertial_flows(const pore_space::PoreSpace& space, double voxel_size_m, std::span<const double> reynolds,
                                                double length_m, const InertialCriterion& criterion,
                                                const core::Communicator& parts = core::ranks());

}  // namespace porepack::lbm
