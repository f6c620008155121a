// The pore space described: `porepack pores`.
#pragma once

#include <optional>
#include <string>

#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

/// Between two walls; those that the section cuts do not count.
struct ChordLengths {
    std::size_t chords = 0;
    double mean_m = 0.0;
    double standard_deviation_m = 0.0;
    std::string from;  ///< "exact" or "voxels"
};
template <core::MembersOf<ChordLengths> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("chords", found.chords);
    visit("mean_m", found.mean_m);
    visit("standard_deviation_m", found.standard_deviation_m);
    visit("from", found.from);
}

/// Basins of the distance to the walls, and the widest path between two of them.
struct NetworkOfPores {
    std::size_t pores = 0;
    std::size_t whole_pores = 0;  ///< not cut by the section
    std::size_t throats = 0;
    std::optional<double> throats_per_whole_pore{};
    std::optional<double> throat_diameter_10_percent_m{};
    std::optional<double> throat_diameter_median_m{};
    std::optional<double> throat_diameter_90_percent_m{};
    std::optional<double> body_diameter_median_m{};
};
template <core::MembersOf<NetworkOfPores> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("pores", found.pores);
    visit("whole_pores", found.whole_pores);
    visit("throats", found.throats);
    visit("throats_per_whole_pore", found.throats_per_whole_pore);
    visit("throat_diameter_10_percent_m", found.throat_diameter_10_percent_m);
    visit("throat_diameter_median_m", found.throat_diameter_median_m);
    visit("throat_diameter_90_percent_m", found.throat_diameter_90_percent_m);
    visit("body_diameter_median_m", found.body_diameter_median_m);
}

struct Pores {
    double voxel_size_m = 0.0;
    core::Interval section_m;
    double porosity_of_voxels = 0.0;
    core::ByName<ChordLengths> chords;    ///< by axis
    double pore_diameter_median_m = 0.0;  ///< by volume, of the largest sphere in the pores that covers a point
    double pore_diameter_10_percent_m = 0.0;
    double pore_diameter_90_percent_m = 0.0;
    NetworkOfPores network = {};
    core::ByName<std::optional<double>> critical_diameter_m;  ///< by axis, of the largest sphere that passes through
    double critical_diameter_uncertainty_m = 0.0;
    std::optional<double> relative_diffusivity{};           ///< D_eff/D0 along z, where z percolates
    std::optional<double> permeability_katz_thompson_m2{};  ///< an estimate within a factor of 2.5
    double surface_per_volume_per_m = 0.0;
    std::optional<double> porosity_scatter_of_such_sections{};  ///< standard deviation
    std::optional<core::Interval> porosity_scatter_interval{};  ///< of 95 %
    std::string meaning =
        "chords: between two walls, without those that the section cuts; pore diameters: by volume, of the largest sphere in the pores "
        "that covers a point; network: basins of the distance to the walls and the widest path between two of them; critical diameter: of "
        "the largest sphere that passes through; Katz & Thompson with a constant between tubes and slits: an estimate within a factor of "
        "2.5; scatter: standard deviation of the porosity of other sections of this length, from the layers of this one, and its interval "
        "of 95 %";
};
template <core::MembersOf<Pores> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("voxel_size_m", found.voxel_size_m);
    visit("section_m", found.section_m);
    visit("porosity_of_voxels", found.porosity_of_voxels);
    visit("chords", found.chords);
    visit("pore_diameter_median_m", found.pore_diameter_median_m);
    visit("pore_diameter_10_percent_m", found.pore_diameter_10_percent_m);
    visit("pore_diameter_90_percent_m", found.pore_diameter_90_percent_m);
    visit("network", found.network);
    visit("critical_diameter_m", found.critical_diameter_m);
    visit("critical_diameter_uncertainty_m", found.critical_diameter_uncertainty_m);
    visit("relative_diffusivity", found.relative_diffusivity);
    visit("permeability_katz_thompson_m2", found.permeability_katz_thompson_m2);
    visit("surface_per_volume_per_m", found.surface_per_volume_per_m);
    visit("porosity_scatter_of_such_sections", found.porosity_scatter_of_such_sections);
    visit("porosity_scatter_interval", found.porosity_scatter_interval);
    visit("meaning", found.meaning);
}

}  // namespace porepack::results
