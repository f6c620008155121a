// The state of a flow on a domain, independent of the kernel.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "lbm/domain.hpp"
#include "lbm/scheme.hpp"

namespace porepack::lbm {

/// Density deviation and velocity of one node, lattice units.
struct Moments {
    double density;
    std::array<double, 3> velocity;
};

/// Populations are deviations from rest. A body force drives the flow; with constant pressure on end planes it is the
/// constant part of the pressure gradient, and the density here is the remainder, zero on both planes.
class Flow {
public:
    virtual ~Flow() = default;
    /// Two collisions and streamings of all nodes.
    virtual void advance_two_steps() = 0;
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
    /// Everything that a later step depends on, in its memory layout.
    [[nodiscard]] virtual std::span<std::byte> state() = 0;
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
/// One flow at rest.
[[nodiscard]] std::unique_ptr<Flow> make_flow(Kernel kernel, const Domain& domain, const Scheme& scheme);

}  // namespace porepack::lbm
