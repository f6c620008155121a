#include "pore_space/percolation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "core/error.hpp"
#include "pore_space/link_cuts.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {

bool step_in_grid(const Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step) {
    for (std::size_t a = 0; a < 3; ++a) {
        at[a] += step[a];
        if (at[a] >= 0 && at[a] < grid.cells[a]) continue;
        if (!drive.periodic[a]) return false;
        at[a] += at[a] < 0 ? grid.cells[a] : -grid.cells[a];
    }
    return true;
}

namespace {

// Pore cells of a row along x, side by side.
struct Run {
    std::int32_t first, last;
};

// Pieces of pore space as trees of runs (union-find). Each run stores how often the path to its parent passes round the box along the
// drive's axis; a piece that meets itself with a different number of turns winds round the box.
class Pieces {
public:
    explicit Pieces(std::size_t runs) : parent_(runs), turns_(runs, 0), flags_(runs, 0) { std::iota(parent_.begin(), parent_.end(), 0U); }

    static constexpr std::uint8_t inlet = 1, outlet = 2, winds = 4;

    std::uint32_t root(std::uint32_t run) {
        std::uint32_t top = run;
        std::int32_t turns = 0;
        for (; parent_[top] != top; top = parent_[top]) turns += turns_[top];
        while (parent_[run] != top && run != top) {
            const std::uint32_t next = parent_[run];
            const std::int32_t rest = turns - turns_[run];
            parent_[run] = top;
            turns_[run] = turns;
            turns = rest;
            run = next;
        }
        return top;
    }
    // A path from `one` to `other` turns `turns` times.
    void join(std::uint32_t one, std::uint32_t other, int turns) {
        const std::uint32_t a = root(one), b = root(other);
        const std::int32_t from_a = a == one ? 0 : turns_[one], from_b = b == other ? 0 : turns_[other];
        const std::int32_t difference = from_a + turns - from_b;  // turns of b relative to a
        if (a == b) {
            if (difference != 0) flags_[a] |= winds;
            return;
        }
        const bool swap = a < b;
        const std::uint32_t child = swap ? b : a, top = swap ? a : b;
        parent_[child] = top;
        turns_[child] = swap ? difference : -difference;
        flags_[top] |= flags_[child];
    }
    void mark(std::uint32_t run, std::uint8_t flag) { flags_[root(run)] |= flag; }
    [[nodiscard]] std::uint8_t flags(std::uint32_t run) { return flags_[root(run)]; }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<std::int32_t> turns_;  // of the run relative to its parent
    std::vector<std::uint8_t> flags_;
};

// The pore space, row by row, and its pieces.
class RunImage {
public:
    RunImage(const PhaseImage& image, const Drive& drive, const LinkCuts& cuts) : image_(image), drive_(drive), cuts_(cuts) {
        const std::size_t rows = image.grid.size() / nx();
        first_.reserve(rows + 1);
        for (std::size_t row = 0; row < rows; ++row) {
            first_.push_back(static_cast<std::uint32_t>(runs_.size()));
            const std::uint8_t* const phase = image.phase.data() + row * nx();
            for (std::size_t i = 0; i < nx(); ++i)
                if (phase[i] == Phase::pore) {
                    const std::size_t begin = i;
                    while (i + 1 < nx() && phase[i + 1] == Phase::pore && !cuts_.closed(row * nx() + i, {1, 0, 0})) ++i;
                    runs_.push_back({static_cast<std::int32_t>(begin), static_cast<std::int32_t>(i)});
                }
        }
        first_.push_back(static_cast<std::uint32_t>(runs_.size()));
        if (runs_.size() > std::numeric_limits<std::uint32_t>::max())
            throw UserError(fmt::format("the pores have {} pieces of rows along x, too many for this program", runs_.size()),
                            {.allowed = "4.2e9", .fix = "use a larger voxel size, or a part of the image"});
    }

