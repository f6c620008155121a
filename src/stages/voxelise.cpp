// Voxels of the section.
#include <utility>

#include "analysis/porosity.hpp"
#include "io/image.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

results::Voxelise write_voxels(const PoreSpace& space, const GeometryConfig& geometry, const Path& folder) {
    Voxels voxels = analysis::voxelise(space, geometry);
    write_phase_image(folder / "pore.vti", voxels.image);
    return written(std::move(voxels.outcome), folder);
}

Stage make_voxelise_stage(const Case& c) {
    return {.name = "voxelise",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container", "section"}, {"voxel_size_m", "reservoir_m"}, true),
            .outputs = {"pore.vti", "porosity.csv"},
            .run = [c](const Path& folder) { return write_voxels(case_pore_space(c), c.settings.geometry, folder); },
            .result_version = results::Voxelise::version};
}

}  // namespace porepack::stages
