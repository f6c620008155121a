#include "scans/phases.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double cube_tolerance = 1e-3;

[[noreturn]] void ask_for_level(const VolumeSource& source, const std::string& where) {
    const VolumeStatistics found = statistics_of(source);
    if (found.values && found.values->size() <= 8) {
        std::vector<std::string> list;
        for (const auto& [value, count] : *found.values)
            list.push_back(
                fmt::format("{:g} ({:.1f} %)", value, 100.0 * static_cast<double>(count) / static_cast<double>(source.header.count())));
        throw UserError(fmt::format("which values are pores? The image has {}", fmt::join(list, ", ")),
                        {.where = where, .fix = fmt::format("--image-pore {:g}, or pore in [image]", found.values->begin()->first)});
    }
    throw UserError(fmt::format("the image has gray values from {:g} to {:g}, and no threshold is given", found.minimum, found.maximum),
                    {.where = where, .fix = "--image-threshold VALUE, with --image-pore-side above where the pores are brighter"});
}

}  // namespace

Grid usable_grid(const VolumeHeader& header, const std::string& where, double bytes_per_voxel) {
    const auto [low, high] = std::minmax_element(header.spacing_m.begin(), header.spacing_m.end());
    if (*high > *low * (1.0 + cube_tolerance))
        throw UserError(
            fmt::format("the voxels are no cubes: {:g} x {:g} x {:g} m", header.spacing_m[0], header.spacing_m[1], header.spacing_m[2]),
            {.where = where, .fix = "resample the image to cubic voxels; binning makes equal factors only"});
    constexpr std::int64_t maximum = 4000000000;  // pores, throats and paths have 32-bit numbers of voxels; all else has 64
    const double count = static_cast<double>(header.count()), bytes = bytes_per_voxel * count;
    if (count > static_cast<double>(maximum))
        throw UserError(fmt::format("the image has {:.4g} voxels, and the solvers hold {}", count, maximum),
                        {.where = where, .fix = "porepack image crop, or porepack image bin"});
    if (const double free = available_memory_bytes(); free > 0.0 && bytes > 0.9 * free)
        throw UserError(fmt::format("the image needs {}, and {} are free", human_bytes(bytes), human_bytes(free)),
                        {.where = where, .fix = "porepack image crop, or porepack image bin"});
    Grid grid;
    for (std::size_t i = 0; i < 3; ++i) {
        grid.cells[i] = static_cast<int>(header.voxels[i]);
        grid.origin_m[i] = header.origin_m[i];
        grid.spacing_m[i] = header.spacing_m[i];
    }
    return grid;
}

SegmentedImage segmented(const VolumeSource& source, const ImageConfig& config, const std::string& where) {
    const VolumeHeader& header = source.header;
    const bool by_value = !config.pore.empty(), by_threshold = config.threshold.has_value();
    const double* given = by_threshold ? std::get_if<double>(&*config.threshold) : nullptr;
    if (by_value && by_threshold) throw UserError("pore values and a threshold exclude each other", {.where = where});
    if (by_threshold && given == nullptr) throw UserError("`threshold` is not a number", {.where = "[image], --image-threshold"});
    const bool own = !by_value && !by_threshold && header.own_phases;
    if (!by_value && !by_threshold && !own) ask_for_level(source, where);

    SegmentedImage result;
    result.image.grid = usable_grid(header, where, 1.0);
    result.image.notes = header.notes;
    std::vector<std::uint8_t>& phase = result.image.phase;
    phase.resize(result.image.grid.size());
    const std::vector<float> pores(config.pore.begin(), config.pore.end());  // as the values of the image
    std::vector<std::size_t> occurs(pores.size(), 0);
    const float threshold = by_threshold ? static_cast<float>(*given) : 0.0F;  // values are in single precision
    const bool below = config.pore_side == PoreSide::below;
    const auto phase_of = [&](float value) {
        if (own) {
            if (value != 0.0F && value != 1.0F && value != 2.0F)
                throw UserError(
                    fmt::format("phase {:g} in the array `phase`", value),
                    {.where = where, .allowed = "0 grain, 1 pore, 2 outside the container", .fix = "--image-pore VALUE for other images"});
            return static_cast<std::uint8_t>(value);
        }
        bool pore = below ? value < threshold : value > threshold;
        if (by_value) {
            const auto found = std::find(pores.begin(), pores.end(), value);
            pore = found != pores.end();
            if (pore) ++occurs[static_cast<std::size_t>(found - pores.begin())];
        }
        return pore ? Phase::pore : Phase::grain;
    };
    std::vector<float> layer(static_cast<std::size_t>(header.layer()));
    std::size_t at = 0, pore_count = 0, inside = 0;
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        for (const float value : layer) {
            phase[at] = phase_of(value);
            pore_count += phase[at] == Phase::pore ? 1 : 0;
            inside += phase[at++] != Phase::outside ? 1 : 0;
        }
    }
    result.pore_level = own        ? "phase 1"
                        : by_value ? fmt::format("value {:g}", fmt::join(pores, ", "))
                                   : fmt::format("values {} {:g}", below ? "below" : "above", threshold);
    for (std::size_t i = 0; i < occurs.size(); ++i)
        if (occurs[i] == 0)
            throw UserError(fmt::format("the image has no voxel of the pore value {:g}", pores[i]),
                            {.where = where, .fix = "porepack image info shows the values"});
    if (!own && (pore_count == 0 || pore_count == inside))
        throw UserError(
            fmt::format("{} of the image is pore", pore_count == 0 ? "nothing" : "all"),
            {.where = where, .allowed = fmt::format("pores: {}", result.pore_level), .fix = "porepack image info shows the values"});
    return result;
}

}  // namespace porepack::scans
