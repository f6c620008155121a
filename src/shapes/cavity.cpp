// Enclosed voids of a union of capsules.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <queue>
#include <utility>

#include "shapes/meridian.hpp"
#include "shapes/shape.hpp"

namespace porepack {
namespace {

constexpr int cells = VoidCells::cells;

// Does the segment from p to q pass through a capsule?
bool blocked(const std::vector<Capsule>& capsules, const Vec3& p, const Vec3& q) {
    const double length = (q - p).norm();
    if (length == 0.0) return false;
    const Vec3 direction = (q - p) / length;
    for (const auto& capsule : capsules)
        if (const auto inside = line_interval(capsule, p, direction))
            if (inside->high > 0.0 && inside->low < length * (1.0 - 1e-9)) return true;
    return false;
}

// Clearance of the ray from `origin`: its least distance to a surface, negative when it is blocked.
double clearance(const std::vector<Capsule>& capsules, const Vec3& origin, const Vec3& direction, double far) {
    double least = 1e300;
    const Capsule ray{origin, origin + far * direction, 0.0};
    for (const auto& capsule : capsules) least = std::min(least, gap(ray, capsule));
    return least;
}

// Climbs to the direction of the largest clearance by a shrinking pattern search; stops early once the ray is free.
double best_clearance(const std::vector<Capsule>& capsules, const Vec3& origin, Vec3 direction, double far) {
    double best = clearance(capsules, origin, direction, far);
    int moves = 0;
    for (double step = 0.1; step > 1e-7 && best <= 0.0 && moves < 200;) {
        const Vec3 e1 = direction.unitOrthogonal();
        const Vec3 e2 = direction.cross(e1);
        Vec3 better = direction;
        for (int k = 0; k < 6; ++k) {
            const double angle = std::numbers::pi * k / 3.0;
            const Vec3 trial = (direction + step * (std::cos(angle) * e1 + std::sin(angle) * e2)).normalized();
            const double value = clearance(capsules, origin, trial, far);
            if (value > best) {
                best = value;
                better = trial;
            }
        }
        if (better == direction)
            step *= 0.5;
        else
            ++moves;
        direction = better;
    }
    return best;
}

// Looks for a straight way out: the 24 most promising of 512 directions, each improved.
bool ray_escapes(const std::vector<Capsule>& capsules, const Vec3& origin, double far) {
    constexpr int starts = 512;
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    std::vector<std::pair<double, Vec3>> directions;
    for (int i = 0; i < starts; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / starts;
        const double rho = std::sqrt(1.0 - z * z);
        const Vec3 direction(rho * std::cos(golden * i), rho * std::sin(golden * i), z);
        directions.emplace_back(clearance(capsules, origin, direction, far), direction);
    }
    std::partial_sort(directions.begin(), directions.begin() + 24, directions.end(),
                      [](const auto& p, const auto& q) { return p.first > q.first; });
    return std::any_of(directions.begin(), directions.begin() + 24,
                       [&](const auto& start) { return best_clearance(capsules, origin, start.second, far) > 0.0; });
}

// The free ball about a point reaches to the nearest surface: the best of 26 points on it, if that is better.
Vec3 wider_place(const std::vector<Capsule>& capsules, const Vec3& point) {
    const double here = signed_distance(capsules, point);
    double most = here * 1.001;
    Vec3 best = point;
    for (int k = 0; k < 27; ++k) {
        if (k == 13) continue;
        const Vec3 trial = point + 0.9 * here * Eigen::Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).cast<double>().normalized();
        const double value = signed_distance(capsules, trial);
        if (value > most) {
            most = value;
            best = trial;
        }
    }
    return best;
}

// Void space as a graph: the void cells of a grid, joined where the straight way between two centres is free, so that what
// hangs together in the graph does so in truth. What does not may still be joined by a throat narrower than a cell.
class VoidSpace {
public:
    explicit VoidSpace(const std::vector<Capsule>& capsules) : capsules_(capsules) {
        const Bounds bounds = bounds_of(capsules);
        const double extent = (bounds.high - bounds.low).maxCoeff();
        size_ = 1.1 * extent / cells;
        origin_ = 0.5 * (bounds.low + bounds.high) - Vec3::Constant(0.55 * extent);
        depth_.resize(static_cast<std::size_t>(cells) * cells * cells);
        part_.assign(depth_.size(), -1);
        for (std::size_t cell = 0; cell < depth_.size(); ++cell) depth_[cell] = signed_distance(capsules, centre(cell));
        // Part 0 is the outside: the corner of the grid is void.
        for (std::size_t cell = 0; cell < depth_.size(); ++cell)
            if (depth_[cell] > 0.0 && part_[cell] < 0) flood(cell);
    }
    [[nodiscard]] std::size_t parts() const { return deepest_.size(); }
    [[nodiscard]] const Vec3& deepest(std::size_t part) const { return deepest_[part]; }
    /// The first of the parts that `part` was joined to.
    [[nodiscard]] std::size_t root(std::size_t part) const {
        while (joined_[part] != part) part = joined_[part];
        return part;
    }
    void join(std::size_t one, std::size_t other) {
        const std::size_t p = root(one), q = root(other);
        joined_[std::max(p, q)] = std::min(p, q);
    }
    [[nodiscard]] double far() const { return 4.0 * cells * size_; }

