#include "scans/gray_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "scans/phases.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr std::size_t max_bins = 1024;

struct Bins {
    double low = 0.0, width = 1.0;
    std::size_t count = 0;
};

// One bin for each whole number where there are few, so that no bin is empty for lack of values.
Bins bins_for(ValueType type, double low, double high) {
    const bool whole = type != ValueType::float32 && type != ValueType::float64;
    if (whole) {
        const double width = std::max(1.0, std::ceil((high - low + 1.0) / static_cast<double>(max_bins)));
        return {low - 0.5, width, static_cast<std::size_t>((high - low) / width) + 1};
    }
    return {low, (high - low) / static_cast<double>(max_bins - 1), max_bins};
}

// Otsu's criterion: the threshold that maximises the variance between the two classes, n1 n2 (mean1 - mean2)^2.
double otsu_threshold(const std::vector<std::int64_t>& bins, double low, double width) {
    double all = 0.0, sum = 0.0;
    for (std::size_t b = 0; b < bins.size(); ++b) {
        all += static_cast<double>(bins[b]);
        sum += static_cast<double>(bins[b]) * static_cast<double>(b);
    }
    double below = 0.0, sum_below = 0.0, best = -1.0;
    double first = 0.0, last = 0.0;  // of equal maxima, as between two peaks without anything in between
    for (std::size_t b = 0; b + 1 < bins.size(); ++b) {
        below += static_cast<double>(bins[b]);
        sum_below += static_cast<double>(bins[b]) * static_cast<double>(b);
        if (below == 0.0 || below == all) continue;
        const double difference = sum_below / below - (sum - sum_below) / (all - below);
        const double between = below * (all - below) * difference * difference;
        if (between > best * (1.0 + 1e-12)) {
            best = between;
            first = static_cast<double>(b);
        }
        if (between >= best * (1.0 - 1e-12)) last = static_cast<double>(b);
    }
    return low + width * (0.5 * (first + last) + 1.0);
}

struct Peak {
    double mean, deviation;
};

