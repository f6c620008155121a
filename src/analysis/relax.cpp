#include "analysis/relax.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>
#include <vector>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/median.hpp"
#include "core/table.hpp"
#include "packing/structure.hpp"
#include "pouring/dem/relax.hpp"
#include "record/resolved_config.hpp"

namespace porepack::analysis {
namespace {

// The keys that do something for grains that are there already.
constexpr std::array used = {"engine",
                             "density_kg_per_m3",
                             "gravity_m_per_s2",
                             "normal_stiffness_N_per_m",
                             "tangential_stiffness_N_per_m",
                             "normal_damping",
                             "tangential_damping",
                             "friction",
                             "wall_friction",
                             "time_step_s",
                             "settle_time_s",
                             "rest_energy_fraction",
                             "friction_limit"};

void require_used_keys(const PackingConfig& config) {
    const Json given = resolved_config(config), usual = resolved_config(PackingConfig{});
    for (const auto& [key, value] : given.items())
        if (value != usual.at(key) && std::find(used.begin(), used.end(), key) == used.end())
            throw UserError(fmt::format("`{}` has no effect on given grains", key), {.where = "pack --from", .fix = "remove it"});
    if (config.engine != Engine::capsule)
        throw UserError("given grains relax in the DEM of exact shapes", {.where = "pack --from", .fix = "remove --engine"});
}

}  // namespace

Relaxation relax_packing(const Packing& given, const PackingConfig& config) {
    require_used_keys(config);
    const Relaxed found = relax(given, config);

    const double d = finest_diameter(given);
    const std::vector<long> before = structure_of(given, 0.0, d, 1).neighbours, after = structure_of(found.packing, 0.0, d, 1).neighbours;
    const std::vector<bool> whole = whole_grains(found.packing);
    Table table({"grain", "shape", "moved_m", "turned_degrees", "neighbours_before", "neighbours", "whole", "held"});
    double sum_before = 0.0, sum = 0.0;
    long counted = 0, held = 0;
    for (std::size_t i = 0; i < given.bodies.size(); ++i) {
        table.add(static_cast<double>(i), given.shapes[given.bodies[i].shape].id, found.moved_m[i],
                  found.turned_rad[i] * 180.0 / std::numbers::pi, static_cast<double>(before[i]), static_cast<double>(after[i]),
                  whole[i] ? 1.0 : 0.0, found.held[i] ? 1.0 : 0.0);
        held += found.held[i] ? 1 : 0;
        if (!whole[i]) continue;
        sum_before += static_cast<double>(before[i]);
        sum += static_cast<double>(after[i]);
        ++counted;
    }
    const auto farthest = std::max_element(found.moved_m.begin(), found.moved_m.end());
    const auto per_grain = [&](double neighbours) {
        return counted > 0 ? std::optional(neighbours / static_cast<double>(counted)) : std::nullopt;
    };
    results::Relax result{.grains = given.bodies.size(),
                          .grains_held = held,
                          .grains_whole = counted,
                          .overlap_before_m = found.overlap_before_m,
                          .overlap_m = found.overlap_after_m,
                          .moved_median_m = median(found.moved_m),
                          .moved_largest_m = *farthest,
                          .grain_moved_most = farthest - found.moved_m.begin(),
                          .turned_median_degrees = median(found.turned_rad) * 180.0 / std::numbers::pi,
                          .mean_force_over_weight = found.mean_force_over_weight,
                          .kinetic_energy_per_grain_J = found.kinetic_energy_per_grain_J,
                          .steps = found.steps,
                          .engine_wall_time_s = found.wall_time_s,
                          .coordination_number_before = per_grain(sum_before),
                          .coordination_number = per_grain(sum)};
    return {.outcome = {result, {.tables = {{"movements.csv", table}}}}, .packing = found.packing};
}

results::Relax written(const Relaxation& relaxation, const Path& folder) {
    write_packing(folder / "packing.json", relaxation.packing);
    return written(relaxation.outcome, folder);
}

}  // namespace porepack::analysis
