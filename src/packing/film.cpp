#include "packing/film.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "packing/grains.hpp"
#include "packing/porosity.hpp"

namespace porepack::packing {
using namespace shapes;

Packing coated(Packing packing, double thickness_m) {
    for (Shape& shape : packing.shapes) {
        for (Capsule& capsule : shape.capsules) capsule.radius += thickness_m;
        if (shape.body == nullptr) {
            find_cavities(shape);
            continue;
        }
        auto body = shape.body->thinned(-thickness_m);
        if (body == nullptr)
            throw UserError(fmt::format("a film of {:g} m closes the hole of the grain `{}`", thickness_m, shape.id),
                            {.where = "[geometry] film_thickness_m", .fix = "choose a thinner film"});
        shape.body = std::move(body);
    }
    packing.overlap_allowed = true;
    return packing;
}

double film_thickness(const Packing& packing, const Section& part, double volume_fraction) {
    const auto pores_with = [&](double thickness) {
        return porosity(Grains(coated(packing, thickness)), packing.container, part, 20000).value;
    };
    const double dry = porosity(Grains(packing), packing.container, part, 20000).value, wanted = dry - volume_fraction;
    if (wanted <= 0.0)
        throw UserError(fmt::format("the films shall fill {:g} of the bed, whose porosity is {:.4g}", volume_fraction, dry),
                        {.where = "[geometry] film_volume_fraction", .allowed = "less than the porosity"});
    double low = 0.0, high = 0.01 * finest_diameter(packing), low_pores = dry, high_pores = pores_with(high);
    while (high_pores > wanted) {
        low = high;
        low_pores = high_pores;
        high *= 2.0;
        high_pores = pores_with(high);
    }
    while (high - low > 1e-4 * high) {
        // The pores are nearly a line in between; never nearer to an end than a tenth.
        const double share = std::clamp((low_pores - wanted) / (low_pores - high_pores), 0.1, 0.9), middle = low + share * (high - low);
        if (const double pores = pores_with(middle); pores > wanted)
            low = middle, low_pores = pores;
        else
            high = middle, high_pores = pores;
    }
    return 0.5 * (low + high);
}

}  // namespace porepack::packing
