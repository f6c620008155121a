// Steady flows with inertia: the apparent permeability against the Reynolds number, by the full equilibrium.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "lbm/permeability.hpp"

namespace porepack {

/// A steady flow at Re = U length / nu, U being the superficial velocity.
struct InertialFlow {
    double reynolds = 0.0;
    double permeability_m2 = 0.0;  ///< apparent: nu U / (drag of grains and walls / volume of the section)
    double momentum_share = 0.0;   ///< of the pressure drop, what the water gains in momentum between the end planes
    double iteration_error = 0.0;
    bool converged = false;
    double relaxation_time = 0.0;
    double fastest_lu = 0.0;  ///< largest velocity on a node; errors of compressibility grow with its square
    long steps = 0;
    double seconds = 0.0;
};

struct InertialSeries {
    double voxel_size_m = 0.0;
    std::size_t nodes = 0;
    double creeping_permeability_m2 = 0.0;
    double peak_over_mean = 0.0;      ///< largest velocity / superficial velocity, creeping
    std::vector<InertialFlow> flows;  ///< rising
    std::string stopped_by;           ///< why the next flow has no number; empty when all were found
};

struct InertialGate {
    double tolerance = 1e-3;  ///< of the apparent permeability, relative
    long max_steps = 100000;
};

/// Flows along z at rising Reynolds numbers, each started from the one before; the first that finds no steady state within the gate,
/// or that this grid cannot carry, ends the series. The pressure is constant on the end planes; the drag is found by momentum exchange, for
/// planes that cut through grains differ in what momentum crosses them. Throws NumericalError when not even creeping flow becomes steady.
/// The image may reach beyond the section on both sides, free water being there (a cut plane is a wall).
[[nodiscard]] InertialSeries lbm_inertial_flows(const LbmScene& scene, double voxel_size_m, std::span<const double> reynolds,
                                                double length_m, const InertialGate& gate);

}  // namespace porepack