    /// The part that a void point belongs to; a new one when none is found.
    std::size_t part_of(Vec3 point) {
        for (int step = 0; step < 80; ++step) {
            for (const std::size_t cell : cells_around(point))
                if (part_[cell] >= 0 && !blocked(capsules_, point, centre(cell))) return static_cast<std::size_t>(part_[cell]);
            const Vec3 next = wider_place(capsules_, point);
            if (next == point) break;
            point = next;
        }
        for (std::size_t part = 0; part < parts(); ++part)
            if (!blocked(capsules_, point, deepest_[part])) return part;
        return add_part(point);
    }

    /// Another part that root `part` is joined to: by the way to ever wider places, or by a throat, which is looked for along
    /// the widest ways through cells that may hide one.
    std::optional<std::size_t> joined_part(std::size_t part) {
        Vec3 point = deepest_[part];
        for (int step = 0; step < 80; ++step) {
            for (const std::size_t cell : cells_around(point))
                if (is_other_part(cell, part) && !blocked(capsules_, point, centre(cell))) return static_cast<std::size_t>(part_[cell]);
            const Vec3 next = wider_place(capsules_, point);
            if (next == point) break;
            point = next;
        }
        constexpr int most_throats = 24;
        std::vector<char> closed(depth_.size(), 0);
        for (int throat = 0; throat < most_throats; ++throat) {
            const auto way = widest_way(part, closed);
            if (!way) return std::nullopt;
            const auto [before, narrowest, after] = *way;
            Vec3 direction = centre(after) - centre(before);
            if (direction.norm() == 0.0) direction = Vec3::UnitZ();
            if (const auto found = pass(centre(narrowest), direction.normalized(), part)) return found;
            for (const std::size_t cell : cells_around(centre(narrowest))) closed[cell] = part_[cell] < 0;
            closed[narrowest] = 1;
        }
        return std::nullopt;
    }

    /// Adds root `part` to the shape's cavities: points from which every cell of it is seen, and a box that holds it.
    void describe(std::size_t part, Shape& shape) const {
        std::vector<Vec3> points;
        for (std::size_t other = part; other < parts(); ++other)
            if (root(other) == part) points.push_back(deepest_[other]);
        std::sort(points.begin(), points.end(),
                  [&](const Vec3& p, const Vec3& q) { return signed_distance(capsules_, p) > signed_distance(capsules_, q); });
        const auto seen = [&](const Vec3& at) {
            return std::any_of(shape.cavity_points.begin(), shape.cavity_points.end(),
                               [&](const Vec3& point) { return !blocked(capsules_, point, at); });
        };
        for (std::size_t cell = 0; cell < depth_.size(); ++cell)
            if (part_[cell] >= 0 && !is_other_part(cell, part)) points.push_back(centre(cell));
        for (const Vec3& point : points) {
            // Whatever of the void is not within a cell of these points lies farther up a wedge between two capsules.
            shape.cavity_bounds.add({point, point, 4.0 * size_});
            if (!seen(point)) shape.cavity_points.push_back(point);
        }
    }

    /// What the cells are once all parts that are joined have been joined.
    [[nodiscard]] VoidCells labelled() const {
        auto label = std::make_shared<std::vector<signed char>>(part_.size());
        for (std::size_t cell = 0; cell < part_.size(); ++cell)
            (*label)[cell] = part_[cell] < 0 ? -1 : static_cast<signed char>(is_other_part(cell, 0));
        return {.origin = origin_, .size = size_, .label = std::move(label)};
    }

private:
    [[nodiscard]] static std::array<int, 3> place(std::size_t cell) {
        const int c = static_cast<int>(cell);
        return {c % cells, c / cells % cells, c / (cells * cells)};
    }
    [[nodiscard]] static std::optional<std::size_t> cell_at(const std::array<int, 3>& at) {
        for (const int i : at)
            if (i < 0 || i >= cells) return std::nullopt;
        return static_cast<std::size_t>((at[2] * cells + at[1]) * cells + at[0]);
    }
    [[nodiscard]] Vec3 centre(std::size_t cell) const {
        const auto at = place(cell);
        return origin_ + size_ * Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
    }
    // The eight cells whose centres surround the point.
    [[nodiscard]] std::vector<std::size_t> cells_around(const Vec3& point) const {
        std::vector<std::size_t> around;
        const Vec3 low = ((point - origin_) / size_ - Vec3::Constant(0.5)).array().floor();
        for (int corner = 0; corner < 8; ++corner)
            if (const auto cell = cell_at({static_cast<int>(low.x()) + corner % 2, static_cast<int>(low.y()) + corner / 2 % 2,
                                           static_cast<int>(low.z()) + corner / 4}))
                around.push_back(*cell);
        return around;
    }
    [[nodiscard]] std::vector<std::size_t> neighbours(std::size_t cell) const {
        std::vector<std::size_t> list;
        const auto at = place(cell);
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
                auto next = at;
                next[axis] += step;
                if (const auto there = cell_at(next)) list.push_back(*there);
            }
        return list;
    }

