#include "scans/ball_walls.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/json.hpp"
#include "core/members_json.hpp"
#include "core/parallel.hpp"
#include "geometry/gray_filters.hpp"
#include "pore_space/gray_measures.hpp"
#include "pores/pores.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

// The solid fraction that stands for a distance from the walls: 1/2 at the wall, 0 and 1 two voxels away on either side.
constexpr double fraction_per_voxel = 0.25, reach_voxels = 2.0;

// Pores become solid and solid becomes pores; outside there is nothing that could limit a ball.
PhaseImage inverted(const PhaseImage& image) {
    PhaseImage solid{.grid = image.grid, .phase = image.phase, .notes = {}};
    for (std::uint8_t& phase : solid.phase) phase = phase == Phase::pore ? Phase::grain : Phase::pore;
    return solid;
}

// Radius in voxels of the ball about the centre of each solid voxel; 0 elsewhere.
std::vector<float> radii_of(const PhaseImage& image, const std::array<bool, 3>& periodic) {
    std::vector<float> radii = pores::wall_distance_m(inverted(image), periodic);
    const auto h = static_cast<float>(image.grid.spacing_m[0]);
    for (std::size_t cell = 0; cell < radii.size(); ++cell) radii[cell] = image.phase[cell] == Phase::grain ? radii[cell] / h : 0.0F;
    return radii;
}

struct Ball {
    std::array<int, 3> at;
    double radius;
};

// Those that no ball about a voxel near by contains, sorted by z.
std::vector<Ball> largest_balls(const Grid& grid, const std::vector<float>& radii, const std::array<bool, 3>& periodic) {
    std::vector<std::vector<Ball>> found(static_cast<std::size_t>(grid.cells[2]));
    core::parallel_for(found.size(), [&](std::size_t layer) {
        const auto radius_at = [&](std::array<int, 3> at) {
            for (std::size_t a = 0; a < 3; ++a) {
                if (at[a] >= 0 && at[a] < grid.cells[a]) continue;
                if (!periodic[a]) return 0.0;
                at[a] = (at[a] + grid.cells[a]) % grid.cells[a];
            }
            return static_cast<double>(radii[grid.index(at[0], at[1], at[2])]);
        };
        const auto is_contained = [&](const std::array<int, 3>& at, double radius) {
            constexpr int near = 2;
            for (int dz = -near; dz <= near; ++dz)
                for (int dy = -near; dy <= near; ++dy)
                    for (int dx = -near; dx <= near; ++dx)
                        if (const int square = dx * dx + dy * dy + dz * dz;
                            square > 0 && radius_at({at[0] + dx, at[1] + dy, at[2] + dz}) >= radius + std::sqrt(square) - 1e-5)
                            return true;
            return false;
        };
        const int k = static_cast<int>(layer);
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i)
                if (const double radius = radii[grid.index(i, j, k)]; radius > 0.0 && !is_contained({i, j, k}, radius))
                    found[layer].push_back({{i, j, k}, radius});
    });
    std::vector<Ball> balls;
    for (const std::vector<Ball>& layer : found) balls.insert(balls.end(), layer.begin(), layer.end());
    return balls;
}

// Depth below the surface of the union of the balls, in voxels, of the voxels of one layer: exact within reach_voxels of it. `depth` holds
// what is known before.
void paint_layer(const Grid& grid, const std::vector<Ball>& balls, int layer, const std::array<bool, 3>& periodic, float* depth) {
    const auto each_place = [](int centre, int n, bool wraps, double reach, const auto& visit) {
        const int low = static_cast<int>(std::ceil(centre - reach)), high = static_cast<int>(std::floor(centre + reach));
        for (int i = wraps ? low : std::max(0, low); i <= (wraps ? high : std::min(n - 1, high)); ++i) visit(((i % n) + n) % n, i - centre);
    };
    const int nz = grid.cells[2];
    for (const Ball& ball : balls) {
        const double reach = ball.radius + reach_voxels, hollow = std::max(0.0, ball.radius - reach_voxels);
        for (const int turn : {-nz, 0, nz}) {
            const int dz = layer + turn - ball.at[2];
            if ((turn != 0 && !periodic[2]) || std::abs(dz) > reach) continue;
            each_place(ball.at[1], grid.cells[1], periodic[1], std::sqrt(reach * reach - dz * dz), [&](int j, int dy) {
                const double row = dz * dz + dy * dy;
                each_place(ball.at[0], grid.cells[0], periodic[0], std::sqrt(std::max(0.0, reach * reach - row)), [&](int i, int dx) {
                    const double square = row + dx * dx;
                    if (square < hollow * hollow) return;
                    float& value = depth[grid.index(i, j, 0)];
                    value = std::max(value, static_cast<float>(ball.radius - std::sqrt(square)));
                });
            });
        }
    }
}

