#include "support/simulated_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/parallel.hpp"
#include "geometry/gray_filters.hpp"

namespace porepack::test {
using namespace pore_space;
using namespace packing;
using namespace vessels;

GrayImage simulated_scan(const Solid& solid, const Container& container, double voxel_size_m, const ScanSettings& settings) {
    GrayImage image;
    Grid& grid = image.grid;
    shapes::Vec3 low = container.low(), high = container.high();
    const double h = (high - low).x() / std::round((high - low).x() / voxel_size_m);
    if (settings.part) {
        low.z() = settings.part->z0_m;
        high.z() = settings.part->z1_m;
    }
    constexpr double shown_voxels = 6.0;
    if (settings.tube)
        for (const int axis : {0, 1}) {
            low[axis] -= shown_voxels * h;
            high[axis] += shown_voxels * h;
        }
    const shapes::Vec3 size = high - low;
    for (const int axis : {0, 1, 2}) {
        const auto a = static_cast<std::size_t>(axis);
        grid.cells[a] = static_cast<int>(std::lround(size[axis] / h));
        grid.origin_m[a] = low[axis];
        grid.spacing_m[a] = h;
    }
    image.packed.resize(grid.size());
    constexpr int lines = 4;
    parallel_for(static_cast<std::size_t>(grid.cells[1]), [&](std::size_t row) {
        const int j = static_cast<int>(row);
        std::vector<Interval> parts;
        std::vector<double> fraction(static_cast<std::size_t>(grid.cells[2]));
        for (int i = 0; i < grid.cells[0]; ++i) {
            std::fill(fraction.begin(), fraction.end(), 0.0);
            for (int b = 0; b < lines; ++b)
                for (int a = 0; a < lines; ++a) {
                    const auto at = [&](int axis, int cell, int line) {
                        return grid.centre(axis, cell) + ((line + 0.5) / lines - 0.5) * h;
                    };
                    solid.column(at(0, i, a), at(1, j, b), parts);
                    if (settings.tube && !container.contains_column(at(0, i, a), at(1, j, b))) parts = {{low.z(), high.z()}};
                    for (const Interval& part : parts) {
                        const double from = std::max(0.0, (part.low - grid.origin_m[2]) / h);
                        const double to = std::min(static_cast<double>(grid.cells[2]), (part.high - grid.origin_m[2]) / h);
                        for (int k = static_cast<int>(from); k < to; ++k)
                            fraction[static_cast<std::size_t>(k)] +=
                                std::max(0.0, std::min(to, k + 1.0) - std::max(from, static_cast<double>(k))) / (lines * lines);
                    }
                }
            for (int k = 0; k < grid.cells[2]; ++k)
                image.packed[grid.index(i, j, k)] = GrayImage::pack(fraction[static_cast<std::size_t>(k)]);
        }
    });
    smooth(image, settings.blur_voxels, container.periodic());
    if (settings.noise > 0.0) {
        std::mt19937 random(settings.seed);
        std::normal_distribution<double> noise(0.0, settings.noise);
        for (std::uint16_t& value : image.packed) value = GrayImage::pack(GrayImage::unpack(value) + noise(random));
    }
    return image;
}

}  // namespace porepack::test
