#include "analysis/stone_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/uses.hpp"
#include "converters/simplify.hpp"
#include "converters/surface.hpp"
#include "core/parallel.hpp"
#include "io/iso_surface.hpp"

namespace porepack::analysis {
namespace {

struct CellBox {
    std::array<int, 3> low = {std::numeric_limits<int>::max(), std::numeric_limits<int>::max(), std::numeric_limits<int>::max()};
    std::array<int, 3> high = {-1, -1, -1};
};

std::vector<CellBox> boxes_of(const Grid& grid, const std::vector<std::uint32_t>& owner) {
    std::vector<CellBox> boxes(*std::max_element(owner.begin(), owner.end()) + 1);
    for (std::size_t cell = 0; cell < owner.size(); ++cell) {
        if (owner[cell] == 0) continue;
        CellBox& box = boxes[owner[cell]];
        const auto at = grid.place(cell);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.low[axis] = std::min(box.low[axis], at[axis]);
            box.high[axis] = std::max(box.high[axis], at[axis]);
        }
    }
    return boxes;
}

GrayImage alone(const GrayImage& gray, const std::vector<std::uint32_t>& owner, std::uint32_t label, const CellBox& box) {
    GrayImage one{.grid = {.spacing_m = gray.grid.spacing_m}, .packed = {}, .level = gray.level, .notes = {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        one.grid.cells[axis] = box.high[axis] - box.low[axis] + 1;
        one.grid.origin_m[axis] = gray.grid.origin_m[axis] + box.low[axis] * gray.grid.spacing_m[axis];
    }
    one.packed.reserve(one.grid.size());
    for (int k = box.low[2]; k <= box.high[2]; ++k)
        for (int j = box.low[1]; j <= box.high[1]; ++j)
            for (int i = box.low[0]; i <= box.high[0]; ++i) {
                const std::size_t cell = gray.grid.index(i, j, k);
                one.packed.push_back(owner[cell] == label ? gray.packed[cell] : GrayImage::pack(0.0));
            }
    return one;
}

}  // namespace

StoneLibrary stones_of(const GrayImage& gray, const std::vector<std::uint32_t>& owner, const std::vector<std::uint32_t>& labels) {
    const std::vector<CellBox> boxes = boxes_of(gray.grid, owner);
    std::vector<std::optional<TriangleSurface>> made(labels.size());
    parallel_for(labels.size(), [&](std::size_t i) {
        made[i] = converters::largest_part(io::iso_surface(alone(gray, owner, labels[i], boxes.at(labels[i]))), library_faces);
    });
    StoneLibrary library;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        if (!made[i]) {
            ++library.left_out;
            continue;
        }
        library.labels.push_back(labels[i]);
        library.surfaces.push_back(std::move(*made[i]));
    }
    return library;
}

void write_library(const StoneLibrary& library, const Path& folder) {
    make_folder(folder);
    Table table({"file", "volume_m3", "equal_volume_diameter_m", "maximum_feret_diameter_m", "surface_area_m2", "sphericity", "convexity",
                 "triangles"});
    table.digits = 6;
    for (std::size_t i = 0; i < library.surfaces.size(); ++i) {
        const TriangleSurface& surface = library.surfaces[i];
        const std::string name = fmt::format("stone_{:05}.stl", library.labels[i]);
        io::write_stl(folder / name, surface);
        const converters::SurfaceMeasures m = converters::measure_surface(surface);
        table.add(name, m.volume_m3, std::cbrt(6.0 * m.volume_m3 / std::numbers::pi), m.maximum_feret_diameter_m, m.area_m2, m.sphericity,
                  std::min(1.0, m.volume_m3 / m.hull_volume_m3), surface.triangles.size());
    }
    table.write(folder / "stones.csv");
}

}  // namespace porepack::analysis
