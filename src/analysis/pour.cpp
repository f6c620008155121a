#include "analysis/pour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/uses.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "pouring/liggghts/liggghts.hpp"

namespace porepack::analysis {
namespace {

// Cost and errors of the clump of spheres; LIGGGHTS is still given the exact mass and inertia.
results::Clump clump_of(const Shape& shape, const PackingConfig& config) {
    const Shape clump{.id = shape.id, .capsules = clump_spheres_for(shape, config), .cavity = shape.cavity};
    const bool faced = shape.body != nullptr;
    const ShapeMeasures exact = measure(shape, 1e-6), of_clump = measure(clump, faced ? 1e-4 : 1e-6);
    const double solid = exact.volume_m3 - (shape.cavity == Cavity::filled ? exact.cavity_volume_m3 : 0.0);
    return {.shape = shape.id,
            .spheres = clump.capsules.size(),
            .largest_surface_error_m = faced ? clump_error(shape, clump.capsules) : clump_for(shape, config).tolerance_m,
            .volume_error = of_clump.volume_m3 / solid - 1.0,
            .area_error = of_clump.surface_area_m2 / exact.surface_area_m2 - 1.0};
}

// Carman-Kozeny, Ergun and the report use the shape of the case: it must be that of the packing.
void require_same_shape(const std::vector<ShapeShare>& shapes, const Packing& packing, const std::string& file) {
    for (const auto& other : packing.shapes) {
        const double volume = measure(other, 1e-6).volume_m3;
        if (std::none_of(shapes.begin(), shapes.end(),
                         [&](const ShapeShare& share) { return std::abs(volume / measure(share.shape, 1e-6).volume_m3 - 1.0) < 1e-3; }))
            throw UserError(fmt::format("the grain of the case is not the one of the packing: {:.4g} m3, `{}` has {:.4g} m3",
                                        measure(shapes.front().shape, 1e-6).volume_m3, other.id, volume),
                            {.where = file, .fix = "let [shape] describe the packing's grain"});
    }
}

results::Pour result_of(const PourResult& pour, const std::vector<ShapeShare>& shapes, const PackingConfig& config) {
    results::Pour result{.batches = pour.batches,
                         .thinned_batches = pour.thinned_batches,
                         .steps = pour.steps,
                         .kinetic_energy_per_grain_J = pour.kinetic_energy_per_grain_J,
                         .rest_limit_J = pour.rest_limit_J,
                         .at_rest = pour.at_rest(),
                         .coordination_number = pour.coordination_number,
                         .mean_force_over_weight = pour.mean_force_over_weight,
                         .largest_force_over_weight = pour.largest_force_over_weight,
                         .engine_wall_time_s = pour.wall_time_s};
    if (config.engine == Engine::liggghts) {
        const double d = finest_diameter(pour.packing);
        result.pose_error_relative_to_diameter = *pour.pose_error_m / d;
        result.largest_clump_overlap_relative_to_diameter = *pour.largest_clump_overlap_m / d;
        result.clumps.emplace();
        for (const auto& share : shapes) result.clumps->push_back(clump_of(share.shape, config));
        result.repeat_by_hand = "cd run && " + pour.command;
    }
    return result;
}

Table protocol_table(const std::vector<ProtocolRow>& rows) {
    Table table({"step", "kind", "repeat", "time_s", "bed_height_m", "porosity", "coordination_number", "coordination_without_rattlers",
                 "rattlers", "lid_height_m", "lid_force_N", "pressure_Pa"});
    const auto known = [](double value) { return value != 0.0 ? std::optional(value) : std::nullopt; };
    for (const ProtocolRow& row : rows) {
        // Grains that are shaken fly.
        const bool flies = row.kind == StepKind::vibrate && row.repeat > 0;
        const auto at_rest = [&](auto value) { return flies ? decltype(value){} : value; };
        table.add(row.step, row.step == 0 ? "pour" : std::string(name_of(row.kind)), row.repeat, row.time_s, row.bed_height_m, row.porosity,
                  at_rest(std::optional(row.coordination_number)), at_rest(row.coordination_without_rattlers), at_rest(row.rattlers),
                  known(row.lid_height_m), known(row.lid_force_N), known(row.pressure_Pa));
    }
    return table;
}

// The last row of each step is the bed after it.
results::Protocol protocol_result(const PourResult& pour, const ProtocolConfig& protocol, const PackingConfig& config) {
    results::Protocol result{.floor_force_N = pour.floor_force_N, .side_force_N = pour.side_force_N, .lid_force_N = pour.lid_force_N};
    long last = -1;
    for (const ProtocolRow& row : pour.protocol) {
        const bool poured = row.step == 0;
        results::ProtocolStep one{.kind = poured ? "pour" : std::string(name_of(row.kind)),
                                  .time_s = row.time_s,
                                  .bed_height_m = row.bed_height_m,
                                  .porosity = row.porosity,
                                  .coordination_number = row.coordination_number,
                                  .reached = row.reached};
        if (row.kind == StepKind::tap && !poured) one.taps = row.repeat;
        if (!poured)
            one.acceleration_over_gravity =
                relative_acceleration(protocol.step[static_cast<std::size_t>(row.step - 1)], config.gravity_m_per_s2);
        if (row.pressure_Pa != 0.0) one.pressure_Pa = row.pressure_Pa;
        if (config.fill == Fill::scatter) one.coordination_without_rattlers = *row.coordination_without_rattlers;
        if (row.step == last)
            result.steps.back() = one;
        else
            result.steps.push_back(one);
        last = row.step;
    }
    const auto missed = [](const results::ProtocolStep& step) { return !step.reached; };
    if (std::any_of(result.steps.begin(), result.steps.end(), missed))
        log_warning(fmt::format("[protocol] did not reach its aim: the porosity is {:.4f}", result.steps.back().porosity));
    return result;
}

// The spheres of LIGGGHTS's clumps lie up to a tolerance below the grains' surface, so two exact grains may overlap by twice that more than
// soft contacts.
void allow_clump_overlaps(Packing& packing, const results::Pour& pour) {
    double error_m = 0.0;
    for (const results::Clump& clump : *pour.clumps) error_m = std::max(error_m, clump.largest_surface_error_m);
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing), soft = largest_overlap_of_diameter * d,
                 largest = std::max(overlaps.largest_between_grains_m, overlaps.largest_with_wall_m);
    packing.overlap_allowed = largest > soft && largest <= soft + 2.0 * error_m;
    if (packing.overlap_allowed)
        log_warning(
            fmt::format("grains overlap by up to {:.2g} of the thickness of the thinnest: the clumps' spheres lie up to {:.2g} of it "
                        "below the surface",
                        largest / d, error_m / d));
}

PourResult pour_with_engine(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                            const ProtocolConfig& protocol, const Path& folder) {
    switch (config.engine) {
        case Engine::liggghts:
            return liggghts::pour_with_liggghts(shapes, container, config, data_file("liggghts_templates"), folder / "run", {}, protocol);
        case Engine::capsule:
            return dem::pour_with_capsules(shapes, container, config, folder, protocol);
        case Engine::none:
            break;
    }
    throw std::logic_error("no engine pours this packing");
}

}  // namespace

