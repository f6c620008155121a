// The state of a flow on a domain, independent of the kernel.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "lbm/domain.hpp"
#include "lbm/scheme.hpp"
#include "lbm/stokes_run.hpp"

namespace porepack::devices {
class Device;
}

namespace porepack::lbm {

/// Density deviation and velocity of one node, lattice units.
struct Moments {
    double density;
    std::array<double, 3> velocity;
};

/// Sums over the nodes of a flow: of all nodes, or of those in some layers normal to the flow. Lattice units.
struct FlowSums {
    std::array<double, 3> velocity{};                             ///< of all nodes
    double density = 0.0;                                         ///< deviation, of all nodes
    double fastest = 0.0;                                         ///< largest speed of all nodes; NaN if one is
    double speed = 0.0, along = 0.0, squares = 0.0, nodes = 0.0;  ///< of the layers: speed, velocity along the flow, square of the speed, number
};

/// Populations are deviations from rest. A body force drives the flow; with constant pressure on end planes it is the
/// constant part of the pressure gradient, and the density here is the remainder, zero on both planes.
class Flow {
public:
    virtual ~Flow() = default;
    /// Two collisions and streamings of all nodes.
    virtual void advance_two_steps() = 0;

    /// What solvers ask of a flow. Here it is computed from moments(), wall_forces() and add_density(), in the order of ordered_sums.hpp; a
    /// flow whose populations are elsewhere has its own way. The domain is that of the flow; sums are of all slabs.
    [[nodiscard]] virtual Layers layers(const Domain& domain) const;
    [[nodiscard]] virtual FlowSums sums(const Domain& domain, int first_layer, int last_layer) const;
    /// Force on the walls by momentum exchange.
    [[nodiscard]] virtual std::array<double, 3> drag(const Domain& domain) const;
    /// Adds to the density of all nodes in each layer normal to the flow; velocities and stresses stay.
    virtual void add_to_layers(const Domain& domain, std::span<const double> added);

    /// Moments of the nodes [first, first + moments.size()): a whole number of chunks, or up to the last node.
    virtual void moments(std::size_t first, std::span<Moments> moments) const = 0;
    /// Force of each node on the walls by momentum exchange, lattice units; nodes as in `moments`.
    virtual void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const = 0;
    /// Sets nodes, numbered as in `moments`, to local equilibrium.
    virtual void set_moments(std::size_t first, std::span<const Moments> moments) = 0;
    /// Adds to the density of nodes, numbered as in `moments`; velocities and stresses stay.
    virtual void add_density(std::size_t first, std::span<const double> added) = 0;
    /// Replaces Domain::boundary_links' `added`, link by link.
    virtual void set_boundary_links(std::span<const double> added) = 0;
    /// No step follows, and nothing reads the populations of the nodes [first, end) any more: their memory may be returned.
    virtual void forget(std::size_t /*first*/, std::size_t /*end*/) {}
    /// All that later steps depend on: the 19 populations of each node, node after node, in the flow's precision. Nodes as in `moments`.
    virtual void populations(std::size_t first, std::span<std::byte> of_nodes) const = 0;
    virtual void set_populations(std::size_t first, std::span<const std::byte> of_nodes) = 0;
    [[nodiscard]] virtual std::size_t bytes_per_number() const = 0;
    [[nodiscard]] virtual double bytes() const = 0;

    /// Nodes are requested in multiples of this.
    static constexpr std::size_t chunk = 128;
};

/// Kernels: readable reference code, or the fast kernel of this processor in double or single precision.
enum class Kernel { reference, cpu_double, cpu_single };

/// What flows on a domain need besides their populations: made once per grid, for all relaxation times.
class FlowPlan {
public:
    virtual ~FlowPlan() = default;
    /// A flow at rest. It keeps the plan.
    [[nodiscard]] virtual std::unique_ptr<Flow> start(const Scheme& scheme) const = 0;
};
/// The plan does not refer to the domain: its wall links, which are large, may be freed before a flow is started.
[[nodiscard]] std::shared_ptr<const FlowPlan> plan_flow(Kernel kernel, const Domain& domain);
/// On a device, of a whole grid: only sums over layers leave it while it computes. MachineError where its memory is too small, DeviceLost
/// when it fails.
[[nodiscard]] std::shared_ptr<const FlowPlan> plan_flow(const std::shared_ptr<devices::Device>& device, bool single_precision,
                                                        const Domain& domain);
/// One flow at rest.
[[nodiscard]] std::unique_ptr<Flow> make_flow(Kernel kernel, const Domain& domain, const Scheme& scheme);

}  // namespace porepack::lbm