// The Gaussian of a peak in bins [begin, end): its logarithm is a parabola around the maximum. Partial volumes lie between the peaks, on
// the side `inner` (+1: above), so that side counts to half a deviation only.
std::optional<Peak> fit_peak(const std::vector<std::int64_t>& bins, std::size_t begin, std::size_t end, int inner) {
    double total = 0.0;
    for (std::size_t b = begin; b < end; ++b) total += static_cast<double>(bins[b]);
    if (total < 16.0) return std::nullopt;
    // The maximum of the histogram, smoothed until it has few bins' width; then the deviation from the outer flank.
    const auto count = [&](long b) {
        return b < static_cast<long>(begin) || b >= static_cast<long>(end) ? 0.0 : static_cast<double>(bins[static_cast<std::size_t>(b)]);
    };
    long best = static_cast<long>(begin);
    double maximum = -1.0;
    for (long b = static_cast<long>(begin); b < static_cast<long>(end); ++b) {
        const double around = count(b - 2) + 2.0 * count(b - 1) + 3.0 * count(b) + 2.0 * count(b + 1) + count(b + 2);
        if (around > maximum) {
            maximum = around;
            best = b;
        }
    }
    Peak peak{.mean = static_cast<double>(best), .deviation = 0.0};
    for (int pass = 0; pass < 12; ++pass) {
        double square = 0.0, weight = 0.0;
        for (long b = static_cast<long>(begin); b < static_cast<long>(end); ++b) {
            const double away = (static_cast<double>(b) - peak.mean) * inner;
            if (away > 0.0) continue;
            square += count(b) * away * away;
            weight += count(b);
        }
        // From the outer flank alone, which partial volumes do not reach.
        peak.deviation = weight > 0.0 ? std::sqrt(square / weight) : 0.0;
        if (peak.deviation < 1.0) break;  // a peak of a few bins: its mean follows below
        // Weighted least squares of ln(count) = a + b x + c x^2.
        // The variance of ln n is about 1/n for counts, hence the weights n. The maximum of the parabola, -b / (2 c), is the new mean; a
        // step is limited to one deviation. The normal equations are solved by Cramer's rule.
        double s[5] = {}, t[3] = {};
        for (long b = static_cast<long>(begin); b < static_cast<long>(end); ++b) {
            const double x = (static_cast<double>(b) - peak.mean) / peak.deviation, n = count(b);
            if (n < 1.0 || x * inner > 0.5 || x * inner < -2.0) continue;
            double power = n;
            for (double& sum : s) {
                sum += power;
                power *= x;
            }
            const double y = std::log(n) * n;
            t[0] += y;
            t[1] += y * x;
            t[2] += y * x * x;
        }
        const double d = s[0] * (s[2] * s[4] - s[3] * s[3]) - s[1] * (s[1] * s[4] - s[3] * s[2]) + s[2] * (s[1] * s[3] - s[2] * s[2]);
        if (!(std::abs(d) > 0.0)) break;
        const double linear =
            (s[0] * (t[1] * s[4] - s[3] * t[2]) - t[0] * (s[1] * s[4] - s[3] * s[2]) + s[2] * (s[1] * t[2] - t[1] * s[2])) / d;
        const double quadratic =
            (s[0] * (s[2] * t[2] - t[1] * s[3]) - s[1] * (s[1] * t[2] - t[1] * s[2]) + t[0] * (s[1] * s[3] - s[2] * s[2])) / d;
        if (!(quadratic < 0.0)) break;
        const double shift = std::clamp(-0.5 * linear / quadratic, -1.0, 1.0) * peak.deviation;
        peak.mean = std::clamp(peak.mean + shift, static_cast<double>(begin), static_cast<double>(end) - 1.0);
        if (std::abs(shift) < 1e-4 * peak.deviation) break;
    }
    if (peak.deviation < 1.0) {  // hardly any noise: the mean of the bins around the maximum
        double sum = 0.0, weight = 0.0;
        for (long b = best - 1; b <= best + 1; ++b) {
            sum += count(b) * static_cast<double>(b);
            weight += count(b);
        }
        peak.mean = sum / weight;
    }
    return peak;
}

}  // namespace

std::optional<GrayLevels> fit_peaks(const std::vector<std::int64_t>& bins, double low, double width, PoreSide pores) {
    GrayLevels levels{.otsu = otsu_threshold(bins, low, width)};
    const auto middle = static_cast<std::size_t>(std::clamp((levels.otsu - low) / width, 1.0, static_cast<double>(bins.size() - 1)));
    const auto lower = fit_peak(bins, 0, middle, 1), upper = fit_peak(bins, middle, bins.size(), -1);
    if (!lower || !upper) return std::nullopt;
    const auto value = [&](double bin) { return low + width * (bin + 0.5); };
    levels.pore = value(lower->mean);
    levels.solid = value(upper->mean);
    levels.pore_noise = width * lower->deviation;
    levels.solid_noise = width * upper->deviation;
    if (pores == PoreSide::above) {
        std::swap(levels.pore, levels.solid);
        std::swap(levels.pore_noise, levels.solid_noise);
    }
    return levels;
}

