#include "lbm/layers.hpp"

#include <algorithm>
#include <numeric>

namespace porepack::lbm {
using namespace converters;

Layers measure_layers(const Flow& flow, const Domain& domain) {
    const auto count = static_cast<std::size_t>(domain.grid.cells[static_cast<std::size_t>(domain.drive.axis)]);
    const std::vector<double> none(count, 0.0);
    const Layers empty{none, none, none, none, none, none, none};
    struct Sums {
        const Domain& domain;
        Layers layers;
        void visit(std::size_t cell, const Moments& here) {
            const std::size_t layer = domain.layer_of_cell(cell);
            const auto& u = here.velocity;
            const double along = u[static_cast<std::size_t>(domain.drive.axis)];
            layers.nodes[layer] += 1.0;
            layers.flow[layer] += along;
            layers.power[layer] += along * here.density;
            const double kinetic = 0.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            layers.kinetic[layer] += kinetic;
            layers.kinetic_flux[layer] += along * kinetic;
            layers.elastic[layer] += here.density * here.density / 6.0;
            layers.density[layer] += here.density;
        }
    };
    Layers all = empty;
    for_all_moments(
        flow, domain,
        [&] {
            return Sums{domain, empty};
        },
        [&](const Sums& sums) {
            for (const auto quantity : {&Layers::nodes, &Layers::flow, &Layers::power, &Layers::kinetic, &Layers::kinetic_flux,
                                        &Layers::elastic, &Layers::density})
                for (std::size_t l = 0; l < count; ++l) (all.*quantity)[l] += (sums.layers.*quantity)[l];
        });
    for (std::size_t l = 0; l < count; ++l) all.density[l] /= std::max(1.0, all.nodes[l]);
    return all;
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
