#include "analysis/pores.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/table.hpp"
#include "pores/pores.hpp"
#include "tortuosity/tortuosity.hpp"
#include "uncertainty/section_scatter.hpp"

namespace porepack::analysis {
namespace {

constexpr const char* axes = "xyz";
// Phase, distance, diameter, pore and tree of a voxel, and the order of the voxels.
constexpr double bytes_per_voxel = 1.0 + 4.0 + 4.0 + 4.0 + 4.0 + 4.0;

// Share of the chords that are longer, at 200 lengths.
Table chord_table(const std::array<Chords, 3>& chords) {
    double longest = 0.0;
    for (const Chords& along : chords)
        if (!along.lengths_m.empty()) longest = std::max(longest, along.lengths_m.back());
    Table table({"length_m", "longer_x", "longer_y", "longer_z"});
    constexpr int rows = 200;
    for (int i = 0; i < rows; ++i) {
        const double length = longest * i / rows;
        std::array<std::optional<double>, 3> longer;
        for (std::size_t a = 0; a < 3; ++a) {
            const auto& all = chords[a].lengths_m;
            if (all.empty()) continue;
            longer[a] = static_cast<double>(all.end() - std::upper_bound(all.begin(), all.end(), length)) / static_cast<double>(all.size());
        }
        table.add(length, longer[0], longer[1], longer[2]);
    }
    return table;
}

struct Sizes {
    std::vector<double> diameter_m;  ///< of every pore voxel, ascending
    [[nodiscard]] double quantile(double part) const {
        return diameter_m[std::min(diameter_m.size() - 1, static_cast<std::size_t>(part * static_cast<double>(diameter_m.size())))];
    }
};

Table size_table(const Sizes& sizes) {
    Table table({"diameter_m", "pore_volume_in_wider_pores"});
    const double total = static_cast<double>(sizes.diameter_m.size());
    constexpr int rows = 200;
    for (int i = 0; i <= rows; ++i) {
        const double diameter = sizes.diameter_m.back() * i / rows;
        const auto wider = sizes.diameter_m.end() - std::lower_bound(sizes.diameter_m.begin(), sizes.diameter_m.end(), diameter);
        table.add(diameter, static_cast<double>(wider) / total);
    }
    return table;
}

struct Quantiles {
    std::optional<double> low, median, high;  ///< at 10, 50 and 90 percent; none of no values
};

Quantiles quantiles_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    const auto at = [&](double part) { return values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))]; };
    return {at(0.1), at(0.5), at(0.9)};
}

results::NetworkOfPores describe_network(const PoreNetwork& network, Files& files) {
    std::vector<long> neighbours(network.pores.size(), 0);
    std::vector<double> widths, bodies;
    Table throats({"pore_1", "pore_2", "diameter_m"}), pores({"x_m", "y_m", "z_m", "diameter_m", "volume_m3", "throats", "cut"});
    for (const auto& throat : network.throats) {
        throats.add(static_cast<double>(throat.first), static_cast<double>(throat.second), throat.diameter_m);
        widths.push_back(throat.diameter_m);
        ++neighbours[throat.first];
        ++neighbours[throat.second];
    }
    double sum = 0.0, whole = 0.0;
    for (std::size_t i = 0; i < network.pores.size(); ++i) {
        const auto& pore = network.pores[i];
        const auto& at = pore.centre_m;
        pores.add(at[0], at[1], at[2], pore.diameter_m, pore.volume_m3, static_cast<double>(neighbours[i]), pore.cut ? 1.0 : 0.0);
        if (pore.cut) continue;
        bodies.push_back(pore.diameter_m);
        sum += static_cast<double>(neighbours[i]);
        whole += 1.0;
    }
    files.tables.emplace_back("throats.csv", throats);
    files.tables.emplace_back("pores.csv", pores);
    const Quantiles width = quantiles_of(widths), body = quantiles_of(bodies);
    return {.pores = network.pores.size(),
            .whole_pores = bodies.size(),
            .throats = network.throats.size(),
            .throats_per_whole_pore = whole > 0.0 ? std::optional(sum / whole) : std::nullopt,
            .throat_diameter_10_percent_m = width.low,
            .throat_diameter_median_m = width.median,
            .throat_diameter_90_percent_m = width.high,
            .body_diameter_median_m = body.median};
}

Table correlation_table(const Correlation& found) {
    Table table({"distance_m", "probability_x", "probability_y", "probability_z"});
    for (std::size_t r = 0; r < found.distance_m.size(); ++r)
        table.add(found.distance_m[r], found.probability[0][r], found.probability[1][r], found.probability[2][r]);
    return table;
}

std::vector<double> layer_porosities(const PhaseImage& image) {
    std::vector<double> layers;
    const std::size_t size = image.grid.index(0, 0, 1);
    for (std::size_t first = 0; first < image.phase.size(); first += size) {
        double pores = 0.0, inside = 0.0;
        for (std::size_t cell = first; cell < first + size; ++cell) {
            pores += image.phase[cell] == Phase::pore ? 1.0 : 0.0;
            inside += image.phase[cell] != Phase::outside ? 1.0 : 0.0;
        }
        layers.push_back(inside > 0.0 ? pores / inside : 1.0);
    }
    return layers;
}

}  // namespace

