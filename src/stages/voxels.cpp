// Voxels and slices of the section.
#include <algorithm>
#include <cmath>

#include "converters/slices.hpp"
#include "core/error.hpp"
#include "core/sides.hpp"
#include "core/table.hpp"
#include "io/image.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace geometry;
using namespace io;
using namespace packing;
using namespace converters;
using namespace pore_space;
using namespace pipeline;

namespace {

// Porosity of layers that are half an equal-volume diameter of a grain high, or a hundredth of the bed.
void write_porosity_profile(const PoreSpace& space, const Path& file) {
    const double bottom = space.bed_bottom_m, bed = space.bed_top_m - bottom;
    const double height = space.equivalent_diameter_m > 0.0 ? 0.5 * space.equivalent_diameter_m : 0.01 * bed;
    const int layers = std::clamp(static_cast<int>(std::ceil(bed / height)), 1, 1000);
    Table table({"z0_m", "z1_m", "porosity", "porosity_uncertainty"});
    for (int i = 0; i < layers; ++i) {
        const Section layer = {bottom + bed * i / layers, bottom + bed * (i + 1) / layers};
        const Porosity found = space.with_section(layer).porosity(4000);
        table.add(layer.z0, layer.z1, found.value, found.uncertainty);
    }
    table.write(file);
}

}  // namespace

results::Voxelise write_voxels(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    const double size = space.voxel_size_m(geometry.voxel_size_m);
    const VoxelPlan plan = space.plan_at(size);
    const PhaseImage image = space.voxelise_at(size);
    write_phase_image(folder / "pore.vti", image);
    write_porosity_profile(space, folder / "porosity.csv");
    std::array<double, 3> count = {0, 0, 0};
    const PoreSpace section = pore_space_of(image, space.container, space.section, space.source).section_only();
    for (const auto phase : section.image->phase) count[phase] += 1.0;
    const Porosity exact = space.porosity();
    const double two = 2.0 * exact.uncertainty;  // standard uncertainties; not known (NaN) without exact walls
    return {.voxel_size_m = plan.voxel_size_m,
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
}

results::Slices write_slice_images(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    if (!space.solid) throw UserError("slices are made of a packing or an STL file, not of an image", {.where = space.source});
    const int count = write_slices(folder, *space.solid, space.container, space.section, geometry.slice_spacing_m, geometry.slice_pixel_m);
    return {
        .slices = count, .spacing_m = geometry.slice_spacing_m, .pixel_m = geometry.slice_pixel_m, .section_m = space.section.interval()};
}

Stage make_voxelise_stage(const Case& c) {
    return {.name = "voxelise",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container", "section"}, {"voxel_size_m", "reservoir_m"}, true),
            .outputs = {"pore.vti", "porosity.csv"},
            .run = [c](const Path& folder) { return write_voxels(case_pore_space(c), c.settings.geometry, folder); },
            .result_version = 3};
}

Stage make_slices_stage(const Case& c) {
    return {.name = "slices",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container"}, {"slice_spacing_m", "slice_pixel_m"}, true),
            .outputs = {"slices.json", "*.png"},
            .run = [c](const Path& folder) { return write_slice_images(case_pore_space(c), c.settings.geometry, folder); }};
}

}  // namespace porepack::stages
