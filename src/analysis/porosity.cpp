#include "analysis/porosity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "analysis/uses.hpp"
#include "core/sides.hpp"
#include "core/table.hpp"

namespace porepack::analysis {
namespace {

// Porosity of layers that are half an equal-volume diameter of a grain high, or a hundredth of the bed.
Table porosity_profile(const PoreSpace& space) {
    const double bottom = space.bed_bottom_m, bed = space.bed_top_m - bottom;
    const double height = space.equivalent_diameter_m > 0.0 ? 0.5 * space.equivalent_diameter_m : 0.01 * bed;
    const int layers = std::clamp(static_cast<int>(std::ceil(bed / height)), 1, 1000);
    Table table({"z0_m", "z1_m", "porosity", "porosity_uncertainty"});
    for (int i = 0; i < layers; ++i) {
        const Section layer = {bottom + bed * i / layers, bottom + bed * (i + 1) / layers};
        const Porosity found = space.with_section(layer).porosity(4000);
        table.add(layer.z0_m, layer.z1_m, found.value, found.uncertainty);
    }
    return table;
}

}  // namespace

results::BedPorosity bed_porosity(const PoreSpace& bed) {
    const Porosity porosity = bed.porosity();
    return {.bed_height_m = bed.section.z1_m, .porosity_bed = porosity.value, .porosity_bed_uncertainty = porosity.uncertainty};
}

Voxels voxelise(const PoreSpace& space, const GeometryConfig& geometry) {
    const double size = space.voxel_size_m(geometry.voxel_size_m);
    const VoxelPlan plan = space.plan_at(size);
    Voxels voxels{.outcome = {}, .image = space.voxelise_at(size)};
    voxels.outcome.files.tables.emplace_back("porosity.csv", porosity_profile(space));
    std::array<double, 3> count = {0, 0, 0};
    const PoreSpace section = pore_space_of(voxels.image, space.container, space.section, space.source);
    for (const auto phase : section.phases_on(section.plan_at(0.0).grid).phase) count[phase] += 1.0;
    const Porosity exact = space.porosity();
    const double two = 2.0 * exact.uncertainty;  // standard uncertainties; not known (NaN) without exact walls
    voxels.outcome.result = {.voxel_size_m = plan.voxel_size_m,
                             .cells = plan.grid.cells,
                             .section_m = space.section.interval(),
                             .bed_m = {space.bed_bottom_m, space.bed_top_m},
                             .buffers_m = space.buffers_m,
                             .reservoir_m = space.reservoir_m,
                             .porosity_of_voxels = count[Phase::pore] / (count[Phase::pore] + count[Phase::grain]),
                             .porosity = exact.value,
                             .porosity_uncertainty = exact.uncertainty,
                             .porosity_interval = two >= 0.0 ? std::optional(about(exact.value, {two, two})) : std::nullopt,
                             .expected_memory_bytes = plan.memory_bytes};
    if (space.film_thickness_m > 0.0) voxels.outcome.result.film_thickness_m = space.film_thickness_m;
    if (space.closing_radius_m > 0.0) voxels.outcome.result.closing_radius_m = space.closing_radius_m;
    return voxels;
}

}  // namespace porepack::analysis
