#include "scans/layer_profile.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/log.hpp"
#include "core/median.hpp"
#include "pore_space/gray_measures.hpp"
#include "scans/gray_input.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {

LayerProfile profile_of(const PhaseImage& image) {
    const Grid& grid = image.grid;
    LayerProfile profile{.solid_fraction = {}, .z0_m = grid.origin_m[2], .spacing_m = grid.spacing_m[2]};
    const std::size_t row = grid.index(0, 1, 0), layer = grid.index(0, 0, 1);
    double solid = 0.0, faces = 0.0;
    for (int k = 0; k < grid.cells[2]; ++k) {
        double here = 0.0, inside = 0.0;
        for (int j = 0; j < grid.cells[1]; ++j)
            for (int i = 0; i < grid.cells[0]; ++i) {
                const std::size_t cell = grid.index(i, j, k);
                const std::uint8_t phase = image.phase[cell];
                if (phase == Phase::outside) continue;
                inside += 1.0;
                here += phase == Phase::grain ? 1.0 : 0.0;
                const auto differs = [&](bool exists, std::size_t other) {
                    return exists && image.phase[other] != Phase::outside && image.phase[other] != phase;
                };
                faces += (differs(i + 1 < grid.cells[0], cell + 1) ? 1.0 : 0.0) + (differs(j + 1 < grid.cells[1], cell + row) ? 1.0 : 0.0) +
                         (differs(k + 1 < grid.cells[2], cell + layer) ? 1.0 : 0.0);
            }
        solid += here;
        profile.solid_fraction.push_back(inside > 0.0 ? here / inside : 0.0);
    }
    constexpr double area_of_a_face = 2.0 / 3.0;  // of steps, for surfaces in all directions
    if (faces > 0.0) profile.grain_size_m = 6.0 * solid / (area_of_a_face * faces) * grid.spacing_m[2];
    return profile;
}

LayerProfile profile_of(const pore_space::GraySolid& solid, const Container& container) {
    const GrayImage& image = *solid.image();
    const Grid& grid = image.grid;
    LayerProfile profile{.solid_fraction = std::vector<double>(static_cast<std::size_t>(grid.cells[2]), 0.0),
                         .z0_m = grid.origin_m[2],
                         .spacing_m = grid.spacing_m[2]};
    double columns = 0.0;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            if (!container.contains_column(grid.centre(0, i), grid.centre(1, j))) continue;
            columns += 1.0;
            for (int k = 0; k < grid.cells[2]; ++k)
                profile.solid_fraction[static_cast<std::size_t>(k)] += std::clamp<double>(image.at(grid.index(i, j, k)), 0.0, 1.0);
        }
    for (double& fraction : profile.solid_fraction) fraction /= std::max(1.0, columns);
    const auto measures = pore_space::measure_gray(solid, container);
    if (measures.area_per_volume_m > 0.0) profile.grain_size_m = 6.0 * measures.solid_fraction / measures.area_per_volume_m;
    return profile;
}

std::optional<Section> bed_of(const LayerProfile& profile) {
    const std::vector<double>& fraction = profile.solid_fraction;
    if (fraction.empty()) return std::nullopt;
    const double maximum = *std::max_element(fraction.begin(), fraction.end());
    std::vector<double> filled;
    for (const double one : fraction)
        if (one > 0.25 * maximum) filled.push_back(one);
    if (filled.empty()) return std::nullopt;
    const double usual = median(filled);
    const auto in_bed = [&](double one) { return one >= 0.5 * usual; };
    const auto first = std::find_if(fraction.begin(), fraction.end(), in_bed) - fraction.begin();
    const auto last = fraction.rend() - std::find_if(fraction.rbegin(), fraction.rend(), in_bed);
    const double below = static_cast<double>(first) * profile.spacing_m,
                 above = static_cast<double>(static_cast<std::ptrdiff_t>(fraction.size()) - last) * profile.spacing_m;
    if (std::max(below, above) <= 0.5 * profile.grain_size_m) return std::nullopt;
    return Section{profile.z0_m + below, profile.z0_m + static_cast<double>(last) * profile.spacing_m};
}

Section default_section(const LayerProfile& profile, const std::string& where) {
    const Section all{profile.z0_m, profile.z0_m + static_cast<double>(profile.solid_fraction.size()) * profile.spacing_m};
    const std::optional<Section> bed = bed_of(profile);
    if (!bed) return all;
    const double grain = profile.grain_size_m;
    Section section = all;
    if (bed->z0_m > all.z0_m + 0.5 * grain) section.z0_m = bed->z0_m + grain;
    if (bed->z1_m < all.z1_m - 0.5 * grain) section.z1_m = bed->z1_m - grain;
    if (section.length() < grain) {
        log_warning(fmt::format("{}: the bed reaches from {:.4g} to {:.4g} m only, and the section is the whole image: give --section",
                                where, bed->z0_m, bed->z1_m));
        return all;
    }
    log_warning(
        fmt::format("{}: the bed ends inside the image, at {:.4g} and {:.4g} m; the section is {:.4g} to {:.4g} m (--section z0,z1 for "
                    "another)",
                    where, bed->z0_m, bed->z1_m, section.z0_m, section.z1_m));
    return section;
}

void warn_beyond_bed(const LayerProfile& profile, const Section& section, const std::string& where) {
    const std::optional<Section> bed = bed_of(profile);
    if (!bed) return;
    const double slack = 0.5 * profile.grain_size_m;
    if (section.z0_m < bed->z0_m - slack || section.z1_m > bed->z1_m + slack)
        log_warning(
            fmt::format("{}: the section from {:.4g} to {:.4g} m reaches beyond the bed ({:.4g} to {:.4g} m): k of the free space counts",
                        where, section.z0_m, section.z1_m, bed->z0_m, bed->z1_m));
}

}  // namespace porepack::scans
