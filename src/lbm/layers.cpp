#include "lbm/layers.hpp"
#include "lbm/uses.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace porepack::lbm {

Layers measure_layers(const Flow& flow, const Domain& domain) {
    const auto count = static_cast<std::size_t>(domain.grid.cells[static_cast<std::size_t>(domain.drive.axis)]);
    const std::vector<double> none(count, 0.0);
    const Layers empty{none, none, none, none, none, none, none};
    // Sums of one layer; they are added to `layers` when the next one begins.
    struct Sums {
        LayerFinder layer_of;
        std::size_t axis;
        Layers layers;
        std::size_t layer = 0;
        double nodes = 0.0, flow = 0.0, power = 0.0, kinetic = 0.0, kinetic_flux = 0.0, elastic = 0.0, density = 0.0;
        void visit(std::size_t cell, const Moments& here) {
            if (const std::size_t now = layer_of.of(cell); now != layer) {
                add_to_layer();
                layer = now;
            }
            const auto& u = here.velocity;
            const double along = u[axis], energy = 0.5 * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
            nodes += 1.0;
            flow += along;
            power += along * here.density;
            kinetic += energy;
            kinetic_flux += along * energy;
            elastic += here.density * here.density / 6.0;
            density += here.density;
        }
        void add_to_layer() {
            layers.nodes[layer] += std::exchange(nodes, 0.0);
            layers.flow[layer] += std::exchange(flow, 0.0);
            layers.power[layer] += std::exchange(power, 0.0);
            layers.kinetic[layer] += std::exchange(kinetic, 0.0);
            layers.kinetic_flux[layer] += std::exchange(kinetic_flux, 0.0);
            layers.elastic[layer] += std::exchange(elastic, 0.0);
            layers.density[layer] += std::exchange(density, 0.0);
        }
    };
    Layers all = empty;
    for_all_moments(
        flow, domain,
        [&] {
            return Sums{LayerFinder(domain), static_cast<std::size_t>(domain.drive.axis), empty};
        },
        [&](Sums& sums) {
            sums.add_to_layer();
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
