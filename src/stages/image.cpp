// A scan or a segmented image, read and put into the container.
#include "io/image.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "imaging/volume.hpp"
#include "inputs/image_input.hpp"
#include "pore_space/gray_solid.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;

std::optional<Container> container_of_image(const Case& c) {
    const ContainerConfig& config = c.settings.container;
    const bool given = config.diameter_m > 0.0 || config.height_m > 0.0 || !config.size_m.empty();
    return given ? std::optional(make_container(config)) : std::nullopt;
}

namespace {

constexpr const char* gray_meaning =
    "porosity of the level set in the container; the image is put with its middle on the container's axis, its first layer on the floor";

results::Image run_image(const Case& c, const Path& folder) {
    const ImageInput input = read_image(c.resolve(c.settings.image.file), c.settings.image, container_of_image(c));
    results::Image result{
        .file = input.file, .pores = input.pores, .gray = input.gray_notes, .container = to_json(input.container), .meaning = gray_meaning};
    if (input.gray) {
        io::write_gray_image(folder / "gray.vti", *input.gray->image());
        const double height = input.gray->image()->grid.cells[2] * input.gray->image()->grid.spacing_m[2];
        result.porosity_bed = porosity(*input.gray, input.container, {0.0, height}).value;
        return result;
    }
    io::write_phase_image(folder / "pore.vti", input.image);
    double pores = 0.0, inside = 0.0;
    for (const std::uint8_t phase : input.image.phase) {
        pores += phase == Phase::pore ? 1.0 : 0.0;
        inside += phase != Phase::outside ? 1.0 : 0.0;
    }
    result.porosity_bed = pores / inside;
    result.meaning =
        "porosity of all voxels in the container; the image is put with its middle on the container's axis, its first layer on the floor";
    return result;
}

}  // namespace

std::string image_file(const Case& c) {
    const imaging::ImageConfig& image = c.settings.image;
    const bool own =
        image.threshold.is_null() && image.pore.is_null() && imaging::open_volume(c.resolve(image.file), image).header.own_fractions;
    return own || has_gray_walls(image) ? "gray.vti" : "pore.vti";
}

Stage make_image_stage(const Case& c) {
    const Path file = c.resolve(c.settings.image.file);
    if (!fs::exists(file)) throw UserError("no such image: " + file.string(), {.where = "[image] file"});
    return {.name = "image",
            .configuration = c.settings.resolved_tables({"image", "container"}),
            .files = imaging::open_volume(file, c.settings.image).header.files,
            .outputs = {image_file(c)},
            .run = [c](const Path& folder) { return run_image(c, folder); }};
}

}  // namespace porepack::stages
