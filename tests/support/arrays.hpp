// Flows that several tests solve: known ones, and random beds.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <utility>

#include "support/helpers.hpp"
#include "support/known_flows.hpp"
#include "vessels/config.hpp"

namespace porepack::test {

inline LbmResult solve(const KnownFlow& known, double cells_per_unit, LbmConfig config, bool with_flow = false) {
    config.direction = config.direction == Axis::z ? known.direction : config.direction;
    return lbm_permeability(known.space(), 1.0 / cells_per_unit, config, {.with_flow = with_flow});
}

inline double error_of(const KnownFlow& known, double cells_per_unit, const LbmConfig& config) {
    return solve(known, cells_per_unit, config).fine().permeability_m2 / known.permeability_m2 - 1.0;
}

/// A packing with its voxels and its domain.
struct Scene {
    Packing packing;
    Section section;
    std::unique_ptr<Grains> grains;
    PhaseImage image;
    Drive drive;
    Domain domain;

    Scene(Packing grains_of, const Section& part, double voxel, double reservoir = 0.0, Axis axis = Axis::z)
        : packing(std::move(grains_of)), section(part) {
        grains = std::make_unique<Grains>(packing);
        image = voxelise(*grains, packing.container, section,
                         plan_voxels(packing.container, section, voxel, {.reservoir_m = reservoir}, 1.0).grid);
        drive = choose_drive(packing.container, axis);
        const FlowWalls walls{*grains, packing.container, section};
        domain = build_domain(image, drive, &walls);
    }
};

/// Grains that overlap at random: gaps of one node, grains cut by the planes, contacts with the wall.
inline Packing random_bed(const std::string& container, int grains, double radius) {
    Packing packing{
        .container = parse_container(container), .shapes = {make_preset(ShapeKind::tetrapod, 2.0 * radius, 2.0 * radius)}, .bodies = {}};
    std::mt19937 random(7);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const Vec3 low = packing.container.low(), size = packing.container.high() - low;
    for (int i = 0; i < grains; ++i) {
        const Vec3 at = low + Vec3(unit(random), unit(random), unit(random)).cwiseProduct(size);
        const Eigen::Vector4d q(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
        packing.bodies.push_back({.shape = 0, .position_m = at, .orientation = Quaternion(q[0], q[1], q[2], q[3]).normalized()});
    }
    return packing;
}

}  // namespace porepack::test
