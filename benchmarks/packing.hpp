// Functions shared by the parts of the packing benchmark.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/json.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/liggghts/liggghts.hpp"

namespace porepack::benchmarks {

struct Bed {
    static constexpr std::size_t rings = 5, slabs = 8;
    double porosity_bed = 0.0, porosity_central = 0.0, coordination = 0.0, overlap = 0.0, largest_overlap = 0.0, seconds = 0.0;
    std::array<double, rings> by_radius{};  // of equal area, in the central section
    std::array<double, slabs> by_height{};  // of 5 mm, from the floor up
};
/// Porosity, contacts and overlaps of the exact capsules.
[[nodiscard]] Bed measure_bed(const packing::Packing& packing, double seconds);

struct PackingBench {
    core::Path folder;
    vessels::Container container;
    long grains = 100;
    bool quick = false;

    [[nodiscard]] pouring::PourResult by_capsules(const std::vector<shapes::ShapeShare>& shape, const pouring::PackingConfig& config) const;
    [[nodiscard]] pouring::PourResult by_liggghts(const std::vector<shapes::ShapeShare>& shape, pouring::PackingConfig config,
                                                  const std::optional<pouring::Pour>& given = {}) const;
    /// Seconds per step of the first run of the last LIGGGHTS pour, from its own "Loop time".
    [[nodiscard]] double liggghts_step_seconds() const;
};
/// A shape of the paper.
[[nodiscard]] std::vector<shapes::ShapeShare> paper_shape(shapes::ShapeKind kind, double sphericity);

/// Seconds per step of both engines from the same state: during a pour, and for a settled bed.
[[nodiscard]] core::Json step_costs(const PackingBench& bench);
/// Seconds per grain and step of settled beds, 100 grains to 10,000.
[[nodiscard]] core::Json cost_by_grains(const PackingBench& bench);
/// LIGGGHTS: porosity, overlap and wall time against time step and surface tolerance.
[[nodiscard]] core::Json time_step_table(const PackingBench& bench);
/// Cylinders and rings, all at once and batch after batch.
[[nodiscard]] core::Json grains_with_faces(const PackingBench& bench);
/// Porosity of beds of spheres as polyhedra of 320 faces, and of exact ones.
[[nodiscard]] core::Json spheres_of_faces(const PackingBench& bench);
/// Stiffness of a rod lying on the floor over that of one contact.
[[nodiscard]] core::Json lying_rods(const PackingBench& bench);

}  // namespace porepack::benchmarks