// The image of the union, as fractions.
GrayImage painted(const PhaseImage& image, const std::array<bool, 3>& periodic) {
    const Grid& grid = image.grid;
    const std::vector<float> radii = radii_of(image, periodic);
    const std::vector<Ball> balls = largest_balls(grid, radii, periodic);
    GrayImage gray{.grid = grid, .packed = std::vector<std::uint16_t>(grid.size()), .notes = {}};
    core::parallel_for(static_cast<std::size_t>(grid.cells[2]), [&](std::size_t k) {
        const std::size_t layer = grid.index(0, 0, 1), first = k * layer;
        std::vector<float> depth(layer);
        for (std::size_t n = 0; n < layer; ++n) depth[n] = radii[first + n] > 0.0F ? radii[first + n] : static_cast<float>(-reach_voxels);
        paint_layer(grid, balls, static_cast<int>(k), periodic, depth.data());
        for (std::size_t n = 0; n < layer; ++n)
            gray.packed[first + n] =
                GrayImage::pack(0.5 + fraction_per_voxel * std::clamp(static_cast<double>(depth[n]), -reach_voxels, reach_voxels));
    });
    return gray;
}

// Towards its mean over about a voxel, but by a tenth of a voxel at most: creases stay.
void smooth_roughness(GrayImage& gray, const std::array<bool, 3>& periodic) {
    constexpr double sigma_voxels = 1.0, largest_change = 0.1 * fraction_per_voxel;
    GrayImage smoother = gray;
    geometry::smooth(smoother, sigma_voxels, periodic);
    for (std::size_t cell = 0; cell < gray.packed.size(); ++cell) {
        const double value = gray.at(cell);
        gray.packed[cell] = GrayImage::pack(value + std::clamp(smoother.at(cell) - value, -largest_change, largest_change));
    }
}

// The level above which the interpolated values fill as much as the solid voxels: from the values at 64 places in each voxel at the wall.
// Others lie on one side as a whole.
double level_of_volume(const GraySolid& solid, const PhaseImage& image) {
    constexpr std::size_t bins = 1U << 14U;
    constexpr int places = 4;
    const Grid& grid = image.grid;
    const auto bin_of = [](double value) {
        return std::min(bins - 1, static_cast<std::size_t>(std::clamp(value, 0.0, 1.0) * static_cast<double>(bins)));
    };
    const auto layers = static_cast<std::size_t>(grid.cells[2]);
    constexpr std::size_t parts = 16;
    std::vector<std::vector<std::uint64_t>> histograms(parts, std::vector<std::uint64_t>(bins, 0));
    std::vector<std::uint64_t> solids(parts, 0);
    core::parallel_for(parts, [&](std::size_t part) {
        for (std::size_t k = layers * part / parts; k < layers * (part + 1) / parts; ++k)
            for (int j = 0; j < grid.cells[1]; ++j)
                for (int i = 0; i < grid.cells[0]; ++i) {
                    const std::size_t cell = grid.index(i, j, static_cast<int>(k));
                    if (image.phase[cell] == Phase::outside) continue;
                    solids[part] += image.phase[cell] == Phase::grain ? 1 : 0;
                    const double middle = solid.image()->at(cell);
                    if (std::abs(middle - 0.5) > 1.5 * fraction_per_voxel) {
                        histograms[part][bin_of(middle)] += places * places * places;
                        continue;
                    }
                    for (int place = 0; place < places * places * places; ++place) {
                        const auto at = [&](int axis, int n, int step) {
                            return grid.centre(axis, n) + ((step + 0.5) / places - 0.5) * grid.spacing_m[static_cast<std::size_t>(axis)];
                        };
                        const shapes::Vec3 point(at(0, i, place % places), at(1, j, place / places % places),
                                                 at(2, static_cast<int>(k), place / places / places));
                        ++histograms[part][bin_of(solid.value(point))];
                    }
                }
    });
    std::uint64_t wanted = 0, above = 0;
    for (const std::uint64_t count : solids) wanted += places * places * places * count;
    const auto count_in = [&](std::size_t bin) {
        std::uint64_t count = 0;
        for (const auto& histogram : histograms) count += histogram[bin];
        return count;
    };
    std::size_t bin = bins;
    while (bin > 0 && above < wanted) above += count_in(--bin);
    // Walls along the lattice leave a gap between the values on both sides: the level lies in its middle.
    std::size_t next = bin;
    while (next > 0 && count_in(next - 1) == 0) --next;
    return 0.5 * static_cast<double>(bin + next) / static_cast<double>(bins);
}

}  // namespace