    void flood(std::size_t start) {
        const int part = static_cast<int>(parts());
        std::size_t deepest = start;
        std::vector<std::size_t> stack = {start};
        part_[start] = part;
        while (!stack.empty()) {
            const std::size_t cell = stack.back();
            stack.pop_back();
            if (depth_[cell] > depth_[deepest]) deepest = cell;
            for (const std::size_t next : neighbours(cell)) {
                if (part_[next] >= 0 || depth_[next] <= 0.0) continue;
                if (depth_[cell] + depth_[next] < size_ && blocked(capsules_, centre(cell), centre(next))) continue;
                part_[next] = part;
                stack.push_back(next);
            }
        }
        (void)add_part(centre(deepest));
    }
    std::size_t add_part(const Vec3& deepest) {
        deepest_.push_back(deepest);
        joined_.push_back(parts() - 1);
        return parts() - 1;
    }
    [[nodiscard]] bool is_other_part(std::size_t cell, std::size_t root_part) const {
        return part_[cell] >= 0 && root(static_cast<std::size_t>(part_[cell])) != root_part;
    }

    struct Way {
        std::size_t before, narrowest, after;
    };
    // The way from `part` to any other whose narrowest cell is as wide as can be (Dijkstra's search by width).
    [[nodiscard]] std::optional<Way> widest_way(std::size_t part, const std::vector<char>& closed) const {
        std::vector<std::size_t> from(depth_.size(), depth_.size());
        using Entry = std::pair<double, std::size_t>;
        std::priority_queue<Entry> open;
        for (std::size_t cell = 0; cell < depth_.size(); ++cell)
            if (part_[cell] >= 0 && !is_other_part(cell, part)) {
                from[cell] = cell;
                open.emplace(depth_[cell], cell);
            }
        while (!open.empty()) {
            const auto [width, cell] = open.top();
            open.pop();
            if (is_other_part(cell, part)) {
                std::vector<std::size_t> cells_on_way = {cell};
                while (from[cells_on_way.back()] != cells_on_way.back()) cells_on_way.push_back(from[cells_on_way.back()]);
                std::size_t narrowest = 0;
                for (std::size_t k = 0; k < cells_on_way.size(); ++k)
                    if (depth_[cells_on_way[k]] < depth_[cells_on_way[narrowest]]) narrowest = k;
                return Way{cells_on_way[std::min(narrowest + 2, cells_on_way.size() - 1)], cells_on_way[narrowest],
                           cells_on_way[narrowest >= 2 ? narrowest - 2 : 0]};
            }
            for (const std::size_t next : neighbours(cell)) {
                // A void point is never farther from its cell's centre than 0.87 cells.
                if (from[next] != depth_.size() || closed[next] || depth_[next] < -0.87 * size_) continue;
                from[next] = cell;
                open.emplace(std::min(width, depth_[next]), next);
            }
        }
        return std::nullopt;
    }

    // Turns and shifts a short line until it is as clear of the surfaces as can be; the part at its other end if it is free.
    std::optional<std::size_t> pass(Vec3 middle, Vec3 direction, std::size_t part) {
        const double half = 1.5 * size_;
        const auto free_width = [&](const Vec3& at, const Vec3& along) {
            return clearance(capsules_, at - half * along, along, 2.0 * half);
        };
        double best = free_width(middle, direction);
        for (double step = 0.5; step > 1e-9 && best <= 0.0;) {
            const Vec3 e1 = direction.unitOrthogonal(), e2 = direction.cross(e1);
            const Vec3 old_middle = middle, old_direction = direction;
            for (int k = 0; k < 12; ++k) {
                const double angle = std::numbers::pi * k / 6.0;
                const Vec3 aside = std::cos(angle) * e1 + std::sin(angle) * e2;
                for (const auto& [at, along] : {std::pair<Vec3, Vec3>(old_middle + step * size_ * aside, old_direction),
                                                std::pair<Vec3, Vec3>(old_middle, (old_direction + step * aside).normalized())})
                    if (const double value = free_width(at, along); value > best) {
                        best = value;
                        middle = at;
                        direction = along;
                    }
            }
            if (middle == old_middle && direction == old_direction) step *= 0.5;
        }
        if (best <= 0.0) return std::nullopt;
        const std::size_t one = root(part_of(middle - half * direction)), other = root(part_of(middle + half * direction));
        if (one == part && other != part) return other;
        if (other == part && one != part) return one;
        return std::nullopt;
    }

