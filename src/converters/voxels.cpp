#include "converters/voxels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/machine.hpp"

namespace porepack::converters {
using namespace core;
using namespace shapes;
using namespace packing;

VoxelPlan plan_voxels(const Container& container, const Section& section, double voxel_size_m, double reservoir_m, double grain_size_m) {
    if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m))
        throw UserError(fmt::format("the voxel size must be positive, got {:g} m", voxel_size_m));
    if (voxel_size_m > grain_size_m || voxel_size_m > section.length())
        throw UserError(
            fmt::format("the voxel is larger than the grain: voxel {:g} m, capsule diameter {:g} m, section {:g} m", voxel_size_m,
                        grain_size_m, section.length()),
            {.allowed = fmt::format("up to {:.3g} m; 10 voxels per diameter are a good start", std::min(grain_size_m, section.length())),
             .fix = "the voxel size is in metres"});
    VoxelPlan plan;
    const Vec3 size = container.high() - container.low();
    const double layers = std::max(1.0, std::round(section.length() / voxel_size_m));
    const double h = section.length() / layers;
    plan.voxel_size_m = h;
    if (reservoir_m > 0.0 && container.any_periodic())
        throw UserError("a periodic cell has no reservoir: it would put void into the cell", {.fix = "leave reservoir_m out"});
    const double reservoir_layers = std::ceil(reservoir_m / h - 1e-9);
    const double ahead = (layers + 2.0 * reservoir_layers) * std::ceil(size.x() / h) * std::ceil(size.y() / h);
    if (!(ahead < 2e9))
        throw UserError(fmt::format("the grid would have {:.3g} cells", ahead),
                        {.allowed = "2e9 cells", .fix = "choose a larger voxel size (metres), a shorter section or a shorter reservoir"});
    plan.reservoir_cells = static_cast<int>(reservoir_layers);
    plan.grid.spacing_m = {h, h, h};
    plan.grid.cells[2] = static_cast<int>(layers) + 2 * plan.reservoir_cells;
    plan.grid.origin_m[2] = section.z0 - plan.reservoir_cells * h;
    for (std::size_t axis = 0; axis < 2; ++axis) {
        const double extent = size[static_cast<int>(axis)];
        if (container.kind == Container::Kind::cylinder) {
            plan.grid.cells[axis] = 2 * static_cast<int>(std::ceil(extent / (2.0 * h) - 1e-9));
            plan.grid.origin_m[axis] = -0.5 * plan.grid.cells[axis] * h;
            continue;
        }
        const double count = std::round(extent / h);
        if (container.periodic[axis] && std::abs(count * h - extent) > 1e-6 * extent)
            throw UserError(fmt::format("the periodic box is no whole number of voxels: {:g} m / {:g} m = {:.4f}", extent, h, extent / h),
                            {.fix = "choose a voxel size that divides all sides of the box"});
        plan.grid.cells[axis] =
            static_cast<int>(std::max(1.0, std::abs(count * h - extent) < 1e-6 * extent ? count : std::ceil(extent / h)));
        plan.grid.origin_m[axis] = 0.5 * (extent - plan.grid.cells[axis] * h);
    }
    plan.memory_bytes = static_cast<double>(plan.grid.size());
    return plan;
}

namespace {

// Fills a column of cells whose centres lie in the intervals.
void fill_column(std::uint8_t* first, std::size_t stride, int cells, double z_first, double h, const std::vector<Interval>& parts,
                 const Section& section) {
    for (const auto& part : parts) {
        const double low = std::max(part.low, section.z0);
        const double high = std::min(part.high, section.z1);
        if (high <= low) continue;
        const int from = std::max(0, static_cast<int>(std::ceil((low - z_first) / h)));
        const int to = std::min(cells - 1, static_cast<int>(std::floor((high - z_first) / h)));
        for (int k = from; k <= to; ++k) first[static_cast<std::size_t>(k) * stride] = Phase::grain;
    }
}

}  // namespace

void fill_phases(std::vector<std::uint8_t>& phase, const Grid& grid, const Solid& solid, const Container& container,
                 const Section& section) {
    const auto stride = static_cast<std::size_t>(grid.cells[0]) * static_cast<std::size_t>(grid.cells[1]);
    const double z_first = grid.centre(2, 0);
#pragma omp parallel for schedule(dynamic, 4)
    for (int j = 0; j < grid.cells[1]; ++j) {
        std::vector<Interval> parts;
        for (int i = 0; i < grid.cells[0]; ++i) {
            std::uint8_t* column = phase.data() + grid.index(i, j, 0);
            const double x = grid.centre(0, i), y = grid.centre(1, j);
            const bool inside = container.contains_column(x, y);
            for (int k = 0; k < grid.cells[2]; ++k) column[static_cast<std::size_t>(k) * stride] = inside ? Phase::pore : Phase::outside;
            if (!inside) continue;
            solid.column(x, y, parts);
            fill_column(column, stride, grid.cells[2], z_first, grid.spacing_m[2], parts, section);
        }
    }
}

PhaseImage voxelise(const Solid& solid, const Container& container, const Section& section, const VoxelPlan& plan) {
    require_memory(plan.memory_bytes,
                   fmt::format("the grid of {} x {} x {} voxels", plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2]),
                   "choose a larger voxel size or a shorter section");
    PhaseImage image{.grid = plan.grid, .phase = std::vector<std::uint8_t>(plan.grid.size()), .notes = {}};
    image.notes["container"] = to_json(container).dump();
    image.notes["section"] = fmt::format("{:.17g},{:.17g}", section.z0, section.z1);
    image.notes["unit"] = "metre";
    fill_phases(image.phase, image.grid, solid, container, section);
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

}  // namespace porepack::converters
