// The cells of an OpenFOAM run and their velocities.
#pragma once

#include <span>
#include <vector>

#include "converters/surface.hpp"
#include "core/choice.hpp"
#include "core/files.hpp"

namespace porepack::openfoam {

struct FoamCell {
    shapes::Vec3 centre_m, velocity;  ///< velocity for viscosity 1 and the case's pressure drop or gradient
    double pressure, volume_m3;       ///< pressure: kinematic
};
/// Runs postProcess to write the cells' centres and volumes at the last time in the case `folder`, reads them and removes them.
/// Velocity and pressure are those of that time, or of the folder `fields`. Throws EngineError when that fails.
[[nodiscard]] std::vector<FoamCell> read_foam_cells(const core::Path& folder, const core::Path& fields = {});

/// Flux-weighted pressure int p u_z dA / int u_z dA on the plane at z: a straight line through the cells within `reach_m` of the plane,
/// fitted with the weights volume times u_z. Throws NumericalError when nothing flows there.
[[nodiscard]] double plane_pressure(std::span<const FoamCell> cells, double z_m, double reach_m);

/// <|u|> / <u_axis> over the cells with their centres in the section, along the axis of the mean velocity. Throws
/// NumericalError when nothing flows.
struct FoamTortuosity {
    core::Axis axis = core::Axis::z;
    double value = 0.0;
};
[[nodiscard]] FoamTortuosity hydraulic_tortuosity(std::span<const FoamCell> cells, const packing::Section& section);

}  // namespace porepack::openfoam
