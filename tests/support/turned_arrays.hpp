// Arrays whose tortuosity factor is known exactly, for tests and benchmarks. Lengths in units of the array's pitch.
#pragma once

#include <random>

#include "pore_space/pore_space.hpp"

namespace porepack::test {

/// D_eff/D0 across a square array of insulating cylinders (Rayleigh 1892; Perrins, McKenzie & McPhedran 1979).
[[nodiscard]] double across_cylinders(double solid_fraction);
/// Of insulating spheres in simple or body-centred cubic order (Sangani & Acrivos 1983); the series are good to 1e-3 up to solid fractions
/// of 0.36 and 0.46.
[[nodiscard]] double among_spheres(double solid_fraction, bool body_centred);

/// An array of pitch 1, turned by a rotation with rational entries and moved, in the smallest periodic box.
struct TurnedArray {
    enum class Grain { rod, simple_cubic, body_centred } grain = Grain::rod;
    enum class Turn { none, about_z, about_odd_axis } turn = Turn::none;  ///< about_z: by the angle of a triangle 3-4-5
    double solid_fraction = 0.0;
    shapes::Vec3 shift = shapes::Vec3::Zero();

    [[nodiscard]] double diameter() const;
    [[nodiscard]] double exact(core::Axis axis) const;  ///< tortuosity factor
    [[nodiscard]] pore_space::PoreSpace space() const;

private:
    [[nodiscard]] Eigen::Matrix3d rotation() const;
    [[nodiscard]] shapes::Vec3 rod_direction() const;
};

[[nodiscard]] shapes::Vec3 random_shift(std::mt19937& random);
/// Solid fraction from 0.15 to the densest of which the answer is known, at a random position.
[[nodiscard]] TurnedArray random_array(TurnedArray::Grain grain, TurnedArray::Turn turn, std::mt19937& random);

}  // namespace porepack::test
