#include "analysis/segment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/slice_picture.hpp"
#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "imaging/separate.hpp"
#include "inputs/image_input.hpp"
#include "io/image.hpp"
#include "io/iso_surface.hpp"
#include "pore_space/gray_measures.hpp"
#include "scans/grain_labels.hpp"
#include "scans/gray_input.hpp"

namespace porepack::analysis {
namespace {

constexpr std::array<const char*, 5> names_of_kinds = {"whole", "cut", "merged", "split", "speck"};

// Light colours that differ between neighbours in number.
Colour label_colour(std::uint32_t label) {
    if (label == 0) return {20, 20, 20};
    Colour colour{};
    for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<std::uint8_t>(110 + (label * (c == 0 ? 97U : c == 1 ? 57U : 151U)) % 130);
    return colour;
}

constexpr Colour orange = {230, 159, 0}, black = {0, 0, 0};

Picture scan_picture(const VolumeSource& source, const GrayNotes& notes, const Grid& grid) {
    const VolumeHeader& header = source.header;
    std::vector<float> layer(static_cast<std::size_t>(header.layer()));
    std::vector<double> slice;
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        for (std::int64_t x = 0; x < header.voxels[0]; ++x)
            slice.push_back((layer[static_cast<std::size_t>(middle_row(grid) * header.voxels[0] + x)] - notes.pore_level) /
                            (notes.solid_level - notes.pore_level));
    }
    return slice_picture(
        "step_1_scan.png", grid, [&](int i, int k) { return gray_colour(slice[static_cast<std::size_t>(k * header.voxels[0] + i)]); },
        [](int, int) { return 0; }, orange);
}

Table grain_table(const std::vector<LabelledGrain>& grains, double voxel_m) {
    Table table({"grain", "volume_m3", "x_m", "y_m", "z_m", "z0_m", "z1_m", "kind"});
    for (std::size_t g = 1; g < grains.size(); ++g) {
        const LabelledGrain& grain = grains[g];
        if (grain.voxels == 0.0) continue;
        const shapes::Vec3 centre = grain.sum / grain.voxels;
        table.add(static_cast<long>(g), grain.voxels * std::pow(voxel_m, 3.0), centre.x(), centre.y(), centre.z(), grain.lowest * voxel_m,
                  (grain.highest + 1) * voxel_m, names_of_kinds[static_cast<std::size_t>(grain.kind)]);
    }
    return table;
}

Table volume_table(const std::vector<LabelledGrain>& grains, double voxel_m3, double median_m3) {
    Table volumes({"# volume / median volume"});
    volumes.digits = 6;
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].kind != GrainKind::cut && grains[g].voxels > 0.0) volumes.add(grains[g].voxels * voxel_m3 / median_m3);
    return volumes;
}

template <typename IsGrain>
PhaseImage phases_of(const Grid& grid, const Container& container, const IsGrain& is_grain) {
    PhaseImage phases{.grid = grid, .phase = std::vector<std::uint8_t>(grid.size(), Phase::outside), .notes = {}};
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            if (!container.contains_column(grid.centre(0, i), grid.centre(1, j))) continue;
            for (int k = 0; k < grid.cells[2]; ++k) {
                const std::size_t cell = grid.index(i, j, k);
                phases.phase[cell] = is_grain(cell) ? Phase::grain : Phase::pore;
            }
        }
    return phases;
}

// The gray values, with what is solid outlined.
Picture outlined(const std::string& file, const GrayImage& gray, const std::vector<std::uint8_t>& solid) {
    const auto at = [&](int i, int k) { return gray.grid.index(i, middle_row(gray.grid), k); };
    return slice_picture(
        file, gray.grid, [&](int i, int k) { return gray_colour(gray.at(at(i, k))); }, [&](int i, int k) { return solid[at(i, k)]; },
        orange);
}