Expectation expect_pores(const PoreSpace& space, const GeometryConfig& geometry) {
    const VoxelPlan plan = space.section_only().plan_at(space.voxel_size_m(geometry.voxel_size_m));
    const auto cells = static_cast<double>(plan.grid.size());
    return {.text = fmt::format("{} x {} x {} voxels of {:.4g} m", plan.grid.cells[0], plan.grid.cells[1], plan.grid.cells[2],
                                plan.voxel_size_m),
            .memory_bytes = std::max(bytes_per_voxel * cells, tortuosity::diffusive_memory_bytes(cells)),
            .wall_time_s = 2e-5 * cells};
}

Outcome<results::Pores> describe_pores(const PoreSpace& space, const GeometryConfig& geometry) {
    vessels::require_prism(space.container, "the description of the pores");
    require_memory(expect_pores(space, geometry).memory_bytes, "the voxels of the pores", "use a larger voxel size or a shorter section");
    const PoreSpace part = space.section_only();
    const PhaseImage image = part.voxelise_at(space.voxel_size_m(geometry.voxel_size_m));
    const std::array<bool, 3> periodic = space.periodic_sides();
    const double h = image.grid.spacing_m[0];
    if (std::count(image.phase.begin(), image.phase.end(), static_cast<std::uint8_t>(Phase::pore)) == 0)
        throw UserError("the section has no pores at this voxel size", {.where = space.source, .fix = "use smaller voxels"});

    log_info("pores: chords and correlation");
    std::array<Chords, 3> chords;
    Outcome<results::Pores> found{{.voxel_size_m = h, .section_m = space.section.interval()}};
    auto& [result, files] = found;
    for (std::size_t a = 0; a < 3; ++a) {
        const bool exact = a == 2 && space.has_exact_walls();
        chords[a] = exact ? vertical_chords(*space.solid, space.container, space.section)
                          : chords_of_voxels(image, static_cast<int>(a), periodic[a]);
        result.chords.emplace_back(std::string(1, axes[a]), results::ChordLengths{.chords = chords[a].lengths_m.size(),
                                                                                  .mean_m = chords[a].mean_m,
                                                                                  .standard_deviation_m = chords[a].deviation_m,
                                                                                  .from = exact ? "exact" : "voxels"});
    }
    files.tables.emplace_back("chords.csv", chord_table(chords));
    const shapes::Vec3 inner = space.container.high() - space.container.low();
    const double farthest = std::isfinite(space.grain_size_m) ? 6.0 * space.grain_size_m : 0.25 * inner.x();
    const Correlation correlation = correlate(image, periodic, farthest);
    files.tables.emplace_back("correlation.csv", correlation_table(correlation));

    log_info("pores: sizes");
    const std::vector<float> distance =
        space.grains() ? wall_distance_m(image, *space.grains(), space.container) : wall_distance_m(image, periodic);
    const std::vector<float> diameter = pore_diameter_m(image, distance, periodic);
    Sizes sizes;
    for (std::size_t cell = 0; cell < diameter.size(); ++cell)
        if (image.phase[cell] == Phase::pore && diameter[cell] > 0.0F) sizes.diameter_m.push_back(static_cast<double>(diameter[cell]));
    std::sort(sizes.diameter_m.begin(), sizes.diameter_m.end());
    files.tables.emplace_back("pore_sizes.csv", size_table(sizes));
    result.network = describe_network(pore_network(image, distance, periodic), files);
    for (int axis = 0; axis < 3; ++axis)
        result.critical_diameter_m.emplace_back(std::string(1, axes[axis]), critical_diameter_m(image, distance, axis));

    log_info("pores: diffusion along z, for Katz & Thompson's permeability");
    if (const auto& along_z = result.critical_diameter_m.back().second) {
        const double relative = tortuosity::diffusive_tortuosity(image, 2, periodic).relative_diffusivity;
        result.relative_diffusivity = relative;
        result.permeability_katz_thompson_m2 = katz_thompson_m2(*along_z, relative);
    }
    const bool worth_drawing = correlation.distance_m.size() > 2 && !chords[2].lengths_m.empty();
    if (worth_drawing)
        files.plots.push_back({"pores.svg", "pores", {{"porosity", correlation.porosity()}}, {.width = 1100, .height = 380}});

    result.porosity_of_voxels = correlation.porosity();
    result.pore_diameter_median_m = sizes.quantile(0.5);
    result.pore_diameter_10_percent_m = sizes.quantile(0.1);
    result.pore_diameter_90_percent_m = sizes.quantile(0.9);
    result.critical_diameter_uncertainty_m = (space.grains() ? 1.5 : 2.0) * h;
    result.surface_per_volume_per_m = correlation.surface_per_volume_m();
    if (const auto scatter = uncertainty::porosity_scatter(layer_porosities(image), space.section.length(), space.equivalent_diameter_m)) {
        result.porosity_scatter_of_such_sections = scatter->deviation;
        result.porosity_scatter_interval = scatter->interval;
    }
    return found;
}

}  // namespace porepack::analysis
