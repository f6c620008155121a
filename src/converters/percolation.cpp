#include "converters/percolation.hpp"

#include <fmt/format.h>

#include <limits>

#include "core/error.hpp"

namespace porepack {

bool step_in_grid(const Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step, int& turns) {
    for (std::size_t a = 0; a < 3; ++a) {
        at[a] += step[a];
        if (at[a] >= 0 && at[a] < grid.cells[a]) continue;
        if (!drive.periodic[a]) return false;
        if (static_cast<int>(a) == drive.axis) turns += at[a] < 0 ? -1 : 1;
        at[a] += at[a] < 0 ? grid.cells[a] : -grid.cells[a];
    }
    return true;
}

std::array<int, 3> place_in_grid(const Grid& grid, std::size_t cell) {
    const auto nx = static_cast<std::size_t>(grid.cells[0]), ny = static_cast<std::size_t>(grid.cells[1]);
    return {static_cast<int>(cell % nx), static_cast<int>(cell / nx % ny), static_cast<int>(cell / (nx * ny))};
}

namespace {

constexpr std::int32_t unseen = std::numeric_limits<std::int32_t>::min();
constexpr std::array<std::array<int, 3>, 6> faces = {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

// One connected piece of the pore space, found from `start`; marks its cells in `turn_at` with the number of turns round
// the box. It carries flow when it touches both ends, or meets itself after a turn.
bool explore(const PhaseImage& image, const Drive& drive, std::size_t start, std::vector<std::int32_t>& turn_at,
             std::vector<std::size_t>& members) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    bool inlet = false, outlet = false, winds = false;
    members.assign(1, start);
    turn_at[start] = 0;
    for (std::size_t next = 0; next < members.size(); ++next) {
        const std::size_t cell = members[next];
        const auto here = place_in_grid(image.grid, cell);
        inlet = inlet || here[axis] == 0;
        outlet = outlet || here[axis] == image.grid.cells[axis] - 1;
        for (int q = 0; q < 6; ++q) {
            auto there = here;
            int turns = turn_at[cell];
            if (!step_in_grid(image.grid, drive, there, faces[static_cast<std::size_t>(q)], turns)) continue;
            const std::size_t other = image.grid.index(there[0], there[1], there[2]);
            if (image.phase[other] != pore) continue;
            if (turn_at[other] == unseen) {
                turn_at[other] = turns;
                members.push_back(other);
            } else if (turn_at[other] != turns) {
                winds = true;
            }
        }
    }
    return drive.by_pressure() ? inlet && outlet : winds;
}

}  // namespace

Drive choose_drive(const Container& container, const std::string& direction) {
    const int axis = direction == "x" ? 0 : direction == "y" ? 1 : 2;
    Drive drive{.axis = axis, .periodic = container.periodic};
    if (axis != 2 && drive.by_pressure())
        throw UserError("flow along " + direction + " needs a box that is periodic along " + direction,
                        {.allowed = "direction z, or a periodic box"});
    return drive;
}

Percolation find_percolating_cells(const PhaseImage& image, const Drive& drive) {
    Percolation result{.keep = std::vector<std::uint8_t>(image.grid.size(), 0)};
    std::vector<std::int32_t> turn_at(image.grid.size(), unseen);
    std::vector<std::size_t> members;
    std::int64_t kept = 0;
    for (std::size_t cell = 0; cell < image.grid.size(); ++cell) {
        if (image.phase[cell] != pore || turn_at[cell] != unseen) continue;
        if (explore(image, drive, cell, turn_at, members)) {
            for (const std::size_t member : members) result.keep[member] = 1;
            kept += static_cast<std::int64_t>(members.size());
        } else {
            result.isolated_cells += static_cast<std::int64_t>(members.size());
        }
    }
    if (kept == 0)
        throw NumericalError(fmt::format("the pore space does not percolate: no path leads along {} from end to end", "xyz"[drive.axis]),
                             {.mend = "check the section and the voxel size (throats narrower than a voxel are closed)"});
    return result;
}

}  // namespace porepack
