// Where the bed ends inside an image.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "packing/packing.hpp"
#include "pore_space/gray_solid.hpp"

namespace porepack::scans {

/// The solid in each layer of an image, and the size of what it consists of.
struct LayerProfile {
    std::vector<double> solid_fraction;  ///< of what lies in the container
    double grain_size_m = 0.0;           ///< 6 volume / surface: the diameter of a sphere
    double z0_m = 0.0, spacing_m = 1.0;
};
[[nodiscard]] LayerProfile profile_of(const geometry::PhaseImage& image);
[[nodiscard]] LayerProfile profile_of(const pore_space::GraySolid& solid, const vessels::Container& container);

/// The layers from the first to the last with at least half the usual solid. Nothing if no end of the image has more than half a grain's
/// size of emptier layers: then the whole image is bed, as far as the layers tell.
[[nodiscard]] std::optional<packing::Section> bed_of(const LayerProfile& profile);

/// The section of an image that states none: all of it, or where the bed ends inside it, the bed without a grain's size there.
[[nodiscard]] packing::Section default_section(const LayerProfile& profile, const std::string& where);
/// Warns of a given section that reaches beyond the bed.
void warn_beyond_bed(const LayerProfile& profile, const packing::Section& section, const std::string& where);

}  // namespace porepack::scans
