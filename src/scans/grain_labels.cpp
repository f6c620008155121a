#include "scans/grain_labels.hpp"

#include <algorithm>

#include "core/median.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

// Of the grains that are kept.
double median_height(std::span<const LabelledGrain> grains) {
    std::vector<double> heights;
    for (const LabelledGrain& grain : grains)
        if (grain.kind == GrainKind::whole && grain.voxels > 0.0) heights.push_back(grain.highest - grain.lowest + 1);
    return heights.empty() ? 0.0 : median(heights);
}

}  // namespace

std::vector<LabelledGrain> labelled_grains(const Grid& grid, std::span<const std::uint32_t> label, std::size_t count) {
    std::vector<LabelledGrain> grains(count + 1);
    for (int k = 0; k < grid.cells[2]; ++k)
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                LabelledGrain& grain = grains[label[grid.index(i, j, k)]];
                grain.voxels += 1.0;
                grain.sum += Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                grain.lowest = std::min(grain.lowest, k);
                // Layers are visited in ascending order: the count begins again with each new layer of the grain, and is the highest
                // layer's in the end.
                if (grain.highest != k) grain.in_highest = 0.0;
                grain.highest = k;
                grain.in_highest += 1.0;
                grain.in_widest = std::max(grain.in_widest, grain.in_highest);
                if (k == grain.lowest) grain.in_lowest += 1.0;
            }
    grains[0] = {};  // pores
    return grains;
}

// A grain that only touches an end stands there: hardly any of it can be missing.
void classify(std::vector<LabelledGrain>& grains, int layers, const GrainRules& rules) {
    constexpr double touches = 0.05;
    for (LabelledGrain& grain : grains) {
        const bool at_floor = grain.lowest == 0 && !rules.on_floor && grain.in_lowest > touches * grain.in_widest;
        const bool at_top = grain.highest == layers - 1 && grain.in_highest > touches * grain.in_widest;
        if (at_floor || at_top) grain.kind = GrainKind::cut;
    }
    // After the ends are known: grains that they cut do not count in the median.
    const double median = median_by_volume(grains);
    for (LabelledGrain& grain : grains) {
        if (grain.voxels < rules.smallest_grain * median) grain.kind = GrainKind::speck;
        if (grain.kind != GrainKind::whole) continue;
        if (grain.voxels > 1.5 * median)
            grain.kind = GrainKind::merged;
        else if (grain.voxels < 0.6 * median)
            grain.kind = GrainKind::split;
    }
}

double median_by_volume(std::span<const LabelledGrain> grains) {
    std::vector<double> volumes;
    for (std::size_t g = 1; g < grains.size(); ++g)
        if (grains[g].voxels > 0.0 && grains[g].kind == GrainKind::whole) volumes.push_back(grains[g].voxels);
    std::sort(volumes.begin(), volumes.end());
    double all = 0.0, below = 0.0;
    for (const double volume : volumes) all += volume;
    for (const double volume : volumes)
        if ((below += volume) >= 0.5 * all) return volume;
    return 0.0;
}

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

std::optional<Section> complete_section(std::span<const LabelledGrain> grains, const Grid& grid, bool with_cut_grains) {
    const int layers = grid.cells[2];
    int low = 0, high = layers, bottom = layers, top = 0;
    bool cut_below = false, cut_above = false;
    for (const LabelledGrain& grain : grains) {
        if (grain.voxels == 0.0 || grain.kind == GrainKind::speck) continue;
        bottom = std::min(bottom, grain.lowest);
        top = std::max(top, grain.highest + 1);
        if (grain.kind != GrainKind::cut) continue;
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

}  // namespace porepack::scans
