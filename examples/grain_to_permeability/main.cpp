// A grain, a packing of it, and the packing's permeability.
#include <cstdio>

#include <porepack/core/error.hpp>
#include <porepack/lbm/permeability.hpp>
#include <porepack/shapes/shape.hpp>
#include <porepack/vessels/container.hpp>

using namespace porepack;

int main() try {
    // A tetrapod: capsules of 4 mm diameter, axes of 6 mm.
    const shapes::Shape tetrapod = shapes::make_preset(shapes::ShapeKind::tetrapod, 4e-3, 6e-3);

    // Four of them in a periodic box of 20 mm.
    packing::Packing packing{.container = vessels::make_box({0.02, 0.02, 0.02}, {true, true, true}), .shapes = {tetrapod}, .bodies = {}};
    for (const double x : {0.004, 0.014})
        for (const double z : {0.005, 0.015}) packing.bodies.push_back({.shape = 0, .position_m = shapes::Vec3(x, x, z)});

    const pore_space::PoreSpace pores = pore_space::pore_space_of(packing);
    const double voxel_size_m = 5e-4;
    const lbm::LbmResult result = lbm::lbm_permeability(pores, voxel_size_m, {.direction = core::Axis::z});
    const auto interval = result.interval_m2().value();
    std::printf("porosity %.4f, k = %.4g m2, %.4g to %.4g m2\n", pores.porosity().value, result.permeability_m2, interval.low,
                interval.high);
    return 0;
} catch (const core::Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return static_cast<int>(error.code());
}