void add_grains(results::Pack& pack, const Packing& packing) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing);
    pack.grains = packing.bodies.size();
    if (packing.shapes.size() > 1) {
        std::vector<long> count(packing.shapes.size(), 0);
        for (const auto& body : packing.bodies) ++count[body.shape];
        pack.grains_of_shape.emplace();
        for (std::size_t i = 0; i < count.size(); ++i) pack.grains_of_shape->emplace_back(packing.shapes[i].id, count[i]);
    }
    pack.largest_overlap_relative_to_diameter = overlaps.largest_between_grains_m / d;
    pack.mean_overlap_relative_to_diameter = overlaps.mean_between_grains_m / d;
    pack.largest_wall_overlap_relative_to_diameter = overlaps.largest_with_wall_m / d;
    pack.contacts = overlaps.contacts;
}

void require_same_bed(const std::vector<ShapeShare>& shapes, const Container& container, const Packing& packing, const std::string& file) {
    if (to_json(packing.container) != to_json(container))
        throw UserError("the container of the packing is not the one of the case",
                        {.where = file, .allowed = text_of(container), .fix = "[container] must say " + text_of(packing.container)});
    require_same_shape(shapes, packing, file);
}

Poured pour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config, const ProtocolConfig& protocol,
            const Path& folder) {
    const PourResult pour = pour_with_engine(shapes, container, config, protocol, folder);
    Poured poured{.result = {.engine = std::string(name_of(config.engine)), .seed = config.seed}, .packing = pour.packing, .protocol = {}};
    poured.result.pour = result_of(pour, shapes, config);
    if (!protocol.none()) {
        poured.result.protocol = protocol_result(pour, protocol, config);
        poured.protocol = protocol_table(pour.protocol);
    }
    if (config.engine == Engine::liggghts) allow_clump_overlaps(poured.packing, *poured.result.pour);
    return poured;
}

Expectation expect_pour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                        const ProtocolConfig& protocol) {
    const PourPlan plan = plan_pour(shapes, container, config, protocol);
    const std::string engine = config.engine == Engine::liggghts
                                   ? fmt::format("LIGGGHTS, up to {} grains of {} spheres", plan.max_grains, plan.clump_spheres)
                                   : fmt::format("capsules, up to {} grains", plan.max_grains);
    return {.text = fmt::format("{}, time step {:.2e} s", engine, plan.time_step_s),
            .memory_bytes = plan.expected_memory_bytes,
            .wall_time_s = plan.expected_wall_time_s};
}

}  // namespace porepack::analysis
