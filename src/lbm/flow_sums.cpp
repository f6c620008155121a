#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "lbm/flow.hpp"
#include "lbm/ordered_sums.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

// The layer of a cell, normal to the flow; fast for cells in ascending order. For one thread.
class LayerFinder {
public:
    explicit LayerFinder(const Domain& domain) : domain_(domain), along_z_(domain.drive.axis == 2) {}
    [[nodiscard]] std::size_t of(std::size_t cell) {
        if (along_z_ && cell - first_cell_ < cells_) return layer_;
        layer_ = domain_.layer_of_cell(cell);
        cells_ = static_cast<std::size_t>(domain_.grid.cells[0]) * static_cast<std::size_t>(domain_.grid.cells[1]);
        first_cell_ = cell / cells_ * cells_;
        return layer_;
    }

private:
    const Domain& domain_;
    bool along_z_;
    std::size_t layer_ = 0, first_cell_ = 0, cells_ = 0;
};

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

// Of the velocity, the density and the largest square of all nodes; of the speed, the velocity along the flow, the square and the number
// of those in some layers.
class VelocitySums {
public:
    VelocitySums(const Domain& domain, int first_layer, int last_layer)
        : layer_of_(domain),
          axis_(static_cast<std::size_t>(domain.drive.axis)),
          first_layer_(static_cast<std::size_t>(first_layer)),
          last_layer_(static_cast<std::size_t>(last_layer)) {}

    void visit(std::size_t cell, const Moments& here) {
        const auto& u = here.velocity;
        const double square = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
        for (std::size_t a = 0; a < 3; ++a) sums_[a] += u[a];
        sums_[3] += here.density;
        keep_largest(square);
        if (const std::size_t layer = layer_of_.of(cell); layer < first_layer_ || layer > last_layer_) return;
        sums_[4] += std::sqrt(square);
        sums_[5] += u[axis_];
        sums_[6] += square;
        sums_[7] += 1.0;
    }
    void add(const VelocitySums& other) {
        for (std::size_t s = 0; s < 8; ++s) sums_[s] += other.sums_[s];
        keep_largest(other.sums_[8]);
    }
    void clear() { sums_ = {}; }
    [[nodiscard]] std::span<double> numbers() { return sums_; }
    [[nodiscard]] FlowSums result() const {
        return {.velocity = {sums_[0], sums_[1], sums_[2]},
                .density = sums_[3],
                .fastest = std::sqrt(sums_[8]),
                .speed = sums_[4],
                .along = sums_[5],
                .squares = sums_[6],
                .nodes = sums_[7]};
    }

private:
    void keep_largest(double square) { sums_[8] = square > sums_[8] || std::isnan(square) ? square : sums_[8]; }

    LayerFinder layer_of_;
    std::size_t axis_, first_layer_, last_layer_;
    std::array<double, 9> sums_{};
};

}  // namespace

Layers Flow::layers(const Domain& domain) const {
    const LayerSums sums = sum_moments(*this, domain, LayerSums(domain));
    Layers all;
    for (std::size_t v = 0; v < quantities.size(); ++v) all.*quantities[v] = sums.all(v);
    for (std::size_t l = 0; l < all.nodes.size(); ++l) all.density[l] /= std::max(1.0, all.nodes[l]);
    return all;
}

std::array<double, 3> Flow::drag(const Domain& domain) const {
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
                                [&](std::size_t first, std::span<std::array<double, 3>> forces) { wall_forces(first, forces); },
                                [&](std::size_t, const std::array<double, 3>& one) {
                                    for (std::size_t a = 0; a < 3; ++a) force.sum[a] += one[a];
                                });
                        })
        .sum;
}

FlowSums Flow::sums(const Domain& domain, int first_layer, int last_layer) const {
    return sum_moments(*this, domain, VelocitySums(domain, first_layer, last_layer)).result();
}

void Flow::add_to_layers(const Domain& domain, std::span<const double> added) {
#pragma omp parallel for schedule(static)
    for (std::size_t first = 0; first < domain.nodes(); first += chunk) {
        std::array<double, chunk> of_nodes;
        std::array<std::size_t, chunk> cells;
        LayerFinder layer_of(domain);
        const std::size_t count = std::min(chunk, domain.nodes() - first);
        domain.cells.list(first, std::span(cells).first(count));
        for (std::size_t i = 0; i < count; ++i) of_nodes[i] = added[layer_of.of(cells[i])];
        add_density(first, std::span(of_nodes).first(count));
    }
}

}  // namespace porepack::lbm
