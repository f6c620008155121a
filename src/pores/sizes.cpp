#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/parallel.hpp"
#include "pores/pores.hpp"

namespace porepack::pores {
namespace {

// Squared distances along one row, in voxels: the lower envelope of parabolas at all places.
class Row {
public:
    void transform(std::vector<double>& values) {
        const int n = static_cast<int>(values.size());
        place_.assign(values.size(), 0);
        from_.assign(values.size() + 1, 0.0);
        int last = -1;
        for (int q = 0; q < n; ++q) {
            if (std::isinf(value(values, q))) continue;
            double start = -std::numeric_limits<double>::infinity();
            while (last >= 0) {
                const int p = place_[static_cast<std::size_t>(last)];
                start = (value(values, q) + q * static_cast<double>(q) - value(values, p) - p * static_cast<double>(p)) / (2.0 * (q - p));
                if (start > from_[static_cast<std::size_t>(last)]) break;
                --last;
            }
            ++last;
            place_[static_cast<std::size_t>(last)] = q;
            from_[static_cast<std::size_t>(last)] = last == 0 ? -std::numeric_limits<double>::infinity() : start;
        }
        if (last < 0) return;
        result_.resize(values.size());
        int at = 0;
        for (int q = 0; q < n; ++q) {
            while (at < last && from_[static_cast<std::size_t>(at) + 1] < q) ++at;
            const int p = place_[static_cast<std::size_t>(at)];
            result_[static_cast<std::size_t>(q)] = (q - p) * static_cast<double>(q - p) + value(values, p);
        }
        values.swap(result_);
    }

private:
    static double value(const std::vector<double>& values, int i) { return values[static_cast<std::size_t>(i)]; }
    std::vector<int> place_;
    std::vector<double> from_, result_;
};

}  // namespace

// The squared distance to the nearest solid centre is separable: a transform of rows along one axis after another (Row), each the lower
// envelope of the parabolas that the values before it place. A periodic axis is repeated three times, and the middle copy is kept. Half a
// voxel is subtracted because the wall lies between the centres.
std::vector<float> wall_distance_m(const PhaseImage& image, const std::array<bool, 3>& periodic) {
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[0];
    std::vector<float> squares(image.phase.size());
    for (std::size_t cell = 0; cell < squares.size(); ++cell)
        squares[cell] = image.phase[cell] == Phase::pore ? std::numeric_limits<float>::infinity() : 0.0F;
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
        const int n = grid.cells[a], copies = periodic[a] ? 3 : 1, middle = periodic[a] ? n : 0;
        parallel_for(static_cast<std::size_t>(grid.cells[c]), [&](std::size_t second) {
            Row row;
            std::vector<double> values(static_cast<std::size_t>(n * copies));
            std::array<int, 3> at{};
            at[c] = static_cast<int>(second);
            for (at[b] = 0; at[b] < grid.cells[b]; ++at[b]) {
                const auto cell = [&](int i) {
                    at[a] = i;
                    return grid.index(at[0], at[1], at[2]);
                };
                values.resize(static_cast<std::size_t>(n * copies));
                for (int i = 0; i < n * copies; ++i) values[static_cast<std::size_t>(i)] = squares[cell(i % n)];
                row.transform(values);
                for (int i = 0; i < n; ++i) squares[cell(i)] = static_cast<float>(values[static_cast<std::size_t>(i + middle)]);
            }
        });
    }
    for (float& value : squares) value = value > 0.0F ? static_cast<float>(h * (std::sqrt(static_cast<double>(value)) - 0.5)) : 0.0F;
    return squares;
}

std::vector<float> wall_distance_m(const PhaseImage& image, const packing::Grains& grains, const vessels::Container& container) {
    const Grid& grid = image.grid;
    const shapes::Vec3 low = container.low(), high = container.high();
    std::vector<float> distance(image.phase.size(), 0.0F);
    parallel_for(static_cast<std::size_t>(grid.cells[2]), [&](std::size_t layer) {
        const int k = static_cast<int>(layer);
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                const std::size_t cell = grid.index(i, j, k);
                if (image.phase[cell] != Phase::pore) continue;
                const shapes::Vec3 at(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                const double wall = std::min(0.5 * (high - low).norm(), container.wall_distance(at));
                distance[cell] = static_cast<float>(std::max(0.0, *grains.distance(at, wall)));
            }
    });
    return distance;
}

// Spheres are painted from the largest to the smallest; one that lies inside that of a neighbour adds nothing.
std::vector<float> pore_diameter_m(const PhaseImage& image, const std::vector<float>& distance_m, const std::array<bool, 3>& periodic) {
    const Grid& grid = image.grid;
    const double h = grid.spacing_m[0];
    const auto moved = [&](std::size_t a, int i) {
        const int n = grid.cells[a];
        if (periodic[a]) return ((i % n) + n) % n;
        return i >= 0 && i < n ? i : -1;
    };
    std::vector<std::uint32_t> centres;
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                const std::size_t cell = grid.index(i, j, k);
                if (image.phase[cell] != Phase::pore || !std::isfinite(distance_m[cell])) continue;
                bool inside_other = false;
                for (int c = -1; c <= 1 && !inside_other; ++c)
                    for (int b = -1; b <= 1 && !inside_other; ++b)
                        for (int a = -1; a <= 1 && !inside_other; ++a) {
                            const int x = moved(0, i + a), y = moved(1, j + b), z = moved(2, k + c);
                            if (x < 0 || y < 0 || z < 0 || (a == 0 && b == 0 && c == 0)) continue;
                            inside_other =
                                distance_m[grid.index(x, y, z)] >= distance_m[cell] + 0.999 * h * std::sqrt(a * a + b * b + c * c);
                        }
                if (!inside_other) centres.push_back(static_cast<std::uint32_t>(cell));
            }
    std::stable_sort(centres.begin(), centres.end(), [&](std::uint32_t p, std::uint32_t q) { return distance_m[p] > distance_m[q]; });
    std::vector<float> diameter(image.phase.size(), 0.0F);
    for (const std::uint32_t centre : centres) {
        const std::size_t at = centre;
        const std::array<int, 3> place = grid.place(at);
        const double radius = (static_cast<double>(distance_m[at]) + 0.5 * h) / h;  // to the centre of the nearest voxel that is no pore
        const auto value = static_cast<float>(2.0 * distance_m[at]);
        const int reach = static_cast<int>(radius);
        for (int c = -reach; c <= reach; ++c)
            for (int b = -reach; b <= reach; ++b) {
                const int y = moved(1, place[1] + b), z = moved(2, place[2] + c);
                if (y < 0 || z < 0) continue;
                const double left = radius * radius - b * b - c * c;
                if (left <= 0.0) continue;
                const int half = static_cast<int>(std::ceil(std::sqrt(left))) - 1;
                for (int a = -half; a <= half; ++a) {
                    const int x = moved(0, place[0] + a);
                    if (x < 0) continue;
                    const std::size_t cell = grid.index(x, y, z);
                    if (image.phase[cell] == Phase::pore && diameter[cell] == 0.0F) diameter[cell] = value;
                }
            }
    }
    return diameter;
}

}  // namespace porepack::pores
