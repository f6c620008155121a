#include "lbm/start.hpp"
#include "lbm/uses.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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
                 ratio = coarse.grid.cells[a] * coarse.grid.spacing_m[a] / (fine.grid.cells[a] * fine.grid.spacing_m[a]);
    return fine.drive.periodic[a] && std::abs(ratio - 1.0) > rounding ? ratio * centre : centre;
}

constexpr std::size_t block_nodes = std::size_t{1} << 17U;  // what is kept twice

// Nodes [first, end) of the flow.
void start_block(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse, std::size_t first, std::size_t end) {
    if (domain.grid.is_slab()) throw std::logic_error("a slab cannot start from a coarser grid");
    const double ratio = coarse.domain.grid.spacing_m[0] / domain.grid.spacing_m[0], thicker = scheme.viscosity_lu() / coarse.viscosity_lu;
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
    // A prescribed flow rate is the same in lattice units; the pressure then falls by nu u / k.
    const bool forced = scheme.force[axis] != 0.0;
    const double faster = forced ? ratio * ratio / thicker : 1.0, denser = forced ? ratio : thicker / ratio;
#pragma omp parallel for schedule(static)
    for (std::size_t begin = first; begin < end; begin += Flow::chunk) {
        std::array<Moments, Flow::chunk> moments;
        std::array<std::size_t, Flow::chunk> cells;
        const std::size_t count = std::min(Flow::chunk, end - begin);
        domain.cells.list(begin, std::span(cells).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const auto at = domain.grid.place(cells[i]);
            moments[i] = interpolate(coarse, {centre_in(coarse.domain, domain, 0, at[0]), centre_in(coarse.domain, domain, 1, at[1]),
                                              centre_in(coarse.domain, domain, 2, at[2])});
            moments[i].density *= denser;
            for (double& u : moments[i].velocity) u *= faster;
        }
        flow.set_moments(begin, std::span(moments).first(count));
    }
}

// Visits blocks of nodes in ascending order.
template <typename Visit>
void for_blocks(std::size_t nodes, const Visit& visit) {
    for (std::size_t first = 0; first < nodes; first += block_nodes) visit(first, std::min(nodes, first + block_nodes));
}

}  // namespace

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
            const int far = static_cast<int>(corner >> a & 1U), n = grid.cells[a];
            around.weight[corner] *= far != 0 ? part[a] : 1.0 - part[a];
            at[a] = base[a] + far;
            if (domain.drive.periodic[a])
                at[a] = (at[a] + n) % n;
            else if (static_cast<int>(a) == domain.drive.axis)
                at[a] = std::clamp(at[a], 0, n - 1);
            else
                inside = inside && at[a] >= 0 && at[a] < n;
        }
        around.node[corner] = inside ? domain.node_at(at) : -1;
    }
    return around;
}

FlowField take_field(Flow& flow, Domain&& domain, const Scheme& scheme) {
    if (domain.grid.is_slab()) throw std::logic_error("a flow field is of a whole grid");
    FlowField field{.domain = std::move(domain), .viscosity_lu = scheme.viscosity_lu(), .moments = {}};
    field.domain.forget_links();
    field.moments = core::Pages<std::array<float, 4>>(field.domain.nodes());
    for_blocks(field.domain.nodes(), [&](std::size_t begin, std::size_t end) {
#pragma omp parallel for schedule(static)
        for (std::size_t first = begin; first < end; first += Flow::chunk) {
            std::array<Moments, Flow::chunk> moments;
            const std::size_t count = std::min(Flow::chunk, end - first);
            flow.moments(first, std::span(moments).first(count));
            for (std::size_t i = 0; i < count; ++i) {
                const auto& [density, u] = moments[i];
                field.moments[first + i] = {static_cast<float>(density), static_cast<float>(u[0]), static_cast<float>(u[1]),
                                            static_cast<float>(u[2])};
            }
        }
        flow.forget(begin, end);
    });
    return field;
}

void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, const FlowField& coarse) {
    start_block(flow, domain, scheme, coarse, 0, domain.nodes());
}

void start_from(Flow& flow, const Domain& domain, const Scheme& scheme, FlowField&& given) {
    FlowField coarse = std::move(given);
    const Grid& grid = coarse.domain.grid;
    const auto first_node = [&](int layer) {
        return static_cast<std::size_t>(coarse.domain.cells.rank(grid.index(0, 0, std::clamp(layer, 0, grid.cells[2] - 1))));
    };
    std::size_t forgotten = first_node(1);  // the last layer of a periodic box needs the first one again
    for_blocks(domain.nodes(), [&](std::size_t first, std::size_t end) {
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
