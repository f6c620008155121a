#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "tortuosity/tortuosity.hpp"
#include "tortuosity/uses.hpp"

namespace porepack::tortuosity {

// Eq. (T22).
double hydraulic_tortuosity(const FlowImage& flow, const Section& section, int axis) {
    double speed = 0.0, along = 0.0;
    for (int k = 0; k < flow.grid.cells[2]; ++k) {
        const double z = flow.grid.centre(2, k);
        if (z < section.z0_m || z > section.z1_m) continue;
        for (int j = 0; j < flow.grid.cells[1]; ++j)
            for (int i = 0; i < flow.grid.cells[0]; ++i) {
                const float* u = &flow.velocity_m_per_s[3 * flow.grid.index(i, j, k)];
                speed += std::sqrt(static_cast<double>(u[0]) * u[0] + static_cast<double>(u[1]) * u[1] + static_cast<double>(u[2]) * u[2]);
                along += u[axis];
            }
    }
    if (!(std::abs(along) > 1e-9 * speed))
        throw NumericalError(fmt::format("nothing flows along {}: the mean velocity there is {:g} of the mean speed", "xyz"[axis],
                                         speed > 0.0 ? along / speed : 0.0),
                             {.fix = "check the direction"});
    return speed / std::abs(along);
}

}  // namespace porepack::tortuosity
