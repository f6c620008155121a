#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"
#include "packing/batches.hpp"
#include "packing/liggghts_run.hpp"

namespace porepack {
namespace {

// The last thermo line of a growing log: step, spheres, energies, height of the bed.
std::optional<std::array<double, 5>> last_state(const Path& log) {
    std::istringstream lines(tail(log, 3));
    std::optional<std::array<double, 5>> state;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream numbers(line.substr(std::min<std::size_t>(4, line.size())));
        std::array<double, 5> values{};
        bool all = true;
        for (double& value : values) all = all && static_cast<bool>(numbers >> value);
        if (all) state = values;
    }
    return state;
}

struct LogEnd {
    long poured = 0, step = 0, spheres = 0;
    double energy = 0.0, limit = 0.0;
    bool done = false;
};

LogEnd read_log_end(const Path& log) {
    LogEnd end;
    std::ifstream in(log);
    for (std::string line; std::getline(in, line);) {
        if (std::sscanf(line.c_str(), "POREPACK poured %ld", &end.poured) == 1) continue;
        end.done = end.done || std::sscanf(line.c_str(), "POREPACK done step %ld spheres %ld energy %lf limit %lf", &end.step, &end.spheres,
                                           &end.energy, &end.limit) == 4;
    }
    return end;
}

// Rows of a LIGGGHTS dump of `columns` numbers behind "ITEM: ENTRIES" or "ITEM: ATOMS".
std::vector<std::vector<double>> read_dump(const Path& file, std::size_t columns) {
    std::ifstream in(file);
    std::vector<std::vector<double>> rows;
    bool inside = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("ITEM:")) {
            inside = line.starts_with("ITEM: ENTRIES") || line.starts_with("ITEM: ATOMS");
            if (inside) rows.clear();
            continue;
        }
        if (!inside) continue;
        std::istringstream numbers(line);
        std::vector<double> row(columns);
        for (double& value : row) numbers >> value;
        if (!numbers) throw EngineError("LIGGGHTS wrote a line that is no row of numbers: " + line, {.where = file.string()});
        rows.push_back(row);
    }
    std::sort(rows.begin(), rows.end());
    return rows;
}

// Predicts every clump sphere from the poses and compares with where LIGGGHTS has it.
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
            double least = 1e300;
            auto at = std::lower_bound(real.begin(), real.end(), there, by_z);
            for (auto up = at; up != real.end() && up->z() - there.z() < least; ++up) least = std::min(least, (*up - there).norm());
            for (auto down = at; down != real.begin() && there.z() - std::prev(down)->z() < least; --down)
                least = std::min(least, (*std::prev(down) - there).norm());
            worst = std::max(worst, least);
        }
    return worst;
}

[[noreturn]] void fail_with_log(const std::string& what, const Path& log, const std::string& mend = {}) {
    throw EngineError(what + "\n" + tail(log, 12), {.where = log.string(), .mend = mend});
}

Packing read_packing_back(const Run& run, long expected_grains, const Path& log) {
    Packing packing{.container = run.container, .shapes = {}, .bodies = {}};
    for (const auto& share : run.shapes) packing.shapes.push_back(share.shape);
    // Bodies are numbered in the order of their creation.
    std::vector<std::size_t> order;
    for (const auto& batch : run.batches) order.insert(order.end(), batch.begin(), batch.end());
    const auto bodies = read_dump(run.folder / "final.bodies", 8);
    if (static_cast<long>(bodies.size()) != expected_grains)
        fail_with_log(fmt::format("LIGGGHTS lost grains: {} were poured, {} are left", expected_grains, bodies.size()), log,
                      "raise the container or lower drop_height_m, horizontal_speed_m_per_s or time_step_s");
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const auto& row = bodies[b];
        const ClumpBody& clump = run.bodies[order[b]];
        Body body{.shape = order[b]};
        const Quaternion q(row[4], row[5], row[6], row[7]);
        body.orientation = (q * clump.turn.conjugate()).normalized();
        body.position_m = Vec3(row[1], row[2], row[3]) - body.orientation * clump.centre;
        packing.bodies.push_back(body);
    }
    return packing;
}

std::vector<std::string> command_for(long processes) {
    std::vector<std::string> command = {"stdbuf", "-oL"};
    if (processes > 1) command.insert(command.end(), {"mpirun", "--oversubscribe", "-np", std::to_string(processes)});
    command.insert(command.end(), {"liggghts", "-in", "pour.in"});
    return command;
}

