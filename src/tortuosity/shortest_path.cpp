// Shortest paths through the pores (geodesics): Dijkstra's search over the voxel corners in which a path runs straight to the last
// visible point (Theta*: Nash, Daniel, Koenig & Felner 2007), so that its length is that of the path and not that of a staircase.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

#include "core/context.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "tortuosity/pore_lattice.hpp"
#include "tortuosity/tortuosity.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {
namespace {

struct Neighbour {
    Corner step;
    double length;
};

std::vector<Neighbour> neighbours_of(const Vec3& spacing) {
    std::vector<Neighbour> all;
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x)
                if (x != 0 || y != 0 || z != 0) all.push_back({{x, y, z}, spacing.cwiseProduct(Vec3(x, y, z)).norm()});
    return all;
}

// Lengths of the paths from the last plane to all corners; each corner stores the previous point of its path.
class Paths {
public:
    Paths(const Lattice& lattice, const VoxelSight& sight, std::size_t axis)
        : lattice_(lattice), sight_(sight), axis_(axis), length_(lattice.size(), 1e30F), back_(lattice.size()), state_(lattice.size(), 0) {
        search();
    }
    [[nodiscard]] bool reached(std::size_t at) const { return state_[at] == settled; }
    // Corners from `start` to the last plane, not wrapped.
    [[nodiscard]] std::vector<Corner> way_from(const Corner& start) const {
        std::vector<Corner> path = {start};
        Corner at = start, free = start;
        while (true) {
            const Step& back = back_[lattice_.index(at)];
            if (back[0] == 0 && back[1] == 0 && back[2] == 0) return path;
            for (std::size_t a = 0; a < 3; ++a) {
                at[a] -= back[a];
                free[a] -= back[a];
            }
            at = wrap_far(at);
            path.push_back(free);
        }
    }

private:
    using Step = std::array<std::int16_t, 3>;  // from the previous point of the path
    using Entry = std::pair<float, std::uint32_t>;
    using Queue = std::priority_queue<Entry, std::vector<Entry>, std::greater<>>;
    enum : std::uint8_t { fresh = 0, settled = 1, closed = 2 };

    [[nodiscard]] Corner wrap_far(Corner at) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (lattice_.periodic[a]) at[a] = (at[a] % lattice_.cells[a] + lattice_.cells[a]) % lattice_.cells[a];
        return at;
    }
    [[nodiscard]] double length_of(const Corner& step) const {
        return lattice_.spacing_m.cwiseProduct(Vec3(step[0], step[1], step[2])).norm();
    }

    void search() {
        Queue queue;
        const std::vector<Neighbour> neighbours = neighbours_of(lattice_.spacing_m);
        Corner at{};
        const std::size_t u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        at[axis_] = lattice_.corners(axis_) - 1;
        for (at[u] = 0; at[u] < lattice_.corners(u); ++at[u])
            for (at[v] = 0; at[v] < lattice_.corners(v); ++at[v]) {
                if (!sight_.open(at)) continue;
                const std::size_t i = lattice_.index(at);
                length_[i] = 0.0F;
                queue.push({0.0F, static_cast<std::uint32_t>(i)});
            }
        Progress progress("tortuosity (shortest_path)");
        const double whole = static_cast<double>(lattice_.corners(axis_)) * lattice_.spacing_m[static_cast<int>(axis_)];
        for (long count = 0; !queue.empty(); ++count) {
            const auto [length, index] = queue.top();
            queue.pop();
            if (state_[index] != fresh) continue;
            state_[index] = settled;
            const Corner here = lattice_.corner(index);
            for (const Neighbour& neighbour : neighbours) relax(here, index, neighbour, queue);
            if (count % 65536 == 0) {
                check_interrupt();
                progress.update(std::min(1.0, length / whole));
            }
        }
    }

    // The anchor is the point at which the path to `here` last turned. If the neighbour is visible from the anchor, the path goes there
    // straight, and `here` drops out; otherwise it turns at `here`. The straight length is a lower bound of both, so corners that it cannot
    // improve need no test of sight.
    void relax(const Corner& here, std::size_t index, const Neighbour& neighbour, Queue& queue) {
        Corner there = {here[0] + neighbour.step[0], here[1] + neighbour.step[1], here[2] + neighbour.step[2]};
        if (!lattice_.wrap(there)) return;
        const std::size_t other = lattice_.index(there);
        if (state_[other] != fresh) return;
        const Step& back = back_[index];
        const Corner from_anchor = {back[0] + neighbour.step[0], back[1] + neighbour.step[1], back[2] + neighbour.step[2]};
        const double anchor = static_cast<double>(length_[index]) - length_of({back[0], back[1], back[2]});
        const double straight = anchor + length_of(from_anchor), bent = length_[index] + neighbour.length;
        // Lengths are stored in single precision: smaller gains are rounding.
        const double known = length_[other] * (1.0 - 1e-6);
        if (straight >= known) return;
        if (!sight_.open(there)) {
            state_[other] = closed;
            return;
        }
        const Corner place = {here[0] - back[0], here[1] - back[1], here[2] - back[2]};
        // Steps are stored in 16 bits.
        constexpr int farthest = 32000;
        const bool near = std::abs(from_anchor[0]) < farthest && std::abs(from_anchor[1]) < farthest && std::abs(from_anchor[2]) < farthest;
        const auto set = [&](double length, const Corner& step) {
            length_[other] = static_cast<float>(length);
            for (std::size_t a = 0; a < 3; ++a) back_[other][a] = static_cast<std::int16_t>(step[a]);
            queue.push({length_[other], static_cast<std::uint32_t>(other)});
        };
        if (near && sight_.visible(wrap_far(place), from_anchor))
            set(straight, from_anchor);
        else if (bent < known && sight_.visible(here, neighbour.step))
            set(bent, neighbour.step);
    }

    const Lattice& lattice_;
    const VoxelSight& sight_;
    std::size_t axis_;
    std::vector<float> length_;
    std::vector<Step> back_;
    std::vector<std::uint8_t> state_;
};

