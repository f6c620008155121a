#include "pore_space/gray_measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/median.hpp"
#include "core/parallel.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

// Columns of voxels inside the container, at most about `maximum` of them, evenly spread.
using Columns = std::vector<std::array<int, 2>>;
Columns columns_in(const Grid& grid, const Container& container, double margin_voxels, std::size_t maximum) {
    const std::optional<double> tube = container.tube_diameter();
    const double radius = 0.5 * tube.value_or(0.0) - margin_voxels * grid.spacing_m[0];
    Columns all;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (!tube || std::hypot(grid.centre(0, i), grid.centre(1, j)) < radius) all.push_back({i, j});
    if (all.empty()) throw UserError("the image is too small: no voxel lies away from the container's wall");
    if (all.size() <= maximum) return all;
    Columns some;
    const double step = static_cast<double>(all.size()) / static_cast<double>(maximum);
    for (double at = 0.5 * step; at < static_cast<double>(all.size()); at += step) some.push_back(all[static_cast<std::size_t>(at)]);
    return some;
}

constexpr std::size_t max_columns = 20000;

// Fraction of the columns' voxels inside the level set, on four lines per voxel.
double solid_fraction(const GraySolid& solid, const Columns& columns) {
    const Grid& grid = solid.image()->grid;
    const double h = grid.spacing_m[0];
    std::vector<double> lengths(columns.size());
    parallel_for(lengths.size(), [&](std::size_t c) {
        thread_local std::vector<Interval> parts;
        for (const double dx : {-0.25, 0.25})
            for (const double dy : {-0.25, 0.25}) {
                solid.column(grid.centre(0, columns[c][0]) + dx * h, grid.centre(1, columns[c][1]) + dy * h, parts);
                for (const Interval& part : parts) lengths[c] += 0.25 * (part.high - part.low);
            }
    });
    double sum = 0.0;
    for (const double length : lengths) sum += length;
    return sum / (static_cast<double>(lengths.size()) * grid.cells[2] * grid.spacing_m[2]);
}

double gray_fraction(const GrayImage& image, const Columns& columns) {
    double sum = 0.0;
    for (const auto& [i, j] : columns)
        for (int k = 0; k < image.grid.cells[2]; ++k) sum += image.at(image.grid.index(i, j, k));
    return sum / (static_cast<double>(columns.size()) * image.grid.cells[2]);
}

// A wall that a Gaussian blurs has there the slope 1 / (sigma sqrt(2 pi)). The voxels add the variance 1/12, differences of neighbours at a
// distance of two voxels add 1/3.
double blur_of(const GraySolid& solid, const Columns& columns) {
    const GrayImage& image = *solid.image();
    const Grid& grid = image.grid;
    const double level = solid.level();
    std::vector<double> slopes;
    for (const auto& [i, j] : columns) {
        if (i == 0 || j == 0 || i + 1 == grid.cells[0] || j + 1 == grid.cells[1]) continue;
        for (int k = 1; k + 2 < grid.cells[2]; ++k) {
            const std::size_t cell = grid.index(i, j, k);
            const double here = image.at(cell), above = image.at(grid.index(i, j, k + 1));
            if ((here > level) == (above > level)) continue;
            const auto slope_at = [&](int l) {
                const double x = image.at(grid.index(i + 1, j, l)) - image.at(grid.index(i - 1, j, l));
                const double y = image.at(grid.index(i, j + 1, l)) - image.at(grid.index(i, j - 1, l));
                const double z = image.at(grid.index(i, j, l + 1)) - image.at(grid.index(i, j, l - 1));
                return 0.5 * std::sqrt(x * x + y * y + z * z);
            };
            const double part = (level - here) / (above - here);
            slopes.push_back((1.0 - part) * slope_at(k) + part * slope_at(k + 1));
        }
    }
    if (slopes.empty()) return 0.0;
    const double width = 1.0 / (median(slopes) * std::sqrt(2.0 * std::numbers::pi));
    return std::sqrt(std::max(0.0, width * width - 1.0 / 12.0 - 1.0 / 3.0));
}

