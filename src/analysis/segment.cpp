#include "analysis/segment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/slice_picture.hpp"
#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "core/table.hpp"
#include "imaging/separate.hpp"
#include "inputs/image_input.hpp"
#include "io/image.hpp"
#include "io/iso_surface.hpp"
#include "pore_space/gray_measures.hpp"
#include "scans/gray_input.hpp"

namespace porepack::analysis {
namespace {

enum class Kind { whole, cut, merged, split, speck };
constexpr std::array<const char*, 5> names_of_kinds = {"whole", "cut", "merged", "split", "speck"};

struct Grain {
    double voxels = 0.0;
    shapes::Vec3 sum = shapes::Vec3::Zero();                     ///< of the voxels' centres
    int lowest = std::numeric_limits<int>::max(), highest = -1;  ///< layers
    double in_lowest = 0.0, in_highest = 0.0, in_widest = 0.0;   ///< voxels of these layers, and of that with most
    Kind kind = Kind::whole;
};

std::vector<Grain> grains_of(const Grid& grid, const Separated& found) {
    std::vector<Grain> grains(found.count + 1);  // 0: pores
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                Grain& grain = grains[found.label[grid.index(i, j, k)]];
                grain.voxels += 1.0;
                grain.sum += shapes::Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                grain.lowest = std::min(grain.lowest, k);
                // Layers are visited in ascending order: the count begins again with each new layer of the grain, and is the highest
                // layer's in the end.
                if (grain.highest != k) grain.in_highest = 0.0;
                grain.highest = k;
                grain.in_highest += 1.0;
                grain.in_widest = std::max(grain.in_widest, grain.in_highest);
                if (k == grain.lowest) grain.in_lowest += 1.0;
            }
    return grains;
}

// Half of the volume of the grains that the ends do not cut lies in smaller ones: specks and merged grains hardly count.
double median_by_volume(const std::vector<Grain>& grains) {
    std::vector<double> volumes;
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].voxels > 0.0 && grains[g].kind == Kind::whole) volumes.push_back(grains[g].voxels);
    std::sort(volumes.begin(), volumes.end());
    double all = 0.0, below = 0.0;
    for (const double volume : volumes) all += volume;
    for (const double volume : volumes)
        if ((below += volume) >= 0.5 * all) return volume;
    return 0.0;
}

// A grain that only touches an end stands there: hardly any of it can be missing.
void classify(std::vector<Grain>& grains, int layers, const SegmentConfig& config) {
    constexpr double touches = 0.05;
    for (Grain& grain : grains) {
        const bool at_floor = grain.lowest == 0 && !config.on_floor && grain.in_lowest > touches * grain.in_widest;
        const bool at_top = grain.highest == layers - 1 && grain.in_highest > touches * grain.in_widest;
        if (at_floor || at_top) grain.kind = Kind::cut;
    }
    // After the ends are known: grains that they cut do not count in the median.
    const double median = median_by_volume(grains);
    for (Grain& grain : grains) {
        if (grain.voxels < config.smallest_grain * median) grain.kind = Kind::speck;
        if (grain.kind != Kind::whole) continue;
        if (grain.voxels > 1.5 * median)
            grain.kind = Kind::merged;
        else if (grain.voxels < 0.6 * median)
            grain.kind = Kind::split;
    }
}

// Gives the voxels within `steps` of a grain to the nearest one: the blurred edge that belongs to it.
std::vector<std::uint32_t> with_edges(const Grid& grid, std::vector<std::uint32_t> label, int steps) {
    std::vector<std::size_t> front, next;
    for (std::size_t cell = 0; cell < label.size(); ++cell)
        if (label[cell] != 0) front.push_back(cell);
    for (int step = 0; step < steps; ++step) {
        next.clear();
        for (const std::size_t cell : front)
            grid.for_neighbours(cell, [&](std::size_t other) {
                if (label[other] != 0) return;
                label[other] = label[cell];
                next.push_back(other);
            });
        front.swap(next);
    }
    return label;
}

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

Table grain_table(const std::vector<Grain>& grains, double voxel_m) {
    Table table({"grain", "volume_m3", "x_m", "y_m", "z_m", "z0_m", "z1_m", "kind"});
    for (std::size_t g = 1; g < grains.size(); ++g) {
        const Grain& grain = grains[g];
        if (grain.voxels == 0.0) continue;
        const shapes::Vec3 centre = grain.sum / grain.voxels;
        table.add(static_cast<long>(g), grain.voxels * std::pow(voxel_m, 3.0), centre.x(), centre.y(), centre.z(), grain.lowest * voxel_m,
                  (grain.highest + 1) * voxel_m, names_of_kinds[static_cast<std::size_t>(grain.kind)]);
    }
    return table;
}

