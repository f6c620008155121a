#include "lbm/domain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/machine.hpp"
#include "core/parallel.hpp"
#include "lbm/neighbours.hpp"
#include "lbm/uses.hpp"
#include "pore_space/find_cuts.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/walls.hpp"

namespace porepack::lbm {

double expected_links_per_node(double porosity, double voxels) {
    return std::min(18.0, 23.0 * (1.0 - porosity) / (porosity * std::max(1.0, voxels)));
}

namespace {
// Of populations, addresses and walls. Addresses of 16 nodes and one direction: 12 bytes. Of the nodes of a third place, each with 8 bytes,
// there are 0.2 per wall link (0.14 to 0.2 on spheres and tetrapods of 8 to 40 nodes).
double bytes_per_node(const RunSize& size) {
    return 19.0 * size.bytes_per_number + 18.0 * 12.0 / 16.0 + 8.0 * 0.2 * size.links_per_node + 4.1 * size.links_per_node;
}
}  // namespace

double lbm_memory_bytes(const RunSize& size) {
    constexpr double set_of_cells = 0.14;
    const double running = size.nodes * bytes_per_node(size) + set_of_cells * size.cells + size.coarser_nodes * 16.0;
    // Voxels and their runs, and the links twice: decides where little of the grid is fluid.
    const double set_up = 2.0 * size.cells + size.nodes * 2.0 * 8.0 * size.links_per_node;
    return program_bytes + std::max(running, set_up);
}

double lbm_device_bytes(const RunSize& size) {
    constexpr double of_a_batch = 4.0 * 8.0 * 4096 * 128, set_of_layers = 0.1;  // per node, for a flow along z
    return size.nodes * (bytes_per_node(size) + set_of_layers) + of_a_batch;
}

std::size_t Domain::layer_of_cell(std::size_t here) const {
    // One of the three divisions of Grid::place(): layers are asked for in loops over all cells.
    const auto nx = static_cast<std::size_t>(grid.cells[0]), ny = static_cast<std::size_t>(grid.cells[1]);
    return drive.axis == 0   ? here % nx
           : drive.axis == 1 ? here / nx % ny
                             : static_cast<std::size_t>(grid.layer(static_cast<int>(here / (nx * ny))));
}

std::int64_t Domain::node_beside(std::array<int, 3> place, const std::array<int, 3>& step) const {
    const int k = place[2] + step[2];
    const auto side = static_cast<std::size_t>(k < 0 ? 0 : 1);
    if ((k >= 0 && k < grid.cells[2]) || !beyond[side].has_grid()) return step_in_grid(grid, drive, place, step) ? node_at(place) : -1;
    if (!step_in_grid(grid, drive, place, {step[0], step[1], 0})) return -1;
    const std::int64_t node = beyond[side].find(grid.index(place[0], place[1], 0));
    return node < 0 ? -1 : static_cast<std::int64_t>(first_beyond(side)) + node;
}

// (`links = {}` would keep the memory.)
void Domain::forget_links() {
    walls = std::vector<WallLink>();
    boundary_links = std::vector<BoundaryLink>();
    cuts = LinkCuts();
}

double Domain::narrow_share() const {
    const auto narrow = std::count_if(walls.begin(), walls.end(), [](const WallLink& link) { return link.narrow; });
    return walls.empty() ? 0.0 : static_cast<double>(narrow) / static_cast<double>(walls.size());
}

namespace {

constexpr std::size_t max_nodes = 4000000000;  // links hold 32-bit numbers of nodes

// Node next to the mirror image along c_q at an open end, or -1: a wall or the side of the container.
std::int64_t beyond_open_end(const Domain& domain, const std::array<int, 3>& here, int q) {
    auto lateral = d3q19::c[static_cast<std::size_t>(q)];
    if (!through_open_end(domain.grid, domain.drive, here, lateral)) return -1;
    lateral[static_cast<std::size_t>(domain.drive.axis)] = 0;
    return domain.node_beside(here, lateral);
}

struct Links {
    std::vector<WallLink> walls;
    std::vector<BoundaryLink> open;
};

// Poiseuille profile at the point where the link along q from a node of the first layer meets the plane.
double inlet_speed(const Grid& grid, double radius, const std::array<int, 3>& here, int q) {
    const auto& c = d3q19::c[static_cast<std::size_t>(q)];
    const double x = here[0] + 0.5 + 0.5 * c[0] - 0.5 * grid.cells[0], y = here[1] + 0.5 + 0.5 * c[1] - 0.5 * grid.cells[1];
    return 2.0 * inlet_velocity_lu * std::max(0.0, 1.0 - (x * x + y * y) / (radius * radius));
}

// The links of the nodes [begin, end).
Links links_of(const Domain& domain, const FlowWalls* walls, double inlet_radius, std::size_t begin, std::size_t end) {
    Links links;
    std::optional<WallFinder> finder;
    if (walls != nullptr) finder.emplace(*walls, domain.grid, domain.drive);
    const double h = domain.grid.spacing_m[0];
    Neighbours neighbours(domain);
    std::vector<std::size_t> cells(end - begin);
    domain.cells.list(begin, cells);
    for (std::size_t node = begin; node < end; ++node) {
        if (neighbours.inside(cells[node - begin])) continue;
        const auto& near = neighbours.of(cells[node - begin]);
        const auto here = domain.grid.place(cells[node - begin]);
        bool moved = false;
        const std::uint32_t closed = domain.cuts.links(cells[node - begin]);
        std::uint32_t wall_mask = 0;
        const std::size_t first = links.walls.size();
        for (int q = 1; q < d3q19::directions; ++q) {
            if (near[static_cast<std::size_t>(q)] >= 0) continue;
            const bool open = (closed & LinkCuts::bit(d3q19::c[static_cast<std::size_t>(q)])) == 0;
            if (const std::int64_t aside = open ? beyond_open_end(domain, here, q) : -1; aside >= 0) {
                // The incoming population is the mirror image of the one that left `aside`, or that of the inlet.
                const int in = d3q19::opposite(q);
                const auto self = static_cast<std::uint32_t>(node);
                const auto in_q = static_cast<std::uint8_t>(in), out_q = static_cast<std::uint8_t>(q);
                if (inlet_radius > 0.0 && domain.layer_of_cell(cells[node - begin]) == 0)
                    links.open.push_back(
                        {self, self, in_q, out_q, 1, 6.0 * d3q19::w(in) * inlet_speed(domain.grid, inlet_radius, here, q)});
                else
                    links.open.push_back({self, static_cast<std::uint32_t>(aside), in_q,
                                          static_cast<std::uint8_t>(d3q19::mirrored(in, domain.drive.axis)), -1, 0.0});
                continue;
            }
            double fraction = 0.5;
            if (finder) {
                if (!moved)
                    finder->move_to({domain.grid.centre(0, here[0]), domain.grid.centre(1, here[1]), domain.grid.centre(2, here[2])});
                moved = true;
                const auto& c = d3q19::c[static_cast<std::size_t>(q)];
                // No wall on the link: the cell beyond is void that flow does not reach, or the grid ends.
                fraction = finder->fraction(h * Vec3(c[0], c[1], c[2])).value_or(0.5);
            }
            wall_mask |= 1U << q;
            links.walls.push_back({static_cast<std::uint32_t>(node), static_cast<std::uint16_t>(std::lround(65535.0 * fraction)),
                                   static_cast<std::uint8_t>(q), false});
        }
        for (std::size_t l = first; l < links.walls.size(); ++l) {
            WallLink& link = links.walls[l];
            link.narrow = (wall_mask >> d3q19::opposite(link.q) & 1U) != 0;
            // Two walls on the node itself would leave the arriving populations undetermined.
            if (link.narrow) link.distance = std::max(link.distance, std::uint16_t{1311});
        }
    }
    return links;
}

std::vector<double> layer_conductance(const Domain& domain) {
    const std::size_t layers = domain.layers();
    std::vector<double> counts(2 * layers, 0.0), conductance(layers);  // nodes, then wall links
    std::size_t node = 0;
    auto link = domain.walls.begin();
    const auto count = [&] {
        domain.cells.for_each([&](std::size_t cell) {
            const std::size_t layer = domain.layer_of_cell(cell);
            counts[layer] += 1.0;
            for (; link != domain.walls.end() && link->node == node; ++link) counts[layers + layer] += 1.0;
            ++node;
        });
    };
    domain.slabs->in_turn(counts, count);
    for (std::size_t layer = 0; layer < layers; ++layer) {
        const double links = 1.0 + counts[layers + layer];
        conductance[layer] = std::pow(counts[layer], 3.0) / (links * links);
    }
    return conductance;
}

}  // namespace

Domain build_domain(const PhaseImage& image, const Drive& drive, const FlowWalls* walls, double inlet_radius_cells,
                    const Communicator& slabs) {
    Domain domain{.grid = image.grid.without_halo(),
                  .drive = drive,
                  .cells = {},
                  .beyond = {},
                  .cuts = {},
                  .walls = {},
                  .boundary_links = {},
                  .layer_conductance = {},
                  .slabs = &slabs};
    domain.cuts = walls != nullptr ? find_cuts(image, *walls, drive) : find_cuts(image, drive);
    {
        Percolation percolation = find_percolating_cells(image, drive, domain.cuts, slabs);
        domain.isolated_cells = percolation.isolated_cells;
        domain.all_nodes = percolation.all_cells;
        domain.cells = std::move(percolation.cells);
        domain.beyond = std::move(percolation.beyond);
    }
    const std::size_t n = domain.nodes();
    if (domain.first_beyond(1) + static_cast<std::size_t>(domain.beyond[1].size()) > max_nodes)
        throw UserError(fmt::format("{} fluid nodes are too many for this solver", n),
                        {.allowed = fmt::format("up to {}", max_nodes), .fix = "use a larger voxel size"});

    constexpr std::size_t share = 16384;
    std::vector<Links> parts((n + share - 1) / share);
    parallel_for(parts.size(),
                 [&](std::size_t p) { parts[p] = links_of(domain, walls, inlet_radius_cells, p * share, std::min(n, (p + 1) * share)); });
    std::size_t links = 0;
    for (const Links& part : parts) links += part.walls.size();
    domain.walls.reserve(links);
    for (Links& part : parts) {
        domain.walls.insert(domain.walls.end(), part.walls.begin(), part.walls.end());
        domain.boundary_links.insert(domain.boundary_links.end(), part.open.begin(), part.open.end());
        part = {};
    }
    domain.layer_conductance = layer_conductance(domain);
    return domain;
}

}  // namespace porepack::lbm
