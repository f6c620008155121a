// End planes of constant pressure for flows with inertia.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "lbm/flow.hpp"

namespace porepack::lbm {

/// A flow between two planes of constant pressure: the incoming population is minus the outgoing one (which keeps p + u^2 constant) plus
/// 6 w u^2 with the velocity normal to the plane, from two steps before.
class PressureEnds : public Flow {
public:
    PressureEnds(std::unique_ptr<Flow> flow, const Domain& domain);  ///< refers to the domain
    void advance_two_steps() override;
    [[nodiscard]] Layers layers(const Domain& domain) const override { return flow_->layers(domain); }
    [[nodiscard]] FlowSums sums(const Domain& domain, int first_layer, int last_layer) const override {
        return flow_->sums(domain, first_layer, last_layer);
    }
    [[nodiscard]] std::array<double, 3> drag(const Domain& domain) const override { return flow_->drag(domain); }
    void add_to_layers(const Domain& domain, std::span<const double> added) override { flow_->add_to_layers(domain, added); }
    void moments(std::size_t first, std::span<Moments> moments) const override { flow_->moments(first, moments); }
    void wall_forces(std::size_t first, std::span<std::array<double, 3>> forces) const override { flow_->wall_forces(first, forces); }
    void set_moments(std::size_t first, std::span<const Moments> moments) override { flow_->set_moments(first, moments); }
    void set_boundary_links(std::span<const double> added) override { flow_->set_boundary_links(added); }
    void populations(std::size_t first, std::span<std::byte> of_nodes) const override { flow_->populations(first, of_nodes); }
    void set_populations(std::size_t first, std::span<const std::byte> of_nodes) override { flow_->set_populations(first, of_nodes); }
    [[nodiscard]] std::size_t bytes_per_number() const override { return flow_->bytes_per_number(); }
    void add_density(std::size_t first, std::span<const double> added) override { flow_->add_density(first, added); }
    [[nodiscard]] double bytes() const override { return flow_->bytes(); }

private:
    void update();

    std::unique_ptr<Flow> flow_;
    const Domain& domain_;
    std::vector<Moments> moments_;  // of some chunks
    std::vector<double> added_;
    std::vector<std::size_t> chunks_;                 // with nodes at open ends, ascending
    std::vector<double> speed_;                       // of their nodes
    std::vector<std::array<std::size_t, 2>> places_;  // of each link's node and source in speed_
};

}  // namespace porepack::lbm