Table volume_table(const std::vector<Grain>& grains, double voxel_m3, double median_m3) {
    Table volumes({"# volume / median volume"});
    volumes.digits = 6;
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].kind != Kind::cut && grains[g].voxels > 0.0) volumes.add(grains[g].voxels * voxel_m3 / median_m3);
    return volumes;
}

std::vector<std::uint8_t> solid_voxels(const GrayImage& gray, const Container& container) {
    const Grid& grid = gray.grid;
    const std::uint16_t level = GrayImage::pack(gray.level);
    std::vector<std::uint8_t> solid(gray.packed.size());
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i)
            if (container.contains_column(grid.centre(0, i), grid.centre(1, j)))
                for (int k = 0; k < grid.cells[2]; ++k) {
                    const std::size_t cell = grid.index(i, j, k);
                    solid[cell] = gray.packed[cell] > level ? 1 : 0;
                }
    return solid;
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

// Of the grains that are kept.
double median_height(const std::vector<Grain>& grains) {
    std::vector<double> heights;
    for (const Grain& grain : grains)
        if (grain.kind == Kind::whole && grain.voxels > 0.0) heights.push_back(grain.highest - grain.lowest + 1);
    return heights.empty() ? 0.0 : median(heights);
}

// Between the planes that no removed grain reaches; a grain's height away from where the bed ends inside the image.
std::optional<Section> complete_section(const std::vector<Grain>& grains, const Grid& grid, bool with_cut_grains) {
    const int layers = grid.cells[2];
    int low = 0, high = layers, bottom = layers, top = 0;
    bool cut_below = false, cut_above = false;
    for (const Grain& grain : grains) {
        if (grain.voxels == 0.0 || grain.kind == Kind::speck) continue;
        bottom = std::min(bottom, grain.lowest);
        top = std::max(top, grain.highest + 1);
        if (grain.kind != Kind::cut) continue;
        cut_below = cut_below || grain.lowest == 0;
        cut_above = cut_above || grain.highest == layers - 1;
        if (with_cut_grains) continue;
        if (grain.lowest == 0) low = std::max(low, grain.highest + 1);
        if (grain.highest == layers - 1) high = std::min(high, grain.lowest);
    }
    const int height = static_cast<int>(median_height(grains));
    if (!cut_below) low = bottom + height;
    if (!cut_above) high = top - height;
    if (high - low < 2) return std::nullopt;
    return Section{low * grid.spacing_m[2], high * grid.spacing_m[2]};
}

}  // namespace

