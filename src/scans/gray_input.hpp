// A scan with gray values as a solid: levels, noise, blur, and what they do to k.
#pragma once

#include <array>
#include <memory>
#include <numbers>
#include <optional>
#include <string>

#include "pore_space/gray_solid.hpp"
#include "scans/gray_levels.hpp"
#include "scans/gray_notes.hpp"

namespace porepack::scans {

/// Puts the middle of an image, or the place `axis_voxels` in it, on the container's axis, and its first layer on the floor.
void place(geometry::Grid& grid, const vessels::Container& container, const std::optional<std::array<double, 2>>& axis_voxels = {});

/// Gray values to a level set in the container's frame. The container's wall is subtracted where it is visible; noise is smoothed.
struct GrayInput {
    std::shared_ptr<const pore_space::GraySolid> solid;
    GrayNotes notes;
};
/// `axis_voxels`: place of the container's axis in the image.
[[nodiscard]] GrayInput read_gray(const imaging::VolumeSource& source, const imaging::ImageConfig& config,
                                  const vessels::Container& container, const std::string& where,
                                  const std::optional<std::array<double, 2>>& axis_voxels = {});
/// Subtracts the wall of a cylinder where it is visible, and makes pores of what lies beyond it; true where it was visible.
bool remove_tube(geometry::GrayImage& image, const vessels::Container& container, double blur_voxels);

/// A solid_fraction image that PorePack wrote. Throws UserError for notes that are damaged.
[[nodiscard]] GrayInput read_own_gray(const imaging::VolumeSource& source, const vessels::Container& container, const std::string& where);

/// The gray value that `threshold` of the configuration means: a number, or one of its words, on half-way walls. Throws UserError.
[[nodiscard]] double threshold_value(const imaging::VolumeSource& source, const imaging::ImageConfig& config,
                                     const vessels::Container& container, const std::string& where);

/// A gray solid with what is uncertain about it changed; null where that is known, or not possible.
struct GrayVariants {
    std::shared_ptr<const pore_space::GraySolid> averaged;     ///< of the means of 2 x 2 x 2 voxels, where their numbers are even
    std::shared_ptr<const pore_space::GraySolid> other_level;  ///< its solid fraction moved by two standard errors
    std::shared_ptr<const pore_space::GraySolid> blurred;      ///< with twice the variance of the blur; levels and threshold found anew
    double blur_voxels = 0.0;                                  ///< of the image itself
    /// Errors grow at least in proportion to sigma: that at sigma is at most this many times the change to sqrt(2) sigma.
    static constexpr double blur_part = 1.0 / (std::numbers::sqrt2 - 1.0);
};
[[nodiscard]] GrayVariants gray_variants(const pore_space::GraySolid& solid, const vessels::Container& container);
/// The same pore space with another gray solid.
[[nodiscard]] pore_space::PoreSpace with_gray(const pore_space::PoreSpace& space, std::shared_ptr<const pore_space::GraySolid> other);

}  // namespace porepack::scans
