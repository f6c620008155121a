// What a gray image tells of its solid: levels, volume, blur.
#pragma once

#include <optional>

#include "pore_space/gray_solid.hpp"

namespace porepack::pore_space {

/// What the edges and the noise of a gray image tell. Lengths in voxels.
struct GrayMeasures {
    double blur = 0.0;               ///< standard deviation of the point spread function, from the slope of the values at the walls
    double area_per_volume_m = 0.0;  ///< of the level set, in the container; from crossings along the axes, for surfaces of any direction
    double solid_fraction = 0.0;     ///< of the level set
    double gray_fraction = 0.0;      ///< mean of the gray values
    double slope = 0.0;              ///< change of the level set's solid fraction with the level
};
/// In the container, without `margin_voxels` at a cylinder's wall.
[[nodiscard]] GrayMeasures measure_gray(const GraySolid& solid, const vessels::Container& container, double margin_voxels = 3.0);

/// Means of the voxels that lie so deep in pores and solid that blur does not reach them, with their standard errors from eight parts of
/// the image; nothing for a phase that has less than 64 such voxels.
struct Plateaus {
    struct Mean {
        double value = 0.0, error = 0.0;
        int depth_voxels = 0;  ///< smaller than asked where there are too few deep voxels
    };
    std::optional<Mean> pores, solid;
};
[[nodiscard]] Plateaus plateaus(const GraySolid& solid, const vessels::Container& container, int depth_voxels, double margin_voxels = 3.0);
/// Volume of the level set over that of the container, without the margin, as measure_gray().
[[nodiscard]] double solid_fraction(const GraySolid& solid, const vessels::Container& container, double margin_voxels = 3.0);

/// The level whose solid has the volume of the gray values, whatever their blur. Throws UserError where there is none between 0.1 and 0.9.
[[nodiscard]] double volume_keeping_level(const GraySolid& solid, const vessels::Container& container, double margin_voxels = 3.0);

}  // namespace porepack::pore_space
