// Grains of a scan by their labels: which are whole, and what of the image is left without those that are not.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "geometry/gray_image.hpp"
#include "geometry/grid.hpp"
#include "packing/section.hpp"
#include "vessels/config.hpp"

namespace porepack::scans {

enum class GrainKind { whole, cut, merged, split, speck };  ///< cut: by the first or the last layer of the image

struct LabelledGrain {
    double voxels = 0.0;
    geometry::Vec3 sum = geometry::Vec3::Zero();                 ///< of the voxels' centres, m
    int lowest = std::numeric_limits<int>::max(), highest = -1;  ///< layers
    double in_lowest = 0.0, in_highest = 0.0, in_widest = 0.0;   ///< voxels of these layers, and of that with most
    GrainKind kind = GrainKind::whole;
};

/// Of each label up to `count`; the first, of the pores, stays empty. `label` has one number per cell of the grid, 0 in pores.
[[nodiscard]] std::vector<LabelledGrain> labelled_grains(const geometry::Grid& grid, std::span<const std::uint32_t> label,
                                                         std::size_t count);

struct GrainRules {
    double smallest_grain = 0.05;  ///< specks are smaller; volume over the median volume
    bool on_floor = false;         ///< grains that reach the first layer stand on the floor, and are whole
};
/// Sets the kinds. A grain of more than 1.5 median volumes is merged, of less than 0.6 split.
void classify(std::vector<LabelledGrain>& grains, int layers, const GrainRules& rules);

/// Voxels of the grain at which, from small to large, half of the volume of whole grains is reached: specks and merged grains hardly count.
[[nodiscard]] double median_by_volume(std::span<const LabelledGrain> grains);

/// Gives the voxels within `steps` of a grain to the nearest one: the blurred edge that belongs to it.
[[nodiscard]] std::vector<std::uint32_t> with_edges(const geometry::Grid& grid, std::vector<std::uint32_t> label, int steps);

/// 1 where the gray value is above the level, inside the container's walls.
[[nodiscard]] std::vector<std::uint8_t> solid_voxels(const geometry::GrayImage& gray, const vessels::Container& container);

/// Between the planes that no removed grain reaches; the median height of whole grains away from where the bed ends inside the image. None
/// where nothing is left.
[[nodiscard]] std::optional<packing::Section> complete_section(std::span<const LabelledGrain> grains, const geometry::Grid& grid,
                                                               bool with_cut_grains);

}  // namespace porepack::scans
