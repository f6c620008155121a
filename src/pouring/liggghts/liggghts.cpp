#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "pouring/batches.hpp"
#include "pouring/liggghts/liggghts_log.hpp"
#include "pouring/liggghts/liggghts_run.hpp"
#include "pouring/uses.hpp"
#include "record/digest.hpp"

namespace porepack::pouring::liggghts {
namespace {

// Predicts every clump sphere from the poses and compares it with the sphere's position in LIGGGHTS.
// A check of all conventions at once (order of the bodies, direction of the rotations, principal axes). Both lists are compared without
// numbers: for each predicted sphere the nearest real one, searched upward and downward in z until z alone is farther than the nearest so
// far.
double pose_error(const Run& run, const Packing& packing, const std::vector<std::vector<double>>& spheres) {
    using Sphere = Eigen::Vector4d;  // centre and radius
    std::vector<Sphere> real;
    real.reserve(spheres.size());
    for (const auto& row : spheres) real.emplace_back(row[1], row[2], row[3], row[4]);
    const auto by_z = [](const Sphere& p, const Sphere& q) { return p.z() < q.z(); };
    std::sort(real.begin(), real.end(), by_z);
    double worst = 0.0;
    for (const auto& body : packing.bodies)
        for (const auto& sphere : run.bodies[body.shape].spheres) {
            const ClumpBody& clump = run.bodies[body.shape];
            Sphere there;
            there << body.position_m + body.orientation * (clump.centre + clump.turn * sphere.a), sphere.radius;
            double minimum = 1e300;
            auto at = std::lower_bound(real.begin(), real.end(), there, by_z);
            for (auto up = at; up != real.end() && up->z() - there.z() < minimum; ++up) minimum = std::min(minimum, (*up - there).norm());
            for (auto down = at; down != real.begin() && there.z() - std::prev(down)->z() < minimum; --down)
                minimum = std::min(minimum, (*std::prev(down) - there).norm());
            worst = std::max(worst, minimum);
        }
    return worst;
}

constexpr const char* keep_them =
    "increase the container's height or lower drop_height_m, horizontal_speed_m_per_s or time_step_s; let steps of [protocol] be gentler";

[[noreturn]] void fail_with_log(const std::string& what, const Path& log, const std::string& fix = {}) {
    throw EngineError(what + "\n" + tail(log, 12), {.where = log.string(), .fix = fix});
}

// Net force on the grains, and the clumps' contacts.
void measure_rest(const Run& run, const std::vector<std::vector<double>>& bodies, PourResult& result) {
    double sum = 0.0, largest = 0.0;
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const double weight = run.bodies[result.packing.bodies[b].shape].mass * run.config.gravity_m_per_s2;
        const double net = Vec3(bodies[b][8], bodies[b][9], bodies[b][10]).norm() / weight;
        sum += net;
        largest = std::max(largest, net);
    }
    result.mean_force_over_weight = sum / static_cast<double>(bodies.size());
    result.largest_force_over_weight = largest;
    const ClumpContacts contacts = clump_contacts(run, result.packing);
    result.coordination_number = contacts.coordination_number;
    result.largest_clump_overlap_m = contacts.largest_overlap_m;
}

std::vector<std::string> command_for(long processes) {
    // Line by line, so that the output can be followed while the program runs.
    std::vector<std::string> command = {"stdbuf", "-oL"};
    if (processes > 1) command.insert(command.end(), {"mpirun", "--oversubscribe", "-np", std::to_string(processes)});
    command.insert(command.end(), {"liggghts", "-in", "pour.in"});
    return command;
}

// Faults that LIGGGHTS does not report: grains that could not be created, were lost, or gain energy.
void require_sound(const Run& run, const PourLog& said, const Path& log) {
    if (const long expected = run.spheres_after(said.batch_then); said.spheres < expected)
        fail_with_log(fmt::format("LIGGGHTS lost grains: {} spheres are left of {} at step {}", said.spheres, expected, said.step), log,
                      keep_them);
    if (!said.batches.empty()) {
        const auto [number, spheres] = said.batches.back();
        if (const long expected = run.spheres_after(number); spheres < expected)
            fail_with_log(
                fmt::format("an insertion fell short: LIGGGHTS has {} spheres after creating batch {}, not {}", spheres, number, expected),
                log, keep_them);
    }
    const double energy = said.kinetic_J + said.rotational_J;
    if (!(energy <= run.max_energy_J))
        throw NumericalError(fmt::format("energy grows: the kinetic energy is {:.3g} J at step {}, the initial potential energy {:.3g} J",
                                         energy, said.step, run.max_energy_J),
                             {.where = log.string(), .fix = "shorten time_step_s"});
}

void run_liggghts(const Run& run, PourLog& said, const Path& log) {
    Progress progress("pour (LIGGGHTS)");
    const double steps_a_batch = std::max(1.0, run.config.batch_interval_s / run.plan.time_step_s);
    const double steps =
        steps_a_batch * static_cast<double>(run.batches.size()) + 1.0 / run.plan.time_step_s + run.plan.expected_protocol_steps;
    const auto require = [&] { require_sound(run, said, log); };
    const Program program{
        .command = command_for(run.config.processes),
        .folder = run.folder,
        .log = log,
        .environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"}, {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"}, {"OMP_NUM_THREADS", "1"}},
        .while_running = [&] {
            said.read_on(require);
            const std::string after = said.finished > 0 ? fmt::format(", step {} of [protocol], part {}", said.finished, said.row) : "";
            progress.update(static_cast<double>(said.step) / steps,
                            fmt::format("time step {}, {} spheres, the highest at {:.3f} m{}", said.step, said.spheres, said.bed_m, after));
        }};
    const ProgramEnd end = run_program(program);
    said.read_on(require);
    const bool says_why = said.restless >= 0 || said.short_step > 0;  // and ends with exit code 1
    if (end.exit_code != 0 && !says_why) fail_with_log(fmt::format("LIGGGHTS failed with exit code {}", end.exit_code), log);
}