// Length minus height, summed without cancellation: exactly 0 for a straight path.
double excess(const std::vector<Vec3>& path, int axis) {
    double sum = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i) {
        const Vec3 part = path[i] - path[i - 1];
        const double along = part[axis], across2 = std::max(0.0, part.squaredNorm() - along * along);
        sum += along > 0.0 ? across2 / (part.norm() + along) : part.norm() - along;
    }
    return sum;
}

// Evenly spaced points along the path, at most `spacing` apart.
std::vector<Vec3> resampled(const std::vector<Vec3>& path, double spacing) {
    std::vector<Vec3> points = {path.front()};
    for (std::size_t i = 1; i < path.size(); ++i) {
        const auto parts = static_cast<int>(std::ceil((path[i] - path[i - 1]).norm() / spacing));
        for (int p = 1; p <= parts; ++p) points.push_back(path[i - 1] + static_cast<double>(p) / parts * (path[i] - path[i - 1]));
    }
    return points;
}

// A thread between grains: its points move to the middle of their neighbours (over-relaxed) and are put back on the grains' surface
// if they are inside. The last point slides on the end plane.
void relax_thread(std::vector<Vec3>& path, int axis, const Grains& grains, double spacing, int max_sweeps) {
    constexpr double overrelaxation = 1.6;
    std::vector<std::vector<Capsule>> near(path.size());
    std::vector<std::vector<PlacedShape>> near_bodies(grains.has_bodies() ? path.size() : 0);
    const auto out_of_bodies = [&](Vec3& point, const std::vector<PlacedShape>& bodies) {
        bool inside = false;
        for (const PlacedShape& body : bodies) {
            Vec3 outward;
            const double away = signed_distance(body, point, outward);
            if (away >= 0.0) continue;
            inside = true;
            point -= away * (1.0 + 1e-12) * outward;
        }
        return inside;
    };
    const auto out_of_grains = [&](Vec3& point, std::size_t i) {
        const std::vector<Capsule>& capsules = near[i];
        // Out of one capsule may be into the next: some rounds, at a joint or a contact.
        for (int round = 0; round < 6; ++round) {
            bool inside = !near_bodies.empty() && out_of_bodies(point, near_bodies[i]);
            for (const Capsule& capsule : capsules) {
                const Vec3 axis_point = closest_on_axis(capsule, point), away = point - axis_point;
                const double distance = away.norm();
                if (distance >= capsule.radius || distance == 0.0) continue;
                inside = true;
                point = axis_point + capsule.radius * (1.0 + 1e-12) / distance * away;
            }
            if (!inside) return;
        }
    };
    for (int sweep = 0; sweep < max_sweeps; ++sweep) {
        double farthest = 0.0;
        for (std::size_t i = 1; i < path.size(); ++i) {
            if (sweep % 8 == 0) {
                near[i].clear();
                grains.capsules_near(path[i], 2.0 * spacing, near[i]);
                if (!near_bodies.empty()) {
                    near_bodies[i].clear();
                    grains.bodies_near(path[i], 2.0 * spacing, near_bodies[i]);
                }
            }
            const bool last = i + 1 == path.size();
            Vec3 middle = last ? path[i - 1] : Vec3(0.5 * (path[i - 1] + path[i + 1]));
            if (last) middle[axis] = path[i][axis];
            Vec3 move = overrelaxation * (middle - path[i]);
            // Short moves, so that no point passes through a grain.
            if (const double size = move.norm(); size > 0.5 * spacing) move *= 0.5 * spacing / size;
            Vec3 there = path[i] + move;
            if (!near[i].empty() || (!near_bodies.empty() && !near_bodies[i].empty())) out_of_grains(there, i);
            if (last) there[axis] = path[i][axis];
            farthest = std::max(farthest, (there - path[i]).norm());
            path[i] = there;
        }
        if (farthest < 1e-4 * spacing) break;
    }
}

