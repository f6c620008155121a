// A scan or a segmented image, read and put into the container.
#include "io/image.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/image.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "imaging/volume.hpp"
#include "inputs/image_input.hpp"
#include "inputs/mesh_vessel.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;

std::optional<Container> container_of_image(const Case& c) {
    const ContainerConfig& config = c.settings.container;
    const bool given = config.diameter_m > 0.0 || config.height_m > 0.0 || !config.size_m.empty() || !config.file.empty();
    return given ? std::optional(inputs::make_container(config, c.folder)) : std::nullopt;
}

namespace {

results::Image run_image(const Case& c, const Path& folder) {
    const ImageInput input = read_image(c.resolve(c.settings.image.file), c.settings.image, container_of_image(c));
    if (input.gray)
        io::write_gray_image(folder / "gray.vti", *input.gray->image());
    else
        io::write_phase_image(folder / "pore.vti", input.image);
    return analysis::describe_image(input);
}

}  // namespace

std::string image_file(const Case& c) {
    const imaging::ImageConfig& image = c.settings.image;
    const bool own = !image.threshold && image.pore.empty() && imaging::open_volume(c.resolve(image.file), image).header.own_fractions;
    return own || image.walls == imaging::ImageWalls::balls || has_gray_walls(image) ? "gray.vti" : "pore.vti";
}

Stage make_image_stage(const Case& c) {
    const Path file = c.resolve(c.settings.image.file);
    if (!fs::exists(file)) throw UserError("no such image: " + file.string(), {.where = "[image] file"});
    std::vector<Path> files = imaging::open_volume(file, c.settings.image).header.files;
    for (const Path& vessel : inputs::vessel_files(c.settings.container, c.folder)) files.push_back(vessel);
    return {.name = "image",
            .configuration = c.settings.resolved_tables({"image", "container"}),
            .files = std::move(files),
            .outputs = {image_file(c)},
            .run = [c](const Path& folder) { return run_image(c, folder); },
            .result_version = results::Image::version};
}

}  // namespace porepack::stages