// "snapshot." or "after.", the beds after a step; scripts stay.
void remove_states(const Path& folder, const char* prefix) {
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().filename().string().starts_with(prefix) && entry.path().extension() != ".in")
            std::filesystem::remove(entry.path());
}

// The last snapshot of an earlier run with the same settings; snapshots with other settings are removed.
// The key covers shapes, container, settings and protocol. The name of a snapshot holds the state of the script.
Snapshot find_snapshot(const Path& folder, const std::string& scene) {
    const Path key = folder / "scene.sha256";
    if (!std::filesystem::exists(key) || read_text(key) != scene + "\n") {
        remove_states(folder, "snapshot.");
        remove_states(folder, "after.");
    }
    write_text(key, scene + "\n");
    Snapshot last;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        Snapshot found{.file = entry.path().filename().string()};
        if (std::sscanf(found.file.c_str(), "snapshot.%ld.%ld.%ld.%ld.%ld.%ld", &found.poured, &found.settled, &found.calm, &found.step,
                        &found.finished, &found.repeated) != 6)
            continue;
        if (found.step > last.step) last = found;
    }
    return last;
}

std::string not_at_rest(const Run& run, const PourLog& said) {
    const double n = static_cast<double>(run.grains_after(said.poured));
    // The energies of a quarter of the settling time, from its middle and from its end: is there still a trend?
    const auto& energies = said.settling_J;
    const std::size_t window = std::max<std::size_t>(1, energies.size() / 4);
    double before = 0.0, after = 0.0;
    for (std::size_t i = 0; i < window; ++i) {
        before += energies[energies.size() / 2 + i];
        after += energies[energies.size() - 1 - i];
    }
    return fmt::format("the grains are not at rest after {:g} s: kinetic energy {:.3g} J per grain (limit {:.3g} J), {}",
                       run.config.settle_time_s, said.end_energy_J / n, said.end_limit_J / n,
                       after > 0.8 * before ? "which no longer decreases" : "which still decreases");
}

// What the steps of [protocol] say of themselves.
void require_carried_out(const Run& run, const PourLog& said, const Path& log) {
    if (said.restless >= 0)
        throw NumericalError(
            said.restless == 0
                ? not_at_rest(run, said)
                : fmt::format("the grains are not at rest {:g} s after step {} of [protocol]: kinetic energy {:.3g} J (limit {:.3g} J)",
                              run.config.settle_time_s, said.restless, said.end_energy_J, said.end_limit_J),
            {.where = log.string(), .fix = "raise settle_time_s, or shorten time_step_s"});
    if (said.short_step > 0)
        throw UserError(fmt::format("the plate would not touch the bed, which is {:.4g} m high", said.plate_m),
                        {.where = fmt::format("[[protocol.step]], step {}", said.short_step), .allowed = "a to_height_m below that"});
}

/// Largest distance (m) between a sphere of LIGGGHTS and its place by the poses read back.
double check_poses(const Run& run, const Packing& packing) {
    const double error_m = pose_error(run, packing, read_dump(run.folder / "final.spheres", 5));
    if (error_m > 1e-6 * finest_diameter(run.shapes))
        throw EngineError(fmt::format("the poses read back do not give the clump's spheres: off by {:.3g} m", error_m),
                          {.where = (run.folder / "final.bodies").string()});
    return error_m;
}

void copy_scripts(const Path& templates, const Path& folder) {
    for (const char* name : {"pour.in", "begin_new.in", "begin_again.in", "snapshot.in", "walls_box.in", "walls_cylinder.in",
                             "walls_annulus.in", "walls_mesh.in", "rest.in", "require_rest.in", "after.in", "shake.in", "fall.in",
                             "step_settle.in", "step_tap.in", "step_vibrate.in", "step_press.in", "step_lower.in"})
        std::filesystem::copy_file(templates / name, folder / name, std::filesystem::copy_options::overwrite_existing);
}

