// Table [image] of case.toml, and the flags --image-*: a scan or a segmented image as the solid.
#pragma once

#include "core/choice.hpp"
#include "core/json.hpp"
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
    core::Json pore = {};
    core::Json threshold = {};
    PoreSide pore_side = PoreSide::below;
    ImageWalls walls = ImageWalls::automatic;
    double smoothing_voxels = -1.0;
    std::vector<double> gray_levels = {};
    bool find_container = false;
    bool fit = false;
    bool fitted_sizes = false;
    double fit_memory_bytes = 0.0;
};

inline void describe(record::ConfigVisitor& v, ImageConfig& c) {
    v.text("file", c.file, "a scan or a segmented image, relative to the case (docs/images.md lists the formats)");
    v.numbers("dims", c.dims, {3, 3}, record::between(1, 1e9), "raw file: number of voxels along the file's axes, the fastest first");
    v.choice("type", c.type, "raw file: type of its values");
    v.choice("byte_order", c.byte_order, "raw file: order of the bytes of a value");
    v.integer("header_bytes", c.header_bytes, record::between(0, 1e9), "raw file: bytes before the first value");
    v.text("axes", c.axes,
           "names of the file's axes, the fastest first: \"zyx\" for an array [x, y, z] in C order; a minus sign turns an axis round: "
           "\"xy-z\"");
    v.numbers("voxel_size_m", c.voxel_size_m, {1, 3}, record::length_range(),
              "edge length of the voxels, or lengths along x, y, z; needed where the file does not state it with a unit");
    v.number("unit_m", c.unit_m, record::length_range_or_auto(),
             "length of the unit of the file's voxel size (0.001: millimetres); auto: as the file states");
    v.text("field", c.field, "array of a .vti file; auto: the only one, or `phase`");
    v.any("pore", c.pore, "number, or list of numbers", "values of the pores in a segmented image; all others are solid");
    v.any("threshold", c.threshold, "number, or \"volume\", \"half_level\", \"otsu\"",
          "gray value between pores and solid; volume: the level that keeps the gray volume; half_level: half-way between the two peaks "
          "of the histogram; otsu: Otsu's threshold");
    v.choice("pore_side", c.pore_side, "side of the threshold on which the pores are");
    v.choice("walls", c.walls,
             "gray: walls where the interpolated gray values reach the threshold; half_way: half-way between voxels of different phase; "
             "balls: of the phases, around the largest balls that fit into the solid, smoother than voxels; "
             "auto: gray with a threshold, half_way with pore values");
    v.number("smoothing_voxels", c.smoothing_voxels, {.low = -1.0, .high = 5.0},
             "standard deviation of the Gaussian that smooths the gray values first; -1: as much as the measured noise needs");
    v.numbers("gray_levels", c.gray_levels, {2, 2}, record::between(-1e9, 1e9),
              "gray values of pores and solid, for instance of air and of a solid block in the same scan; auto: found in the image, which "
              "needs pores and grains that are wider than six standard deviations of the blur");
    v.boolean("find_container", c.find_container,
              "the image shows a tube along z that attenuates like the grains: its inner circle is found and becomes the container");
    v.boolean("fit", c.fit, "case: grains of [shape] are found in the scan, and their exact poses are the packing of all later stages");
    v.boolean("fitted_sizes", c.fitted_sizes,
              "fit: the packing has the fitted radii and lengths instead of the given ones; both are reported");
    v.number("fit_memory_bytes", c.fit_memory_bytes, record::positive_or_auto(),
             "fit: memory that it may take; grains of a larger scan are searched on binned voxels and fitted slab by slab; auto: most of "
             "what is free");
}

}  // namespace porepack::imaging
