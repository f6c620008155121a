// The scheme of Ng, Min & Gibou, J. Comput. Phys. 228 (2009) 8807: the flux through a face is its open area times the difference of the
// values at the two cell centres, where a centre may lie in the solid. It is second order, and its matrix has the form of that of whole
// voxels. Faces are divided into squares. Where their sides meet the wall is exact; within a square the wall is straight.
//
// A cell has one value. If thin solid divides a cell, its two parts would exchange what the solid separates. Between pore centres closed
// links prevent that. A solid centre conducts only beside a cell without any open face: a plate in which such a cell fits is so thick that
// no cell reaches both of its sides.
#include "tortuosity/cut_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/parallel.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {
namespace {

using Place = std::array<int, 3>;
using shapes::Vec3;

constexpr int squares = 4;  // per side of a face

// Open area of a unit square, of which the wall cuts off corners: `open` at the corners, and the open parts of its sides. Corners and sides
// go round: side s lies between the corners s and s + 1.
double open_area(const std::array<bool, 4>& open, const std::array<double, 4>& side) {
    const int count = open[0] + open[1] + open[2] + open[3];
    if (count == 0 || count == 4) return count / 4.0;
    double area = 0.0;
    if (count == 2 && open[0] != open[2]) {  // two neighbours
        const int across = open[0] == open[1] ? 1 : 0;
        return 0.5 * (side[static_cast<std::size_t>(across)] + side[static_cast<std::size_t>(across + 2)]);
    }
    // Single corners of one kind, two of them if they are opposite.
    for (std::size_t c = 0; c < 4; ++c) {
        const double one = side[c], other = side[(c + 3) % 4];
        if (open[c] && count < 3) area += 0.5 * one * other;
        if (!open[c] && count == 3) area = 1.0 - 0.5 * (1.0 - one) * (1.0 - other);
    }
    return area;
}

// Points at the corners of the squares in one row of cells along x: whether they are open, and how much of the way to the point above.
class CornerRow {
public:
    CornerRow(const FlowWalls& walls, const Grid& grid, const std::array<bool, 3>& periodic)
        : walls_(walls),
          grid_(grid),
          periodic_(periodic),
          columns_(grid.cells[0] * squares + 1),
          heights_(grid.cells[2] * squares + 1),
          open_(static_cast<std::size_t>(columns_) * (squares + 1) * static_cast<std::size_t>(heights_)),
          above_(open_.size()),
          probe_(walls.solid.probe()) {}

