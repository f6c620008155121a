// Table [image] of case.toml, and the flags --image-*: a scan or a segmented image as the solid.
#pragma once

#include "core/config.hpp"

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
};

inline void describe(core::ConfigVisitor& v, ImageConfig& c) {
    v.text("file", c.file, "a scan or a segmented image, relative to the case (docs/images.md lists the formats)");
    v.numbers("dims", c.dims, {3, 3}, core::between(1, 1e9), "raw file: number of voxels along the file's axes, the fastest first");
    v.choice("type", c.type, "raw file: type of its values");
    v.choice("byte_order", c.byte_order, "raw file: order of the bytes of a value");
    v.integer("header_bytes", c.header_bytes, core::between(0, 1e9), "raw file: bytes before the first value");
    v.text("axes", c.axes,
           "names of the file's axes, the fastest first: \"zyx\" for an array [x, y, z] in C order; a minus sign turns an axis round: "
           "\"xy-z\"");
    v.numbers("voxel_size_m", c.voxel_size_m, {1, 3}, core::length_range(),
              "edge length of the voxels, or lengths along x, y, z; needed where the file does not state it with a unit");
    v.number("unit_m", c.unit_m, core::length_range_or_auto(),
             "length of the unit of the file's voxel size (0.001: millimetres); auto: as the file states");
    v.text("field", c.field, "array of a .vti file; auto: the only one, or `phase`");
    v.any("pore", c.pore, "number, or list of numbers", "values of the pores in a segmented image; all others are solid");
    v.any("threshold", c.threshold, "number", "gray value between pores and solid");
    v.choice("pore_side", c.pore_side, "side of the threshold on which the pores are");
}

}  // namespace porepack::imaging
