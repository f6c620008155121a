// Grains found in a scan: the stage pack of a case with fit = true.
#include <utility>
#include <vector>

#include "analysis/fit_image.hpp"

#include "analysis/porosity.hpp"
#include "analysis/pour.hpp"
#include "core/json.hpp"
#include "imaging/volume.hpp"
#include "inputs/mesh_grains.hpp"
#include "inputs/mesh_vessel.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace {

imaging::VolumeHeader scan_of(const Case& c) {
    return imaging::open_volume(c.resolve(c.settings.image.file), c.settings.image).header;
}

results::Pack run_fit(const Case& c, const Path& folder) {
    std::vector<shapes::Shape> shapes;
    for (const shapes::ShapeShare& share : case_shapes(c)) shapes.push_back(share.shape);
    results::Pack result{.engine = "fit"};
    result.fit = written(fit_image(c.resolve(c.settings.image.file), c.settings.image, container_of_image(c), shapes), folder);
    const Packing packing = read_packing(folder / "packing.json");
    add_grains(result, packing);
    result.bed = bed_porosity(pore_space_of(packing));
    return result;
}

}  // namespace

Stage make_fit_stage(const Case& c) {
    std::vector<Path> files = scan_of(c).files;
    for (const Path& file : inputs::mesh_files(c.settings.shape, c.folder)) files.push_back(file);
    for (const Path& file : inputs::vessel_files(c.settings.container, c.folder)) files.push_back(file);
    return {.name = "pack",
            .configuration = c.settings.resolved_tables({"shape", "image", "container"}),
            .files = std::move(files),
            .outputs = {"packing.json"},
            .run = [c](const Path& folder) { return run_fit(c, folder); },
            .expect = [c] { return expect_fit(static_cast<double>(scan_of(c).count())); },
            .result_version = results::Pack::version};
}

}  // namespace porepack::stages
