// Porosity of the bed and of the section, and its voxels.
#pragma once

#include "analysis/outcome.hpp"
#include "converters/config.hpp"
#include "geometry/grid.hpp"
#include "pore_space/pore_space.hpp"
#include "results/geometry.hpp"
#include "results/pack.hpp"

namespace porepack::analysis {

/// Of the whole bed, which is the section of `bed`.
[[nodiscard]] results::BedPorosity bed_porosity(const pore_space::PoreSpace& bed);

struct Voxels {
    Outcome<results::Voxelise> outcome;  ///< with the table porosity.csv: layers of half an equal-volume diameter
    geometry::PhaseImage image;          ///< of the section, with its buffers
};
[[nodiscard]] Voxels voxelise(const pore_space::PoreSpace& space, const converters::GeometryConfig& geometry);

}  // namespace porepack::analysis
