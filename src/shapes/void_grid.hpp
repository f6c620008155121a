// The void between a grain's capsules on a grid; only for the sources of this folder.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "shapes/shape.hpp"

namespace porepack::shapes {

/// Void space as a graph: the void cells of a grid, joined where the straight line between two centres is free, so that cells
/// connected in the graph are connected in space. Others may still be joined by a throat narrower than a cell. Connected
/// cells form a part; part 0 is the outside.
class VoidGrid {
public:
    /// Keeps a reference to `capsules`.
    explicit VoidGrid(const std::vector<Capsule>& capsules);

    [[nodiscard]] const std::vector<Capsule>& capsules() const { return capsules_; }
    [[nodiscard]] std::size_t parts() const { return deepest_.size(); }
    /// The point of a part that is farthest from the surfaces, among its cells' centres.
    [[nodiscard]] const Vec3& deepest(std::size_t part) const { return deepest_[part]; }
    /// The first of the parts that `part` was joined to.
    [[nodiscard]] std::size_t root(std::size_t part) const {
        while (joined_[part] != part) part = joined_[part];
        return part;
    }
    void join(std::size_t one, std::size_t other);
    /// The part that contains a void point; a new part when none is found.
    std::size_t part_of(Vec3 point);

    /// Adds root `part` to the shape's cavities: points from which each of its cells is visible, and its bounding box.
    void describe(std::size_t part, Shape& shape) const;
    /// The cells, after all connected parts have been joined.
    [[nodiscard]] VoidCells labelled() const;

    [[nodiscard]] std::size_t size() const { return depth_.size(); }
    [[nodiscard]] double cell_size() const { return size_; }
    /// A length that reaches out of the grid from every point in it.
    [[nodiscard]] double far() const { return 4.0 * VoidCells::cells * size_; }
    /// Distance from the cell's centre to the surface; negative inside.
    [[nodiscard]] double depth(std::size_t cell) const { return depth_[cell]; }
    /// Label of a void cell; -1 in the solid.
    [[nodiscard]] int part(std::size_t cell) const { return part_[cell]; }
    [[nodiscard]] bool is_other_part(std::size_t cell, std::size_t root_part) const {
        return part_[cell] >= 0 && root(static_cast<std::size_t>(part_[cell])) != root_part;
    }
    [[nodiscard]] Vec3 centre(std::size_t cell) const;
    /// The eight cells whose centres surround the point.
    [[nodiscard]] std::vector<std::size_t> cells_around(const Vec3& point) const;
    [[nodiscard]] std::vector<std::size_t> neighbours(std::size_t cell) const;

private:
    void flood(std::size_t start);
    std::size_t add_part(const Vec3& deepest);

    const std::vector<Capsule>& capsules_;
    Vec3 origin_;
    double size_ = 0.0;
    std::vector<double> depth_;
    std::vector<int> part_;
    std::vector<Vec3> deepest_;
    std::vector<std::size_t> joined_;
};

}  // namespace porepack::shapes