Segmented segment_image(const VolumeSource& source, ImageConfig image, const std::optional<Container>& given, const SegmentConfig& config,
                        const std::string& name) {
    if (image.threshold.is_null()) image.threshold = "volume";
    image.walls = ImageWalls::gray;
    if (source.header.own_phases) throw UserError("the image is segmented already", {.where = name, .fix = "give the scan"});
    const ImageInput input = read_image(source, image, given, name);
    const GrayNotes& notes = *input.gray_notes;
    GrayImage gray = *input.gray->image();
    const Grid& grid = gray.grid;
    require_fit(grid, input.container, {0.0, grid.cells[2] * grid.spacing_m[2]}, name, gray.notes.contains("shows_wall"));
    Files files{.pictures = {scan_picture(source, notes, grid)}};

    std::vector<std::uint8_t> solid = solid_voxels(gray, input.container);
    const auto at = [&](int i, int k) { return grid.index(i, middle_row(grid), k); };
    files.pictures.push_back(slice_picture(
        "step_2_threshold.png", grid, [&](int i, int k) { return gray_colour(gray.at(at(i, k))); },
        [&](int i, int k) { return solid[at(i, k)]; }, orange));

    std::int64_t filled = 0;
    if (!config.keep_cavities) {
        const std::vector<std::uint8_t> before = solid;
        filled = fill_cavities(grid, solid);
        for (std::size_t cell = 0; cell < solid.size(); ++cell)
            if (solid[cell] != before[cell]) gray.packed[cell] = GrayImage::pack(1.0);
        files.pictures.push_back(slice_picture(
            "step_3_filled.png", grid, [&](int i, int k) { return gray_colour(gray.at(at(i, k))); },
            [&](int i, int k) { return solid[at(i, k)]; }, orange));
    }
    const GrayMeasures measures = measure_gray(*input.gray, input.container);
    // For a long cylinder V/A = r/2, hence twice the ratio of the whole solid.
    const double half_thickness = 2.0 * measures.solid_fraction / measures.area_per_volume_m;
    log_info("watershed: half the grains' thickness is {:.3g} m, {:.1f} voxels", half_thickness, half_thickness / grid.spacing_m[0]);
    Separated found = separate_grains(grid, solid, config.separation * half_thickness);
    std::vector<Grain> grains = grains_of(grid, found);
    // Label 0, the pores, is no grain.
    grains[0] = {};
    classify(grains, grid.cells[2], config);
    const auto removed = [&](std::uint32_t label) {
        const Kind kind = grains[label].kind;
        return label != 0 && (kind == Kind::speck || (kind == Kind::cut && !config.keep_cut_grains));
    };
    std::array<long, 5> numbers{};
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].voxels > 0.0) ++numbers[static_cast<std::size_t>(grains[g].kind)];
    files.pictures.push_back(slice_picture(
        "step_4_grains.png", grid, [&](int i, int k) { return label_colour(found.label[at(i, k)]); },
        [&](int i, int k) { return found.label[at(i, k)]; }, black));

    // The blurred edge of a removed grain lies below the threshold but would remain as a shell of gray values: it is removed with its
    // grain, as far as the blur reaches and no other grain is nearer.
    const int edge = 1 + static_cast<int>(std::ceil(3.0 * notes.blur_voxels));
    const std::vector<std::uint32_t> owner = with_edges(grid, found.label, edge);
    for (std::size_t cell = 0; cell < owner.size(); ++cell)
        if (removed(owner[cell])) gray.packed[cell] = GrayImage::pack(0.0);
    PhaseImage phases =
        phases_of(grid, input.container, [&](std::size_t cell) { return found.label[cell] != 0 && !removed(found.label[cell]); });
    files.pictures.push_back(slice_picture(
        "step_5_kept.png", grid,
        [&](int i, int k) {
            const std::uint32_t label = found.label[at(i, k)];
            return removed(label) ? Colour{90, 60, 60} : label_colour(label);
        },
        [&](int i, int k) { return found.label[at(i, k)]; }, black));

    const long kept = numbers[0] + numbers[2] + numbers[3] + (config.keep_cut_grains ? numbers[1] : 0);
    if (kept == 0)
        throw UserError(fmt::format("no grain is left: {} are cut by the ends of the image, {} are specks", numbers[1], numbers[4]),
                        {.where = name, .fix = "--keep-cut-grains, a longer scan, or another threshold (porepack image info)"});
    const auto section = complete_section(grains, grid, config.keep_cut_grains);
    if (section) {
        const std::string note = fmt::format("{:.10g},{:.10g}", section->z0_m, section->z1_m);
        gray.notes["section"] = phases.notes["section"] = note;
    } else {
        log_warning("nothing is left of the bed between the grains that the ends of the image cut, or where the bed ends: give --section");
    }
    if (notes.tube_removed) phases.notes["shows_wall"] = "true";
    gray.notes["container"] = phases.notes["container"] = to_json(input.container).dump();
    files.tables.emplace_back("grains.csv", grain_table(grains, grid.spacing_m[0]));
    const double voxel = std::pow(grid.spacing_m[0], 3.0), median = median_by_volume(grains) * voxel;
    files.tables.emplace_back("volumes.dat", volume_table(grains, voxel, median));
    if (median > 0.0) files.plots.push_back({"volumes.svg", "volumes"});

    results::Segment result{
        .file = input.file,
        .pores = input.pores,
        .gray = notes,
        .container = to_json(input.container),
        .cavity_voxels = filled,
        .half_thickness_m = half_thickness,
        .median_grain_volume_m3 = median,
        .grains = {.kept = kept, .whole = numbers[0], .cut = numbers[1], .merged = numbers[2], .split = numbers[3], .speck = numbers[4]}};
    if (section) {
        result.section_m = section->interval();
        result.porosity = porosity(GraySolid(std::make_shared<GrayImage>(gray), input.container), input.container, *section).value;
    }
    std::optional<StoneLibrary> library;
    if (config.library) {
        std::vector<std::uint32_t> whole;
        for (std::size_t g = 1; g < grains.size(); ++g)
            if (grains[g].voxels > 0.0 && grains[g].kind == Kind::whole) whole.push_back(static_cast<std::uint32_t>(g));
        library = stones_of(gray, owner, whole);
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
