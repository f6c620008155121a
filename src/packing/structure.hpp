// How the grains of a packing lie, touch and are distributed, from their exact poses.
#pragma once

#include <vector>

#include "packing/packing.hpp"

namespace porepack::packing {

struct RadialBin {
    double r0_m = 0.0;
    double r1_m = 0.0;
    double distribution = 0.0;  ///< pairs of centres over those of random points as far from the walls; 1 without order
};

struct Structure {
    /// Mean of a a^T over the axes a of all capsules, and of grains with faces, weighted by their length: 1/3 on the diagonal where no
    /// direction is preferred. Zero for shapes in which it is isotropic in every pose: spheres, tetrapods, tetrahedra, stars, cubes.
    Eigen::Matrix3d orientation = Eigen::Matrix3d::Zero();
    /// The same of the normals of all contacts between grains; zero without contacts.
    Eigen::Matrix3d contact_orientation = Eigen::Matrix3d::Zero();
    std::vector<long> neighbours;              ///< of each grain: others that it touches
    std::vector<long> grains_with_neighbours;  ///< [n]: number of grains that touch n others
    double mean_neighbours = 0.0;              ///< coordination number
    long contact_points = 0;                   ///< two concave grains can have several; one, if either has faces
    std::vector<RadialBin> radial_distribution;
};

/// Grains closer than `contact_gap_m` are in contact. The radial distribution of the centres of mass goes up to `range_m`, in `bins` bins;
/// its random points are always the same. Only the nearest periodic image of a grain counts: sides must be twice as wide as the grains.
[[nodiscard]] Structure structure_of(const Packing& packing, double contact_gap_m, double range_m, long bins);

/// Of each grain: it does not reach through a cut end of the container.
[[nodiscard]] std::vector<bool> whole_grains(const Packing& packing);

}  // namespace porepack::packing
