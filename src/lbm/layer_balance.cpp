#include "lbm/layer_balance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "core/median.hpp"
#include "lbm/layers.hpp"

namespace porepack::lbm {
namespace {

constexpr int smoothing_passes = 8;                           // over about four layers
constexpr double largest_share = 0.7, smallest_share = 1e-3;  // of a correction
constexpr double free_water = 10.0;                           // conductance relative to the median from which end layers count as such

double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// From the median, relative to it.
double largest_deviation(const std::vector<double>& values) {
    const double middle = core::median(values);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    return std::max(*high - middle, middle - *low) / std::abs(middle);
}

// Root of the sum of squares about the mean.
double scatter(const std::vector<double>& values) {
    const double mean = mean_of(values);
    double sum = 0.0;
    for (const double value : values) sum += (value - mean) * (value - mean);
    return std::sqrt(sum);
}

}  // namespace

LayerBalance::LayerBalance(const Domain& domain, const Scheme& scheme, double area_cells, bool balance)
    : domain_(domain),
      viscosity_(scheme.viscosity_lu()),
      force_(scheme.force[static_cast<std::size_t>(domain.drive.axis)]),
      area_cells_(area_cells),
      closed_(!domain.drive.by_pressure()),
      balance_(balance && force_ != 0.0 && !scheme.inertia()),
      end_(domain.layer_conductance.size()) {
    if (closed_) return;
    const std::vector<double>& conductance = domain.layer_conductance;
    const double free = free_water * core::median(conductance);
    while (first_ < end_ && conductance[first_] > free) ++first_;
    while (end_ > first_ && conductance[end_ - 1] > free) --end_;
}

void LayerBalance::begin(Flow& flow) const {
    if (!balance_) return;
    const auto& conductance = domain_.layer_conductance;
    double resistance = 0.0;
    for (const double c : conductance) resistance += 1.0 / c;
    std::vector<double> added(conductance.size());
    double plane = 0.0;
    for (std::size_t l = 0; l < added.size(); ++l) {
        const double step = 3.0 * force_ * (1.0 - static_cast<double>(added.size()) / (resistance * conductance[l]));
        added[l] = plane + 0.5 * step;
        plane += step;
    }
    flow.add_to_layers(domain_, added);
}

void LayerBalance::correct(Flow& flow, const Layers& layers, double permeability_lu, long steps, BalanceState& state) const {
    const std::vector<double> before = std::exchange(state.density, layers.density);
    std::vector<double> added(layers.flow.size(), 0.0);
    if (balance_ && !before.empty() && permeability_lu > 0.0) {
        const std::vector<double> unsteady = unsteady_flow(layers, before, steps);
        const double size = scatter(unsteady);
        state.share = size > 1.2 * state.unsteady && state.unsteady > 0.0 ? std::max(smallest_share, 0.4 * state.share)
                                                                          : std::min(largest_share, 1.05 * state.share);
        state.unsteady = size;
        // Velocities follow the pressure within about 3 k/(porosity nu) steps: a correction that comes more often is smaller.
        const double porosity = static_cast<double>(domain_.all_nodes) / (area_cells_ * static_cast<double>(layers.flow.size()));
        // Darcy's law holds for small deviations: not while the flow begins, or while its direction changes.
        const auto bed = [&](std::size_t l) { return layers.flow.begin() + static_cast<std::ptrdiff_t>(l); };
        if (largest_deviation({bed(first_), bed(end_)}) <= 1.5)
            added = pressure_steps(layers, unsteady,
                                   std::min(state.share, static_cast<double>(steps) * porosity * viscosity_ / (3.0 * permeability_lu)));
    }
    for (std::size_t l = 0; l < added.size(); ++l) state.density[l] += added[l];
    if (closed_) {
        const double mean = mean_density(layers.nodes, state.density);
        for (std::size_t l = 0; l < added.size(); ++l) {
            state.density[l] -= mean;
            added[l] -= mean;
        }
    }
    if (closed_ || balance_) flow.add_to_layers(domain_, added);
}

// Density to be added to each layer. `unsteady`: of the layers of the bed.
std::vector<double> LayerBalance::pressure_steps(const Layers& layers, const std::vector<double>& unsteady, double share) const {
    const auto& conductance = domain_.layer_conductance;
    double resistance = 0.0, weighted = 0.0, flow = 0.0;
    for (std::size_t l = first_; l < end_; ++l) {
        resistance += 1.0 / conductance[l];
        weighted += unsteady[l - first_] / conductance[l];
        flow += layers.flow[l];
    }
    const double mean = flow / static_cast<double>(end_ - first_);
    const double scale = mean * resistance / (force_ * static_cast<double>(conductance.size()));
    std::vector<double> added(conductance.size(), 0.0);
    double plane = 0.0;
    for (std::size_t l = first_; l < end_; ++l) {
        const double step = -3.0 * share * (weighted / resistance - unsteady[l - first_]) / (scale * conductance[l]);
        added[l] = plane + 0.5 * step;
        plane += step;
    }
    return added;
}

// Flow rate of each layer of the bed relative to its first plane, from the mass that the layers have gained; what walls leak is not
// part of it.
std::vector<double> LayerBalance::unsteady_flow(const Layers& layers, const std::vector<double>& before, long steps) const {
    const double leak = closed_ ? mean_density(layers.nodes, layers.density) - mean_density(layers.nodes, before) : 0.0;
    std::vector<double> flow(end_ - first_);
    double plane = 0.0;
    for (std::size_t l = first_; l < end_; ++l) {
        const double gain = layers.nodes[l] * (layers.density[l] - before[l] - leak) / static_cast<double>(steps);
        flow[l - first_] = plane - 0.5 * gain;
        plane -= gain;
    }
    smooth(flow);
    return flow;
}

// Differences from layer to layer decay by themselves, and a pressure per layer cannot remove those that alternate.
void LayerBalance::smooth(std::vector<double>& flow) const {
    for (int pass = 0; pass < smoothing_passes; ++pass) {
        const double first = flow.front();
        double last = closed_ ? flow.back() : first;
        for (std::size_t l = 0; l < flow.size(); ++l) {
            const double here = flow[l], next = l + 1 < flow.size() ? flow[l + 1] : closed_ ? first : here;
            flow[l] = 0.25 * last + 0.5 * here + 0.25 * next;
            last = here;
        }
    }
}

}  // namespace porepack::lbm
