#include "pore_space/voxels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

// Cubic voxels of a box whose axes are stretched; its volume stays. Sides that are not periodic stay as they are.
struct PeriodicFit {
    double voxel_size_m = 0.0;
    Vec3 stretch = Vec3::Ones();
    [[nodiscard]] double strain() const { return (stretch.array() - 1.0).abs().maxCoeff(); }
};

// Voxel sizes over the asked one.
struct Near {
    double low, high;
    [[nodiscard]] bool contains(double size, double asked) const { return size > low * asked && size < high * asked; }
};
constexpr Near near_asked{0.65, 1.55}, very_near{0.85, 1.18};

// The periodic sides of a box as numbers of voxels. A size that divides all sides is used wherever it is near the asked one.
class PeriodicSides {
public:
    PeriodicSides(const Container& container, const Near& near) : size_(container.high() - container.low()), near_(near) {
        for (const int axis : {0, 1, 2})
            if (container.periodic()[static_cast<std::size_t>(axis)]) axes_.push_back(axis);
        for (const int axis : axes_) smallest_ = std::min(smallest_, size_[axis]);
    }

    // Without a size that divides all sides, each is rounded to its own number of voxels: one per cent of stretch counts as much as 20 % of
    // the size. The fit of the size that is returned is this size again: each candidate costs its distance from the asked size and a part
    // that does not depend on it, and a size near one that divides all sides is no candidate. It can be far from `asked` if that is so
    // large that the candidates near it would stretch the box by more than 3 %.
    [[nodiscard]] PeriodicFit fit(double asked) const {
        if (const auto size = divisor(asked)) return {.voxel_size_m = *size};
        constexpr double largest_strain = 0.03, cost_of_strain = 20.0, cost_of_divisor = 1.0;
        const double count = count_of(asked);
        PeriodicFit best;
        double minimum = std::numeric_limits<double>::infinity();
        for (double apart = 0.0; std::log1p(apart / count) - largest_strain < minimum; ++apart)
            for (const double n : {count + apart, count - apart}) {
                if (n < 1.0) continue;
                const bool divides = are_whole(smallest_ / n);
                const PeriodicFit fit = divides ? PeriodicFit{.voxel_size_m = smallest_ / n} : rounded(n);
                const double cost =
                    std::abs(std::log(fit.voxel_size_m / asked)) + (divides ? cost_of_divisor : cost_of_strain * fit.strain());
                if (cost >= minimum || fit.strain() > largest_strain || (!divides && divisor(fit.voxel_size_m))) continue;
                minimum = cost;
                best = fit;
            }
        return best;
    }

private:
    [[nodiscard]] double count_of(double h) const { return std::max(1.0, std::round(smallest_ / h)); }
    [[nodiscard]] bool are_whole(double h) const {
        return std::all_of(axes_.begin(), axes_.end(), [&](int axis) {
            const double count = size_[axis] / h;
            return std::abs(count - std::round(count)) < 1e-6 * count;
        });
    }
    // The size nearest to `asked` of which all sides are whole multiples, if it is near.
    [[nodiscard]] std::optional<double> divisor(double asked) const {
        const double count = count_of(asked), farthest = 1000.0;
        for (double apart = 0.0; apart < farthest; ++apart)
            for (const double n : {count + apart, count - apart})
                if (n >= 1.0 && are_whole(smallest_ / n))
                    return near_.contains(smallest_ / n, asked) ? std::optional(smallest_ / n) : std::nullopt;
        return std::nullopt;
    }
    [[nodiscard]] PeriodicFit rounded(double count) const {
        PeriodicFit fit;
        double product = 1.0;
        for (const int axis : axes_) {
            fit.stretch[axis] = std::max(1.0, std::round(size_[axis] / smallest_ * count)) / size_[axis];
            product *= fit.stretch[axis];
        }
        fit.voxel_size_m = std::pow(product, -1.0 / static_cast<double>(axes_.size()));
        for (const int axis : axes_) fit.stretch[axis] *= fit.voxel_size_m;
        return fit;
    }

