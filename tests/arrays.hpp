// Periodic arrays whose permeability is known, and solids made for tests.
#pragma once

#include <cmath>
#include <numbers>

#include "lbm/permeability.hpp"

namespace porepack::test {

struct Array {
    Packing packing;
    double permeability_m2 = 0.0;
    double diameter_m = 0.0;
};

// Spheres in a unit cell; `centres` and `shift` in units of it; drag factor K of Zick & Homsy (1982): k = 2 a^2/(9 c K).
inline Array sphere_array(double solid_fraction, double drag, const std::vector<Vec3>& centres, const Vec3& shift = Vec3::Zero()) {
    Array array;
    array.packing.container = parse_container("box:1,1,1:periodic");
    const double r = std::cbrt(3.0 * solid_fraction / (4.0 * std::numbers::pi * static_cast<double>(centres.size())));
    array.packing.shapes.push_back({.id = "sphere", .capsules = {{Vec3::Zero(), Vec3::Zero(), r}}});
    for (const Vec3& centre : centres) {
        Vec3 at = centre + shift;
        for (int a = 0; a < 3; ++a) at[a] -= std::floor(at[a]);
        array.packing.bodies.push_back({.shape = 0, .position_m = at});
    }
    array.permeability_m2 = 2.0 * r * r / (9.0 * solid_fraction * drag);
    array.diameter_m = 2.0 * r;
    return array;
}

inline const std::vector<Vec3> simple_cubic = {{0.5, 0.5, 0.5}}, body_centred = {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}};

// A square array of cylinders along z, pitch 1, in a cell `height` high.
inline Array cylinder_array(double solid_fraction, double permeability, double height, const Vec3& shift) {
    Array array;
    array.packing.container = {.kind = Container::Kind::box, .size_m = {1, 1, height}, .periodic = {true, true, true}};
    const double r = std::sqrt(solid_fraction / std::numbers::pi);
    array.packing.shapes.push_back({.id = "cylinder", .capsules = {{Vec3(0, 0, -2), Vec3(0, 0, 3), r}}});
    array.packing.bodies.push_back({.shape = 0, .position_m = {0.5 + shift.x(), 0.5 + shift.y(), 0.0}});
    array.permeability_m2 = permeability;
    array.diameter_m = 2.0 * r;
    return array;
}

// A simple cubic array turned about z by the angle whose tangent is 3/4: 25 cells of pitch 1/5 in a box 1 x 1 x 1/5.
inline Array turned_array(double solid_fraction, double drag) {
    Array array = sphere_array(solid_fraction, drag, simple_cubic);
    array.packing.container.size_m = {5, 5, 1};
    array.packing.bodies.clear();
    for (int i = -10; i <= 10; ++i)
        for (int j = -10; j <= 10; ++j) {
            const Vec3 at(0.8 * i - 0.6 * j + 0.13, 0.6 * i + 0.8 * j + 0.29, 0.5);
            if ((at.array() >= 0.0).all() && at.x() < 5.0 && at.y() < 5.0) array.packing.bodies.push_back({.shape = 0, .position_m = at});
        }
    return array;
}

inline LbmScene scene_of(const Array& array, const Grains& grains) {
    const Container& box = array.packing.container;
    const Section whole{0.0, box.size_m.z()};
    return {.voxels = [&, whole](double size) { return voxelise(grains, box, whole, plan_voxels(box, whole, size, 0.0, 1.0)); },
            .solid = &grains,
            .container = box,
            .section = whole,
            .grain_size_m = array.diameter_m > 0.0 ? array.diameter_m : std::numeric_limits<double>::infinity()};
}

inline LbmResult solve(const Array& array, double cells_a_unit, const LbmConfig& config, bool with_flow = false) {
    const Grains grains(array.packing);
    return lbm_permeability(scene_of(array, grains), 1.0 / cells_a_unit, config, with_flow);
}

inline double error_of(const Array& array, double cells_a_unit, const LbmConfig& config) {
    return solve(array, cells_a_unit, config).fine().permeability_m2 / array.permeability_m2 - 1.0;
}

}  // namespace porepack::test
