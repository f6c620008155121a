// The fluid nodes that flow can reach, their neighbours, and the links that end at walls or open ends: of a grid, or of a slab of it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/communicator.hpp"
#include "pore_space/drive.hpp"
#include "pore_space/link_cuts.hpp"

namespace porepack::pore_space {
struct FlowWalls;
}

namespace porepack::lbm {

/// The link from a node along c_q ends at a wall.
struct WallLink {
    std::uint32_t node;
    std::uint16_t distance;  ///< from the node, in 1/65535 of the link
    std::uint8_t q;          ///< direction towards the wall
    bool narrow;             ///< the opposite link ends at a wall too; then at least 0.02 of the link
    [[nodiscard]] double fraction() const { return distance / 65535.0; }
};

/// The population entering along c_q through an open end is sign times the one leaving `source` along `source_q`, plus `added`.
struct BoundaryLink {
    std::uint32_t node, source;
    std::uint8_t q, source_q;
    std::int8_t sign;
    double added;
};

/// Mean velocity of the inlet profile, lattice units; arbitrary, because Stokes flow is linear.
inline constexpr double inlet_velocity_lu = 1e-3;

/// Of a slab, its own nodes, links and layers; the nodes of the slabs next to it follow its own in number.
struct Domain {
    geometry::Grid grid;  ///< of a slab, without halo
    pore_space::Drive drive;
    pore_space::CellSet cells;                  ///< of the nodes, which have their numbers
    std::array<pore_space::CellSet, 2> beyond;  ///< of the nodes in the layers of other slabs below and above: one layer of cells each
    pore_space::LinkCuts cuts;                  ///< links between two nodes that a wall crosses
    std::vector<WallLink> walls;                ///< by node
    std::vector<BoundaryLink> boundary_links;   ///< by node
    std::vector<double> layer_conductance;      ///< of each layer normal to the flow: nodes^3 / wall links^2 (Kozeny), for estimates
    std::int64_t all_nodes = 0;                 ///< of all slabs
    std::int64_t isolated_cells = 0;            ///< pore cells that no flow reaches, of all slabs
    const core::Communicator* slabs = &core::no_communicator();  ///< outlives the domain

    [[nodiscard]] std::size_t nodes() const { return static_cast<std::size_t>(cells.size()); }
    /// Number of the first node of the slab below (0) or above (1).
    [[nodiscard]] std::size_t first_beyond(std::size_t side) const {
        return nodes() + (side == 0 ? 0 : static_cast<std::size_t>(beyond[0].size()));
    }
    /// Layers normal to the flow, of all slabs.
    [[nodiscard]] std::size_t layers() const { return static_cast<std::size_t>(grid.whole_cells(static_cast<std::size_t>(drive.axis))); }
    /// Layer of a cell, normal to the flow; counted in all slabs.
    [[nodiscard]] std::size_t layer_of_cell(std::size_t cell) const;
    /// Node in cell (i, j, k), or -1 when flow does not reach it.
    [[nodiscard]] std::int64_t node_at(const std::array<int, 3>& place) const {
        return cells.find(grid.index(place[0], place[1], place[2]));
    }
    /// Node at the end of a step from cell (i, j, k), through periodic sides and into other slabs, or -1.
    [[nodiscard]] std::int64_t node_beside(std::array<int, 3> place, const std::array<int, 3>& step) const;
    /// Fraction of the wall links that lie in a gap of one node.
    [[nodiscard]] double narrow_share() const;
    /// Frees the links, once a plan of the flow is made.
    void forget_links();
};

/// Size of a run on a grid or a slab of it, for lbm_memory_bytes().
struct RunSize {
    double cells = 0.0, nodes = 0.0;
    double links_per_node = 1.0;  ///< wall links
    double bytes_per_number = 8.0;
    double coarser_nodes = 0.0;  ///< of a coarser grid whose flow is kept during the run
};
/// Wall links per node of grains that are `voxels` wide (long capsules): 23 (1 - porosity) / (porosity voxels). A surface of area A crosses
/// 5.74 A links, the mean over all its directions, and the area of long cylinders is 4 volume / diameter.
[[nodiscard]] double expected_links_per_node(double porosity, double voxels);
/// What the program needs besides: code, libraries, grains.
inline constexpr double program_bytes = 6e7;
/// Bytes that a run needs, including set-up and the program.
[[nodiscard]] double lbm_memory_bytes(const RunSize& size);
/// Bytes of it that are in the memory of a device, where one computes the flow.
[[nodiscard]] double lbm_device_bytes(const RunSize& size);
/// Of the machine of core::slowness() = 1, in double precision with interpolated walls (docs/lattice-boltzmann-speed.md).
inline constexpr double lattice_updates_per_second = 5e7;

/// Keeps the cells that flow can reach (find_percolating_cells). With `walls` the distances are exact, and solid between two nodes closes
/// their link; without (an image) walls are half-way, and two solid cells that share an edge close the links across it. On end planes the
/// pressure is constant and the flow normal: the incoming population is minus the mirror image of the outgoing one. With
/// `inlet_radius_cells` a Poiseuille profile of that radius enters through the first plane.
/// From the image of a slab with its halo (Grid::slab_of) the domain of that slab, together with those of all slabs of the communicator.
[[nodiscard]] Domain build_domain(const geometry::PhaseImage& image, const pore_space::Drive& drive, const pore_space::FlowWalls* walls,
                                  double inlet_radius_cells = 0.0, const core::Communicator& slabs = core::no_communicator());

}  // namespace porepack::lbm
