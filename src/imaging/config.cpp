#include "imaging/config.hpp"

#include <cmath>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::imaging {
namespace {

std::vector<double> pore_values(const Json& pore) {
    if (pore.is_null()) return {};
    std::vector<double> values;
    for (const Json& value : pore.is_array() ? pore : Json::array({pore})) {
        if (!value.is_number()) throw UserError("`pore` is not a number or a list of numbers", {.where = "[image], --image-pore"});
        values.push_back(value.get<double>());
    }
    if (values.empty()) throw UserError("`pore` is an empty list", {.where = "[image], --image-pore"});
    return values;
}

// Whole numbers as such, as a file writes them: configurations are compared by their text.
Json json_of(double value) {
    constexpr double largest = 9e15;
    return value == std::floor(value) && std::abs(value) < largest ? Json(static_cast<std::int64_t>(value)) : Json(value);
}

Json json_of(const std::vector<double>& values) {
    if (values.empty()) return {};
    if (values.size() == 1) return json_of(values[0]);
    Json list = Json::array();
    for (const double value : values) list.push_back(json_of(value));
    return list;
}

Json json_of(const std::optional<Threshold>& threshold) {
    if (!threshold) return {};
    const double* value = std::get_if<double>(&*threshold);
    return value != nullptr ? json_of(*value) : Json(name_of(std::get<ThresholdRule>(*threshold)));
}

std::optional<Threshold> threshold_of(const Json& threshold) {
    if (threshold.is_null()) return std::nullopt;
    if (threshold.is_number()) return threshold.get<double>();
    if (threshold.is_string())
        if (const auto rule = choice_named<ThresholdRule>(threshold.get<std::string>())) return *rule;
    throw UserError("`threshold` is neither a number nor one of its words",
                    {.where = "[image], --image-threshold", .allowed = "a gray value, or volume, half_level, otsu"});
}

}  // namespace

void describe(record::ConfigVisitor& v, ImageConfig& c) {
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
    Json pore = json_of(c.pore);
    v.any("pore", pore, "number, or list of numbers", "values of the pores in a segmented image; all others are solid");
    c.pore = pore_values(pore);
    Json threshold = json_of(c.threshold);
    v.any("threshold", threshold, "number, or \"volume\", \"half_level\", \"otsu\"",
          "gray value between pores and solid; volume: the level that keeps the gray volume; half_level: half-way between the two peaks "
          "of the histogram; otsu: Otsu's threshold");
    c.threshold = threshold_of(threshold);
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
