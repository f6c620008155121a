#include "stages/inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "imaging/phases.hpp"
#include "io/image.hpp"

namespace porepack::stages {
using namespace core;
using namespace io;
using namespace packing;
using namespace converters;
namespace {

constexpr const char* container_flag = "--container cylinder:D,H or box:X,Y,Z[:periodic] (metres)";

PoreSpace load_surface(const Path& input, const InputOptions& options) {
    if (!options.container) throw UserError("an STL file needs a container", {.where = input.string(), .allowed = container_flag});
    return pore_space_of(read_stl(input, options.unit_m), *options.container, input.string());
}

// --container, the image's own, or the box that the image fills.
Container container_of_image(const PhaseImage& image, const std::optional<Container>& given, const Path& file) {
    if (given) return *given;
    if (const auto note = image.notes.find("container"); note != image.notes.end()) {
        const Json json = Json::parse(note->second, nullptr, false);
        if (json.is_discarded())
            throw UserError("the image's field data `container` is not JSON: " + note->second,
                            {.where = file.string(), .fix = container_flag});
        return container_from_json(json, file.string());
    }
    Container box{.kind = Container::Kind::box};
    for (const int axis : {0, 1, 2}) {
        const auto a = static_cast<std::size_t>(axis);
        box.size_m[axis] = image.grid.cells[a] * image.grid.spacing_m[a];
    }
    return box;
}

// An image of another producer has no place in the container: its middle is put on the container's axis, and its first layer on the floor.
void place(PhaseImage& image, const Container& container) {
    if (image.notes.contains("container")) return;
    Grid& grid = image.grid;
    const shapes::Vec3 middle = 0.5 * (container.low() + container.high());
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        grid.origin_m[a] = middle[axis] - 0.5 * grid.cells[a] * grid.spacing_m[a];
    }
    grid.origin_m[2] = 0.0;
}

// What lies outside a cylinder is no pore, whatever the image shows there.
void leave_out_outside(PhaseImage& image, const Container& container) {
    if (container.kind != Container::Kind::cylinder) return;
    const Grid& grid = image.grid;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (!container.contains_column(grid.centre(0, i), grid.centre(1, j)))
                for (int k = 0; k < grid.cells[2]; ++k) image.phase[grid.index(i, j, k)] = Phase::outside;
}

PoreSpace load_image(const Path& file, const InputOptions& options) {
    ImageInput found = read_image(file, options.image, options.container);
    const Grid& grid = found.image.grid;
    if (!found.description["own"].get<bool>())
        log_info("image: {}, {} x {} x {} voxels of {:.4g} m ({}), {}; pores: {}", found.description["format"].get<std::string>(),
                 grid.cells[0], grid.cells[1], grid.cells[2], grid.spacing_m[2], found.description["voxel_size_from"].get<std::string>(),
                 found.description["orientation"].get<std::string>(), found.description["pores"].get<std::string>());
    Section section{grid.origin_m[2], grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2]};
    if (const auto& given = options.geometry.section_m; given.size() == 2)
        section = {given[0], given[1]};
    else if (const auto note = found.image.notes.find("section"); note != found.image.notes.end())
        section = section_of_note(note->second, file);
    return pore_space_of(std::move(found.image), found.container, section, file.string());
}

PoreSpace load_slices(const Path& folder, const InputOptions& options) {
    SliceStack stack = read_slices(folder);
    PoreSpace space{.container = stack.container, .section = stack.section};
    space.image = std::make_shared<const PhaseImage>(PhaseImage{.grid = stack.grid, .phase = std::move(stack.phase), .notes = {}});
    if (const auto& given = options.geometry.section_m; given.size() == 2) space.section = {given[0], given[1]};
    return space;
}

PoreSpace with_ends(const PoreSpace& space, const SectionConfig& section) {
    PoreSpace ready = space.with_ends(section.ends, section.buffer_m);
    if (section.ends != Ends::in_situ || space.container.periodic[2]) return ready;
    if (ready.ends == Ends::planes)
        log_warning(
            fmt::format("{}: the image ends at the section, so the flow is computed between planes of constant pressure there; k "
                        "is too high where they cut grains",
                        space.source));
    return ready;
}

}  // namespace

