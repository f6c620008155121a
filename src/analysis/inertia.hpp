// Flows with inertia by both solvers, and the resulting inertial permeability.
#pragma once

#include "analysis/outcome.hpp"
#include "converters/config.hpp"
#include "core/expectation.hpp"
#include "permeability/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/forchheimer.hpp"

namespace porepack::analysis {

/// Permeability against the Reynolds number, of the section between two layers of free water. Grids that are done, and OpenFOAM's case, are
/// kept in `folder`, from which an interrupted run resumes. Throws UserError for an image, and for keys without effect.
[[nodiscard]] Outcome<results::Forchheimer> compute_inertial_flows(const pore_space::PoreSpace& space,
                                                                   const converters::GeometryConfig& geometry,
                                                                   const permeability::ForchheimerConfig& config, const core::Path& folder);
/// Its grids by lattice Boltzmann alone, which it then finds in `folder`. All ranks call it.
void solve_lattice_grids(const pore_space::PoreSpace& space, const permeability::ForchheimerConfig& config, const core::Path& folder);
[[nodiscard]] core::Expectation expect_inertia(const pore_space::PoreSpace& space, const permeability::ForchheimerConfig& config);

}  // namespace porepack::analysis