    // Rows in ascending order share the lines between them.
    void move_to(int j) {
        const bool next = row_ >= 0 && j == row_ + 1;
        row_ = j;
        if (next) {
            const auto line = static_cast<std::ptrdiff_t>(index({0, 1, 0}));
            std::copy(open_.end() - line, open_.end(), open_.begin());
            std::copy(above_.end() - line, above_.end(), above_.begin());
        }
        for (int y = next ? 1 : 0; y <= squares; ++y)
            for (int x = 0; x < columns_; ++x) fill_line(x, y);
    }
    // Open fraction of the face across `axis` whose lowest corner is this one; corners are numbered in the row.
    double face(const Place& corner, std::size_t axis) {
        const std::size_t u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
        const bool first = open(corner);
        bool same = true;
        for (int q = 0; q <= squares && same; ++q)
            for (int p = 0; p <= squares && same; ++p) same = open(moved(corner, u, p, v, q)) == first;
        if (same) return first ? 1.0 : 0.0;
        probe_->move_to(point(moved(corner, u, squares / 2, v, squares / 2)), 1.001 * grid_.spacing_m[0]);
        double area = 0.0;
        for (int q = 0; q < squares; ++q)
            for (int p = 0; p < squares; ++p) area += square(moved(corner, u, p, v, q), u, v);
        return area / (squares * squares);
    }

private:
    [[nodiscard]] static Place moved(Place corner, std::size_t u, int p, std::size_t v, int q) {
        corner[u] += p;
        corner[v] += q;
        return corner;
    }
    [[nodiscard]] std::size_t index(const Place& corner) const {
        return (static_cast<std::size_t>(corner[1]) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(corner[0])) *
                   static_cast<std::size_t>(heights_) +
               static_cast<std::size_t>(corner[2]);
    }
    [[nodiscard]] bool open(const Place& corner) const { return open_[index(corner)] != 0; }
    [[nodiscard]] Vec3 point(const Place& corner) const {
        const Place number = {corner[0], row_ * squares + corner[1], corner[2]};
        Vec3 at;
        for (std::size_t a = 0; a < 3; ++a) at[static_cast<int>(a)] = grid_.origin_m[a] + grid_.spacing_m[a] / squares * number[a];
        return at;
    }
    // The points at a periodic end are the first ones: rounding must not put them outside the container.
    [[nodiscard]] double along_side(std::size_t axis, double at) const {
        const double length = grid_.cells[axis] * grid_.spacing_m[axis];
        return periodic_[axis] && at > grid_.origin_m[axis] + (1.0 - 1e-9) * length ? grid_.origin_m[axis] : at;
    }
    void fill_line(int x, int y) {
        const std::size_t first = index({x, y, 0}), last = first + static_cast<std::size_t>(heights_);
        const auto line = [&](auto& values) {
            return std::pair(values.begin() + static_cast<std::ptrdiff_t>(first), values.begin() + static_cast<std::ptrdiff_t>(last));
        };
        const Vec3 lowest = point({x, y, 0});
        const double px = along_side(0, lowest.x()), py = along_side(1, lowest.y());
        walls_.container.vessel().column(px, py, inside_);
        const auto [open_begin, open_end] = line(open_);
        const auto [above_begin, above_end] = line(above_);
        std::fill(open_begin, open_end, inside_.empty() ? 0 : 1);
        std::fill(above_begin, above_end, inside_.empty() ? 0.0F : 1.0F);
        if (inside_.empty()) return;
        const double step = grid_.spacing_m[2] / squares;
        const auto close = [&](double low, double high) {
            const double from = std::max(-1.0, (low - grid_.origin_m[2]) / step),
                         to = std::min(heights_ + 0.0, (high - grid_.origin_m[2]) / step);
            for (int k = std::max(0, static_cast<int>(std::ceil(from))); k <= std::min<double>(heights_ - 1, to); ++k) open_begin[k] = 0;
            for (int k = std::max(0, static_cast<int>(std::floor(from))); k < std::min<double>(heights_ - 1, to); ++k)
                above_begin[k] -= static_cast<float>(std::max(0.0, std::min(to, k + 1.0) - std::max(from, k + 0.0)));
        };
        walls_.solid.column(px, py, parts_);
        constexpr double endless = std::numeric_limits<double>::infinity();
        if (!is_whole_line(inside_)) intersect(parts_, inside_);
        for (const Interval& part : parts_) close(std::max(part.low, walls_.section.z0_m), std::min(part.high, walls_.section.z1_m));
        // What lies between the sides' intervals is outside the vessel.
        double end = -endless;
        for (const Interval& part : inside_) {
            if (part.low > end) close(end, part.low);
            end = part.high;
        }
        if (end < endless) close(end, endless);
    }
    double square(const Place& corner, std::size_t u, std::size_t v) {
        const std::array<Place, 4> corners = {corner, moved(corner, u, 1, v, 0), moved(corner, u, 1, v, 1), moved(corner, u, 0, v, 1)};
        std::array<bool, 4> are_open{};
        for (std::size_t c = 0; c < 4; ++c) are_open[c] = open(corners[c]);
        return open_area(are_open, {side(corners[0], corners[1], u), side(corners[1], corners[2], v), side(corners[3], corners[2], u),
                                    side(corners[0], corners[3], v)});
    }
    // Open fraction of the side between two neighbouring corners, the lower one first.
    double side(const Place& low, const Place& high, std::size_t along) {
        const bool from_low = open(low);
        if (from_low == open(high)) return from_low ? 1.0 : 0.0;
        if (along == 2) return std::clamp(static_cast<double>(above_[index(low)]), 0.0, 1.0);
        const Vec3 from = point(from_low ? low : high);
        Vec3 step = Vec3::Zero();
        step[static_cast<int>(along)] = (from_low ? 1.0 : -1.0) * grid_.spacing_m[along] / squares;
        double open = 1.0;
        if (const auto hit = probe_->first_hit(from, step)) open = *hit;
        if (const auto wall = walls_.container.vessel().first_hit(from, step)) open = std::min(open, *wall);
        return open;
    }

