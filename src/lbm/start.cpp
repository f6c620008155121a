#include "lbm/start.hpp"

#include "lbm/uses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace porepack::lbm {
namespace {

// Where there is no fluid the velocity is zero, and the density that of the other nodes.
Moments interpolate(const FlowField& coarse, const std::array<double, 3>& place) {
    const NodesAround around = nodes_around(coarse.domain, place);
    Moments mean{.density = 0.0, .velocity = {0, 0, 0}};
    double fluid = 0.0;
    for (std::size_t corner = 0; corner < 8; ++corner) {
        if (around.node[corner] < 0) continue;
        const double weight = around.weight[corner];
        const auto& moments = coarse.moments[static_cast<std::size_t>(around.node[corner])];
        fluid += weight;
        mean.density += weight * static_cast<double>(moments[0]);
        for (std::size_t a = 0; a < 3; ++a) mean.velocity[a] += weight * static_cast<double>(moments[a + 1]);
    }
    if (fluid > 0.0) mean.density /= fluid;
    return mean;
}

// The centre of a cell along an axis, in the coarser box: the two may have been stretched to whole voxels by different factors.
double centre_in(const Domain& coarse, const Domain& fine, int axis, int cell) {
    const auto a = static_cast<std::size_t>(axis);
    const double centre = fine.grid.centre(axis, cell), rounding = 1e-9,
                 ratio = coarse.grid.whole_cells(a) * coarse.grid.spacing_m[a] / (fine.grid.whole_cells(a) * fine.grid.spacing_m[a]);
    return fine.drive.periodic[a] && std::abs(ratio - 1.0) > rounding ? ratio * centre : centre;
}

// Of the nodes that are kept twice, and of those whose moments are at hand at once.
constexpr std::size_t kept_twice = std::size_t{1} << 17U, at_once = std::size_t{1} << 14U;

// Visits blocks of the nodes [first, end) in ascending order; of whole chunks where `first` is the first of one.
template <typename Visit>
void for_blocks(std::size_t first, std::size_t end, std::size_t nodes, const Visit& visit) {
    for (; first < end; first += nodes) visit(first, std::min(end, first + nodes));
}

// Nodes [first, end) of the flow.
void start_block(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse, std::size_t first, std::size_t end) {
    const double ratio = coarse.domain.grid.spacing_m[0] / domain.grid.spacing_m[0], thicker = scheme.viscosity_lu() / coarse.viscosity_lu;
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
    // A prescribed flow rate is the same in lattice units; the pressure then falls by nu u / k.
    const bool forced = scheme.force[axis] != 0.0;
    const double faster = forced ? ratio * ratio / thicker : 1.0, denser = forced ? ratio : thicker / ratio;
    std::vector<Moments> moments;
    for_blocks(first, end, at_once, [&](std::size_t begin, std::size_t behind) {
        moments.resize(behind - begin);
#pragma omp parallel for schedule(static)
        for (std::size_t of_chunk = begin; of_chunk < behind; of_chunk += Flow::chunk) {
            std::array<std::size_t, Flow::chunk> cells;
            const std::size_t count = std::min(Flow::chunk, behind - of_chunk);
            domain.cells.list(of_chunk, std::span(cells).first(count));
            for (std::size_t i = 0; i < count; ++i) {
                const auto at = domain.grid.place(cells[i]);
                Moments& here = moments[of_chunk - begin + i];
                here = interpolate(coarse, {centre_in(coarse.domain, domain, 0, at[0]), centre_in(coarse.domain, domain, 1, at[1]),
                                            centre_in(coarse.domain, domain, 2, at[2])});
                here.density *= denser;
                for (double& u : here.velocity) u *= faster;
            }
        }
        flow.set_moments(begin, moments);
    });
}

// The slab's layer with this number in the whole grid.
int local_layer(const Grid& slab, int layer) {
    for (const int local :
         {layer - slab.slab.first, layer - slab.slab.first + slab.slab.layers, layer - slab.slab.first - slab.slab.layers})
        if (local >= 0 && local < slab.cells[2]) return local;
    throw std::logic_error("a slab needs a layer of a coarser grid that it does not hold");
}

// Some layers of a field for a neighbour: numbers of the cells, from the first of these layers on, and their moments.
struct FieldLayers {
    std::vector<std::uint64_t> cells;
    std::vector<std::array<float, 4>> moments;
};

FieldLayers layers_of(const FlowField& field, int first, int end) {
    const Grid& grid = field.domain.grid;
    const std::size_t begin = grid.index(0, 0, first), behind = grid.index(0, 0, end);
    FieldLayers found;
    auto node = static_cast<std::size_t>(field.domain.cells.rank(begin));
    for (std::size_t cell = begin; cell < behind; ++cell)
        if (field.domain.cells.contains(cell)) {
            found.cells.push_back(cell - begin);
            found.moments.push_back(field.moments[node++]);
        }
    return found;
}

}  // namespace

