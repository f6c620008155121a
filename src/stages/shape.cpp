// The grain itself.
#include "analysis/shape.hpp"

#include "converters/surface_file.hpp"
#include "inputs/mesh_grains.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

Stage make_shape_stage(const Case& c) {
    const double density = c.settings.packing.density_kg_per_m3;
    Stage stage{.name = "shape", .configuration = c.settings.resolved_tables({"shape"}), .result_version = results::Shape::version};
    if (c.from_surface()) {
        const Path file = c.resolve(c.settings.shape.file);
        stage.files = {file};
        stage.run = [=, unit_m = surface_unit_m(c.settings.shape)](const Path&) {
            return measure_surface_shape(converters::read_surface(file, unit_m), file.string(), density);
        };
    } else {
        stage.files = inputs::mesh_files(c.settings.shape, c.folder);
        stage.run = [=, shape = c.settings.shape, folder = c.folder](const Path& output) {
            if (shape.kind == shapes::ShapeKind::mesh) write_mesh_grain(shape, folder, output);
            return measure_shape(shape, density, folder);
        };
    }
    return stage;
}

}  // namespace porepack::stages
