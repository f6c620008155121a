// Corrections of the pressure during the iteration that leave the steady state as it is.
#pragma once

#include <vector>

#include "lbm/flow.hpp"

namespace porepack::lbm {

/// The pressure along the flow is the slowest mode of a long bed: mass must move from layer to layer until no layer gains any. The
/// mass that the layers gain gives the flow rates that are not steady yet; Darcy's law, with the relative conductance of the layers,
/// gives the pressures that remove them, and they are added to the nodes. In the steady state no layer gains mass, so the steady state
/// is not changed. (In it, the flow rates of the layers differ slightly, because interpolated walls do not conserve mass.) Water before
/// and behind a bed, where Darcy's law does not hold and the pressure hardly falls, is left alone. In a cell without end planes the mean
/// density, which has no effect on the flow but drifts because walls leak, is set back to zero.
class LayerBalance {
public:
    /// `area_cells`: cross-section of the container. `balance` false: only the mean density is corrected.
    LayerBalance(const Domain& domain, const Scheme& scheme, double area_cells, bool balance);

    /// Sets a flow at rest to the pressures that the layers' conductances give.
    void begin(Flow& flow) const;
    /// `steps` after the last call, which left `state`.
    void correct(Flow& flow, const Layers& layers, double permeability_lu, long steps, BalanceState& state) const;

private:
    [[nodiscard]] std::vector<double> pressure_steps(const Layers& layers, const std::vector<double>& unsteady, double share) const;
    [[nodiscard]] std::vector<double> unsteady_flow(const Layers& layers, const std::vector<double>& before, long steps) const;
    void smooth(std::vector<double>& flow) const;

    const Domain& domain_;
    double viscosity_, force_, area_cells_;
    bool closed_, balance_;
    std::size_t first_ = 0, end_ = 0;  // layers of the bed: what is outside is nearly free water
};
}  // namespace porepack::lbm
