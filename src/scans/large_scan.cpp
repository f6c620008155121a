#include "scans/large_scan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "imaging/write_volume.hpp"
#include "scans/refine_slabs.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double smallest_voxels = 4.0;  ///< per diameter: fewer do not show the grains
constexpr double wanted_voxels = 6.0;    ///< per diameter, for the search
constexpr double bytes_per_voxel = 6.0, bytes_per_voxel_of_search = 12.0;

// By which voxels are binned for the search.
int search_bin(double thinnest_voxels) {
    return std::max(1, static_cast<int>(thinnest_voxels / wanted_voxels + 1e-6));
}

}  // namespace

VolumeSource Scan::reduced() const {
    return bin > 1 ? binned(source, bin) : source;
}

Scan open_scan(const VolumeSource& source, const ImageConfig& image, double thinnest_m, const std::string& where) {
    Scan scan{.source = source, .memory_bytes = image.fit_memory_bytes};
    if (scan.memory_bytes == 0.0) scan.memory_bytes = 0.8 * available_memory_bytes();
    const double h = scan.voxel_size_m(), voxels = static_cast<double>(scan.source.header.count());
    if (thinnest_m < smallest_voxels * h)
        throw UserError(fmt::format("the thinnest part of the grains is {:.1f} voxels thick", thinnest_m / h),
                        {.where = where, .allowed = "4 voxels or more", .fix = "check the voxel size and the shape's lengths"});
    const auto bytes_of = [&](std::int64_t bin) {
        const auto wide = static_cast<double>(bin);
        return voxels / std::pow(wide, 3.0) *
               (bytes_per_voxel + bytes_per_voxel_of_search / std::pow(search_bin(thinnest_m / (h * wide)), 3.0));
    };
    while (bytes_of(scan.bin) > scan.memory_bytes) ++scan.bin;
    const auto maximum = static_cast<std::int64_t>(std::max(1.0, std::floor(thinnest_m / (wanted_voxels * h) + 1e-6)));
    if (scan.bin > maximum)
        throw MachineError(fmt::format("the search needs {} on the fewest voxels by which grains are found (6 per diameter)",
                                       human_bytes(bytes_of(maximum))),
                           {.where = where,
                            .allowed = human_bytes(scan.memory_bytes),
                            .fix = "raise `fit_memory_bytes`, or fit parts of the scan (porepack image crop)"});
    scan.search_bin = search_bin(thinnest_m / (h * static_cast<double>(scan.bin)));
    if (scan.bin > 1)
        log_info("the scan needs {} and may take {}: the grains are searched on voxels of {:.4g} m, then fitted slab by slab",
                 human_bytes(bytes_of(1)), human_bytes(scan.memory_bytes), h * static_cast<double>(scan.bin * scan.search_bin));
    return scan;
}

// At the scan's own resolution. `found`: from binned voxels, whose blur is that of the scan and of the larger voxels together.
Refined refine_at_full_size(const Scan& scan, const GrayImage& reduced, const GrayNotes& notes, const Container& container,
                            const std::vector<ShapePoints>& points, Refined found, const std::string& where) {
    const double h = scan.voxel_size_m(), wide = h * static_cast<double>(scan.bin);
    double& blur = found.common.blur_m.value;
    blur = std::sqrt(std::max(0.09 * h * h, blur * blur - std::pow(notes.smoothing_voxels * wide, 2.0) - (wide * wide - h * h) / 12.0));
    Grid grid = reduced.grid;
    for (std::size_t a = 0; a < 3; ++a) {
        grid.cells[a] = static_cast<int>(scan.source.header.voxels[a]);
        grid.spacing_m[a] = scan.source.header.spacing_m[a];
    }
    const ReadLayers read = [&](int first, int count) {
        const auto& n = scan.source.header.voxels;
        const VolumeSource layers = cropped(scan.source, {.low = {0, 0, first}, .high = {n[0], n[1], first + count}});
        GrayImage part = solid_fractions(layers, {.pore = notes.pore_level, .solid = notes.solid_level}, where);
        part.grid.origin_m = grid.origin_m;
        part.grid.origin_m[2] += first * h;
        remove_tube(part, container, blur / h);
        return part;
    };
    const double smallest = smallest_slab_bytes(grid, points, blur), free = available_memory_bytes();
    if (smallest > free)
        throw MachineError(
            fmt::format("{}: a slab that holds whole grains needs {}, and {} are free", where, human_bytes(smallest), human_bytes(free)),
            {.where = where, .fix = "porepack image bin, or image crop"});
    return refine_slabs(read, grid, container, points, found, 0.5 * scan.memory_bytes);
}

}  // namespace porepack::scans
