// Slices of a section as a stack of images.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "converters/slices.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "io/image.hpp"
#include "pore_space/voxels.hpp"
#include "vessels/config.hpp"

namespace porepack::converters {

int write_slices(const Path& folder, const Solid& solid, const Container& container, const Section& section, double spacing_m,
                 double pixel_m) {
    if (!(spacing_m > 0.0) || !(pixel_m > 0.0))
        throw UserError("the slice spacing and the pixel must be positive", {.where = "slice_spacing_m, pixel_m"});
    constexpr double maximum_slices = 100000, maximum_pixels = 1e8;
    const Vec3 inner = container.high() - container.low();
    const double pixels_per_slice = std::ceil(inner.x() / pixel_m) * std::ceil(inner.y() / pixel_m);
    if (pixel_m > inner.head<2>().minCoeff() / 4.0 || pixels_per_slice > maximum_pixels)
        throw UserError(fmt::format("pixels of {:g} m do not fit a container {:g} x {:g} m wide: {:.3g} pixels per slice", pixel_m,
                                    inner.x(), inner.y(), pixels_per_slice),
                        {.allowed = "at least 4 pixels across, at most 1e8 per slice", .fix = "the pixel is in metres"});
    if (section.length() / spacing_m > maximum_slices)
        throw UserError(fmt::format("a spacing of {:g} m would make {:.3g} slices", spacing_m, section.length() / spacing_m),
                        {.allowed = fmt::format("at most {:g} slices", maximum_slices), .fix = "the spacing is in metres"});
    Grid layer;
    const Vec3 low = container.low(), size = container.high() - container.low();
    for (std::size_t axis = 0; axis < 2; ++axis) {
        layer.cells[axis] = static_cast<int>(std::ceil(size[static_cast<int>(axis)] / pixel_m - 1e-9));
        layer.spacing_m[axis] = pixel_m;
        layer.origin_m[axis] = low[static_cast<int>(axis)] - 0.5 * (layer.cells[axis] * pixel_m - size[static_cast<int>(axis)]);
    }
    const int count = std::max(1, 1 + static_cast<int>(std::floor(section.length() / spacing_m + 1e-9)));
    require_memory(static_cast<double>(layer.cells[0]) * layer.cells[1] * 64.0, "a block of slices", "choose larger pixels");
    make_folder(folder);
    Progress progress("slices");
    // In blocks of slices: this limits the memory, and a column is evaluated only once per block.
    constexpr int block = 64;
    for (int first = 0; first < count; first += block) {
        Grid grid = layer;
        grid.cells[2] = std::min(block, count - first);
        grid.spacing_m[2] = spacing_m;
        grid.origin_m[2] = section.z0_m + (first - 0.5) * spacing_m;  // slice s lies at z0 + s spacing, the middle of its cell
        std::vector<std::uint8_t> phase(grid.size());
        fill_phases(phase, grid, solid, container, {section.z0_m - spacing_m, section.z1_m + spacing_m});
        const auto pixels = static_cast<std::size_t>(grid.cells[0]) * static_cast<std::size_t>(grid.cells[1]);
        for (auto& value : phase) value = value == Phase::grain ? 0 : value == Phase::pore ? 255 : 128;
        for (int k = 0; k < grid.cells[2]; ++k) {
            check_interrupt();
            write_gray_png(folder / fmt::format("slice_{:04}.png", first + k), grid.cells[0], grid.cells[1],
                           {phase.data() + static_cast<std::size_t>(k) * pixels, pixels});
        }
        progress.update(static_cast<double>(first + grid.cells[2]) / count);
    }
    write_json(folder / "slices.json", {{"format", "porepack-slices"},
                                        {"version", 1},
                                        {"slices", count},
                                        {"pixels", {layer.cells[0], layer.cells[1]}},
                                        {"pixel_m", pixel_m},
                                        {"spacing_m", spacing_m},
                                        {"origin_m", {layer.origin_m[0], layer.origin_m[1], section.z0_m}},
                                        {"values", {{"grain", 0}, {"pore", 255}, {"outside", 128}}},
                                        {"axes", "columns: +x to the right, rows: +y upwards, slice number: +z"},
                                        {"section_m", {section.z0_m, section.z1_m}},
                                        {"container", to_json(container)}});
    return count;
}

SliceStack read_slices(const Path& folder) {
    const Json json = read_json(folder / "slices.json");
    SliceStack stack;
    int count = 0;
    try {
        if (json.at("format") != "porepack-slices")
            throw UserError("not a slice stack: " + folder.string(), {.allowed = "a folder that porepack slices wrote"});
        count = json.at("slices").get<int>();
        stack.grid.cells = {json.at("pixels").at(0).get<int>(), json.at("pixels").at(1).get<int>(), count};
        const double pixel = json.at("pixel_m").get<double>();
        stack.grid.spacing_m = {pixel, pixel, json.at("spacing_m").get<double>()};
        stack.grid.origin_m = {json.at("origin_m").at(0).get<double>(), json.at("origin_m").at(1).get<double>(),
                               json.at("origin_m").at(2).get<double>() - 0.5 * stack.grid.spacing_m[2]};
        stack.section = {json.at("section_m").at(0).get<double>(), json.at("section_m").at(1).get<double>()};
        stack.container = container_from_json(json.at("container"), (folder / "slices.json").string());
    } catch (const Json::exception& fault) {
        throw UserError(std::string("slices.json is incomplete: ") + fault.what(), {.where = (folder / "slices.json").string()});
    }
    for (const double spacing : stack.grid.spacing_m)
        if (!(spacing > 0.0)) throw UserError("spacing_m and pixel_m must be positive", {.where = (folder / "slices.json").string()});
    stack.phase.reserve(stack.grid.size());
    for (int s = 0; s < count; ++s) {
        const Path file = folder / fmt::format("slice_{:04}.png", s);
        int width = 0, height = 0;
        const auto pixels = read_gray_png(file, width, height);
        if (width != stack.grid.cells[0] || height != stack.grid.cells[1])
            throw UserError(fmt::format("{} has {} x {} pixels, slices.json says {} x {}", file.string(), width, height,
                                        stack.grid.cells[0], stack.grid.cells[1]),
                            {.fix = "write the slices again: porepack slices"});
        for (const auto value : pixels) stack.phase.push_back(value < 64 ? Phase::grain : value > 192 ? Phase::pore : Phase::outside);
    }
    return stack;
}

}  // namespace porepack::converters
