// Stokes flow by the lattice Boltzmann method: D3Q19, two relaxation times, linear equilibrium, half-way bounce-back
// (Ginzburg, Verhaeghe & d'Humieres 2008; docs/theory.md). Populations are deviations from rest, in lattice units.
#pragma once

#include <span>

#include "lbm/domain.hpp"

namespace porepack {

struct Relaxation {
    double tau = 1.2;           ///< of the symmetric part: viscosity (tau - 1/2)/3
    double magic = 3.0 / 16.0;  ///< (tau - 1/2)(tau_minus - 1/2)
    [[nodiscard]] double viscosity_lu() const { return (tau - 0.5) / 3.0; }
};

class StokesSolver {
public:
    StokesSolver(const Domain& domain, const Relaxation& relaxation);

    /// One collision and one streaming of all nodes.
    void step();
    /// Of each layer of cells across the drive's axis: velocity along it summed, density deviation averaged; lattice units.
    struct Layers {
        std::vector<double> flow, density;
    };
    [[nodiscard]] Layers layers() const;
    /// Density deviation and velocity of one node.
    struct Moments {
        double density;
        std::array<double, 3> velocity;
    };
    [[nodiscard]] Moments moments(std::size_t node) const;
    /// Body force a node; 0 when pressure drives.
    [[nodiscard]] double force_lu() const { return force_[static_cast<std::size_t>(domain_.drive.axis)]; }
    [[nodiscard]] double bytes_per_node() const;

private:
    void gather(std::size_t node, std::array<double, 19>& f) const;
    void fill_open_links();

    const Domain& domain_;
    Relaxation relaxation_;
    std::array<double, 3> force_ = {0.0, 0.0, 0.0};
    std::vector<double> now_, next_;  ///< after collision; population-major, then the slots of the open links
};

/// One check of the run's state, the history of the convergence plot.
struct ConvergencePoint {
    long step;
    double permeability_lu;
    double iteration_error;  ///< relative, extrapolated from the last three checks
    double flow_imbalance;   ///< largest relative difference of the flow rate between layers
};

struct StokesRun {
    double permeability_lu = 0.0;         ///< by the flow rate through the end planes, for the area of `area_cells`
    double permeability_volume_lu = 0.0;  ///< by the volume average between the planes
    double superficial_velocity_lu = 0.0;
    double gradient_lu = 0.0;           ///< driving gradient of pressure over the section
    double hydraulic_tortuosity = 0.0;  ///< sum |u| / sum u_axis over the section's fluid
    double iteration_error = 0.0;
    double flow_imbalance = 0.0;
    bool converged = false;
    long steps = 0;
    double seconds = 0.0;
    double updates_per_second = 0.0;
    std::vector<ConvergencePoint> history;
};

struct StokesGate {
    double tolerance = 1e-4;
    long max_steps = 200000;
};

/// The cross-section that the flow rate is divided by, and the layers between the planes of the section.
struct FlowSection {
    double area_cells = 0.0;
    int first_layer = 0;
    int last_layer = 0;  ///< inclusive
};

/// Steps until the gate is passed. Throws NumericalError on divergence (named, with the step).
/// When the gate is not passed, `converged` is false and the numbers must not be used.
[[nodiscard]] StokesRun run_to_steady(StokesSolver& solver, const Domain& domain, const Relaxation& relaxation, const FlowSection& section,
                                      const StokesGate& gate);

}  // namespace porepack
