// Flows whose permeability is known exactly, for tests and benchmarks. Lengths in units of a cell of the array.
#pragma once

#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "lbm/permeability.hpp"
#include "packing/grains.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::test {

struct KnownFlow {
    std::string name;
    packing::Packing packing;  ///< of an array
    std::shared_ptr<const geometry::Solid> solid;
    vessels::Container container;
    core::Axis direction = core::Axis::z;
    double permeability_m2 = 0.0;
    double diameter_m = 0.0;  ///< diameter of a grain, or width of a duct
    [[nodiscard]] pore_space::PoreSpace space() const;
};

/// Centres of the spheres in a unit cell.
[[nodiscard]] inline std::vector<shapes::Vec3> simple_cubic() {
    return {{0.5, 0.5, 0.5}};
}
[[nodiscard]] inline std::vector<shapes::Vec3> body_centred() {
    return {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}};
}
[[nodiscard]] inline std::vector<shapes::Vec3> face_centred() {
    return {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}, {0.75, 0.25, 0.75}, {0.25, 0.75, 0.75}};
}

/// Drag factor K of Zick & Homsy (1982): Eq. (T25).
struct SphereDrag {
    double solid_fraction, simple_cubic, body_centred;  ///< 0 where there is no such array
};
/// Drag F/(mu U) per length of a square array of cylinders of pitch 1 (Drummond & Tahir 1984); k = 1/drag.
struct CylinderDrag {
    double solid_fraction, across, along;
};
[[nodiscard]] std::span<const SphereDrag> sphere_drags();
[[nodiscard]] std::span<const CylinderDrag> cylinder_drags();

/// Spheres in a periodic unit cell, at `centres` + `shift`.
[[nodiscard]] KnownFlow sphere_array(double solid_fraction, double drag, const std::vector<shapes::Vec3>& centres,
                                     const shapes::Vec3& shift = shapes::Vec3::Zero());
/// Cylinders along z in a periodic cell 1 x 1 x `height`.
[[nodiscard]] KnownFlow cylinder_array(double solid_fraction, double drag, double height, const shapes::Vec3& shift, core::Axis direction);
/// A simple cubic array rotated about z by the angle whose tangent is 3/4: 25 cells in a box 5 x 5 x 1.
[[nodiscard]] KnownFlow turned_array(double solid_fraction, double drag);
/// Three layers of a simple cubic array, centres at z = 1.5, 2.5 and 3.5, in a box 1 x 1 x 6 that is periodic in x and y alone.
/// `permeability_m2` is that of the array, and of one period anywhere between the layers.
[[nodiscard]] KnownFlow three_layers(double solid_fraction, double drag);
/// Void where depth(x, y) > 0, in a periodic box 1 x 1 x `height` along z; `flow_rate` at gradient and viscosity 1.
[[nodiscard]] KnownFlow duct(const std::string& name, std::function<double(double x, double y)> depth, double width, double flow_rate,
                             double height = 0.25);

/// Arrays of all tabulated fractions at random positions on the grid, and slits, ellipses and rectangles at random angles: 35 in total.
/// `height`: of the periodic box of cylinders and ducts, on which the answer does not depend.
[[nodiscard]] std::vector<KnownFlow> random_known_flows(unsigned seed, double height = 0.25);

}  // namespace porepack::test
