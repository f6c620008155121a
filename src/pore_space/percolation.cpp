#include "pore_space/percolation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <stdexcept>
#include <vector>

#include "core/communicator.hpp"
#include "core/error.hpp"
#include "pore_space/link_cuts.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {

bool step_in_grid(const Grid& grid, const Drive& drive, std::array<int, 3>& at, const std::array<int, 3>& step) {
    for (std::size_t a = 0; a < 3; ++a) {
        at[a] += step[a];
        if (at[a] >= 0 && at[a] < grid.cells[a]) continue;
        if (!drive.periodic[a] || (a == 2 && grid.is_slab())) return false;
        at[a] += at[a] < 0 ? grid.cells[a] : -grid.cells[a];
    }
    return true;
}

bool through_open_end(const Grid& grid, const Drive& drive, const std::array<int, 3>& at, const std::array<int, 3>& step) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    const int end = (axis == 2 ? grid.layer(at[2]) : at[axis]) + step[axis];
    return drive.by_pressure() && (end < 0 || end >= grid.whole_cells(axis));
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
    // After root(run): how often the path from it to its root turns.
    [[nodiscard]] std::int32_t turns_to_root(std::uint32_t run) const { return parent_[run] == run ? 0 : turns_[run]; }
    void mark(std::uint32_t run, std::uint8_t flag) { flags_[root(run)] |= flag; }
    [[nodiscard]] std::uint8_t flags(std::uint32_t run) { return flags_[root(run)]; }

private:
    std::vector<std::uint32_t> parent_;
    std::vector<std::int32_t> turns_;  // of the run relative to its parent
    std::vector<std::uint8_t> flags_;
};

// A row's run, as the slab below needs it to join its own pieces with those above.
struct FaceRun {
    std::uint32_t row, piece;
    std::int32_t first, last, turns;  // of the run relative to its piece's root
};
// A piece of this slab is the same as a piece of the slab above, which turns this often relative to it.
struct Joint {
    std::uint32_t here, above;
    std::int32_t turns;
    auto operator<=>(const Joint&) const = default;
};
// A piece that reaches a face of its slab.
struct FacePiece {
    std::uint32_t piece, flags;
    auto operator<=>(const FacePiece&) const = default;
};

template <typename T>
void sort_unique(std::vector<T>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
}