// The grains, outlined in black; those without a `shade` in their own colours.
template <typename Shade>
Picture of_labels(const std::string& file, const Grid& grid, const std::vector<std::uint32_t>& labels, const Shade& shade) {
    const auto label = [&](int i, int k) { return labels[grid.index(i, middle_row(grid), k)]; };
    return slice_picture(
        file, grid, [&](int i, int k) { return shade(label(i, k)).value_or(label_colour(label(i, k))); }, label, black);
}

// Cavities of `solid` become solid, in the gray values too. Returns how many voxels.
std::int64_t fill(GrayImage& gray, std::vector<std::uint8_t>& solid) {
    const std::vector<std::uint8_t> before = solid;
    const std::int64_t filled = fill_cavities(gray.grid, solid);
    for (std::size_t cell = 0; cell < solid.size(); ++cell)
        if (solid[cell] != before[cell]) gray.packed[cell] = GrayImage::pack(1.0);
    return filled;
}

results::SegmentedGrains counted(const std::vector<LabelledGrain>& grains, bool with_cut_grains) {
    std::array<long, names_of_kinds.size()> numbers{};
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].voxels > 0.0) ++numbers[static_cast<std::size_t>(grains[g].kind)];
    const auto& [whole, cut, merged, split, speck] = numbers;
    return {.kept = whole + merged + split + (with_cut_grains ? cut : 0),
            .whole = whole,
            .cut = cut,
            .merged = merged,
            .split = split,
            .speck = speck};
}

std::vector<std::uint32_t> whole_grains(const std::vector<LabelledGrain>& grains) {
    std::vector<std::uint32_t> whole;
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].voxels > 0.0 && grains[g].kind == GrainKind::whole) whole.push_back(static_cast<std::uint32_t>(g));
    return whole;
}

void note_frame(GrayImage& gray, PhaseImage& phases, const ImageInput& input, const std::optional<Section>& section) {
    if (section)
        gray.notes["section"] = phases.notes["section"] = fmt::format("{:.10g},{:.10g}", section->z0_m, section->z1_m);
    else
        log_warning("nothing is left of the bed between the grains that the ends of the image cut, or where the bed ends: give --section");
    if (input.gray_notes->tube_removed) phases.notes["shows_wall"] = "true";
    gray.notes["container"] = phases.notes["container"] = to_json(input.container).dump();
}

Files files_of(const std::vector<LabelledGrain>& grains, double voxel_size_m, double median_m3) {
    Files files;
    files.tables.emplace_back("grains.csv", grain_table(grains, voxel_size_m));
    files.tables.emplace_back("volumes.dat", volume_table(grains, std::pow(voxel_size_m, 3.0), median_m3));
    if (median_m3 > 0.0) files.plots.push_back({"volumes.svg", "volumes"});
    return files;
}

}  // namespace

