// The pore space described: chords, pore sizes, throats, critical diameter, two-point correlation.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "geometry/grid.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"

namespace porepack::pores {

/// Lengths of straight lines in the pores between two walls. Chords that a plane of the section cuts are left out.
struct Chords {
    std::vector<double> lengths_m;  ///< ascending
    double mean_m = 0.0;
    double deviation_m = 0.0;  ///< equal to the mean where lengths are exponentially distributed, as between overlapping spheres
};
/// On all rows of voxels along an axis.
[[nodiscard]] Chords chords_of_voxels(const geometry::PhaseImage& image, int axis, bool periodic);
/// On about `lines` vertical lines, exact. A container that is periodic along z is taken as a whole, and nothing is cut.
[[nodiscard]] Chords vertical_chords(const geometry::Solid& solid, const vessels::Container& container, const packing::Section& section,
                                     long lines = 40000);

/// Distance from the centre of each pore voxel to the nearest wall, which lies half a voxel before the centre of the nearest other voxel; 0
/// in other voxels. By parabolas along the axes (Felzenszwalb & Huttenlocher 2012). Beyond open sides there are no walls.
[[nodiscard]] std::vector<float> wall_distance_m(const geometry::PhaseImage& image, const std::array<bool, 3>& periodic);

/// The same from exact grains and the container's exact walls.
[[nodiscard]] std::vector<float> wall_distance_m(const geometry::PhaseImage& image, const packing::Grains& grains,
                                                 const vessels::Container& container);

/// Diameter of the largest sphere in the pores that contains the voxel's centre (Hildebrand & Ruegsegger 1997); 0 outside the pores.
[[nodiscard]] std::vector<float> pore_diameter_m(const geometry::PhaseImage& image, const std::vector<float>& distance_m,
                                                 const std::array<bool, 3>& periodic);

/// Diameter of the largest sphere that passes from the first to the last layer along `axis`, over faces of voxels; nothing where no path
/// leads through. With distances from voxels it is up to two voxels too small.
[[nodiscard]] std::optional<double> critical_diameter_m(const geometry::PhaseImage& image, const std::vector<float>& distance_m, int axis);

/// Pores and the throats between them: basins of the distance to the walls (watershed). Two basins are one pore where the place between
/// them is at least 0.9 as wide as the narrower one.
struct PoreNetwork {
    struct Pore {
        double diameter_m;  ///< of the largest sphere in it
        std::array<double, 3> centre_m;
        double volume_m3 = 0.0;
        bool cut = false;  ///< reaches an end of the section: parts of it and of its throats can be missing
    };
    struct Throat {
        std::size_t first, second;  ///< places in `pores`
        double diameter_m;          ///< of the largest sphere that passes; where there are several paths, of the widest
    };
    std::vector<Pore> pores;
    std::vector<Throat> throats;
};
[[nodiscard]] PoreNetwork pore_network(const geometry::PhaseImage& image, const std::vector<float>& distance_m,
                                       const std::array<bool, 3>& periodic);

/// Permeability by the relation of Katz & Thompson (1986), critical diameter squared times the relative diffusivity, over a constant: 32 in
/// equal tubes, 12 in equal slits, and 226 in their theory of widely distributed pore sizes, which is about ten times too low between
/// grains. Here it is the geometric mean of tubes and slits, 19.6.
[[nodiscard]] double katz_thompson_m2(double critical_diameter_m, double relative_diffusivity);

/// Probability that both ends of a segment of length r lie in pores, of those with both ends in the container.
struct Correlation {
    std::vector<double> distance_m;                  ///< whole voxels, from 0
    std::array<std::vector<double>, 3> probability;  ///< along x, y, z
    std::array<std::vector<double>, 3> differing;    ///< probability that one end lies in a pore and the other one does not
    [[nodiscard]] double porosity() const { return (probability[0][0] + probability[1][0] + probability[2][0]) / 3.0; }
    /// Surface per volume from the slope at 0 by the first two distances; mean of the axes, for surfaces of any direction.
    [[nodiscard]] double surface_per_volume_m() const;
};
[[nodiscard]] Correlation correlate(const geometry::PhaseImage& image, const std::array<bool, 3>& periodic, double farthest_m);

}  // namespace porepack::pores