ImageInput read_image(const Path& file, const imaging::ImageConfig& config, const std::optional<Container>& container) {
    const imaging::VolumeSource source = imaging::open_volume(file, config);
    imaging::SegmentedImage found = imaging::segmented(source, config, file.string());
    ImageInput input{.image = std::move(found.image)};
    const bool own = source.header.own_phases && input.image.notes.contains("container");
    input.container = container_of_image(input.image, container, file);
    place(input.image, input.container);
    leave_out_outside(input.image, input.container);
    input.image.notes["container"] = to_json(input.container).dump();
    const imaging::VolumeHeader& header = source.header;
    input.description = {{"format", header.format},
                         {"voxels", header.voxels},
                         {"voxel_size_m", header.spacing_m},
                         {"voxel_size_from", header.size_source},
                         {"orientation", header.orientation},
                         {"pores", found.pore_level},
                         {"own", own}};
    return input;
}

bool is_packing(const Path& input) {
    const std::string name = input.filename().string();
    return name.ends_with(".json") || name.ends_with(".json.gz");
}

bool is_surface(const Path& input) {
    return input.extension() == ".stl" || input.extension() == ".STL";
}

bool is_image(const Path& input) {
    return std::filesystem::exists(input / "slices.json") || imaging::is_volume(input);
}

bool is_case(const Path& input) {
    return std::filesystem::is_directory(input) ? std::filesystem::exists(input / "case.toml") : input.extension() == ".toml";
}

PoreSpace load_pore_space(const Path& input, const InputOptions& options) {
    if (!(options.unit_m >= 1e-12 && options.unit_m <= 1e6))
        throw UserError(fmt::format("a unit of {:g} m is not possible", options.unit_m), {.allowed = "1e-12 to 1e6 (0.001: millimetres)"});
    PoreSpace space;
    if (!imaging::is_volume(input) && resolved_config(options.image) != resolved_config(imaging::ImageConfig()))
        throw UserError("--image-... have no effect here: they belong to images", {.where = input.string(), .fix = "remove them"});
    if (is_packing(input))
        space = pore_space_of(read_packing(input));
    else if (is_surface(input))
        space = load_surface(input, options);
    else if (is_image(input))
        space = std::filesystem::exists(input / "slices.json") ? load_slices(input, options) : load_image(input, options);
    else
        throw UserError(
            "cannot tell what " + input.string() + " is",
            {.allowed = "packing.json, packing.json.gz, an .stl file, an image (docs/images.md), a folder of slices, or a case"});
    space.source = input.string();
    if (options.whole_bed) return space;
    if (space.image) return with_ends(space, options.section);
    const GeometryConfig& geometry = options.geometry;
    space.section = choose_section(space.container, {.section_m = geometry.section_m, .trim_m = geometry.trim_m},
                                   {space.bed_bottom_m, space.bed_top_m}, space.maximum_feret_diameter_m);
    if (space.porosity(2000).value == 1.0 && space.porosity().value == 1.0)  // few lines may miss small grains
        throw UserError(
            fmt::format("there is no grain in the section from {:g} to {:g} m", space.section.z0, space.section.z1),
            {.allowed = fmt::format("a section in the bed, which reaches from {:g} to {:g} m", space.bed_bottom_m, space.bed_top_m)});
    space.reservoir_m = geometry.reservoir_m;
    if (space.section.length() < space.maximum_feret_diameter_m && !space.container.periodic[2])
        log_warning(fmt::format(
            "the section is {:.3g} m long, less than one grain's maximum Feret diameter ({:.3g} m): it hardly represents the packing",
            space.section.length(), space.maximum_feret_diameter_m));
    return with_ends(space, options.section);
}

Section section_of_note(const std::string& note, const Path& file) {
    Section section;
    if (std::sscanf(note.c_str(), "%lf,%lf", &section.z0, &section.z1) != 2 || !std::isfinite(section.z0) || !std::isfinite(section.z1))
        throw UserError("the image's field data `section` is not \"z0,z1\": " + note,
                        {.where = file.string(), .fix = "--section z0,z1 (metres)"});
    return section;
}

}  // namespace porepack::stages
