// Voxels and slices of the section.
#include "core/error.hpp"
#include "io/image.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"

namespace porepack::stages {
using namespace core;
using namespace io;
using namespace packing;
using namespace converters;
using namespace lbm;
using namespace pipeline;

Json write_voxels(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    const double size = space.voxel_size_m(geometry.voxel_size_m);
    const VoxelPlan plan = space.plan_at(size);
    const PhaseImage image = space.voxelise_at(size);
    write_phase_image(folder / "pore.vti", image);
    std::array<double, 3> count = {0, 0, 0};
    const PoreSpace section = pore_space_of(image, space.container, space.section, space.source).section_only();
    for (const auto phase : section.image->phase) count[phase] += 1.0;
    const Porosity exact = space.porosity();
    return {{"voxel_size_m", plan.voxel_size_m},
            {"cells", plan.grid.cells},
            {"section_m", section_json(space.section)},
            {"buffers_m", space.buffers_m},
            {"reservoir_m", space.reservoir_m},
            {"porosity_of_voxels", count[Phase::pore] / (count[Phase::pore] + count[Phase::grain])},
            {"porosity", exact.value},
            {"porosity_uncertainty", exact.uncertainty},
            {"expected_memory_bytes", plan.memory_bytes}};
}

Json write_slice_images(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    if (!space.solid) throw UserError("slices are made of a packing or an STL file, not of an image", {.where = space.source});
    const int count = write_slices(folder, *space.solid, space.container, space.section, geometry.slice_spacing_m, geometry.slice_pixel_m);
    return {{"slices", count},
            {"spacing_m", geometry.slice_spacing_m},
            {"pixel_m", geometry.slice_pixel_m},
            {"section_m", section_json(space.section)}};
}

Stage make_voxelise_stage(const Case& c) {
    return {.name = "voxelise",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container", "section"}, {"voxel_size_m", "reservoir_m"}, true),
            .outputs = {"pore.vti"},
            .run = [c](const Path& folder) { return write_voxels(case_pore_space(c), c.settings.geometry, folder); }};
}

Stage make_slices_stage(const Case& c) {
    return {.name = "slices",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container"}, {"slice_spacing_m", "slice_pixel_m"}, true),
            .outputs = {"slices.json", "*.png"},
            .run = [c](const Path& folder) { return write_slice_images(case_pore_space(c), c.settings.geometry, folder); }};
}

}  // namespace porepack::stages
