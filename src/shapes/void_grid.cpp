// Grid of void cells.
#include "shapes/void_grid.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "shapes/clearance.hpp"

namespace porepack::shapes {
namespace {

constexpr int cells = VoidCells::cells;

std::array<int, 3> place(std::size_t cell) {
    const int c = static_cast<int>(cell);
    return {c % cells, c / cells % cells, c / (cells * cells)};
}

std::optional<std::size_t> cell_at(const std::array<int, 3>& at) {
    for (const int i : at)
        if (i < 0 || i >= cells) return std::nullopt;
    return static_cast<std::size_t>((at[2] * cells + at[1]) * cells + at[0]);
}

}  // namespace

VoidGrid::VoidGrid(const std::vector<Capsule>& capsules) : capsules_(capsules) {
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

Vec3 VoidGrid::centre(std::size_t cell) const {
    const auto at = place(cell);
    return origin_ + size_ * Vec3(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5);
}

std::vector<std::size_t> VoidGrid::cells_around(const Vec3& point) const {
    std::vector<std::size_t> around;
    const Vec3 low = ((point - origin_) / size_ - Vec3::Constant(0.5)).array().floor();
    for (int corner = 0; corner < 8; ++corner)
        if (const auto cell = cell_at({static_cast<int>(low.x()) + corner % 2, static_cast<int>(low.y()) + corner / 2 % 2,
                                       static_cast<int>(low.z()) + corner / 4}))
            around.push_back(*cell);
    return around;
}

std::vector<std::size_t> VoidGrid::neighbours(std::size_t cell) const {
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

void VoidGrid::flood(std::size_t start) {
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

std::size_t VoidGrid::add_part(const Vec3& deepest) {
    deepest_.push_back(deepest);
    joined_.push_back(parts() - 1);
    return parts() - 1;
}

void VoidGrid::join(std::size_t one, std::size_t other) {
    const std::size_t p = root(one), q = root(other);
    joined_[std::max(p, q)] = std::min(p, q);
}

std::size_t VoidGrid::part_of(Vec3 point) {
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

void VoidGrid::describe(std::size_t part, Shape& shape) const {
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
        // Void farther than one cell from these points lies deeper in a wedge between two capsules.
        shape.cavity_bounds.add(point, 4.0 * size_);
        if (!seen(point)) shape.cavity_points.push_back(point);
    }
}

VoidCells VoidGrid::labelled() const {
    auto label = std::make_shared<std::vector<signed char>>(part_.size());
    for (std::size_t cell = 0; cell < part_.size(); ++cell)
        (*label)[cell] = part_[cell] < 0 ? -1 : static_cast<signed char>(is_other_part(cell, 0));
    return {.origin = origin_, .size = size_, .label = std::move(label)};
}

}  // namespace porepack::shapes
