#include "geometry/gray_filters.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.hpp"

namespace porepack::inline geometry {

void rescale(GrayImage& image, double pores, double solid) {
    parallel_for(static_cast<std::size_t>(image.grid.cells[2]), [&](std::size_t layer) {
        const std::size_t size = image.grid.index(0, 0, 1);
        for (std::size_t cell = layer * size; cell < (layer + 1) * size; ++cell)
            image.packed[cell] = GrayImage::pack((image.at(cell) - pores) / (solid - pores));
    });
}

GrayImage averaged(const GrayImage& image, int factor) {
    GrayImage coarse{.grid = image.grid, .packed = {}, .level = image.level, .notes = {}};
    for (std::size_t a = 0; a < 3; ++a) {
        coarse.grid.cells[a] = image.grid.cells[a] / factor;
        coarse.grid.spacing_m[a] = image.grid.spacing_m[a] * factor;
    }
    coarse.packed.resize(coarse.grid.size());
    for (int k = 0; k < coarse.grid.cells[2]; ++k)
        for (int j = 0; j < coarse.grid.cells[1]; ++j)
            for (int i = 0; i < coarse.grid.cells[0]; ++i) {
                double sum = 0.0;
                for (int c = 0; c < factor; ++c)
                    for (int b = 0; b < factor; ++b)
                        for (int a = 0; a < factor; ++a) sum += image.at(image.grid.index(factor * i + a, factor * j + b, factor * k + c));
                coarse.packed[coarse.grid.index(i, j, k)] = GrayImage::pack(sum / (factor * factor * factor));
            }
    return coarse;
}

void smooth(GrayImage& image, double sigma_voxels, const std::array<bool, 3>& periodic) {
    if (sigma_voxels <= 0.0) return;
    const int reach = static_cast<int>(std::ceil(4.0 * sigma_voxels));
    std::vector<double> weight;
    for (int i = -reach; i <= reach; ++i) weight.push_back(std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels)));
    double sum = 0.0;
    for (const double w : weight) sum += w;
    const Grid& grid = image.grid;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
        const int n = grid.cells[a];
        parallel_for(static_cast<std::size_t>(grid.cells[c]), [&](std::size_t second) {
            std::vector<double> line(static_cast<std::size_t>(n + 2 * reach));
            std::array<int, 3> at{};
            at[c] = static_cast<int>(second);
            for (at[b] = 0; at[b] < grid.cells[b]; ++at[b]) {
                const auto cell = [&](int i) {
                    at[a] = i;
                    return grid.index(at[0], at[1], at[2]);
                };
                for (int i = -reach; i < n + reach; ++i)
                    line[static_cast<std::size_t>(i + reach)] = image.at(cell(periodic[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1)));
                for (int i = 0; i < n; ++i) {
                    double value = 0.0;
                    for (int j = 0; j <= 2 * reach; ++j)
                        value += weight[static_cast<std::size_t>(j)] * line[static_cast<std::size_t>(i + j)];
                    image.packed[cell(i)] = GrayImage::pack(value / sum);
                }
            }
        });
    }
}

}  // namespace porepack::inline geometry
