// Verlet lists. The container is divided into cells wider than any two grains in contact, so that a body's neighbours are in its own cell
// and the 26 around it. A list contains all pairs of arms with a gap below the skin; it is complete until one of the bodies has moved by
// half the skin, and only then that body searches again. The order of a list determines the order of the force sums:
// it depends on the bodies' numbers and their history, not on the threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <set>

#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

long CapsuleDem::State::cell_of(const Vec3& place) const {
    std::array<long, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        double x = place[axis] - cell_low_[axis];
        const double extent = container_.periodic()[a] ? container_.size()[axis] : 0.0;
        if (extent > 0.0) x -= extent * std::floor(x / extent);
        const double width = extent > 0.0 ? extent / static_cast<double>(cell_count_[a]) : cell_size_;
        at[a] = std::clamp(static_cast<long>(std::clamp(x / width, 0.0, 1e6)), 0L, cell_count_[a] - 1);
    }
    return at[0] + cell_count_[0] * (at[1] + cell_count_[1] * at[2]);
}

// New neighbours of the bodies that have moved far enough.
void CapsuleDem::State::search() {
    for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (bodies_[i].travelled - bodies_[i].searched_at > 0.5 * skin_) search_one(i);
}

void CapsuleDem::State::list_neighbours(std::size_t i) {
    auto& others = neighbours_[i];
    others.clear();
    for (const VerletPair& pair : verlet_lists_[i])
        if (std::find(others.begin(), others.end(), pair.other) == others.end()) others.push_back(pair.other);
    if (!faced_) return;
    for (const PiecePair& pair : piece_pairs_[i])
        if (std::find(others.begin(), others.end(), pair.other) == others.end()) others.push_back(pair.other);
}

void CapsuleDem::State::move_to_cell(std::size_t i, long cell) {
    if (cell_of_body_[i] >= 0) std::erase(cells_[static_cast<std::size_t>(cell_of_body_[i])], static_cast<std::uint32_t>(i));
    cells_[static_cast<std::size_t>(cell)].push_back(static_cast<std::uint32_t>(i));
    cell_of_body_[i] = cell;
}

void CapsuleDem::State::search_one(std::size_t i) {
    BodyState& body = bodies_[i];
    const long cell = cell_of(body.x);
    if (cell != cell_of_body_[i]) move_to_cell(i, cell);
    body.searched_at = body.travelled;
    const std::array<long, 3> at = {cell % cell_count_[0], cell / cell_count_[0] % cell_count_[1],
                                    cell / (cell_count_[0] * cell_count_[1])};
    std::array<std::set<long>, 3> around;  // a narrow periodic box has fewer than three cells
    for (std::size_t a = 0; a < 3; ++a)
        for (const long step : {-1L, 0L, 1L}) {
            long c = at[a] + step;
            if (container_.periodic()[a]) c = (c + cell_count_[a]) % cell_count_[a];
            if (c >= 0 && c < cell_count_[a]) around[a].insert(c);
        }
    for (const long z : around[2])
        for (const long y : around[1])
            for (const long x : around[0])
                for (const std::uint32_t other : cells_[static_cast<std::size_t>(x + cell_count_[0] * (y + cell_count_[1] * z))])
                    if (other != i) add_pairs(i, other);
}

// Adds the arms of two bodies that are near each other to the Verlet list, unless they are there.
void CapsuleDem::State::add_pairs(std::size_t i, std::size_t other) {
    const BodyState& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const BodyState& neighbour = bodies_[other];
    const Kind& other_kind = kinds_[neighbour.kind];
    const Vec3 shift = image_shift(neighbour.x - body.x);
    const double reach = kind.radius + other_kind.radius + skin_;
    if ((neighbour.x + shift - body.x).squaredNorm() > reach * reach) return;
    if (is_faced(i, other)) return add_piece_pairs(i, other, shift);
    const std::size_t owner = std::min<std::size_t>(i, other), second = std::max<std::size_t>(i, other);
    auto& list = verlet_lists_[owner];
    const std::size_t before = list.size();
    for (std::size_t p = 0; p < kind.arms.size(); ++p)
        for (std::size_t q = 0; q < other_kind.arms.size(); ++q) {
            const WorldArm &one = arms_[body.first_arm + p], &two = arms_[neighbour.first_arm + q];
            const Vec3 between = two.start + 0.5 * two.along + shift - one.start - 0.5 * one.along;
            const double radii = kind.arms[p].radius + other_kind.arms[q].radius;
            const double far = 0.5 * (one.along.norm() + two.along.norm()) + radii + skin_;
            if (between.squaredNorm() > far * far) continue;
            const double gap = closest_points({one.start, one.along}, {two.start + shift, two.along}).distance - radii;
            if (gap > skin_) continue;
            const auto arm = static_cast<std::uint16_t>(owner == i ? p : q), other_arm = static_cast<std::uint16_t>(owner == i ? q : p);
            const auto known = [&](const VerletPair& pair) {
                return pair.other == second && pair.arm == arm && pair.other_arm == other_arm;
            };
            if (std::any_of(list.begin(), list.end(), known)) continue;
            list.push_back({.other = static_cast<std::uint32_t>(second),
                            .arm = arm,
                            .other_arm = other_arm,
                            .out_of_reach = body.travelled + neighbour.travelled + gap,
                            .tangential_displacement = Vec3::Zero(),
                            .base_force = Vec3::Zero()});
        }
    if (list.size() > before) list_neighbours(owner);
}

}  // namespace porepack::pouring::dem
