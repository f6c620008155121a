#include "pore_space/walls.hpp"
#include "pore_space/uses.hpp"

#include <algorithm>

namespace porepack::pore_space {

WallFinder::WallFinder(const FlowWalls& walls, const Grid& grid, const Drive& drive)
    : walls_(walls), drive_(drive), reach_(1.001 * std::ranges::max(grid.spacing_m)), probe_(walls.solid.probe()) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    end_low_ = grid.origin_m[axis];
    end_high_ = grid.origin_m[axis] + grid.whole_cells(axis) * grid.spacing_m[axis];
}

void WallFinder::move_to(const Vec3& centre) {
    centre_ = centre;
    probe_->move_to(centre, reach_);
}

// The container's side, or the solid between the section's planes; a plane that cuts a grain is a wall there.
std::optional<double> WallFinder::straight(const Vec3& from, const Vec3& step) const {
    std::optional<double> first = walls_.container.vessel().first_hit(from, step);
    const Section& section = walls_.section;
    double enter = 0.0, leave = 1.0;
    if (walls_.container.periodic()[2]) {
        // No planes.
    } else if (step.z() != 0.0) {
        const double a = (section.z0_m - from.z()) / step.z(), b = (section.z1_m - from.z()) / step.z();
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    } else if (from.z() < section.z0_m || from.z() > section.z1_m) {
        return first;
    }
    if (enter > leave) return first;
    const Vec3 entry = from + enter * step;
    std::optional<double> hit;
    if (enter > 0.0 && walls_.solid.contains(entry))
        hit = enter;
    else if (const auto part = probe_->first_hit(entry, (1.0 - enter) * step))
        hit = enter + *part * (1.0 - enter);
    if (hit && *hit <= leave + 1e-9 && (!first || *hit < *first)) first = hit;
    return first;
}

bool WallFinder::closes_first_half(const Vec3& step) const {
    constexpr double half = 0.5 * (1.0 + 1e-9);
    return straight(centre_, half * step).has_value();
}

std::optional<double> WallFinder::fraction(const Vec3& step) const {
    const double end = centre_[drive_.axis] + step[drive_.axis];
    if (!drive_.by_pressure() || (end > end_low_ && end < end_high_)) return straight(centre_, step);
    // Through an open end: the second half of the segment lies in the mirror image.
    const double half = 0.5;
    if (const auto before = straight(centre_, half * step)) return half * *before;
    Vec3 back = half * step;
    back[drive_.axis] *= -1.0;
    const auto after = straight(centre_ + half * step, back);
    return after ? std::optional(half + half * *after) : std::nullopt;
}

}  // namespace porepack::pore_space
