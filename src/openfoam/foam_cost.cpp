#include "openfoam/foam_cost.hpp"
#include "openfoam/uses.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace porepack::openfoam {

double expected_foam_cells(const PoreSpace& space, double cell_size_m, long surface_level, double porosity) {
    const Container& container = space.container;
    const double length = space.computed().length() + 2.0 * space.reservoir_m,
                 volume = container.vessel().mean_area(space.computed().interval()) * length;
    double surface_to_solid = 4.0 / space.grain_size_m;  // of long capsules
    if (space.packing()) {
        double area = 0.0, solid = 0.0;
        std::vector<double> areas, volumes;
        for (const auto& shape : space.packing()->shapes) {
            const auto measures = shapes::measure(shape, 1e-4);
            areas.push_back(measures.surface_area_m2);
            volumes.push_back(measures.volume_m3);
        }
        for (const auto& body : space.packing()->bodies) area += areas[body.shape], solid += volumes[body.shape];
        surface_to_solid = area / solid;
    }
    // A box's own sides are faces of the background block, which are not refined.
    const double wall = container.vessel().fills_bounds() ? 0.0 : container.vessel().side_per_volume() * volume;
    const double surface = surface_to_solid * (1.0 - porosity) * volume + wall;
    double cells = 0.0, refined_before = 1.0;
    for (long level = 0; level <= surface_level; ++level) {
        const double thickness = 1.4 * cell_size_m / std::exp2(static_cast<double>(level));  // of the layer that the next level refines
        const double refined = level < surface_level ? 1.0 - std::exp(-surface * thickness / (porosity * volume)) : 0.0;
        cells += std::exp2(3.0 * static_cast<double>(level)) * (refined_before - refined);
        refined_before = refined;
    }
    return cells * porosity * volume / std::pow(cell_size_m, 3);
}

}  // namespace porepack::openfoam
