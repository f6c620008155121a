#include "pouring/dem/capsule_pour.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "pouring/batches.hpp"
#include "pouring/dem/protocol_run.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr long part = 500;          // steps between two checks
constexpr int snapshot_format = 4;  // of PourProgress and what follows

struct PourProgress {
    long next_batch = 0;
    bool poured = false, calm = false;  // calm: at rest with sleeping grains; all were woken since
    long settled_at = 0;                // step at which the last batch was created, all were woken, or may sleep again
    long awakenings = 0;                // of all grains
    enum class Part : long { pour, protocol, rest } now = Part::pour;
};

// Grains with faces cost so much more than capsules that a bed in which a few of them roll on may sleep again, until it has been woken
// this many times.
constexpr long max_awakenings = 10;

// The key comes first, so that a snapshot of other settings is recognised before its content is read. The file replaces the earlier one
// only when it is complete.
void write_snapshot(const Path& file, const std::string& key, const CapsuleDem& dem, const PourProgress& at, const ProtocolRun& protocol) {
    write_whole(file, [&](const Path& temporary) {
        std::ofstream out(temporary, std::ios::binary);
        out << key << "\n";
        out.write(reinterpret_cast<const char*>(&at), sizeof at);
        dem.save(out);
        protocol.save(out);
        if (!out.flush()) throw MachineError("the snapshot could not be written", {.where = file.string(), .fix = "is the disk full?"});
    });
}

// False when there is no snapshot, or its settings differ.
bool read_snapshot(const Path& file, const std::string& key, CapsuleDem& dem, PourProgress& at, ProtocolRun& protocol) {
    std::ifstream in(file, std::ios::binary);
    std::string theirs;
    if (!in || !std::getline(in, theirs)) return false;
    if (theirs != key) {
        log_info("pour: {} is of other settings or another version; the pour starts from the beginning", file.string());
        return false;
    }
    in.read(reinterpret_cast<char*>(&at), sizeof at);
    dem.load(in, file.string());
    if (!protocol.load(in))
        throw UserError("this snapshot is cut short", {.where = file.string(), .fix = "remove it to start from the beginning"});
    return true;
}

void require_all_inside(const CapsuleDem& dem, double feret_diameter) {
    const Container& container = dem.container();
    const Vec3 low = container.low(), high = container.high();
    for (std::size_t i = 0; i < dem.size(); ++i) {
        const Vec3& x = dem.centre_of_mass(i);
        bool inside = x.allFinite() && x.z() > -0.5 * feret_diameter && container.wall_distance(x) > -0.5 * feret_diameter;
        for (int axis = 0; axis < 2; ++axis)
            if (!container.periodic()[static_cast<std::size_t>(axis)])
                inside = inside && x[axis] > low[axis] - 0.5 * feret_diameter && x[axis] < high[axis] + 0.5 * feret_diameter;
        if (!inside)
            throw NumericalError(
                fmt::format("grain {} has left the container: its centre is at {:g} {:g} {:g} m", i, x.x(), x.y(), x.z()),
                {.fix = "lower drop_height_m, horizontal_speed_m_per_s or time_step_s, or raise normal_stiffness_N_per_m"});
    }
}

// One pour: batches are inserted on schedule until the bed is full, then the grains settle until they are at rest. With sleep there are
// two phases of settling: first with sleeping grains, then with all grains awake, because the packing must also be at rest without sleep;
// grains with faces may go through both several times.
class CapsulePour {
public:
    CapsulePour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                const ProtocolConfig& protocol, const Path& folder)
        : config_(config),
          plan_(plan_pour(shapes, container, config, protocol)),
          pour_(make_batches(shapes, container, config, plan_.drop_height_m, plan_.max_grains)),
          dem_(container, shapes_of(shapes), config.density_kg_per_m3, contact_law(config), options()),
          snapshot_(folder / "snapshot.bin"),
          key_(fmt::format("{} {}", scene_key(shapes, container, config, protocol), snapshot_format)),
          diameter_(finest_diameter(shapes)),
          feret_diameter_(maximum_feret_diameter(shapes)),
          interval_(steps_of(config.batch_interval_s)),
          snapshot_steps_(steps_of(config.snapshot_interval_s)),
          settle_steps_(std::lround(config.settle_time_s / plan_.time_step_s)),
          limit_J_(config.rest_energy_fraction * plan_.grain_mass_kg * config.gravity_m_per_s2 * diameter_),
          faced_(std::any_of(shapes.begin(), shapes.end(), [](const ShapeShare& share) { return share.shape.body != nullptr; })),
          has_protocol_(!protocol.none()),
          protocol_(protocol, config,
                    {.plan = plan_, .diameter_m = diameter_, .feret_diameter_m = feret_diameter_, .rest_limit_J = limit_J_}, dem_) {}

    [[nodiscard]] PourResult run() {
        start_or_resume();
        const Stopwatch watch;
        if (at_.now == PourProgress::Part::pour) {
            pour_and_settle();
            if (has_protocol_) begin_protocol();
        }
        if (at_.now == PourProgress::Part::protocol) {
            carry_out_protocol();
            begin_rest();
        }
        if (at_.now == PourProgress::Part::rest && !scattered()) pour_and_settle();
        std::error_code ignored;
        std::filesystem::remove(snapshot_, ignored);
        return result(watch.seconds());
    }

