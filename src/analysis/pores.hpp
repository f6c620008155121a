// The pore space described: chords, pore sizes, throats, critical diameter, correlation.
#pragma once

#include "analysis/outcome.hpp"
#include "converters/config.hpp"
#include "core/expectation.hpp"
#include "pore_space/pore_space.hpp"
#include "results/pores.hpp"

namespace porepack::analysis {

/// Of the section. Throws UserError where it has no pores at this voxel size.
[[nodiscard]] Outcome<results::Pores> describe_pores(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry);
[[nodiscard]] core::Expectation expect_pores(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry);

}  // namespace porepack::analysis