GrayInput walls_of_balls(const PhaseImage& image, const Container& container) {
    const std::array<bool, 3>& periodic = container.periodic();
    auto gray = std::make_shared<GrayImage>(painted(image, periodic));
    smooth_roughness(*gray, periodic);
    GrayNotes notes{.levels_given = true, .keeps_volume = false};
    notes.level = notes.threshold = gray->level = level_of_volume(GraySolid(gray, container), image);
    GrayInput input{.solid = std::make_shared<const GraySolid>(gray, container), .notes = notes};
    input.notes.slope = measure_gray(*input.solid, container).slope;
    input.notes.fraction_error = std::abs(input.notes.slope) * wall_error_voxels * fraction_per_voxel;
    gray->notes["walls"] = "balls";
    gray->notes["container"] = to_json(container).dump();
    gray->notes["gray"] = json_of(input.notes).dump();
    return input;
}

bool has_walls_of_balls(const GraySolid& solid) {
    return solid.image()->notes.contains("walls");
}

ThinParts thin_parts(const PhaseImage& image, const std::array<bool, 3>& periodic) {
    const Grid& grid = image.grid;
    // Marks what lies within two voxels of a mark, along each axis in turn.
    const auto spread = [&](std::vector<std::uint8_t>& marks) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::vector<std::uint8_t> before = marks;
            const int n = grid.cells[axis];
            core::parallel_for(static_cast<std::size_t>(grid.cells[2]), [&](std::size_t layer) {
                const std::size_t first = grid.index(0, 0, static_cast<int>(layer)), end = first + grid.index(0, 0, 1);
                for (std::size_t cell = first; cell < end; ++cell)
                    for (const int step : {-2, -1, 1, 2}) {
                        std::array<int, 3> at = grid.place(cell);
                        at[axis] += step;
                        if (periodic[axis]) at[axis] = (at[axis] % n + n) % n;
                        if (at[axis] >= 0 && at[axis] < n && before[grid.index(at[0], at[1], at[2])] != 0) marks[cell] = 1;
                    }
            });
        }
    };
    // A feature of two voxels has balls of radius 0.5 about all its voxels, one of three voxels 1.5 in its middle.
    const auto thin = [&](const PhaseImage& of) {
        const std::vector<float> distance = pores::wall_distance_m(of, periodic);
        const auto wide = static_cast<float>(1.2 * grid.spacing_m[0]);
        std::vector<std::uint8_t> near_wide(distance.size());
        for (std::size_t cell = 0; cell < distance.size(); ++cell) near_wide[cell] = distance[cell] >= wide ? 1 : 0;
        spread(near_wide);
        std::size_t all = 0, narrow = 0;
        for (std::size_t cell = 0; cell < distance.size(); ++cell)
            if (of.phase[cell] == Phase::pore) {
                ++all;
                narrow += near_wide[cell] == 0 ? 1 : 0;
            }
        return all > 0 ? static_cast<double>(narrow) / static_cast<double>(all) : 0.0;
    };
    PhaseImage solid = image;
    for (std::uint8_t& phase : solid.phase)
        phase = phase == Phase::pore ? Phase::grain : phase == Phase::grain ? Phase::pore : Phase::outside;
    return {.solid = thin(solid), .pores = thin(image)};
}

}  // namespace porepack::scans