Segmented segment_image(const VolumeSource& source, ImageConfig image, const std::optional<Container>& given, const SegmentConfig& config,
                        const std::string& name) {
    if (!image.threshold) image.threshold = imaging::ThresholdRule::volume;
    image.walls = ImageWalls::gray;
    if (source.header.own_phases) throw UserError("the image is segmented already", {.where = name, .fix = "give the scan"});
    const ImageInput input = read_image(source, image, given, name);
    const GrayNotes& notes = *input.gray_notes;
    GrayImage gray = *input.gray->image();
    const Grid& grid = gray.grid;
    require_fit(grid, input.container, {0.0, grid.cells[2] * grid.spacing_m[2]}, name, gray.notes.contains("shows_wall"));
    std::vector<std::uint8_t> solid = solid_voxels(gray, input.container);
    std::vector<Picture> pictures = {scan_picture(source, notes, grid), outlined("step_2_threshold.png", gray, solid)};
    const std::int64_t filled = config.keep_cavities ? 0 : fill(gray, solid);
    if (!config.keep_cavities) pictures.push_back(outlined("step_3_filled.png", gray, solid));

    const GrayMeasures measures = measure_gray(*input.gray, input.container);
    // For a long cylinder V/A = r/2, hence twice the ratio of the whole solid.
    const double half_thickness = 2.0 * measures.solid_fraction / measures.area_per_volume_m;
    log_info("watershed: half the grains' thickness is {:.3g} m, {:.1f} voxels", half_thickness, half_thickness / grid.spacing_m[0]);
    Separated found = separate_grains(grid, solid, config.separation * half_thickness);
    std::vector<LabelledGrain> grains = labelled_grains(grid, found.label, found.count);
    classify(grains, grid.cells[2], {.smallest_grain = config.smallest_grain, .on_floor = config.on_floor});
    const auto removed = [&](std::uint32_t label) {
        const GrainKind kind = grains[label].kind;
        return label != 0 && (kind == GrainKind::speck || (kind == GrainKind::cut && !config.keep_cut_grains));
    };
    pictures.push_back(of_labels("step_4_grains.png", grid, found.label, [](std::uint32_t) { return std::optional<Colour>(); }));
    pictures.push_back(of_labels("step_5_kept.png", grid, found.label, [&](std::uint32_t label) {
        return removed(label) ? std::optional(Colour{90, 60, 60}) : std::nullopt;
    }));
    const results::SegmentedGrains numbers = counted(grains, config.keep_cut_grains);
    if (numbers.kept == 0)
        throw UserError(fmt::format("no grain is left: {} are cut by the ends of the image, {} are specks", numbers.cut, numbers.speck),
                        {.where = name, .fix = "--keep-cut-grains, a longer scan, or another threshold (porepack image info)"});

    // The blurred edge of a removed grain lies below the threshold but would remain as a shell of gray values: it is removed with its
    // grain, as far as the blur reaches and no other grain is nearer.
    const std::vector<std::uint32_t> owner = with_edges(grid, found.label, 1 + static_cast<int>(std::ceil(3.0 * notes.blur_voxels)));
    for (std::size_t cell = 0; cell < owner.size(); ++cell)
        if (removed(owner[cell])) gray.packed[cell] = GrayImage::pack(0.0);
    PhaseImage phases =
        phases_of(grid, input.container, [&](std::size_t cell) { return found.label[cell] != 0 && !removed(found.label[cell]); });
    const auto section = complete_section(grains, grid, config.keep_cut_grains);
    note_frame(gray, phases, input, section);

    const double median = median_by_volume(grains) * std::pow(grid.spacing_m[0], 3.0);
    Files files = files_of(grains, grid.spacing_m[0], median);
    files.pictures = std::move(pictures);
    results::Segment result{.file = input.file,
                            .pores = input.pores,
                            .gray = notes,
                            .container = to_json(input.container),
                            .cavity_voxels = filled,
                            .half_thickness_m = half_thickness,
                            .median_grain_volume_m3 = median,
                            .grains = numbers};
    if (section) {
        result.section_m = section->interval();
        result.porosity = porosity(GraySolid(std::make_shared<GrayImage>(gray), input.container), input.container, *section).value;
    }
    std::optional<StoneLibrary> library;
    if (config.library) {
        library = stones_of(gray, owner, whole_grains(grains));
        result.library = {.stones = static_cast<long>(library->labels.size()), .left_out = library->left_out};
    }
    return {.outcome = {result, std::move(files)},
            .gray = std::move(gray),
            .phases = std::move(phases),
            .labels = std::move(found.label),
            .library = std::move(library)};
}

Segmented segment_image(const Path& file, const ImageConfig& image, const std::optional<Container>& container,
                        const SegmentConfig& config) {
    return segment_image(open_volume(file, image), image, container, config, file.string());
}

results::Segment written(const Segmented& segmented, const Path& folder) {
    io::write_gray_image(folder / "gray.vti", segmented.gray);
    io::write_phase_image(folder / "pore.vti", segmented.phases);
    io::write_label_image(folder / "labels.vti", segmented.gray.grid, segmented.labels);
    io::write_stl(folder / "solid.stl", io::iso_surface(segmented.gray));
    if (segmented.library) write_library(*segmented.library, folder / "library");
    return written(segmented.outcome, folder);
}

}  // namespace porepack::analysis
