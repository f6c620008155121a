// Slices of the section, as images.
#include "converters/slices.hpp"
#include "core/error.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

results::Slices write_slice_images(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    if (!space.has_exact_walls()) throw UserError("slices are made of a packing or an STL file, not of an image", {.where = space.source});
    const int count = write_slices(folder, *space.solid, space.container, space.section, geometry.slice_spacing_m, geometry.slice_pixel_m);
    return {
        .slices = count, .spacing_m = geometry.slice_spacing_m, .pixel_m = geometry.slice_pixel_m, .section_m = space.section.interval()};
}

Stage make_slices_stage(const Case& c) {
    return {.name = "slices",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container"}, {"slice_spacing_m", "slice_pixel_m"}, true),
            .outputs = {"slices.json", "*.png"},
            .run = [c](const Path& folder) { return write_slice_images(case_pore_space(c), c.settings.geometry, folder); },
            .result_version = results::Slices::version};
}

}  // namespace porepack::stages