    Vec3 size_;
    Near near_;
    std::vector<int> axes_;
    double smallest_ = std::numeric_limits<double>::infinity();
};

// Near `asked`, so that the periodic sides, or else the section, are whole numbers of voxels.
PeriodicFit fitted(const Container& container, const Section& section, double asked, bool round_sides) {
    if (!container.any_periodic()) return {.voxel_size_m = section.length() / std::max(1.0, std::round(section.length() / asked))};
    const PeriodicFit fit = PeriodicSides(container, round_sides ? very_near : near_asked).fit(asked);
    if (!near_asked.contains(fit.voxel_size_m, asked))
        throw UserError(fmt::format("the sides of the periodic box are no whole numbers of voxels of about {:g} m", asked),
                        {.allowed = fmt::format("{:.6g} m is the nearest size that fits", fit.voxel_size_m)});
    return fit;
}

}  // namespace

VoxelPlan plan_voxels(const Container& container, const Section& section, double voxel_size_m, const BeyondSection& beyond,
                      double grain_size_m, bool round_sides) {
    if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m))
        throw UserError(fmt::format("the voxel size must be positive, got {:g} m", voxel_size_m),
                        {.fix = "a tenth of the thinnest part of a grain"});
    if (voxel_size_m > grain_size_m || voxel_size_m > section.length())
        throw UserError(
            fmt::format("the voxel is larger than the grain: voxel {:g} m, grains {:g} m thick, section {:g} m", voxel_size_m, grain_size_m,
                        section.length()),
            {.allowed = fmt::format("up to {:.3g} m; 10 voxels per diameter are a good start", std::min(grain_size_m, section.length())),
             .fix = "the voxel size is in metres; where several grids are solved, their coarsest must fit too"});
    VoxelPlan plan;
    const Vec3 size = container.high() - container.low();
    const PeriodicFit fit = fitted(container, section, voxel_size_m, round_sides);
    plan.voxel_size_m = fit.voxel_size_m;
    for (std::size_t a = 0; a < 3; ++a) plan.grid.spacing_m[a] = fit.voxel_size_m / fit.stretch[static_cast<int>(a)];
    const auto& [dx, dy, dz] = plan.grid.spacing_m;
    const double layers = std::max(1.0, std::round(section.length() / dz));
    if (beyond.reservoir_m > 0.0 && container.periodic()[2])
        throw UserError("a periodic cell has no reservoir: it would put void into the cell", {.fix = "leave reservoir_m out"});
    const auto layers_of = [&](double length) { return std::ceil(length / dz - 1e-9); };
    const double below = layers_of(beyond.buffers_m[0] + beyond.reservoir_m), above = layers_of(beyond.buffers_m[1] + beyond.reservoir_m);
    const double ahead = (layers + below + above) * std::ceil(size.x() / dx) * std::ceil(size.y() / dy);
    if (!(ahead < 1e11))
        throw UserError(fmt::format("the grid would have {:.3g} cells", ahead),
                        {.allowed = "1e11 cells", .fix = "choose a larger voxel size (metres), a shorter section or a shorter reservoir"});
    plan.grid.cells[2] = static_cast<int>(layers + below + above);
    plan.grid.origin_m[2] = section.z0_m - below * dz;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double extent = size[static_cast<int>(axis)], h = plan.grid.spacing_m[axis];
        if (!container.vessel().fills_bounds()) {
            plan.grid.cells[axis] = 2 * static_cast<int>(std::ceil(extent / (2.0 * h) - 1e-9));
            const int a = static_cast<int>(axis);
            plan.grid.origin_m[axis] = 0.5 * (container.low()[a] + container.high()[a]) - 0.5 * plan.grid.cells[axis] * h;
            continue;
        }
        const double count = std::round(extent / h);
        plan.grid.cells[axis] =
            static_cast<int>(std::max(1.0, std::abs(count * h - extent) < 1e-6 * extent ? count : std::ceil(extent / h)));
        // Exactly the corner of a periodic box: a face must not lie outside by rounding.
        if (!container.periodic()[axis]) plan.grid.origin_m[axis] = 0.5 * (extent - plan.grid.cells[axis] * h);
    }
    plan.memory_bytes = static_cast<double>(plan.grid.size());
    return plan;
}