    const std::vector<Capsule>& capsules_;
    Vec3 origin_;
    double size_ = 0.0;
    std::vector<double> depth_;  // distance from each cell's centre to the surface
    std::vector<int> part_;
    std::vector<Vec3> deepest_;
    std::vector<std::size_t> joined_;
};

}  // namespace

void find_cavities(Shape& shape) {
    shape.cavity_points.clear();
    shape.cavity_bounds = {};
    shape.void_cells = {};
    if (shape.capsules.size() < 3) return;  // the complement of two convex bodies is connected
    VoidSpace space(shape.capsules);
    // A void between the cells' centres has a wall: look from every exposed piece of the surface. The middle comes first: a
    // small cavity of a symmetric grain is there.
    Vec3 middle = Vec3::Zero();
    for (const auto& capsule : shape.capsules) middle += (capsule.a + capsule.b) / (2.0 * static_cast<double>(shape.capsules.size()));
    if (signed_distance(shape.capsules, middle) > 0.0) (void)space.part_of(middle);
    const ExposedSurface surface(shape.capsules);
    constexpr int meridians = 12;
    std::vector<ExposedPart> parts;
    for (std::size_t own = 0; own < surface.capsules().size(); ++own)
        for (int k = 0; k < meridians; ++k) {
            const double phi = 2.0 * std::numbers::pi * (k + 0.37) / meridians;
            surface.meridian(own, phi, parts);
            for (const auto& part : parts) {
                const SurfacePoint at = surface.point(own, phi, part.piece, 0.5 * (part.low + part.high));
                const Vec3 above = at.x + 1e-5 * surface.capsules()[own].radius * at.normal;
                if (signed_distance(shape.capsules, above) > 0.0) (void)space.part_of(above);
            }
        }

    for (std::size_t part = 1; part < space.parts(); ++part)
        if (ray_escapes(shape.capsules, space.deepest(part), space.far())) space.join(0, part);
    for (std::size_t part = 1; part < space.parts(); ++part)
        while (space.root(part) == part) {
            const auto other = space.joined_part(part);
            if (!other) break;
            space.join(part, *other);
        }
    for (std::size_t part = 1; part < space.parts(); ++part)
        if (space.root(part) == part) space.describe(part, shape);
    if (!shape.cavity_points.empty()) shape.void_cells = space.labelled();
}

namespace {

// The label of a void cell among the eight round the point whose centre is seen from it.
std::optional<int> label_near(const Shape& shape, const Vec3& point) {
    const VoidCells& grid = shape.void_cells;
    if (grid.label == nullptr) return std::nullopt;
    const Vec3 low = ((point - grid.origin) / grid.size - Vec3::Constant(0.5)).array().floor();
    for (int corner = 0; corner < 8; ++corner) {
        const std::array<int, 3> at = {static_cast<int>(low.x()) + corner % 2, static_cast<int>(low.y()) + corner / 2 % 2,
                                       static_cast<int>(low.z()) + corner / 4};
        if (std::any_of(at.begin(), at.end(), [](int i) { return i < 0 || i >= cells; })) continue;
        const auto cell =
            (static_cast<std::size_t>(at[2]) * cells + static_cast<std::size_t>(at[1])) * cells + static_cast<std::size_t>(at[0]);
        const auto label = static_cast<int>((*grid.label)[cell]);  // NOLINT(bugprone-signed-char-misuse): -1 is solid
        if (label < 0) continue;
        const Vec3 centre = grid.origin + grid.size * Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
        if (!blocked(shape.capsules, point, centre)) return label;
    }
    return std::nullopt;
}

}  // namespace

bool in_cavity(const Shape& shape, Vec3 point) {
    // A point in a corner that no lookout sees is led to wider places.
    constexpr int most_steps = 60;
    for (int step = 0; step < most_steps; ++step) {
        if (((shape.cavity_bounds.low - point).array() > 0.0).any() || ((point - shape.cavity_bounds.high).array() > 0.0).any())
            return false;
        if (const auto label = label_near(shape, point)) return *label == 1;
        if (step == 0)
            for (const auto& seed : shape.cavity_points)  // a void without a cell of its own has only these
                if (!blocked(shape.capsules, seed, point)) return true;
        const Vec3 next = wider_place(shape.capsules, point);
        if (next == point) return false;
        point = next;
    }
    return false;
}

}  // namespace porepack
