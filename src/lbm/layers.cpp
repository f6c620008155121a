#include "lbm/layers.hpp"
#include "lbm/ordered_sums.hpp"
#include "lbm/uses.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace porepack::lbm {

namespace {

constexpr std::array quantities = {&Layers::nodes,        &Layers::flow,    &Layers::power,  &Layers::kinetic,
                                   &Layers::kinetic_flux, &Layers::elastic, &Layers::density};

// Of the layers [low_, high_), all quantities of a layer side by side; the last one that was visited is in `open_`, whose sums stay in
// registers.
class LayerSums {
public:
    explicit LayerSums(const Domain& domain)
        : layer_of_(domain), axis_(static_cast<std::size_t>(domain.drive.axis)), sums_(domain.layers()), low_(sums_.size()) {}

    void visit(std::size_t cell, const Moments& here) {
        if (const std::size_t now = layer_of_.of(cell); now != layer_) {
            close();
            layer_ = now;
        }
        const auto& u = here.velocity;
        const double along = u[axis_], energy = 0.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        const Quantities values = {1.0,         along, along * here.density, energy, along * energy, here.density * here.density / 6.0,
                                   here.density};
        for (std::size_t v = 0; v < values.size(); ++v) open_[v] += values[v];
    }
    void add(LayerSums& other) {
        other.close();
        for (std::size_t l = other.low_; l < other.high_; ++l)
            for (std::size_t v = 0; v < quantities.size(); ++v) sums_[l][v] += other.sums_[l][v];
        low_ = std::min(low_, other.low_);
        high_ = std::max(high_, other.high_);
    }
    void clear() {
        close();
        for (std::size_t l = low_; l < high_; ++l) sums_[l] = {};
        low_ = sums_.size();
        high_ = 0;
    }
    [[nodiscard]] std::span<double> numbers() { return {sums_.front().data(), sums_.size() * quantities.size()}; }
    [[nodiscard]] std::vector<double> all(std::size_t quantity) const {
        std::vector<double> list;
        for (const Quantities& layer : sums_) list.push_back(layer[quantity]);
        return list;
    }

private:
    using Quantities = std::array<double, quantities.size()>;

    void close() {
        if (open_[0] == 0.0) return;
        for (std::size_t v = 0; v < quantities.size(); ++v) sums_[layer_][v] += std::exchange(open_[v], 0.0);
        low_ = std::min(low_, layer_);
        high_ = std::max(high_, layer_ + 1);
    }

    LayerFinder layer_of_;
    std::size_t axis_;
    std::vector<Quantities> sums_;
    std::size_t layer_ = 0, low_, high_ = 0;
    Quantities open_{};
};

}  // namespace

Layers measure_layers(const Flow& flow, const Domain& domain) {
    const LayerSums sums = sum_moments(flow, domain, LayerSums(domain));
    Layers all;
    for (std::size_t v = 0; v < quantities.size(); ++v) all.*quantities[v] = sums.all(v);
    for (std::size_t l = 0; l < all.nodes.size(); ++l) all.density[l] /= std::max(1.0, all.nodes[l]);
    return all;
}

std::array<double, 3> drag_of(const Flow& flow, const Domain& domain) {
    struct Force {
        std::array<double, 3> sum{};
        void add(const Force& other) {
            for (std::size_t a = 0; a < 3; ++a) sum[a] += other.sum[a];
        }
        void clear() { sum = {}; }
        [[nodiscard]] std::span<double> numbers() { return sum; }
    };
    return sum_in_order(domain, Force{},
                        [&](Force& force, std::size_t begin, std::size_t end) {
                            visit_nodes<std::array<double, 3>>(
                                domain, begin, end,
                                [&](std::size_t first, std::span<std::array<double, 3>> forces) { flow.wall_forces(first, forces); },
                                [&](std::size_t, const std::array<double, 3>& one) {
                                    for (std::size_t a = 0; a < 3; ++a) force.sum[a] += one[a];
                                });
                        })
        .sum;
}

double mean_density(const std::vector<double>& nodes, const std::vector<double>& density) {
    return std::inner_product(density.begin(), density.end(), nodes.begin(), 0.0) / std::accumulate(nodes.begin(), nodes.end(), 0.0);
}

double density_on_plane(const Drive& drive, const Layers& layers, std::size_t plane, PlanePressure pressure) {
    const std::size_t n = layers.flow.size();
    if (drive.by_pressure() && (plane == 0 || plane == n)) return 0.0;
    // Inside, the pressure on a plane is that of the layers on both sides.
    const std::size_t before = (plane + n - 1) % n, behind = plane % n;
    const double flow = layers.flow[before] + layers.flow[behind];
    if (pressure == PlanePressure::flux_weighted && flow != 0.0) return (layers.power[before] + layers.power[behind]) / flow;
    return 0.5 * (layers.density[before] + layers.density[behind]);
}

double kinetic_energy_on_plane(const Layers& layers, std::size_t plane) {
    const std::size_t n = layers.flow.size(), before = (plane + n - 1) % n, behind = plane % n;
    return (layers.kinetic_flux[before] + layers.kinetic_flux[behind]) / (layers.flow[before] + layers.flow[behind]);
}

double gradient_between(double force, const Drive& drive, const Layers& layers, std::size_t first, std::size_t last,
                        PlanePressure pressure) {
    const double drop = density_on_plane(drive, layers, first, pressure) - density_on_plane(drive, layers, last + 1, pressure);
    return force + drop / (3.0 * static_cast<double>(last - first + 1));
}

}  // namespace porepack::lbm
