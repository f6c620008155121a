// Table [image] of case.toml, and the flags --image-*: a scan or a segmented image as the solid.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/choice.hpp"
#include "record/config.hpp"

namespace porepack::imaging {

enum class ValueType { uint8, int8, uint16, int16, uint32, int32, float32, float64 };
constexpr std::array<core::Choice<ValueType>, 8> choices_of(ValueType) {
    return {{{ValueType::uint8, "uint8"},
             {ValueType::int8, "int8"},
             {ValueType::uint16, "uint16"},
             {ValueType::int16, "int16"},
             {ValueType::uint32, "uint32"},
             {ValueType::int32, "int32"},
             {ValueType::float32, "float32"},
             {ValueType::float64, "float64"}}};
}
enum class ByteOrder { little, big };
constexpr std::array<core::Choice<ByteOrder>, 2> choices_of(ByteOrder) {
    return {{{ByteOrder::little, "little"}, {ByteOrder::big, "big"}}};
}
/// Side of the threshold on which the pores are: in a scan of attenuation, air is darker than the grains.
enum class PoreSide { below, above };
constexpr std::array<core::Choice<PoreSide>, 2> choices_of(PoreSide) {
    return {{{PoreSide::below, "below"}, {PoreSide::above, "above"}}};
}

/// Where the walls lie between the voxels of a scan.
enum class ImageWalls { automatic, gray, half_way, balls };
constexpr std::array<core::Choice<ImageWalls>, 4> choices_of(ImageWalls) {
    return {
        {{ImageWalls::automatic, "auto"}, {ImageWalls::gray, "gray"}, {ImageWalls::half_way, "half_way"}, {ImageWalls::balls, "balls"}}};
}

/// How the threshold between pores and solid follows from the gray values: the level that keeps the gray volume, half-way between the two
/// peaks of the histogram, Otsu's.
enum class ThresholdRule { volume, half_level, otsu };
constexpr std::array<core::Choice<ThresholdRule>, 3> choices_of(ThresholdRule) {
    return {{{ThresholdRule::volume, "volume"}, {ThresholdRule::half_level, "half_level"}, {ThresholdRule::otsu, "otsu"}}};
}
/// A gray value, or the rule that gives it.
using Threshold = std::variant<double, ThresholdRule>;

struct ImageConfig {
    std::string file = {};
    std::vector<double> dims = {};
    ValueType type = ValueType::uint8;
    ByteOrder byte_order = ByteOrder::little;
    long header_bytes = 0;
    std::string axes = "xyz";
    std::vector<double> voxel_size_m = {};
    double unit_m = 0.0;
    std::string field = {};
    std::vector<double> pore = {};  ///< empty: not given
    std::optional<Threshold> threshold = {};
    PoreSide pore_side = PoreSide::below;
    ImageWalls walls = ImageWalls::automatic;
    double smoothing_voxels = -1.0;
    std::vector<double> gray_levels = {};
    bool find_container = false;
    bool fit = false;
    bool fitted_sizes = false;
    double fit_memory_bytes = 0.0;
};

void describe(record::ConfigVisitor& v, ImageConfig& c);

}  // namespace porepack::imaging