    [[nodiscard]] Percolation percolation() {
        Pieces pieces(runs_.size());
        const int ny = image_.grid.cells[1], nz = image_.grid.cells[2];
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j) {
                join_within(pieces, row_of(j, k));
                if (j + 1 < ny || drive_.periodic[1])
                    join_rows(pieces, row_of(j, k), row_of((j + 1) % ny, k), {0, 1, 0}, drive_.axis == 1 && j + 1 == ny ? 1 : 0);
                if (k + 1 < nz || drive_.periodic[2])
                    join_rows(pieces, row_of(j, k), row_of(j, (k + 1) % nz), {0, 0, 1}, drive_.axis == 2 && k + 1 == nz ? 1 : 0);
            }
        Percolation result{.cells = CellSet(image_.grid)};
        for (std::size_t row = 0; row + 1 < first_.size(); ++row)
            for (std::uint32_t r = first_[row]; r < first_[row + 1]; ++r) {
                const std::uint8_t flags = pieces.flags(r);
                const bool keep =
                    drive_.by_pressure() ? (flags & Pieces::inlet) != 0 && (flags & Pieces::outlet) != 0 : (flags & Pieces::winds) != 0;
                const Run& run = runs_[r];
                if (!keep) result.isolated_cells += run.last - run.first + 1;
                if (keep) result.cells.insert_run(row * nx(), run.first, run.last);
            }
        result.cells.finish();
        return result;
    }

private:
    [[nodiscard]] std::size_t nx() const { return static_cast<std::size_t>(image_.grid.cells[0]); }
    [[nodiscard]] std::size_t row_of(int j, int k) const { return image_.grid.index(0, j, k) / nx(); }

    // Marks the ends, and joins a row with itself through a periodic face.
    void join_within(Pieces& pieces, std::size_t row) const {
        const std::uint32_t begin = first_[row], end = first_[row + 1];
        if (begin == end) return;
        const auto last_x = image_.grid.cells[0] - 1;
        if (drive_.by_pressure())
            for (std::uint32_t r = begin; r < end; ++r) {
                if (reaches_end(row, runs_[r], -1)) pieces.mark(r, Pieces::inlet);
                if (reaches_end(row, runs_[r], 1)) pieces.mark(r, Pieces::outlet);
            }
        if (drive_.periodic[0] && runs_[begin].first == 0 && runs_[end - 1].last == last_x &&
            !cuts_.closed(row * nx() + static_cast<std::size_t>(last_x), {1, 0, 0}))
            pieces.join(end - 1, begin, drive_.axis == 0 ? 1 : 0);
    }

    // A cell of the run lies at the first (side -1) or last (1) plane of the drive's axis, and no solid lies between its centre and the
    // plane.
    [[nodiscard]] bool reaches_end(std::size_t row, const Run& run, int side) const {
        const auto ny = static_cast<std::size_t>(image_.grid.cells[1]);
        const auto axis = static_cast<std::size_t>(drive_.axis);
        const int end = side < 0 ? 0 : image_.grid.cells[axis] - 1;
        std::array<int, 3> step{};
        step[axis] = side;
        if (axis == 0) return (side < 0 ? run.first : run.last) == end && !cuts_.closed(row * nx() + static_cast<std::size_t>(end), step);
        if (static_cast<int>(axis == 1 ? row % ny : row / ny) != end) return false;
        for (std::int32_t i = run.first; i <= run.last; ++i)
            if (!cuts_.closed(row * nx() + static_cast<std::size_t>(i), step)) return true;
        return false;
    }

    // Two runs are joined by any link between them that is open. `step` leads from `row` to the other.
    void join_rows(Pieces& pieces, std::size_t row, std::size_t other, const std::array<int, 3>& step, int turns) const {
        std::uint32_t a = first_[row], b = first_[other];
        while (a < first_[row + 1] && b < first_[other + 1]) {
            const std::int32_t last = std::min(runs_[a].last, runs_[b].last);
            std::int32_t i = std::max(runs_[a].first, runs_[b].first);
            while (i <= last && cuts_.closed(row * nx() + static_cast<std::size_t>(i), step)) ++i;
            if (i <= last) pieces.join(a, b, turns);
            runs_[a].last < runs_[b].last ? ++a : ++b;
        }
    }

    const PhaseImage& image_;
    Drive drive_;
    const LinkCuts& cuts_;
    std::vector<Run> runs_;
    std::vector<std::uint32_t> first_;  // first run of each row, and the end of the last
};

}  // namespace

Drive choose_drive(const Container& container, Axis direction) {
    const auto axis = static_cast<int>(direction);
    Drive drive{.axis = axis, .periodic = container.periodic()};
    if (axis != 2 && drive.by_pressure())
        throw UserError(fmt::format("flow along {0} needs a box that is periodic along {0}", name_of(direction)),
                        {.allowed = "direction z, or a periodic box"});
    return drive;
}

Percolation find_percolating_cells(const PhaseImage& image, const Drive& drive, const LinkCuts& cuts) {
    Percolation result = RunImage(image, drive, cuts).percolation();
    if (result.cells.empty())
        throw DoesNotPercolate(fmt::format("the pore space does not percolate: no path leads along {} from end to end", "xyz"[drive.axis]),
                               {.fix = "check the section and the voxel size (throats narrower than a voxel are closed)"});
    return result;
}

Percolation find_percolating_cells(const PhaseImage& image, const Drive& drive) {
    return find_percolating_cells(image, drive, {});
}

}  // namespace porepack::pore_space
