// From the values of a scan to solid fractions: gray levels of pores and solid, thresholds.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/gray_image.hpp"
#include "imaging/volume.hpp"

namespace porepack::scans {

/// Gray levels of an image, fitted to the two peaks of its histogram.
struct GrayLevels {
    double pore = 0.0, solid = 0.0;              ///< means of the peaks
    double pore_noise = 0.0, solid_noise = 0.0;  ///< standard deviations of the peaks
    double pore_error = 0.0, solid_error = 0.0;  ///< standard errors of the means, from eight parts of the image
    double otsu = 0.0;                           ///< threshold of Otsu (1979)
    bool only_two_values = false;                ///< the image has no others: it is segmented
    [[nodiscard]] double contrast() const { return std::abs(solid - pore); }
    [[nodiscard]] double noise() const { return 0.5 * (pore_noise + solid_noise) / contrast(); }
    [[nodiscard]] double half_level() const { return 0.5 * (pore + solid); }
    /// Solid fraction of a gray value.
    [[nodiscard]] double fraction(double value) const { return (value - pore) / (solid - pore); }
};

/// Columns (i, j) of voxels that count: 1, or all if empty.
using ColumnMask = std::vector<std::uint8_t>;

/// Two passes over the image. Throws UserError where there are not two peaks; `where` names the image.
[[nodiscard]] GrayLevels fit_gray_levels(const imaging::VolumeSource& source, imaging::PoreSide pores, const ColumnMask& mask,
                                         const std::string& where);
/// The same of a histogram, whose first bin is at `low`, without errors of the means. Empty if it has not two peaks.
[[nodiscard]] std::optional<GrayLevels> fit_peaks(const std::vector<std::int64_t>& bins, double low, double width, imaging::PoreSide pores);

/// One pass: 2 bytes per voxel. Throws UserError as segmented().
[[nodiscard]] geometry::GrayImage solid_fractions(const imaging::VolumeSource& source, const GrayLevels& levels, const std::string& where);

/// The image as a scan whose pores and solid have these gray values. The image must outlive it.
[[nodiscard]] imaging::VolumeSource scan_of(const geometry::GrayImage& image, double pores, double solid,
                                            imaging::ValueType type = imaging::ValueType::float32);

/// Standard deviation in voxels of the Gaussian that brings white noise down to 3 % of the contrast; 0 where it is smaller.
[[nodiscard]] double needed_smoothing(double noise);

}  // namespace porepack::scans
