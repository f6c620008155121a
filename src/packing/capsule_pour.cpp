#include "packing/capsule_pour.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "packing/batches.hpp"

namespace porepack {
namespace {

constexpr long part = 500;  // steps between two looks

struct Progressing {
    long next_batch = 0;
    bool poured = false, calm = false;  // calm: came to rest with sleepers, and is awake since
    long settled_at = 0;                // step at which the last batch was created
};

void write_snapshot(const Path& file, const std::string& key, const CapsuleDem& dem, const Progressing& at) {
    write_whole(file, [&](const Path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out << key << "\n";
        out.write(reinterpret_cast<const char*>(&at), sizeof at);
        dem.save(out);
        if (!out.flush()) throw MachineError("the snapshot could not be written", {.where = file.string(), .mend = "is the disk full?"});
    });
}

// False when there is none, or one of other settings.
bool read_snapshot(const Path& file, const std::string& key, CapsuleDem& dem, Progressing& at) {
    std::ifstream in(file, std::ios::binary);
    std::string theirs;
    if (!in || !std::getline(in, theirs)) return false;
    if (theirs != key) {
        log_info("pour: {} is of other settings; the pour starts anew", file.string());
        return false;
    }
    in.read(reinterpret_cast<char*>(&at), sizeof at);
    dem.load(in, file.string());
    return true;
}

void require_all_inside(const CapsuleDem& dem, const Container& container, double span) {
    const Vec3 low = container.low(), high = container.high();
    for (std::size_t i = 0; i < dem.size(); ++i) {
        const Vec3& x = dem.centre_of_mass(i);
        bool inside = x.allFinite() && x.z() > -0.5 * span;
        for (int axis = 0; axis < 2; ++axis)
            if (!container.periodic[static_cast<std::size_t>(axis)])
                inside = inside && x[axis] > low[axis] - 0.5 * span && x[axis] < high[axis] + 0.5 * span;
        if (!inside)
            throw NumericalError(
                fmt::format("grain {} has left the container: its centre is at {:g} {:g} {:g} m", i, x.x(), x.y(), x.z()),
                {.mend = "lower drop_height_m, horizontal_speed_m_per_s or time_step_s, or raise normal_stiffness_N_per_m"});
    }
}

}  // namespace

ContactLaw contact_law(const PackingConfig& config) {
    return {.normal_stiffness_N_per_m = config.normal_stiffness_N_per_m,
            .tangential_stiffness_N_per_m = config.tangential_stiffness_N_per_m,
            .normal_damping = config.normal_damping,
            .tangential_damping = config.tangential_damping,
            .friction = config.friction,
            .wall_friction = config.wall_friction,
            .elastic_limit = config.friction_limit == "elastic"};
}

PourResult pour_with_capsules(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                              const Path& folder) {
    const PourPlan plan = plan_pour(shapes, container, config);
    const Pour pour = make_batches(shapes, container, config, plan.drop_height_m, plan.most_grains);
    std::vector<Shape> kinds;
    for (const auto& share : shapes) kinds.push_back(share.shape);
    CapsuleDem dem(container, kinds, config.density_kg_per_m3, contact_law(config),
                   {.time_step_s = plan.time_step_s,
                    .gravity_m_per_s2 = Vec3(0, 0, -config.gravity_m_per_s2),
                    .integrator = config.integrator == "verlet" ? Integrator::verlet : Integrator::adams_bashforth,
                    .sleep = config.sleep});
    make_folder(folder);
    const Path snapshot = folder / "snapshot.bin";
    const std::string key = scene_key(shapes, container, config);
    Progressing at;
    if (read_snapshot(snapshot, key, dem, at)) {
        log_info("pour: goes on from {:.2f} s with {} grains", dem.time_s(), dem.size());
        dem.set_sleep(config.sleep && !at.calm);
    } else {
        log_info("pour: at most {} grains of exact capsules, time step {:.2e} s", plan.most_grains, plan.time_step_s);
    }
    const Stopwatch watch;
    Progress progress("pour (capsules)");
    const double d = finest_diameter(shapes), span = largest_span(shapes);
    const long interval = std::max(1L, std::lround(config.batch_interval_s / plan.time_step_s)),
               snapshot_steps = std::max(1L, std::lround(config.snapshot_interval_s / plan.time_step_s)),
               settle_steps = std::lround(config.settle_time_s / plan.time_step_s);
    const long batches = static_cast<long>(pour.batches.size());
    const double limit = config.rest_energy_fraction * plan.grain_mass_kg * config.gravity_m_per_s2 * d;
    DemRest rest;
    long next_snapshot = dem.steps() + snapshot_steps;
    double energy_before = std::numeric_limits<double>::infinity();
    while (true) {
        if (!at.poured && dem.steps() == at.next_batch * interval) {
            const bool full = at.next_batch > 0 && config.grains == 0 && dem.rest().top_m > plan.fill_height_m;
            if (at.next_batch == batches || full) {
                at.poured = true;
                at.settled_at = dem.steps();
            } else {
                for (const Newcomer& grain : pour.batches[static_cast<std::size_t>(at.next_batch)])
                    dem.add(grain.shape, grain.position_m, grain.orientation, grain.velocity_m_per_s);
                ++at.next_batch;
            }
        }
        const long until = at.poured ? dem.steps() + part : std::min(dem.steps() / part * part + part, at.next_batch * interval);
        dem.step(until - dem.steps());
        check_interrupt();
        if (dem.steps() >= next_snapshot) {
            write_snapshot(snapshot, key, dem, at);
            next_snapshot = dem.steps() + snapshot_steps;
        }
        const double poured = static_cast<double>(at.next_batch) / static_cast<double>(batches);
        progress.update(at.poured ? 0.97 : 0.95 * poured,
                        fmt::format("{:.2f} s, {} grains, {} asleep", dem.time_s(), dem.size(), dem.sleeping()));
        if (!at.poured) continue;
        require_all_inside(dem, container, span);
        rest = dem.rest();
        // Without drive energy only falls; a little more comes from the steps' rounding of impacts.
        const double energy = dem.energy().total(),
                     scale = static_cast<double>(dem.size()) * plan.grain_mass_kg * config.gravity_m_per_s2 * d;
        if (!std::isfinite(energy) || energy > energy_before + 0.05 * scale)
            throw NumericalError(fmt::format("energy grows: by {:.3g} J in {} steps", energy - energy_before, part),
                                 {.allowed = "it falls once nothing is poured", .mend = "shorten time_step_s"});
        energy_before = energy;
        const bool last_phase = !config.sleep || at.calm;
        const bool balanced = !last_phase || rest.mean_force_over_weight < rest_force_limit;
        if (rest.kinetic_energy_per_grain_J < limit && balanced && dem.steps() - at.settled_at > interval) {
            if (last_phase) break;
            // All are woken once more: the packing must be at rest without sleepers.
            at.calm = true;
            at.settled_at = dem.steps();
            dem.set_sleep(false);
        }
        if (dem.steps() - at.settled_at > settle_steps)
            throw NumericalError(
                fmt::format("the grains are not at rest after {:g} s: kinetic energy {:.3g} J a grain (limit {:.3g} J), net force {:.2g} "
                            "weights (limit {:g})",
                            config.settle_time_s, rest.kinetic_energy_per_grain_J, limit, rest.mean_force_over_weight, rest_force_limit),
                {.mend = "raise settle_time_s, or shorten time_step_s"});
    }
    std::error_code ignored;
    std::filesystem::remove(snapshot, ignored);
    return {.packing = dem.packing(),
            .grains = static_cast<long>(dem.size()),
            .batches = at.next_batch,
            .thinned_batches = pour.thinned,
            .steps = dem.steps(),
            .kinetic_energy_per_grain_J = rest.kinetic_energy_per_grain_J,
            .rest_limit_J = limit,
            .coordination_number = rest.coordination_number,
            .largest_force_over_weight = rest.largest_force_over_weight,
            .mean_force_over_weight = rest.mean_force_over_weight,
            .pose_error_m = std::nullopt,
            .wall_time_s = watch.seconds(),
            .command = {}};
}

}  // namespace porepack
