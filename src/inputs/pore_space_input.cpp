#include "inputs/pore_space_input.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "converters/slices.hpp"
#include "converters/surface.hpp"
#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "inputs/image_input.hpp"
#include "inputs/uses.hpp"
#include "packing/film.hpp"
#include "pore_space/closing.hpp"
#include "pore_space/image_solid.hpp"
#include "record/resolved_config.hpp"
#include "scans/ball_walls.hpp"
#include "scans/doubts.hpp"
#include "scans/find_tube.hpp"
#include "scans/gray_input.hpp"
#include "scans/layer_profile.hpp"
#include "scans/phases.hpp"

namespace porepack::inputs {
namespace {

const Container& container_of_surface(const std::string& name, const InputOptions& options) {
    if (!options.container) throw UserError("a surface needs a container", {.where = name, .allowed = container_flag()});
    return *options.container;
}

// Standard uncertainty: of the gray levels; where a wall was subtracted, its place is known to about 0.15 voxels, judged on simulated scans
// as the half width of 95 %.
double porosity_error(const GrayNotes& notes, const PoreSpace& space) {
    constexpr double wall_voxels = 0.15;
    const double wall = notes.tube_removed ? 4.0 * wall_voxels * space.image_voxel_size_m / *space.container.tube_diameter() : 0.0;
    return std::hypot(notes.fraction_error, 0.5 * wall);
}

PoreSpace space_of(ImageInput found, const Path& file, const InputOptions& options) {
    const Grid& grid = found.gray ? found.gray->image()->grid : found.image.grid;
    if (!found.own)
        log_info("image: {}, {} x {} x {} voxels of {:.4g} m ({}), {}; pores: {}", found.file.format, grid.cells[0], grid.cells[1],
                 grid.cells[2], grid.spacing_m[2], found.file.voxel_size_from, found.file.orientation, found.pores);
    if (found.gray && scans::has_walls_of_balls(*found.gray)) {
        log_info("walls around the largest balls that fit into the solid voxels");
    } else if (found.gray_notes) {
        const GrayNotes& gray = *found.gray_notes;
        log_info("gray values: pores {:.5g}, solid {:.5g}, noise {:.2g} %, smoothed by {:.2g} voxels, then blur {:.2g} voxels{}",
                 gray.pore_level, gray.solid_level, 100.0 * gray.noise, gray.smoothing_voxels, gray.blur_voxels,
                 gray.tube_removed ? "; the container's wall is visible and was subtracted" : "");
    }
    const auto& notes = found.gray ? found.gray->image()->notes : found.image.notes;
    Section section{grid.origin_m[2], grid.origin_m[2] + grid.cells[2] * grid.spacing_m[2]};
    if (const auto& given = options.geometry.section_m; given.size() == 2) {
        section = {given[0], given[1]};
        if (const auto note = notes.find("section"); found.gray && note != notes.end()) {
            const Section complete = section_of_note(note->second, file);
            if (section.z0_m < complete.z0_m - 1e-9 || section.z1_m > complete.z1_m + 1e-9)
                log_warning(fmt::format("{}: grains were removed beyond the section from {:g} to {:g} m, and the given one reaches further",
                                        file.string(), complete.z0_m, complete.z1_m));
        }
    } else if (const auto note = notes.find("section"); note != notes.end()) {
        section = section_of_note(note->second, file);
    }
    if (!found.container.periodic()[2]) {
        const LayerProfile profile = found.gray ? profile_of(*found.gray, found.container) : profile_of(found.image);
        if (options.geometry.section_m.empty() && !notes.contains("section"))
            section = default_section(profile, file.string());
        else
            warn_beyond_bed(profile, section, file.string());
    }
    if (found.gray) {
        PoreSpace space = pore_space_of(found.gray, found.container, section, file.string());
        // A single voxel is a feature that the image shows, however thin its ball is.
        if (scans::has_walls_of_balls(*space.gray())) space.grain_size_m = std::max(space.grain_size_m, 1.01 * space.image_voxel_size_m);
        space.image_porosity_error = porosity_error(*found.gray_notes, space);
        return space;
    }
    if (!found.own)
        for (const std::string& doubt : scans::doubts_of(found.image)) log_warning(fmt::format("{}: {}", file.string(), doubt));
    return pore_space_of(std::move(found.image), found.container, section, file.string());
}

PoreSpace load_slices(const Path& folder, const InputOptions& options) {
    SliceStack stack = read_slices(folder);
    PoreSpace space{.container = stack.container, .section = stack.section};
    space.solid = std::make_shared<const ImageSolid>(PhaseImage{.grid = stack.grid, .phase = std::move(stack.phase), .notes = {}});
    if (const auto& given = options.geometry.section_m; given.size() == 2) space.section = {given[0], given[1]};
    return space;
}

PoreSpace space_of(Packing packing, const GeometryConfig& geometry) {
    double film = geometry.film_thickness_m;
    if (const double fraction = geometry.film_volume_fraction; fraction > 0.0) {
        if (film > 0.0)
            throw UserError("film_thickness_m and film_volume_fraction exclude each other",
                            {.where = "[geometry]", .fix = "give one of them"});
        const PoreSpace dry = pore_space_of(packing);
        film = film_thickness(packing, dry.section, fraction);
        log_info("a film that fills {:g} of the bed is {:.4g} m thick", fraction, film);
    }
    PoreSpace space = pore_space_of(film > 0.0 ? coated(std::move(packing), film) : std::move(packing));
    space.film_thickness_m = film;
    return space;
}

// The superficial velocity is that of the mean area.
void warn_of_changing_area(const PoreSpace& space) {
    constexpr int parts = 50;
    const double length = space.section.length() / parts;
    double least = 1e300, most = 0.0;
    for (int n = 0; n < parts; ++n) {
        const double z0 = space.section.z0_m + n * length, area = space.container.vessel().mean_area({z0, z0 + length});
        least = std::min(least, area);
        most = std::max(most, area);
    }
    if (most > 1.05 * least)
        log_warning(fmt::format("the container's area changes from {:.4g} to {:.4g} m2 within the section: k is that of the mean area",
                                least, most));
}

// A single stone in a tube, or grains that hang in the air, are solved as well as a bed is, and mean something else.
void warn_of_no_bed(const PoreSpace& space) {
    if (space.container.any_periodic() || space.container.cut_ends()) return;
    if (space.bed_bottom_m > 0.25 * space.maximum_feret_diameter_m)
        log_warning(fmt::format("{}: the lowest grain lies {:.3g} m above the floor", space.source, space.bed_bottom_m));
    constexpr double minimum = 0.1;
    if (const double solid = 1.0 - space.porosity(4000).value; solid < minimum)
        log_warning(fmt::format("{}: solid fills {:.2g} % of the section: k is that of single bodies in a container, not of a bed",
                                space.source, 100.0 * solid));
}

PoreSpace with_ends(const PoreSpace& space, const SectionConfig& section) {
    PoreSpace ready = space.with_ends(section.ends, section.buffer_m);
    if (section.ends != Ends::in_situ || space.container.periodic()[2]) return ready;
    if (ready.ends == Ends::planes)
        log_warning(
            fmt::format("{}: the image ends at the section, so planes of constant pressure or concentration lie there; k is too high and "
                        "the tortuosity factor too low where they cut grains",
                        space.source));
    return ready;
}

// Its section and ends, and what there is to say about them.
PoreSpace with_section(PoreSpace space, const std::string& source, const InputOptions& options) {
    space.source = source;
    if (options.whole_bed) {
        if (options.geometry.closing_radius_m > 0.0)
            throw UserError("a surface of the grains has no menisci", {.where = source, .fix = "remove closing_radius_m"});
        return space;
    }
    if (space.own_grid() || space.gray()) return with_ends(space, options.section);
    const GeometryConfig& geometry = options.geometry;
    space.section = choose_section(space.container, {.section_m = geometry.section_m, .trim_m = geometry.trim_m},
                                   {space.bed_bottom_m, space.bed_top_m}, space.maximum_feret_diameter_m);
    if (space.porosity(2000).value == 1.0 && space.porosity().value == 1.0)  // few lines may miss small grains
        throw UserError(
            fmt::format("there is no grain in the section from {:g} to {:g} m", space.section.z0_m, space.section.z1_m),
            {.allowed = fmt::format("a section in the bed, which reaches from {:g} to {:g} m", space.bed_bottom_m, space.bed_top_m)});
    space.reservoir_m = geometry.reservoir_m;
    warn_of_no_bed(space);
    if (space.section.length() < space.maximum_feret_diameter_m && !space.container.periodic()[2])
        log_warning(fmt::format(
            "the section is {:.3g} m long, less than one grain's maximum Feret diameter ({:.3g} m): it hardly represents the packing",
            space.section.length(), space.maximum_feret_diameter_m));
    warn_of_changing_area(space);
    space = with_ends(space, options.section);
    return geometry.closing_radius_m > 0.0 ? closed(space, geometry.closing_radius_m) : space;
}

void refuse_film(const std::string& source, const GeometryConfig& geometry) {
    if (geometry.film_thickness_m > 0.0 || geometry.film_volume_fraction > 0.0 || geometry.closing_radius_m > 0.0)
        throw UserError("films and menisci belong to the grains of a packing; this is none",
                        {.where = source, .fix = "remove film_thickness_m, film_volume_fraction and closing_radius_m"});
}

}  // namespace

bool is_packing(const Path& input) {
    const std::string name = input.filename().string();
    return name.ends_with(".json") || name.ends_with(".json.gz");
}

bool is_surface(const Path& input) {
    return is_surface_file(input);
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
    if (!imaging::is_volume(input) && record::resolved_config(options.image) != record::resolved_config(imaging::ImageConfig()))
        throw UserError("--image-... have no effect here: they belong to images", {.where = input.string(), .fix = "remove them"});
    if (is_packing(input)) return load_pore_space(read_packing(input), input.string(), options);
    refuse_film(input.string(), options.geometry);
    if (is_surface(input)) {
        (void)container_of_surface(input.string(), options);  // before a large file is read
        return load_pore_space(read_surface(input, options.unit_m), input.string(), options);
    }
    if (std::filesystem::exists(input / "slices.json")) return with_section(load_slices(input, options), input.string(), options);
    if (is_image(input))
        return with_section(space_of(read_image(input, options.image, options.container), input, options), input.string(), options);
    throw UserError("cannot tell what " + input.string() + " is",
                    {.allowed = "packing.json, packing.json.gz, an .stl file, an image (docs/images.md), a folder of slices, or a case"});
}

PoreSpace load_pore_space(Packing packing, const std::string& name, const InputOptions& options) {
    return with_section(space_of(std::move(packing), options.geometry), name, options);
}

PoreSpace load_pore_space(geometry::TriangleSurface surface, const std::string& name, const InputOptions& options) {
    refuse_film(name, options.geometry);
    return with_section(pore_space_of(std::move(surface), container_of_surface(name, options), name), name, options);
}

PoreSpace load_pore_space(const imaging::VolumeSource& image, const std::string& name, const InputOptions& options) {
    refuse_film(name, options.geometry);
    return with_section(space_of(read_image(image, options.image, options.container, name), name, options), name, options);
}

Section section_of_note(const std::string& note, const Path& file) {
    Section section;
    if (std::sscanf(note.c_str(), "%lf,%lf", &section.z0_m, &section.z1_m) != 2 || !std::isfinite(section.z0_m) ||
        !std::isfinite(section.z1_m))
        throw UserError("the image's field data `section` is not \"z0,z1\": " + note,
                        {.where = file.string(), .fix = "--section z0,z1 (metres)"});
    return section;
}

}  // namespace porepack::inputs
