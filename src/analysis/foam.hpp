// Permeability by OpenFOAM.
#pragma once

#include "converters/config.hpp"
#include "core/expectation.hpp"
#include "core/files.hpp"
#include "openfoam/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/foam.hpp"

namespace porepack::analysis {

/// The cases and their logs are written into `folder`, from which an interrupted run resumes. Throws UserError for an image, and where the
/// cells do not fit the scene; EngineError.
[[nodiscard]] results::Foam compute_foam_flow(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                              const openfoam::FoamConfig& config, const core::Path& folder,
                                              const geometry::TriangleSurface* made = nullptr);
[[nodiscard]] core::Expectation expect_foam(const pore_space::PoreSpace& space, const openfoam::FoamConfig& config);
/// Of a pore space that need not exist yet.
[[nodiscard]] core::Expectation expect_foam(const pore_space::PoreSpace& space, const openfoam::FoamConfig& config, double cell_size_m,
                                            double porosity);

}  // namespace porepack::analysis
