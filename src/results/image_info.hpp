// What is in an image file: `porepack image info`, and what the other commands of `image` wrote.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/members.hpp"

namespace porepack::results {

struct Volume {
    std::string format;
    std::array<std::int64_t, 3> voxels{};
    std::array<double, 3> voxel_size_m{};
    std::string voxel_size_from;
    std::array<double, 3> origin_m{}, size_m{};
    std::string orientation, type;
};
template <core::MembersOf<Volume> Self, typename Visit>
void visit_members(Self& volume, const Visit& visit) {
    visit("format", volume.format);
    visit("voxels", volume.voxels);
    visit("voxel_size_m", volume.voxel_size_m);
    visit("voxel_size_from", volume.voxel_size_from);
    visit("origin_m", volume.origin_m);
    visit("size_m", volume.size_m);
    visit("orientation", volume.orientation);
    visit("type", volume.type);
}

struct ValueShare {
    double value = 0.0;
    double fraction = 0.0;  ///< of the voxels
};
template <core::MembersOf<ValueShare> Self, typename Visit>
void visit_members(Self& share, const Visit& visit) {
    visit("value", share.value);
    visit("fraction", share.fraction);
}

struct Histogram {
    double from = 0.0, class_width = 0.0;
    std::vector<double> fractions;  ///< of the voxels, by class
};
template <core::MembersOf<Histogram> Self, typename Visit>
void visit_members(Self& histogram, const Visit& visit) {
    visit("from", histogram.from);
    visit("class_width", histogram.class_width);
    visit("fractions", histogram.fractions);
}

/// None: the values have no two peaks.
struct GrayThresholds {
    core::OptionalKey<double> gray_level_of_pores = {}, gray_level_of_solid = {};
    std::optional<double> threshold_half_level{}, threshold_otsu{};
};
template <core::MembersOf<GrayThresholds> Self, typename Visit>
void visit_members(Self& levels, const Visit& visit) {
    visit("gray_level_of_pores", levels.gray_level_of_pores);
    visit("gray_level_of_solid", levels.gray_level_of_solid);
    visit("threshold_half_level", levels.threshold_half_level);
    visit("threshold_otsu", levels.threshold_otsu);
}

struct VolumeValues {
    double minimum = 0.0, maximum = 0.0, mean = 0.0, standard_deviation = 0.0;
    core::OptionalKey<std::vector<ValueShare>> values = {};  ///< of a few values; else a histogram
    core::OptionalKey<Histogram> histogram = {};
    core::OptionalKey<GrayThresholds> thresholds = {};
};
template <core::MembersOf<VolumeValues> Self, typename Visit>
void visit_members(Self& values, const Visit& visit) {
    visit("minimum", values.minimum);
    visit("maximum", values.maximum);
    visit("mean", values.mean);
    visit("standard_deviation", values.standard_deviation);
    visit("values", values.values);
    visit("histogram", values.histogram);
    visit("", values.thresholds);
}

struct ImageInfo {
    Volume volume;
    core::OptionalKey<VolumeValues> values = {};
};
template <core::MembersOf<ImageInfo> Self, typename Visit>
void visit_members(Self& info, const Visit& visit) {
    visit("", info.volume);
    visit("", info.values);
}

struct WrittenImage {
    Volume volume;
    core::OptionalKey<std::string> would_write = {}, written = {};
};
template <core::MembersOf<WrittenImage> Self, typename Visit>
void visit_members(Self& image, const Visit& visit) {
    visit("", image.volume);
    visit("would_write", image.would_write);
    visit("written", image.written);
}

}  // namespace porepack::results