// Pulls a path taut. Returns length minus height for threads with more and more points; their chords cut the round grains with a second-
// order error, which extrapolation of the last two removes.
double pull_taut(std::vector<Vec3>& path, int axis, const Grains& grains, double radius) {
    double before = 0.0, now = excess(path, axis);
    for (const auto& [part, sweeps] : {std::pair(1.0, 100), std::pair(0.5, 60), std::pair(0.25, 60), std::pair(0.125, 60)}) {
        path = resampled(path, part * radius);
        relax_thread(path, axis, grains, part * radius, sweeps);
        before = now;
        now = excess(path, axis);
    }
    return std::max(0.0, now + (now - before) / 3.0);
}

// The path from every start, or from an even selection of a large number of starts, and their mean.
template <typename Finish>
ShortestPathResult summarise(const Lattice& lattice, const VoxelSight& sight, std::size_t axis, std::size_t maximum, const Finish& finish) {
    const Paths paths(lattice, sight, axis);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    struct Start {
        Corner at;
        double weight;  // a corner on a side represents half the area
    };
    std::vector<Start> starts;
    ShortestPathResult result;
    Corner at{};
    for (at[v] = 0; at[v] < lattice.corners(v); ++at[v])
        for (at[u] = 0; at[u] < lattice.corners(u); ++at[u]) {
            if (!sight.open(at)) continue;
            double weight = 1.0;
            for (const std::size_t across : {u, v})
                if (!lattice.periodic[across] && (at[across] == 0 || at[across] == lattice.cells[across])) weight *= 0.5;
            if (paths.reached(lattice.index(at)))
                starts.push_back({at, weight});
            else
                ++result.blocked_starts;
        }
    if (starts.empty())
        throw NumericalError("no path crosses the pores: the section does not percolate", {.fix = "use finer voxels if it should"});
    // Every n-th start of the list, the first one half a step from its beginning.
    const std::size_t every = 1 + (starts.size() - 1) / maximum;
    const double length = lattice.cells[axis] * lattice.spacing_m[static_cast<int>(axis)];
    std::vector<std::pair<double, double>> values((starts.size() - every / 2 + every - 1) / every);  // with their weights
    std::vector<std::vector<Vec3>> kept(values.size());
    // Of the other paths only about a hundred are kept.
    const std::size_t keep_every = 1 + values.size() / 100;
    // Value and number of the shortest path: ties go to the lower number, whatever the order of the threads.
    std::pair<double, std::size_t> best = {1e300, 0};
    // No exception may leave a parallel loop.
    const Context& run = context();
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t n = 0; n < values.size(); ++n) {
        const ContextScope here(run);
        if (interrupted()) continue;
        const Start& start = starts[every / 2 + n * every];
        std::vector<Vec3> path;
        for (const Corner& corner : paths.way_from(start.at)) path.push_back(lattice.place(corner));
        const double value = excess(path, static_cast<int>(axis)) > 0.0 ? finish(path) / length : 0.0;
        values[n] = {value, start.weight};
#pragma omp critical
        if (const std::pair<double, std::size_t> one = {value, n}; one < best || n % keep_every == 0) {
            best = std::min(best, one);
            kept[n] = std::move(path);
        }
    }
    check_interrupt();
    result.paths_m.push_back(std::move(kept[best.second]));
    for (std::size_t n = 0; n < kept.size(); n += keep_every)
        if (!kept[n].empty()) result.paths_m.push_back(std::move(kept[n]));
    result.minimum = 1.0 + best.first;
    for (const auto& [value, weight] : values) result.maximum = std::max(result.maximum, 1.0 + value);
    result.starts = static_cast<long>(values.size());
    double weights = 0.0, mean = 0.0, squares = 0.0;
    for (const auto& [value, weight] : values) weights += weight;
    for (const auto& [value, weight] : values) mean += weight / weights * value;
    for (const auto& [value, weight] : values) squares += weight / weights * (value - mean) * (value - mean);
    result.value = 1.0 + mean;
    result.standard_deviation = std::sqrt(squares);
    return result;
}

