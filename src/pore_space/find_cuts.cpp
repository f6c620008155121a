#include "pore_space/find_cuts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

using Step = std::array<int, 3>;
using Cut = LinkCuts::Cut;

std::vector<Step> steps_across_faces_and_edges() {
    std::vector<Step> steps;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                if (const int length = x * x + y * y + z * z; length == 1 || length == 2) steps.push_back({x, y, z});
    return steps;
}

struct Link {
    std::size_t other;
    Step back;  // from the other end
};

// The pore cell at the other end of the link. Through an open end of the grid it is the mirror image of a cell in the same layer.
std::optional<Link> link_between_pores(const PhaseImage& image, const Drive& drive, Step at, const Step& step) {
    Link link{0, {-step[0], -step[1], -step[2]}};
    Step there = step;
    if (const auto axis = static_cast<std::size_t>(drive.axis); through_open_end(image.grid, drive, at, step)) {
        there[axis] = 0;
        link.back[axis] = step[axis];
    }
    if (!step_in_grid(image.grid, drive, at, there)) return std::nullopt;
    link.other = image.grid.index(at[0], at[1], at[2]);
    return image.phase[link.other] == Phase::pore ? std::optional(link) : std::nullopt;
}

// All cut lists as one, of the cells that are not in a halo.
LinkCuts joined(const Grid& grid, const std::vector<std::vector<Cut>>& parts) {
    const Grid own = grid.without_halo();
    const std::size_t first = grid.index(0, 0, grid.slab.halo[0]);
    std::vector<Cut> all;
    for (const auto& part : parts)
        for (const Cut& cut : part)
            if (cut.cell >= first && cut.cell - first < own.size()) all.push_back({cut.cell - first, cut.links});
    return {own, std::move(all)};
}

// Whichever end of a closed link is nearer to the solid finds the wall in its half of the link; it closes the link for both.
class CutFinder {
public:
    CutFinder(const PhaseImage& image, const FlowWalls& walls, const Drive& drive)
        : image_(image), drive_(drive), finder_(walls, image.grid, drive), steps_(steps_across_faces_and_edges()) {}

    void add_cuts_of(const Step& at, std::vector<Cut>& cuts) {
        const Grid& grid = image_.grid;
        const std::size_t cell = grid.index(at[0], at[1], at[2]);
        finder_.move_to({grid.centre(0, at[0]), grid.centre(1, at[1]), grid.centre(2, at[2])});
        for (const Step& step : steps_) {
            const auto link = link_between_pores(image_, drive_, at, step);
            if (!link || !finder_.closes_first_half(spacing_.cwiseProduct(Vec3(step[0], step[1], step[2])))) continue;
            cuts.push_back({cell, LinkCuts::bit(step)});
            cuts.push_back({link->other, LinkCuts::bit(link->back)});
        }
    }

private:
    const PhaseImage& image_;
    Drive drive_;
    WallFinder finder_;
    const Vec3 spacing_{image_.grid.spacing_m.data()};
    std::vector<Step> steps_;
};

}  // namespace

LinkCuts find_cuts(const PhaseImage& image, const FlowWalls& walls, const Drive& drive) {
    const Grid& grid = image.grid;
    const Vessel& vessel = walls.container.vessel();
    const std::optional<VesselWalls> sides = vessel.walls();
    const bool convex = sides && sides->convex();
    const double h = grid.spacing_m[2], first = grid.origin_m[2] + 0.5 * h, last = grid.whole_cells(2) - 1.0,
                 longest = std::numbers::sqrt2 * std::ranges::max(grid.spacing_m);
    std::vector<std::vector<Cut>> parts(static_cast<std::size_t>(grid.cells[1]));
    parallel_for(parts.size(), [&](std::size_t row) {
        const int j = static_cast<int>(row);
        CutFinder finder(image, walls, drive);
        std::vector<Interval> near;
        for (int i = 0; i < grid.cells[0]; ++i) {
            for (int k = 0; !convex && k < grid.cells[2]; ++k)
                if (image.phase[grid.index(i, j, k)] == Phase::pore &&
                    vessel.distance({grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)}) <= longest)
                    finder.add_cuts_of({i, j, k}, parts[row]);
            walls.solid.near_column(grid.centre(0, i), grid.centre(1, j), longest, near);
            for (const Interval& part : near) {
                const auto from = static_cast<int>(std::clamp(std::ceil((part.low - first) / h), 0.0, last + 1.0));
                const auto to = static_cast<int>(std::clamp(std::floor((part.high - first) / h), -1.0, last));
                grid.for_layers(from, to, [&](int k) {
                    if (image.phase[grid.index(i, j, k)] == Phase::pore) finder.add_cuts_of({i, j, k}, parts[row]);
                });
            }
        }
    });
    return joined(grid, parts);
}

LinkCuts find_cuts(const PhaseImage& image, const Drive& drive) {
    const Grid& grid = image.grid;
    const auto solid_at = [&](Step at, const Step& step) {
        return !step_in_grid(grid, drive, at, step) || image.phase[grid.index(at[0], at[1], at[2])] != Phase::pore;
    };
    // Of each edge's two links, those that lead forward along the first of its axes.
    std::vector<std::array<Step, 2>> diagonals;
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = a + 1; b < 3; ++b)
            for (const int sign : {1, -1}) {
                std::array<Step, 2> sides{};
                sides[0][a] = 1;
                sides[1][b] = sign;
                diagonals.push_back(sides);
            }
    std::vector<std::vector<Cut>> parts(static_cast<std::size_t>(grid.cells[2]));
    parallel_for(parts.size(), [&](std::size_t layer) {
        Step at{0, 0, static_cast<int>(layer)};
        for (at[1] = 0; at[1] < grid.cells[1]; ++at[1])
            for (at[0] = 0; at[0] < grid.cells[0]; ++at[0]) {
                const std::size_t cell = grid.index(at[0], at[1], at[2]);
                if (image.phase[cell] != Phase::pore) continue;
                for (const auto& [one, other] : diagonals) {
                    if (!solid_at(at, one) || !solid_at(at, other)) continue;
                    const Step step = {one[0] + other[0], one[1] + other[1], one[2] + other[2]};
                    Step there = at;
                    if (!step_in_grid(grid, drive, there, step)) continue;
                    const std::size_t end = grid.index(there[0], there[1], there[2]);
                    if (image.phase[end] != Phase::pore) continue;
                    parts[layer].push_back({cell, LinkCuts::bit(step)});
                    parts[layer].push_back({end, LinkCuts::bit({-step[0], -step[1], -step[2]})});
                }
            }
    });
    return joined(grid, parts);
}

}  // namespace porepack::pore_space