double area_per_volume(const GrayImage& image, double level, const Columns& columns) {
    const Grid& grid = image.grid;
    double crossings = 0.0, pairs = 0.0;
    for (const auto& [i, j] : columns)
        for (int k = 0; k + 1 < grid.cells[2]; ++k) {
            if (i + 1 == grid.cells[0] || j + 1 == grid.cells[1]) continue;
            const bool here = image.at(grid.index(i, j, k)) > level;
            for (const std::size_t next : {grid.index(i + 1, j, k), grid.index(i, j + 1, k), grid.index(i, j, k + 1)})
                crossings += here != (image.at(next) > level) ? 1.0 : 0.0;
            pairs += 3.0;
        }
    return pairs > 0.0 ? 2.0 * crossings / pairs / grid.spacing_m[0] : 0.0;
}

}  // namespace

double solid_fraction(const GraySolid& solid, const Container& container, double margin_voxels) {
    return solid_fraction(solid, columns_in(solid.image()->grid, container, margin_voxels, max_columns));
}

GrayMeasures measure_gray(const GraySolid& solid, const Container& container, double margin_voxels) {
    const GrayImage& image = *solid.image();
    const Columns columns = columns_in(image.grid, container, margin_voxels, max_columns);
    GrayMeasures found{.blur = blur_of(solid, columns),
                       .area_per_volume_m = area_per_volume(image, solid.level(), columns),
                       .solid_fraction = solid_fraction(solid, columns),
                       .gray_fraction = gray_fraction(image, columns)};
    constexpr double apart = 0.05;
    found.slope = (solid_fraction(solid.with_level(solid.level() + apart), columns) -
                   solid_fraction(solid.with_level(solid.level() - apart), columns)) /
                  (2.0 * apart);
    return found;
}

Plateaus plateaus(const GraySolid& solid, const Container& container, int depth_voxels, double margin_voxels) {
    const GrayImage& image = *solid.image();
    const Grid& grid = image.grid;
    std::vector<std::uint8_t> counted(static_cast<std::size_t>(grid.cells[0]) * static_cast<std::size_t>(grid.cells[1]), 0);
    for (const auto& [i, j] : columns_in(grid, container, margin_voxels, counted.size())) counted[grid.index(i, j, 0)] = 1;
    // depth[cell]: number of steps from the nearest voxel of the other phase, alternately over faces and over corners too.
    std::vector<std::uint8_t> depth(grid.size(), static_cast<std::uint8_t>(depth_voxels + 1));
    const std::uint16_t level = GrayImage::pack(solid.level());
    const auto neighbour = [&](int a, int i) {
        const int n = grid.cells[static_cast<std::size_t>(a)];
        return container.periodic()[static_cast<std::size_t>(a)] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1);
    };
    for (int step = 1; step <= depth_voxels; ++step) {
        const int maximum = step % 2 == 1 ? 1 : 3;  // of the three coordinates that differ
        const auto near_other = [&](int i, int j, int k, std::size_t cell) {
            const bool phase = image.packed[cell] > level;
            for (int c = -1; c <= 1; ++c)
                for (int b = -1; b <= 1; ++b)
                    for (int a = -1; a <= 1; ++a) {
                        if (std::abs(a) + std::abs(b) + std::abs(c) > maximum) continue;
                        const std::size_t other = grid.index(neighbour(0, i + a), neighbour(1, j + b), neighbour(2, k + c));
                        if (step == 1 ? (image.packed[other] > level) != phase : depth[other] < step) return true;
                    }
            return false;
        };
        parallel_for(static_cast<std::size_t>(grid.cells[2]), [&](std::size_t layer) {
            const int k = static_cast<int>(layer);
            for (int j = 0; j < grid.cells[1]; ++j)
                for (int i = 0; i < grid.cells[0]; ++i)
                    if (const std::size_t cell = grid.index(i, j, k); depth[cell] > step && near_other(i, j, k, cell))
                        depth[cell] = static_cast<std::uint8_t>(step);
        });
    }
    Plateaus found;
    for (const bool of_solid : {false, true})
        for (int deep = depth_voxels; deep >= 1; --deep) {
            std::array<double, 8> sum{}, count{};
            for (int k = 0; k < grid.cells[2]; ++k)
                for (int j = 0; j < grid.cells[1]; ++j)
                    for (int i = 0; i < grid.cells[0]; ++i) {
                        const std::size_t cell = grid.index(i, j, k);
                        if (counted[grid.index(i, j, 0)] == 0 || depth[cell] <= deep || (image.packed[cell] > level) != of_solid) continue;
                        const std::size_t part =
                            (2 * i >= grid.cells[0] ? 1U : 0U) + (2 * j >= grid.cells[1] ? 2U : 0U) + (2 * k >= grid.cells[2] ? 4U : 0U);
                        sum[part] += image.at(cell);
                        count[part] += 1.0;
                    }
            double all = 0.0, total = 0.0;
            for (std::size_t part = 0; part < 8; ++part) {
                all += count[part];
                total += sum[part];
            }
            if (all < 64.0) continue;
            // Of a mean of parts with different numbers of voxels.
            Plateaus::Mean mean{.value = total / all, .depth_voxels = deep};
            double squares = 0.0, parts = 0.0;
            for (std::size_t part = 0; part < 8; ++part) {
                if (count[part] == 0.0) continue;
                squares += std::pow(count[part] / all * (sum[part] / count[part] - mean.value), 2.0);
                parts += 1.0;
            }
            mean.error = parts > 1.0 ? std::sqrt(squares * parts / (parts - 1.0)) : 0.0;
            (of_solid ? found.solid : found.pores) = mean;
            break;
        }
    return found;
}