Lattice lattice_of(const PhaseImage& image, int axis, std::array<bool, 3> periodic) {
    Lattice lattice{.cells = image.grid.cells, .periodic = periodic};
    for (int a = 0; a < 3; ++a) {
        lattice.origin_m[a] = image.grid.origin_m[static_cast<std::size_t>(a)];
        lattice.spacing_m[a] = image.grid.spacing_m[static_cast<std::size_t>(a)];
    }
    lattice.periodic[static_cast<std::size_t>(axis)] = false;
    if (lattice.size() >= 4294967295U)
        throw UserError(fmt::format("the grid has {:.3g} corners", static_cast<double>(lattice.size())),
                        {.allowed = "fewer than 4.29e9", .fix = "use larger voxels or a shorter section"});
    return lattice;
}

ShortestPathResult along_corners(const PhaseImage& image, const Lattice& lattice, int axis, const LinkCuts& cuts) {
    return summarise(lattice, VoxelSight(image, lattice, cuts), static_cast<std::size_t>(axis), 1000000,
                     [&](const std::vector<Vec3>& path) { return excess(path, axis); });
}

}  // namespace

double shortest_path_memory_bytes(double cells) {
    return 15.0 * cells;
}

ShortestPathResult shortest_path(const PhaseImage& image, int axis, std::array<bool, 3> periodic) {
    const Lattice lattice = lattice_of(image, axis, periodic);
    return along_corners(image, lattice, axis, {});
}

ShortestPathResult shortest_path(const PoreSpace& space, double voxel_size_m, Axis direction, long max_starts) {
    const PoreSpace section = space.section_only();
    const int axis = static_cast<int>(direction);
    require_memory(shortest_path_memory_bytes(static_cast<double>(section.plan_at(voxel_size_m).grid.size())),
                   "the search for the shortest paths", "use a larger voxel size or a shorter section");
    const PhaseImage image = section.voxelise_at(voxel_size_m);
    const Lattice lattice = lattice_of(image, axis, section.periodic_sides());
    const LinkCuts cuts = section.own_grid() ? LinkCuts() : section.link_cuts(image, {.axis = axis, .periodic = section.periodic_sides()});
    if (!section.grains()) return along_corners(image, lattice, axis, cuts);
    return summarise(lattice, VoxelSight(image, lattice, cuts), static_cast<std::size_t>(axis), static_cast<std::size_t>(max_starts),
                     [&](std::vector<Vec3>& path) { return pull_taut(path, axis, *section.grains(), 0.5 * section.grain_size_m); });
}

}  // namespace porepack::tortuosity