void run_liggghts(const Run& run, const Path& log) {
    Progress progress("pour (LIGGGHTS)");
    const double steps_a_batch = std::max(1.0, run.config.batch_interval_s / run.plan.time_step_s);
    const double steps = steps_a_batch * static_cast<double>(run.batches.size()) + 1.0 / run.plan.time_step_s;
    const Program program{
        .command = command_for(run.config.processes),
        .folder = run.folder,
        .log = log,
        .environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"}, {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"}, {"OMP_NUM_THREADS", "1"}},
        .while_running = [&] {
            if (const auto state = last_state(log))
                progress.update((*state)[0] / steps,
                                fmt::format("step {:.0f}, {:.0f} spheres, the highest at {:.3f} m", (*state)[0], (*state)[1], (*state)[4]));
        }};
    const ProgramEnd end = run_program(program);
    if (end.exit_code != 0) fail_with_log(fmt::format("LIGGGHTS failed with exit code {}", end.exit_code), log);
}

}  // namespace

PourResult pour_with_liggghts(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                              const Path& templates, const Path& folder) {
    Run run{.shapes = shapes,
            .container = container,
            .config = config,
            .plan = plan_pour(shapes, container, config),
            .bodies = {},
            .folder = folder};
    for (const auto& share : shapes) run.bodies.push_back(clump_body(share.shape, config));
    if (container.any_periodic())
        throw UserError("LIGGGHTS pours into a container with walls, this one is periodic",
                        {.mend = "engine = \"capsule\" pours into boxes that are periodic in x and y; or take a container with walls"});
    require_program("liggghts", "liggghts");
    if (config.processes > 1) require_program("mpirun", "openmpi-bin");
    make_folder(folder);
    for (const char* name : {"pour.in", "walls_cylinder.in", "walls_box.in"})
        std::filesystem::copy_file(templates / name, folder / name, std::filesystem::copy_options::overwrite_existing);
    PourResult result;
    result.thinned_batches = write_batches(run);
    write_parameters(run);
    write_grains(run);

    for (const auto& word : command_for(config.processes)) result.command += (result.command.empty() ? "" : " ") + word;
    log_info("pour: at most {} grains of {} spheres, time step {:.2e} s", run.plan.most_grains, run.plan.clump_spheres,
             run.plan.time_step_s);
    const Path log = folder / "log.liggghts.screen";
    const Stopwatch watch;
    run_liggghts(run, log);
    result.wall_time_s = watch.seconds();

    const LogEnd end = read_log_end(log);
    if (!end.done) fail_with_log("LIGGGHTS ended with exit code 0, but before the end of its script", log);
    if (end.poured < 1 || end.poured > static_cast<long>(run.batches.size()))
        fail_with_log(fmt::format("LIGGGHTS says that it poured {} batches of {}", end.poured, run.batches.size()), log);
    run.batches.resize(static_cast<std::size_t>(end.poured));
    long spheres = 0;
    for (const auto& batch : run.batches)
        for (const std::size_t shape : batch) {
            ++result.grains;
            spheres += static_cast<long>(run.bodies[shape].spheres.size());
        }
    if (end.spheres != spheres)
        fail_with_log(fmt::format("LIGGGHTS lost grains: {} spheres are left of {}", end.spheres, spheres), log,
                      "raise the container or lower drop_height_m, horizontal_speed_m_per_s or time_step_s");
    result.packing = read_packing_back(run, result.grains, log);
    result.batches = end.poured;
    result.steps = end.step;
    result.kinetic_energy_per_grain_J = end.energy / static_cast<double>(result.grains);
    result.rest_limit_J = end.limit / static_cast<double>(result.grains);
    if (!(result.kinetic_energy_per_grain_J <= result.rest_limit_J))
        throw NumericalError(fmt::format("the grains are not at rest after {:g} s: kinetic energy {:.3g} J a grain, limit {:.3g} J",
                                         config.settle_time_s, result.kinetic_energy_per_grain_J, result.rest_limit_J),
                             {.where = log.string(), .mend = "raise settle_time_s, or shorten time_step_s"});
    result.pose_error_m = pose_error(run, result.packing, read_dump(folder / "final.spheres", 5));
    if (*result.pose_error_m > 1e-6 * finest_diameter(shapes))
        throw EngineError(fmt::format("the poses read back do not give the clump's spheres: off by {:.3g} m", *result.pose_error_m),
                          {.where = (folder / "final.bodies").string()});
    return result;
}

}  // namespace porepack