// The grains as LIGGGHTS left them. Throws where some are missing, or the bed is not at rest.
void take_end(Run& run, const PourLog& said, const Path& log, PourResult& result) {
    require_carried_out(run, said, log);
    if (!said.done) fail_with_log("LIGGGHTS ended with exit code 0, but before the end of its script", log);
    if (said.poured < 1 || said.poured > static_cast<long>(run.batches.size()))
        fail_with_log(fmt::format("LIGGGHTS reports {} poured batches of {}", said.poured, run.batches.size()), log);
    // The pour ends early when the bed reaches the fill height: later batches were never created.
    run.batches.resize(static_cast<std::size_t>(said.poured));
    result.grains = run.grains_after(said.poured);
    if (const long spheres = run.spheres_after(said.poured); said.end_spheres != spheres)
        fail_with_log(fmt::format("LIGGGHTS lost grains: {} spheres are left of {}", said.end_spheres, spheres), log, keep_them);
    const auto bodies = read_dump(run.folder / "final.bodies", 11);
    if (static_cast<long>(bodies.size()) != result.grains)
        fail_with_log(fmt::format("LIGGGHTS lost grains: {} were poured, {} are left", result.grains, bodies.size()), log, keep_them);
    result.packing = packing_of(run, bodies);
    result.batches = said.poured;
    result.steps = said.end_step;
    result.kinetic_energy_per_grain_J = said.end_energy_J / static_cast<double>(result.grains);
    result.rest_limit_J = said.end_limit_J / static_cast<double>(result.grains);
    if (!(said.end_energy_J <= said.end_limit_J))
        throw NumericalError(not_at_rest(run, said), {.where = log.string(), .fix = "raise settle_time_s, or shorten time_step_s"});
    measure_rest(run, bodies, result);
    if (*result.mean_force_over_weight > rest_force_limit)
        throw NumericalError(
            fmt::format("the grains do not move, but are not in equilibrium: the mean net force on a grain is {:.2g} weights",
                        *result.mean_force_over_weight),
            {.where = log.string(),
             .allowed = fmt::format("{:g}", rest_force_limit),
             .fix = "lower rest_energy_fraction, or shorten time_step_s"});
}

}  // namespace

PourResult pour_with_liggghts(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                              const Path& templates, const Path& folder, const std::optional<Pour>& given, const ProtocolConfig& protocol) {
    Run run{.shapes = shapes,
            .container = container,
            .config = config,
            .protocol = protocol,
            .plan = plan_pour(shapes, container, config, protocol),
            .bodies = {},
            .folder = folder};
    for (const auto& share : shapes) run.bodies.push_back(clump_body(share.shape, config));
    if (wall_script(container).empty())
        throw UserError("LIGGGHTS pours into boxes, cylinders, annuli, cones and meshes",
                        {.where = text_of(container), .fix = "engine = \"capsule\""});
    if (container.any_periodic())
        throw UserError("LIGGGHTS pours into a container with walls, this one is periodic",
                        {.fix = "engine = \"capsule\" pours into boxes that are periodic in x and y; or use a container with walls"});
    require_program("liggghts", "liggghts");
    if (config.processes > 1) require_program("mpirun", "openmpi-bin");
    make_folder(folder);
    copy_scripts(templates, folder);
    PourResult result;
    const Pour pour = given ? *given : make_batches(shapes, container, config, run.plan.drop_height_m, run.plan.max_grains);
    result.thinned_batches = pour.thinned;
    write_batches(run, pour);
    // Given poses are not part of the key.
    if (given) remove_states(folder, "snapshot.");
    const Snapshot snapshot = find_snapshot(folder, scene_key(shapes, container, config, protocol));
    write_parameters(run, snapshot);
    write_grains(run);
    write_protocol(run, snapshot);

    for (const auto& word : command_for(config.processes)) result.command += (result.command.empty() ? "" : " ") + word;
    if (snapshot.step > 0)
        log_info("pour: resumes from {:.2f} s with {} grains", static_cast<double>(snapshot.step) * run.plan.time_step_s,
                 run.grains_after(snapshot.poured));
    else
        log_info("pour: at most {} grains of {} spheres, time step {:.2e} s", run.plan.max_grains, run.plan.clump_spheres,
                 run.plan.time_step_s);
    const Path log = folder / "log.liggghts.screen";
    PourLog said(log);
    std::filesystem::remove(log);
    const Stopwatch watch;
    run_liggghts(run, said, log);
    result.wall_time_s = watch.seconds();

    take_end(run, said, log, result);
    result.pose_error_m = check_poses(run, result.packing);
    if (!protocol.none()) result.protocol = read_protocol(run);
    remove_states(folder, "snapshot.");
    write_parameters(run, {});  // a run by hand starts from the beginning
    write_protocol(run, {});
    return result;
}

}  // namespace porepack::pouring::liggghts