    const FlowWalls& walls_;
    const Grid& grid_;
    std::array<bool, 3> periodic_;
    int columns_, heights_, row_ = -1;
    std::vector<std::uint8_t> open_;
    std::vector<float> above_;
    std::vector<Interval> inside_, parts_;
    std::unique_ptr<geometry::SolidProbe> probe_;
};

// Rounding leaves tiny open fractions of closed faces.
float open_fraction(double found) {
    constexpr double minimum = 1e-6;
    return found < minimum ? 0.0F : static_cast<float>(std::min(found, 1.0));
}

// Open fractions of the faces of one row of cells.
void fill_row(ConductanceGrid& grid, const Grid& cells, CornerRow& corners, int j) {
    for (int k = 0; k < cells.cells[2]; ++k)
        for (int i = 0; i < cells.cells[0]; ++i) {
            const Place at{i, j, k};
            const std::size_t cell = cells.index(i, j, k);
            for (std::size_t a = 0; a < 3; ++a) {
                const bool last = at[a] + 1 == grid.n[a], planes = a == grid.axis && !grid.periodic[a];
                const Place low{i * squares, 0, k * squares};
                Place high = low;
                high[a] += squares;
                if (planes && at[a] == 0) grid.plane[0][grid.plane_index(at)] = open_fraction(corners.face(low, a));
                if (planes && last) grid.plane[1][grid.plane_index(at)] = open_fraction(corners.face(high, a));
                if (!last || grid.periodic[a]) grid.face[a][cell] = open_fraction(corners.face(high, a));
            }
        }
}

void fill_faces(ConductanceGrid& grid, const Grid& cells, const FlowWalls& walls) {
    constexpr int rows = 16;  // of a strip
    const int strips = (cells.cells[1] + rows - 1) / rows;
    parallel_for(static_cast<std::size_t>(strips), [&](std::size_t strip) {
        CornerRow corners(walls, cells, grid.periodic);
        const int first = static_cast<int>(strip) * rows;
        for (int j = first; j < std::min(first + rows, cells.cells[1]); ++j) {
            corners.move_to(j);
            fill_row(grid, cells, corners, j);
        }
    });
}

// visit(face's conductance, cell beyond it or nothing) for the faces of a cell.
template <typename Visit>
void for_faces(const ConductanceGrid& grid, std::size_t i, const Visit& visit) {
    const Place at = grid.place(i);
    const auto stride = grid.strides();
    for (std::size_t a = 0; a < 3; ++a) {
        if (grid.n[a] == 1) continue;
        const std::size_t around = stride[a] * static_cast<std::size_t>(grid.n[a] - 1);
        const bool first = at[a] == 0, last = at[a] + 1 == grid.n[a];
        if (!last || grid.periodic[a]) visit(grid.face[a][i], last ? i - around : i + stride[a]);
        if (first && !grid.periodic[a]) continue;
        const std::size_t before = first ? i + around : i - stride[a];
        visit(grid.face[a][before], before);
    }
}

enum Role : std::uint8_t {
    closed,
    whole_solid,  // no open face
    thick_solid,  // the centre is solid, a face is open
    thin_solid,   // the same, where no cell beside it is whole solid
    pore,         // or beyond the container, with an open face
    conducting
};

bool beside_whole_solid(const std::vector<std::uint8_t>& roles, const PhaseImage& image, const Drive& drive, std::size_t cell) {
    for (int z = -1; z <= 1; ++z)
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) {
                Place at = image.grid.place(cell);
                if (step_in_grid(image.grid, drive, at, {x, y, z}) && roles[image.grid.index(at[0], at[1], at[2])] == Role::whole_solid)
                    return true;
            }
    return false;
}

std::vector<std::uint8_t> roles_of(const ConductanceGrid& grid, const PhaseImage& image, const Drive& drive) {
    std::vector<std::uint8_t> first(grid.size(), Role::closed);
    for_cells(grid, [&](std::size_t i) {
        bool open = false;
        for_faces(grid, i, [&](float g, std::size_t) { open = open || g > 0.0F; });
        if (image.phase[i] == Phase::grain)
            first[i] = open ? Role::thick_solid : Role::whole_solid;
        else if (open)
            first[i] = Role::pore;
    });
    std::vector<std::uint8_t> roles = first;
    for_cells(grid, [&](std::size_t i) {
        if (first[i] == Role::thick_solid && !beside_whole_solid(first, image, drive, i)) roles[i] = Role::thin_solid;
    });
    return roles;
}