FlowField with_layers_beyond(FlowField&& field, int layers) {
    const Domain& own = field.domain;
    const Grid& grid = own.grid;
    if (!grid.is_slab() || field.layers_beyond > 0) return std::move(field);
    const FieldLayers low = layers_of(field, 0, layers), high = layers_of(field, grid.cells[2] - layers, grid.cells[2]);
    const auto cells = exchange_lists<std::uint64_t>(*own.slabs, {low.cells, high.cells});
    const auto moments = exchange_lists<std::array<float, 4>>(*own.slabs, {low.moments, high.moments});

    const bool below = grid.slab.first > 0 || own.drive.periodic[2],
               above = grid.slab.first + grid.cells[2] < grid.slab.layers || own.drive.periodic[2];
    Grid wider = grid;
    wider.slab.first -= below ? layers : 0;
    wider.cells[2] += (below ? layers : 0) + (above ? layers : 0);
    const std::size_t shift = below ? grid.index(0, 0, layers) : 0, top = shift + grid.size();
    std::vector<std::uint64_t> words((wider.size() + 63) / 64, 0);
    std::vector<std::array<float, 4>> all;
    const auto add = [&](std::size_t cell, const std::array<float, 4>& of_cell) {
        words[cell / 64] |= std::uint64_t{1} << (cell % 64);
        all.push_back(of_cell);
    };
    if (below)
        for (std::size_t i = 0; i < cells[0].size(); ++i) add(cells[0][i], moments[0][i]);
    std::size_t node = 0;
    own.cells.for_each([&](std::size_t cell) { add(shift + cell, field.moments[node++]); });
    if (above)
        for (std::size_t i = 0; i < cells[1].size(); ++i) add(top + cells[1][i], moments[1][i]);

    FlowField found{.domain = {.grid = wider, .drive = own.drive, .cells = CellSet(wider, std::move(words)), .slabs = own.slabs},
                    .viscosity_lu = field.viscosity_lu,
                    .moments = core::Pages<std::array<float, 4>>(all.size()),
                    .layers_beyond = layers};
    for (std::size_t i = 0; i < all.size(); ++i) found.moments[i] = all[i];
    return found;
}

NodesAround nodes_around(const Domain& domain, const std::array<double, 3>& place) {
    const Grid& grid = domain.grid;
    std::array<int, 3> base{};
    std::array<double, 3> part{};
    for (std::size_t a = 0; a < 3; ++a) {
        const double at = (place[a] - grid.origin_m[a]) / grid.spacing_m[a] - 0.5;
        base[a] = static_cast<int>(std::floor(at));
        part[a] = at - base[a];
    }
    NodesAround around{};
    for (std::size_t corner = 0; corner < 8; ++corner) {
        around.weight[corner] = 1.0;
        std::array<int, 3> at{};
        bool inside = true;
        for (std::size_t a = 0; a < 3; ++a) {
            const int far = static_cast<int>(corner >> a & 1U), n = grid.whole_cells(a);
            around.weight[corner] *= far != 0 ? part[a] : 1.0 - part[a];
            at[a] = base[a] + far;
            if (domain.drive.periodic[a])
                at[a] = (at[a] + n) % n;
            else if (static_cast<int>(a) == domain.drive.axis)
                at[a] = std::clamp(at[a], 0, n - 1);
            else
                inside = inside && at[a] >= 0 && at[a] < n;
        }
        if (inside && grid.is_slab()) at[2] = local_layer(grid, at[2]);
        around.node[corner] = inside ? domain.node_at(at) : -1;
    }
    return around;
}

FlowField take_field(Flow& flow, Domain&& domain, const Scheme& scheme) {
    FlowField field{.domain = std::move(domain), .viscosity_lu = scheme.viscosity_lu(), .moments = {}};
    field.domain.forget_links();
    field.moments = core::Pages<std::array<float, 4>>(field.domain.nodes());
    std::vector<Moments> moments;
    for_blocks(0, field.domain.nodes(), kept_twice, [&](std::size_t first, std::size_t end) {
        for_blocks(first, end, at_once, [&](std::size_t begin, std::size_t behind) {
            moments.resize(behind - begin);
            flow.moments(begin, moments);
#pragma omp parallel for schedule(static)
            for (std::size_t i = 0; i < moments.size(); ++i) {
                const auto& [density, u] = moments[i];
                field.moments[begin + i] = {static_cast<float>(density), static_cast<float>(u[0]), static_cast<float>(u[1]),
                                            static_cast<float>(u[2])};
            }
        });
        flow.forget(first, end);
    });
    return field;
}

void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse) {
    start_block(flow, domain, scheme, coarse, 0, domain.nodes());
}

void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, FlowField&& given) {
    FlowField coarse = std::move(given);
    const Grid& grid = coarse.domain.grid;
    if (grid.is_slab()) return start_block(flow, domain, scheme, coarse, 0, domain.nodes());
    const auto first_node = [&](int layer) {
        return static_cast<std::size_t>(coarse.domain.cells.rank(grid.index(0, 0, std::clamp(layer, 0, grid.cells[2] - 1))));
    };
    std::size_t forgotten = first_node(1);  // the last layer of a periodic box needs the first one again
    for_blocks(0, domain.nodes(), kept_twice, [&](std::size_t first, std::size_t end) {
        start_block(flow, domain, scheme, coarse, first, end);
        if (end == domain.nodes()) return;
        const double z = centre_in(coarse.domain, domain, 2, domain.grid.place(domain.cells.cell(end))[2]);
        const std::size_t needed = first_node(static_cast<int>(std::floor((z - grid.origin_m[2]) / grid.spacing_m[2] - 0.5)));
        if (needed <= forgotten) return;
        coarse.moments.release(forgotten, needed);
        forgotten = needed;
    });
}

}  // namespace porepack::lbm