private:
    [[nodiscard]] bool scattered() const { return config_.fill == Fill::scatter; }

    // Scattered grains have no weight, and do not settle.
    void pour_and_settle() {
        Progress progress("pour (capsules)");
        if (scattered()) {
            insert();
            at_.poured = true;
            return;
        }
        do {
            save();  // between a decision of settled() and the next steps
            if (!at_.poured && dem_.steps() == at_.next_batch * interval_) insert();
            advance();
            report(progress);
        } while (!at_.poured || !settled());
    }

    void begin_protocol() {
        at_.now = PourProgress::Part::protocol;
        protocol_.begin();
    }

    void carry_out_protocol() {
        Progress progress("protocol");
        while (!protocol_.done()) {
            save();
            protocol_.advance();
            check_interrupt();
            if (!scattered()) require_all_inside(dem_, feret_diameter_);
            progress.update(std::min(0.99, protocol_.fraction_done()), protocol_.text());
        }
    }

    // As after the pour.
    void begin_rest() {
        at_.now = PourProgress::Part::rest;
        at_.calm = false;
        at_.settled_at = dem_.steps();
        at_.awakenings = 0;
        energy_before_ = std::numeric_limits<double>::infinity();
        dem_.set_sleep(may_sleep());
        if (scattered()) rest_ = dem_.rest();
    }

    [[nodiscard]] bool may_sleep() const { return config_.sleep && !dem_.lid(); }

    static std::vector<Shape> shapes_of(const std::vector<ShapeShare>& shapes) {
        std::vector<Shape> kinds;
        for (const auto& share : shapes) kinds.push_back(share.shape);
        return kinds;
    }
    [[nodiscard]] DemOptions options() const {
        return {.time_step_s = plan_.time_step_s,
                .gravity_m_per_s2 = Vec3(0, 0, scattered() ? 0.0 : -config_.gravity_m_per_s2),
                .integrator = config_.integrator,
                .sleep = config_.sleep};
    }
    [[nodiscard]] long steps_of(double time_s) const { return std::max(1L, std::lround(time_s / plan_.time_step_s)); }
    [[nodiscard]] long batches() const { return static_cast<long>(pour_.batches.size()); }

    void start_or_resume() {
        make_folder(snapshot_.parent_path());
        if (read_snapshot(snapshot_, key_, dem_, at_, protocol_)) {
            log_info("pour: resumes from {:.2f} s with {} grains", dem_.time_s(), dem_.size());
            // A snapshot of the second phase continues with all grains awake.
            if (at_.now != PourProgress::Part::protocol) dem_.set_sleep(may_sleep() && !at_.calm);
        } else {
            log_info("pour: at most {} grains of exact shape, time step {:.2e} s", plan_.max_grains, plan_.time_step_s);
        }
        next_snapshot_ = dem_.steps() + snapshot_steps_;
    }

    // Inserts the next batch; none when all are poured or the bed has reached the fill height.
    void insert() {
        const bool full = at_.next_batch > 0 && config_.grains == 0 && dem_.rest().top_m > plan_.fill_height_m;
        if (at_.next_batch == batches() || full) {
            at_.poured = true;
            at_.settled_at = dem_.steps();
            return;
        }
        for (const Newcomer& grain : pour_.batches[static_cast<std::size_t>(at_.next_batch)])
            dem_.add(grain.shape, grain.position_m, grain.orientation, grain.velocity_m_per_s);
        ++at_.next_batch;
    }

    // Steps until the next check or the next batch.
    void advance() {
        // Steps end exactly at the next batch, because run() inserts it at this step only.
        const long until = at_.poured ? dem_.steps() + part : std::min(dem_.steps() / part * part + part, at_.next_batch * interval_);
        dem_.step(until - dem_.steps());
        check_interrupt();
    }

    void save() {
        if (dem_.steps() < next_snapshot_) return;
        write_snapshot(snapshot_, key_, dem_, at_, protocol_);
        next_snapshot_ = dem_.steps() + snapshot_steps_;
    }

    // After the last batch, also how far the bed was from rest at the last check.
    void report(Progress& progress) const {
        std::string text = fmt::format("{:.2f} s, {} grains, {} asleep", dem_.time_s(), dem_.size(), dem_.sleeping());
        if (at_.poured && checked_) text += fmt::format(", energy {:.1e} of {:.1e} J", rest_.kinetic_energy_per_grain_J, limit_J_);
        if (at_.calm && checked_) text += fmt::format(", force {:.1g} of {:g} weights", rest_.mean_force_over_weight, rest_force_limit);
        progress.update(std::min(0.97, static_cast<double>(dem_.steps()) / plan_.expected_steps), text);
    }

    // Returns true at rest; wakes all grains at the end of the first phase.
    bool settled() {
        require_all_inside(dem_, feret_diameter_);
        rest_ = dem_.rest();
        checked_ = true;
        require_falling_energy();
        const bool last_phase = !may_sleep() || at_.calm;
        // Net forces are judged with all grains awake only.
        const bool balanced = !last_phase || (rest_.mean_force_over_weight < rest_force_limit && protocol_.lid_at_rest());
        if (rest_.kinetic_energy_per_grain_J < limit_J_ && balanced && dem_.steps() - at_.settled_at > interval_) {
            if (last_phase) return true;
            // The second phase has its own settling time.
            at_.calm = true;
            at_.settled_at = dem_.steps();
            ++at_.awakenings;
            dem_.set_sleep(false);
        } else if (at_.calm && faced_ && at_.awakenings < max_awakenings && dem_.steps() - at_.settled_at > interval_) {
            at_.calm = false;
            at_.settled_at = dem_.steps();
            dem_.set_sleep(true);
        }
        if (dem_.steps() - at_.settled_at > settle_steps_)
            throw NumericalError(fmt::format("the grains are not at rest {:g} s after the last batch or awakening: kinetic energy {:.3g} J "
                                             "per grain (limit {:.3g} J), net force {:.2g} "
                                             "weights (limit {:g})",
                                             config_.settle_time_s, rest_.kinetic_energy_per_grain_J, limit_J_,
                                             rest_.mean_force_over_weight, rest_force_limit),
                                 {.fix = "raise settle_time_s, or shorten time_step_s"});
        return false;
    }

    // After the pour no energy is supplied; the time discretisation of an impact may add a small amount.
    void require_falling_energy() {
        const double energy = dem_.energy().total(),
                     scale = static_cast<double>(dem_.size()) * plan_.grain_mass_kg * config_.gravity_m_per_s2 * diameter_;
        if (!std::isfinite(energy) || energy > energy_before_ + 0.05 * scale)
            throw NumericalError(fmt::format("energy grows: by {:.3g} J in {} steps", energy - energy_before_, part),
                                 {.allowed = "it decreases after the pour", .fix = "shorten time_step_s"});
        energy_before_ = energy;
    }

    [[nodiscard]] PourResult result(double wall_time_s) const {
        const WallLoads loads = dem_.wall_loads();
        const auto with_protocol = [&](double force) { return has_protocol_ && !scattered() ? std::optional(force) : std::nullopt; };
        return {.packing = dem_.packing(),
                .grains = static_cast<long>(dem_.size()),
                .batches = at_.next_batch,
                .thinned_batches = pour_.thinned,
                .steps = dem_.steps(),
                .kinetic_energy_per_grain_J = rest_.kinetic_energy_per_grain_J,
                .rest_limit_J = limit_J_,
                .coordination_number = rest_.coordination_number,
                .largest_force_over_weight = rest_.largest_force_over_weight,
                .mean_force_over_weight = rest_.mean_force_over_weight,
                .pose_error_m = std::nullopt,
                .protocol = protocol_.rows(),
                .floor_force_N = with_protocol(loads.floor_N),
                .side_force_N = with_protocol(loads.sides_N),
                .lid_force_N = dem_.lid() ? std::optional(loads.lid_N) : std::nullopt,
                .wall_time_s = wall_time_s,
                .command = {}};
    }

    const PackingConfig& config_;
    PourPlan plan_;
    Pour pour_;
    CapsuleDem dem_;
    Path snapshot_;
    std::string key_;
    double diameter_, feret_diameter_;
    long interval_, snapshot_steps_, settle_steps_;  // in steps
    double limit_J_;                                 // of the kinetic energy per grain at rest
    bool faced_, has_protocol_;
    ProtocolRun protocol_;
    PourProgress at_;
    DemRest rest_;
    bool checked_ = false;  // rest_ is known
    long next_snapshot_ = 0;
    double energy_before_ = std::numeric_limits<double>::infinity();
};

}  // namespace

ContactLaw contact_law(const PackingConfig& config) {
    return {.normal_stiffness_N_per_m = config.normal_stiffness_N_per_m,
            .tangential_stiffness_N_per_m = config.tangential_stiffness_N_per_m,
            .normal_damping = config.normal_damping,
            .tangential_damping = config.tangential_damping,
            .friction = config.friction,
            .wall_friction = config.wall_friction,
            .elastic_limit = config.friction_limit == FrictionLimit::elastic};
}

PourResult pour_with_capsules(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                              const Path& folder, const ProtocolConfig& protocol) {
    return CapsulePour(shapes, container, config, protocol, folder).run();
}

}  // namespace porepack::pouring::dem