// The volume falls with the level: regula falsi, kept inside the bracket by bisection.
double volume_keeping_level(const GraySolid& solid, const Container& container, double margin_voxels) {
    const Columns columns = columns_in(solid.image()->grid, container, margin_voxels, max_columns);
    const double wanted = gray_fraction(*solid.image(), columns);
    const auto surplus = [&](double level) { return solid_fraction(solid.with_level(level), columns) - wanted; };
    double low = 0.1, high = 0.9, at_low = surplus(low), at_high = surplus(high);
    if (at_low < 0.0 || at_high > 0.0)
        throw UserError(fmt::format("no level keeps the volume of the gray values: their mean is a solid fraction of {:.4f}", wanted),
                        {.fix = "give the threshold as a number; porepack image info shows the values"});
    for (int i = 0; i < 30 && high - low > 1e-5; ++i) {
        double middle = low + (high - low) * at_low / (at_low - at_high);
        if (i % 3 == 2 || !(middle > low && middle < high)) middle = 0.5 * (low + high);
        const double at_middle = surplus(middle);
        if (std::abs(at_middle) < 1e-7) return middle;
        (at_middle > 0.0 ? low : high) = middle;
        (at_middle > 0.0 ? at_low : at_high) = at_middle;
    }
    return 0.5 * (low + high);
}

PoreSpace pore_space_of(std::shared_ptr<const GraySolid> solid, const Container& container, const Section& section,
                        const std::string& where) {
    const Grid& grid = solid->image()->grid;
    require_fit(grid, container, section, where, solid->image()->notes.contains("shows_wall"));
    const GrayMeasures found = measure_gray(*solid, container);
    if (!(found.solid_fraction > 0.0 && found.area_per_volume_m > 0.0))
        throw UserError("there is no solid in the image at this threshold",
                        {.where = where, .fix = "porepack image info shows the values"});
    if (found.solid_fraction >= 1.0)
        throw UserError("there are no pores in the image at this threshold",
                        {.where = where, .fix = "porepack image info shows the values"});
    // 4 volume / area is the diameter of a long capsule, as for surfaces.
    PoreSpace space = pore_space::pore_space_of(solid, container, section, 4.0 * found.solid_fraction / found.area_per_volume_m);
    space.image_voxel_size_m = grid.spacing_m[2];
    space.bed_bottom_m = grid.origin_m[2];
    space.bed_top_m = grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2];
    return space;
}

}  // namespace porepack::pore_space
