// Permeability by lattice Boltzmann, with its flow field.
#pragma once

#include "analysis/outcome.hpp"
#include "converters/config.hpp"
#include "core/expectation.hpp"
#include "geometry/grid.hpp"
#include "lbm/config.hpp"
#include "pore_space/pore_space.hpp"
#include "results/lbm.hpp"

namespace porepack::analysis {

struct ComputedFlow {
    Outcome<results::Lbm> outcome;     ///< with the tables history.csv and, of a flow along z, gradient.csv
    geometry::LayeredFlow field = {};  ///< empty where config.fields is none
};
/// Resumes from the file `checkpoint` if it exists, and updates it until the end. Of several ranks, each drops what only the others need
/// of an image, unless there are other copies of the pore space. Throws UserError as lbm_permeability().
[[nodiscard]] ComputedFlow compute_flow(pore_space::PoreSpace space, const converters::GeometryConfig& geometry,
                                        const lbm::LbmConfig& config, const core::Path& checkpoint = {});
[[nodiscard]] core::Expectation expect_flow(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry,
                                            const lbm::LbmConfig& config);
/// Of a pore space that need not exist yet.
[[nodiscard]] core::Expectation expect_flow(const pore_space::PoreSpace& space, const lbm::LbmConfig& config, double voxel_size_m,
                                            double porosity);

/// Of the same flow, or flows with inertia, on so many ranks: memory of all, and in the text that of the one with the largest slab.
/// `config` gives the grids. UserError for more ranks than lbm::max_parts(), and for several ranks with a device.
[[nodiscard]] core::Expectation on_ranks(core::Expectation expected, long ranks, const pore_space::PoreSpace& space, double voxel_size_m,
                                         const lbm::LbmConfig& config);

}  // namespace porepack::analysis