// The pore space, row by row, and its pieces; of a slab without its halo.
class RunImage {
public:
    RunImage(const PhaseImage& image, const Drive& drive, const LinkCuts& cuts)
        : grid_(image.grid.without_halo()), drive_(drive), cuts_(cuts) {
        const std::size_t rows = grid_.size() / nx();
        const std::uint8_t* const phases = image.phase.data() + image.grid.index(0, 0, image.grid.slab.halo[0]);
        first_.reserve(rows + 1);
        for (std::size_t row = 0; row < rows; ++row) {
            first_.push_back(static_cast<std::uint32_t>(runs_.size()));
            const std::uint8_t* const phase = phases + row * nx();
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

    [[nodiscard]] Percolation percolation(const Communicator& parts) {
        Pieces pieces(runs_.size());
        const int ny = grid_.cells[1], nz = grid_.cells[2];
        const bool wraps_z = drive_.periodic[2] && !grid_.is_slab();
        for (int k = 0; k < nz; ++k)
            for (int j = 0; j < ny; ++j) {
                join_within(pieces, row_of(j, k));
                if (j + 1 < ny || drive_.periodic[1])
                    join_rows(row_of(j, k), row_of((j + 1) % ny, k), {0, 1, 0}, pieces, drive_.axis == 1 && j + 1 == ny ? 1 : 0);
                if (k + 1 < nz || wraps_z)
                    join_rows(row_of(j, k), row_of(j, (k + 1) % nz), {0, 0, 1}, pieces, drive_.axis == 2 && k + 1 == nz ? 1 : 0);
            }
        if (grid_.is_slab()) join_slabs(pieces, parts);
        Percolation result{.cells = CellSet(grid_)};
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
    [[nodiscard]] std::size_t nx() const { return static_cast<std::size_t>(grid_.cells[0]); }
    [[nodiscard]] std::size_t row_of(int j, int k) const { return grid_.index(0, j, k) / nx(); }

    // Marks the ends, and joins a row with itself through a periodic face.
    void join_within(Pieces& pieces, std::size_t row) const {
        const std::uint32_t begin = first_[row], end = first_[row + 1];
        if (begin == end) return;
        const auto last_x = grid_.cells[0] - 1;
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
        const auto ny = static_cast<std::size_t>(grid_.cells[1]);
        const auto axis = static_cast<std::size_t>(drive_.axis);
        const int end = side < 0 ? 0 : grid_.whole_cells(axis) - 1;
        std::array<int, 3> step{};
        step[axis] = side;
        if (axis == 0) return (side < 0 ? run.first : run.last) == end && !cuts_.closed(row * nx() + static_cast<std::size_t>(end), step);
        if ((axis == 1 ? static_cast<int>(row % ny) : grid_.layer(static_cast<int>(row / ny))) != end) return false;
        for (std::int32_t i = run.first; i <= run.last; ++i)
            if (!cuts_.closed(row * nx() + static_cast<std::size_t>(i), step)) return true;
        return false;
    }

    // Calls joined(a, b) for the runs a of `row` and b of `others` between which a link along `step` is open.
    template <typename Runs, typename Joined>
    void for_joints(std::size_t row, const Runs& others, const std::array<int, 3>& step, const Joined& joined) const {
        auto a = runs_.begin() + first_[row], end = runs_.begin() + first_[row + 1];
        auto b = others.begin();
        while (a != end && b != others.end()) {
            const std::int32_t last = std::min(a->last, b->last);
            std::int32_t i = std::max(a->first, b->first);
            while (i <= last && cuts_.closed(row * nx() + static_cast<std::size_t>(i), step)) ++i;
            if (i <= last) joined(static_cast<std::uint32_t>(a - runs_.begin()), b);
            if (a->last < b->last)
                ++a;
            else
                ++b;
        }
    }

    // Two runs are joined by any link between them that is open. `step` leads from `row` to the other.
    void join_rows(std::size_t row, std::size_t other, const std::array<int, 3>& step, Pieces& pieces, int turns) const {
        const std::span<const Run> others(runs_.data() + first_[other], runs_.data() + first_[other + 1]);
        for_joints(row, others, step,
                   [&](std::uint32_t a, auto b) { pieces.join(a, static_cast<std::uint32_t>(&*b - runs_.data()), turns); });
    }

    // The runs of the first layer, with their pieces.
    [[nodiscard]] std::vector<FaceRun> first_layer(Pieces& pieces) const {
        std::vector<FaceRun> runs;
        for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(grid_.cells[1]); ++row)
            for (std::uint32_t r = first_[row]; r < first_[row + 1]; ++r) {
                const std::uint32_t piece = pieces.root(r);
                runs.push_back({row, piece, runs_[r].first, runs_[r].last, pieces.turns_to_root(r)});
            }
        return runs;
    }

    // Where this slab's last layer meets the first one of the slab above.
    [[nodiscard]] std::vector<Joint> joints_with(const std::vector<FaceRun>& above, Pieces& pieces) const {
        const int last = grid_.cells[2] - 1, turns = drive_.axis == 2 && grid_.layer(last) == grid_.whole_cells(2) - 1 ? 1 : 0;
        std::vector<Joint> joints;
        auto begin = above.begin();
        for (int j = 0; j < grid_.cells[1]; ++j) {
            const auto end = std::find_if(begin, above.end(), [&](const FaceRun& run) { return static_cast<int>(run.row) != j; });
            for_joints(row_of(j, last), std::span(begin, end), {0, 0, 1}, [&](std::uint32_t a, auto b) {
                const std::uint32_t piece = pieces.root(a);
                joints.push_back({piece, b->piece, pieces.turns_to_root(a) + turns - b->turns});
            });
            begin = end;
        }
        sort_unique(joints);
        return joints;
    }

    // Each slab knows its own pieces; all slabs join the pieces that reach a face in the same manner, and keep what concerns them.
    void join_slabs(Pieces& pieces, const Communicator& parts) const {
        const std::vector<FaceRun> own_first = first_layer(pieces);
        const std::vector<FaceRun> above = exchange_lists<FaceRun>(parts, {own_first, {}})[1];
        const bool more_above = grid_.layer(grid_.cells[2] - 1) + 1 < grid_.whole_cells(2) || drive_.periodic[2];
        const std::vector<Joint> joints = more_above ? joints_with(above, pieces) : std::vector<Joint>();
        std::vector<FacePiece> faces;
        const auto add_face = [&](std::uint32_t piece) { faces.push_back({piece, pieces.flags(piece)}); };
        for (const FaceRun& run : own_first) add_face(run.piece);
        for (const Joint& joint : joints) add_face(joint.here);
        sort_unique(faces);

        const std::vector<Bytes> all_faces = parts.gather(bytes_of(faces)), all_joints = parts.gather(bytes_of(joints));
        std::vector<std::vector<FacePiece>> faces_of;
        std::vector<std::uint32_t> first_of = {0};
        for (const Bytes& bytes : all_faces) {
            faces_of.push_back(list_of<FacePiece>(bytes));
            first_of.push_back(first_of.back() + static_cast<std::uint32_t>(faces_of.back().size()));
        }
        const auto number_of = [&](std::size_t slab, std::uint32_t piece) {
            const auto& list = faces_of[slab];
            const auto at =
                std::lower_bound(list.begin(), list.end(), piece, [](const FacePiece& face, std::uint32_t p) { return face.piece < p; });
            return first_of[slab] + static_cast<std::uint32_t>(at - list.begin());
        };
        Pieces merged(first_of.back());
        for (std::size_t slab = 0; slab < faces_of.size(); ++slab)
            for (const FacePiece& face : faces_of[slab]) merged.mark(number_of(slab, face.piece), static_cast<std::uint8_t>(face.flags));
        for (std::size_t slab = 0; slab < faces_of.size(); ++slab)
            for (const Joint& joint : list_of<Joint>(all_joints[slab]))
                merged.join(number_of(slab, joint.here), number_of((slab + 1) % faces_of.size(), joint.above), joint.turns);
        const auto own = static_cast<std::size_t>(parts.part());
        for (const FacePiece& face : faces) pieces.mark(face.piece, merged.flags(number_of(own, face.piece)));
    }

    Grid grid_;
    Drive drive_;
    const LinkCuts& cuts_;
    std::vector<Run> runs_;
    std::vector<std::uint32_t> first_;  // first run of each row, and the end of the last
};

// The cells of the slabs below and above that lie next to this one.
std::array<CellSet, 2> cells_beyond(const CellSet& cells, const Grid& grid, const std::array<int, 2>& halo, const Communicator& parts) {
    Grid layer = grid;
    layer.cells[2] = 1;
    const auto copy_of = [&](int k) {
        CellSet copy(layer);
        for (std::size_t cell = 0; cell < layer.size(); ++cell)
            if (cells.contains(grid.index(0, 0, k) + cell)) copy.insert_run(cell, 0, 0);
        return std::vector<std::uint64_t>(copy.words().begin(), copy.words().end());
    };
    std::array<CellSet, 2> beyond;
    const auto words = exchange_lists<std::uint64_t>(parts, {copy_of(0), copy_of(grid.cells[2] - 1)});
    for (std::size_t side = 0; side < 2; ++side)
        if (halo[side] > 0) beyond[side] = CellSet(layer, words[side]);
    return beyond;
}

}  // namespace

Drive choose_drive(const Container& container, Axis direction) {
    const auto axis = static_cast<int>(direction);
    Drive drive{.axis = axis, .periodic = container.periodic()};
    if (axis != 2 && drive.by_pressure())
        throw UserError(fmt::format("flow along {0} needs a box that is periodic along {0}", name_of(direction)),
                        {.allowed = "direction z, or a periodic box"});
    return drive;
}

Percolation find_percolating_cells(const PhaseImage& image, const Drive& drive, const LinkCuts& cuts, const Communicator& parts) {
    if (image.grid.is_slab() != (parts.parts() > 1)) throw std::logic_error("each slab of a grid needs the communicator of all slabs");
    Percolation result = RunImage(image, drive, cuts).percolation(parts);
    std::array<std::int64_t, 2> all{};
    const std::array<std::int64_t, 2> own = {result.cells.size(), result.isolated_cells};
    for (const Bytes& bytes : parts.gather(std::as_bytes(std::span(own)))) {
        const auto counts = list_of<std::int64_t>(bytes);
        for (std::size_t i = 0; i < all.size(); ++i) all[i] += counts[i];
    }
    result.all_cells = all[0];
    result.isolated_cells = all[1];
    if (result.all_cells == 0)
        throw DoesNotPercolate(fmt::format("the pore space does not percolate: no path leads along {} from end to end", "xyz"[drive.axis]),
                               {.fix = "check the section and the voxel size (throats narrower than a voxel are closed)"});
    if (image.grid.is_slab()) result.beyond = cells_beyond(result.cells, image.grid.without_halo(), image.grid.slab.halo, parts);
    return result;
}

Percolation find_percolating_cells(const PhaseImage& image, const Drive& drive) {
    return find_percolating_cells(image, drive, {});
}

}  // namespace porepack::pore_space
