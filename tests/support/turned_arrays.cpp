#include "support/turned_arrays.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace porepack::test {
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;

double across_cylinders(double f) {
    return 1.0 - 2.0 * f / (1.0 + f - 0.305827 * std::pow(f, 4) / (1.0 - 1.402958 * std::pow(f, 8)) - 0.013362 * std::pow(f, 8));
}

double among_spheres(double f, bool body_centred) {
    const std::array<double, 6> a = body_centred ? std::array{0.1290, -0.41286, 0.76421, 0.2569, 0.0113, 0.00562}
                                                 : std::array{1.3047, 0.2305, 0.4054, 0.07231, 0.1526, 0.0105};
    const auto L = [](int i) { return -(2.0 * i - 1.0) / (2.0 * i); };
    return 1.0 - 3.0 * f /
                     (2.0 + f +
                      a[0] * L(2) * std::pow(f, 10.0 / 3.0) * (1.0 + a[1] * L(3) * std::pow(f, 11.0 / 3.0)) /
                          (1.0 - a[2] * L(2) * std::pow(f, 7.0 / 3.0)) +
                      a[3] * L(3) * std::pow(f, 14.0 / 3.0) + a[4] * L(4) * std::pow(f, 6.0) + a[5] * L(5) * std::pow(f, 22.0 / 3.0));
}

Eigen::Matrix3d TurnedArray::rotation() const {
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    if (turn == Turn::about_z) m << 0.6, -0.8, 0, 0.8, 0.6, 0, 0, 0, 1;
    if (turn == Turn::about_odd_axis) m << 1, 2, 2, 2, 1, -2, -2, 2, -1;
    return turn == Turn::about_odd_axis ? Eigen::Matrix3d(m / 3.0) : m;
}

Vec3 TurnedArray::rod_direction() const {
    return rotation() * (turn == Turn::about_z ? Vec3::UnitX() : Vec3::UnitZ());
}

double TurnedArray::diameter() const {
    if (grain == Grain::rod) return 2.0 * std::sqrt(solid_fraction / std::numbers::pi);
    return std::cbrt(6.0 * solid_fraction / (std::numbers::pi * (grain == Grain::body_centred ? 2.0 : 1.0)));
}

double TurnedArray::exact(Axis axis) const {
    if (grain != Grain::rod) return (1.0 - solid_fraction) / among_spheres(solid_fraction, grain == Grain::body_centred);
    const double along = std::pow(rod_direction()[static_cast<int>(axis)], 2);
    return (1.0 - solid_fraction) / (along * (1.0 - solid_fraction) + (1.0 - along) * across_cylinders(solid_fraction));
}

PoreSpace TurnedArray::space() const {
    const double side = turn == Turn::none ? 1.0 : turn == Turn::about_z ? 5.0 : 3.0;
    const Vec3 size(side, side, turn == Turn::about_z ? 1.0 : side);
    Packing packing;
    packing.container = vessels::make_box(size, {true, true, true});
    const bool rods = grain == Grain::rod;
    packing.shapes = {make_preset(rods ? ShapeKind::rod : ShapeKind::sphere, diameter(), rods ? 1.0 : 0.0)};
    const Capsule& axis = packing.shapes.front().capsules.front();
    Quaternion orientation = Quaternion::Identity();
    if (rods) orientation = Quaternion::FromTwoVectors(axis.b - axis.a, rod_direction());
    std::vector<Vec3> cell = {Vec3::Zero()};
    if (grain == Grain::body_centred) cell.push_back(Vec3::Constant(0.5));
    const int reach = 12;
    for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j <= reach; ++j)
            for (int k = -reach; k <= reach; ++k)
                for (const Vec3& place : cell) {
                    const Vec3 at = rotation() * (Vec3(i, j, k) + place) + shift;
                    if ((at.array() >= -1e-9).all() && (at.array() < size.array() - 1e-9).all())
                        packing.bodies.push_back({.shape = 0, .position_m = at, .orientation = orientation});
                }
    return pore_space_of(packing);
}

Vec3 random_shift(std::mt19937& random) {
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    return {unit(random), unit(random), unit(random)};
}

TurnedArray random_array(TurnedArray::Grain grain, TurnedArray::Turn turn, std::mt19937& random) {
    using Grain = TurnedArray::Grain;
    const double densest = grain == Grain::rod ? 0.6 : grain == Grain::simple_cubic ? 0.36 : 0.46;
    std::uniform_real_distribution<double> fraction(0.15, densest);
    return {.grain = grain, .turn = turn, .solid_fraction = fraction(random), .shift = random_shift(random)};
}

}  // namespace porepack::test