namespace {

// Sets the cells of the column at (i, j) whose centres lie in the parts between two heights.
void fill(std::vector<std::uint8_t>& phases, const Grid& grid, int i, int j, const std::vector<Interval>& parts, const Section& between,
          std::uint8_t phase) {
    const double h = grid.spacing_m[2], first = grid.origin_m[2] + 0.5 * h, cells = grid.whole_cells(2);
    for (const auto& part : parts) {
        const double low = std::max(part.low, between.z0_m), high = std::min(part.high, between.z1_m);
        if (high <= low) continue;
        const int from = static_cast<int>(std::clamp(std::ceil((low - first) / h), 0.0, cells)),
                  to = static_cast<int>(std::clamp(std::floor((high - first) / h), -1.0, cells - 1.0));
        grid.for_layers(from, to, [&](int k) { phases[grid.index(i, j, k)] = phase; });
    }
}

}  // namespace

void fill_phases(std::vector<std::uint8_t>& phase, const Grid& grid, const Solid& solid, const Container& container,
                 const Section& section) {
    constexpr double endless = std::numeric_limits<double>::infinity();
    const Interval everywhere{-endless, endless};
    const Section all{-endless, endless};
#pragma omp parallel for schedule(dynamic, 4)
    for (int j = 0; j < grid.cells[1]; ++j) {
        std::vector<Interval> inside, parts;
        for (int i = 0; i < grid.cells[0]; ++i) {
            const double x = grid.centre(0, i), y = grid.centre(1, j);
            container.vessel().column(x, y, inside);
            const bool whole = is_whole_line(inside);
            fill(phase, grid, i, j, {everywhere}, all, whole ? Phase::pore : Phase::outside);
            if (!whole) fill(phase, grid, i, j, inside, all, Phase::pore);
            if (inside.empty()) continue;
            solid.column(x, y, parts);
            if (!whole) intersect(parts, inside);
            fill(phase, grid, i, j, parts, section, Phase::grain);
        }
    }
}

PhaseImage voxelise(const Solid& solid, const Container& container, const Section& section, const Grid& grid, std::optional<Section> kept) {
    require_memory(static_cast<double>(grid.size()),
                   fmt::format("the grid of {} x {} x {} voxels", grid.cells[0], grid.cells[1], grid.cells[2]),
                   "choose a larger voxel size or a shorter section");
    PhaseImage image{.grid = grid, .phase = std::vector<std::uint8_t>(grid.size()), .notes = {}};
    image.notes["container"] = to_json(container).dump();
    image.notes["section"] = fmt::format("{:.17g},{:.17g}", section.z0_m, section.z1_m);
    image.notes["unit"] = "metre";
    fill_phases(image.phase, image.grid, solid, container, kept.value_or(section));
    return image;
}

double narrow_fraction(const PhaseImage& image, int cells) {
    std::vector<std::uint8_t> narrow(image.phase.size(), 0);
    const auto& n = image.grid.cells;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        std::array<int, 3> at{};
        const auto cell = [&](int along) {
            at[axis] = along;
            return image.grid.index(at[0], at[1], at[2]);
        };
        for (at[u] = 0; at[u] < n[u]; ++at[u])
            for (at[v] = 0; at[v] < n[v]; ++at[v]) {
                int start = -1;  // of a run of pores behind a solid; none before the first solid
                for (int i = 0; i < n[axis]; ++i) {
                    if (image.phase[cell(i)] == Phase::pore) continue;
                    if (start >= 0 && i - start <= cells)
                        for (int k = start; k < i; ++k) narrow[cell(k)] = 1;
                    start = i + 1;
                }
            }
    }
    const auto pores = std::count(image.phase.begin(), image.phase.end(), Phase::pore);
    return pores > 0 ? static_cast<double>(std::count(narrow.begin(), narrow.end(), 1)) / static_cast<double>(pores) : 0.0;
}

}  // namespace porepack::pore_space