GrayLevels fit_gray_levels(const VolumeSource& source, PoreSide pores, const ColumnMask& mask, const std::string& where) {
    const VolumeHeader& header = source.header;
    const VolumeStatistics found = statistics_of(source);
    if (!(found.maximum > found.minimum))
        throw UserError(fmt::format("all values of the image are {:g}", found.minimum), {.where = where, .fix = "porepack image info"});
    const Bins bins = bins_for(header.type, found.minimum, found.maximum);
    // One histogram per octant: the scatter of their peaks gives the errors of the means, including slow drifts of the gray values.
    std::vector<std::vector<std::int64_t>> parts(8, std::vector<std::int64_t>(bins.count, 0));
    std::vector<float> layer(static_cast<std::size_t>(header.layer()));
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        std::size_t at = 0;
        for (std::int64_t y = 0; y < header.voxels[1]; ++y)
            for (std::int64_t x = 0; x < header.voxels[0]; ++x, ++at) {
                if (!mask.empty() && mask[at] == 0) continue;
                const std::size_t part =
                    (2 * x >= header.voxels[0] ? 1U : 0U) + (2 * y >= header.voxels[1] ? 2U : 0U) + (2 * z >= header.voxels[2] ? 4U : 0U);
                ++parts[part][std::min(bins.count - 1, static_cast<std::size_t>((layer[at] - bins.low) / bins.width))];
            }
    }
    std::vector<std::int64_t> all(bins.count, 0);
    for (const auto& part : parts)
        for (std::size_t b = 0; b < bins.count; ++b) all[b] += part[b];
    auto levels = fit_peaks(all, bins.low, bins.width, pores);
    // Two peaks that noise or a single phase has made are not apart.
    if (!levels || levels->contrast() < 2.0 * (levels->pore_noise + levels->solid_noise))
        throw UserError("the histogram of the image has not two peaks that are apart, so pores and solid cannot be told",
                        {.where = where,
                         .fix = "porepack image info; if both phases are there: --image-gray-levels PORE,SOLID, or --image-walls half_way "
                                "with a number as threshold"});
    double squares[2] = {}, count = 0.0;
    for (const auto& part : parts)
        if (const auto own = fit_peaks(part, bins.low, bins.width, pores); own && own->contrast() > 0.5 * levels->contrast()) {
            squares[0] += std::pow(own->pore - levels->pore, 2.0);
            squares[1] += std::pow(own->solid - levels->solid, 2.0);
            count += 1.0;
        }
    // Standard error of a mean of `count` values; where fewer than two octants have two peaks, it stays finite.
    const double number = std::max(2.0, count) * std::max(1.0, count - 1.0);
    levels->only_two_values = found.values && found.values->size() == 2;
    levels->pore_error = std::sqrt(squares[0] / number);
    levels->solid_error = std::sqrt(squares[1] / number);
    return *levels;
}

GrayImage solid_fractions(const VolumeSource& source, const GrayLevels& levels, const std::string& where) {
    const VolumeHeader& header = source.header;
    GrayImage image{.grid = usable_grid(header, where, 2.0), .notes = header.notes};
    image.packed.resize(image.grid.size());
    std::vector<float> layer(static_cast<std::size_t>(header.layer()));
    auto out = image.packed.begin();
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        for (const float value : layer) *out++ = GrayImage::pack(levels.fraction(value));
    }
    return image;
}

VolumeSource scan_of(const GrayImage& image, double pores, double solid, ValueType type) {
    VolumeSource source;
    for (std::size_t a = 0; a < 3; ++a) {
        source.header.voxels[a] = image.grid.cells[a];
        source.header.spacing_m[a] = image.grid.spacing_m[a];
    }
    source.header.type = type;
    const bool whole = type != ValueType::float32 && type != ValueType::float64;
    source.read = [&image, pores, solid, whole, layer = static_cast<std::size_t>(source.header.layer())](std::int64_t first,
                                                                                                         std::span<float> values) {
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double value = pores + (solid - pores) * image.at(static_cast<std::size_t>(first) * layer + i);
            values[i] = static_cast<float>(whole ? std::round(value) : value);
        }
    };
    return source;
}

double needed_smoothing(double noise) {
    constexpr double allowed = 0.03;
    if (noise <= 1.2 * allowed) return 0.0;
    // A Gaussian leaves 1 / ((4 pi)^(3/4) s^(3/2)) of white noise; below half a voxel less.
    const double sigma = std::pow(noise / (allowed * std::pow(4.0 * std::numbers::pi, 0.75)), 2.0 / 3.0);
    return std::clamp(sigma, 0.4, 2.0);
}

}  // namespace porepack::scans
