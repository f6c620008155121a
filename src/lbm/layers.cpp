#include "lbm/layers.hpp"
#include "lbm/uses.hpp"

#include <numeric>

namespace porepack::lbm {

double mean_density(const std::vector<double>& nodes, const std::vector<double>& density) {
    return std::inner_product(density.begin(), density.end(), nodes.begin(), 0.0) / std::accumulate(nodes.begin(), nodes.end(), 0.0);
}

// Eq. (T13).
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