// A closed face for each closed link of two pore centres, except where the solid between them is the round side of a thick grain. Returns
// the number of cells with such a face.
double close_links(ConductanceGrid& grid, const PhaseImage& image, const LinkCuts& cuts, const std::vector<std::uint8_t>& roles,
                   const Drive& drive) {
    if (cuts.empty()) return 0.0;
    return sum_over(grid, [&](std::size_t i) {
        if (image.phase[i] != Phase::pore || !cuts.at(i) || beside_whole_solid(roles, image, drive, i)) return 0.0;
        const Place at = grid.place(i);
        for (std::size_t a = 0; a < 3; ++a) {
            Place up{}, down{};
            up[a] = 1;
            down[a] = -1;
            if (cuts.closed(i, up)) grid.face[a][i] = 0.0F;
            if (a != grid.axis || grid.periodic[a]) continue;
            if (at[a] == 0 && cuts.closed(i, down)) grid.plane[0][grid.plane_index(at)] = 0.0F;
            if (at[a] + 1 == grid.n[a] && cuts.closed(i, up)) grid.plane[1][grid.plane_index(at)] = 0.0F;
        }
        return 1.0;
    });
}

// Cells that hang together with percolating pores.
void spread(std::vector<std::uint8_t>& roles, const ConductanceGrid& grid, const Percolation& percolation) {
    std::vector<std::size_t> front;
    percolation.cells.for_each([&](std::size_t i) {
        roles[i] = Role::conducting;
        front.push_back(i);
    });
    while (!front.empty()) {
        const std::size_t i = front.back();
        front.pop_back();
        for_faces(grid, i, [&](float g, std::size_t other) {
            if (g == 0.0F || (roles[other] != Role::pore && roles[other] != Role::thick_solid)) return;
            roles[other] = Role::conducting;
            front.push_back(other);
        });
    }
}

void keep_conducting(ConductanceGrid& grid, const std::vector<std::uint8_t>& roles) {
    const auto stride = grid.strides();
    for_cells(grid, [&](std::size_t i) {
        const Place at = grid.place(i);
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t around = stride[a] * static_cast<std::size_t>(grid.n[a] - 1);
            const bool last = at[a] + 1 == grid.n[a];
            if (grid.n[a] == 1 || roles[i] != Role::conducting || (last && !grid.periodic[a]) ||
                roles[last ? i - around : i + stride[a]] != Role::conducting)
                grid.face[a][i] = 0.0F;
        }
        for (std::size_t end = 0; end < 2; ++end)
            if (!grid.plane[end].empty() && at[grid.axis] == (end == 0 ? 0 : grid.n[grid.axis] - 1) && roles[i] != Role::conducting)
                grid.plane[end][grid.plane_index(at)] = 0.0F;
    });
}

}  // namespace

CutCells cut_cells(const PhaseImage& image, const Percolation& percolation, const LinkCuts& cuts, const FlowWalls& walls,
                   const Drive& drive) {
    CutCells cells{.grid = {.n = image.grid.cells, .periodic = drive.periodic, .axis = static_cast<std::size_t>(drive.axis)}};
    ConductanceGrid& grid = cells.grid;
    grid.allocate();
    fill_faces(grid, image.grid, walls);
    std::vector<std::uint8_t> roles = roles_of(grid, image, drive);
    const double closed = close_links(grid, image, cuts, roles, drive);
    const auto count = [&](std::uint8_t role) { return static_cast<double>(std::count(roles.begin(), roles.end(), role)); };
    const double thin = closed + count(Role::thin_solid);
    cells.thin_solid = thin / std::max(1.0, thin + count(Role::thick_solid));
    spread(roles, grid, percolation);
    keep_conducting(grid, roles);
    for (auto& plane : grid.plane)
        for (float& conductance : plane) conductance *= 2.0F;  // half a cell away
    return cells;
}

}  // namespace porepack::tortuosity
