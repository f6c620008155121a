#include "packing/liggghts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/process.hpp"

namespace porepack {
namespace {

// The standard library's distributions differ between implementations; these do not.
class Random {
public:
    explicit Random(long seed) : engine_(static_cast<std::uint64_t>(seed)) {}
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
    // Uniform over all rotations (Shoemake 1992).
    Quaternion rotation() {
        const double u = uniform(0, 1), v = 2.0 * std::numbers::pi * uniform(0, 1), w = 2.0 * std::numbers::pi * uniform(0, 1);
        return {std::sqrt(1 - u) * std::sin(v), std::sqrt(1 - u) * std::cos(v), std::sqrt(u) * std::sin(w), std::sqrt(u) * std::cos(w)};
    }

private:
    std::mt19937_64 engine_;
};

// The grain as LIGGGHTS sees it: clump about the centre of mass, axes along the principal ones, so that the body frame
// that LIGGGHTS finds is this frame.
struct ClumpBody {
    std::vector<Capsule> spheres;
    double mass = 0.0;
    Vec3 inertia = Vec3::Zero();
    Vec3 centre = Vec3::Zero();                // in the shape's frame
    Quaternion turn = Quaternion::Identity();  // from the principal frame to the shape's frame
};

// To seven digits of `size`: a packing is chaotic, and must not change because the last bits of an integral do.
double rounded(double value, double size) {
    const double unit = std::pow(10.0, std::floor(std::log10(size)) - 6.0);
    return std::round(value / unit) * unit;
}

ClumpBody clump_body(const Shape& shape, const PackingConfig& config) {
    const ShapeMeasures measures = measure(shape);
    ClumpBody body;
    const double mass = config.density_kg_per_m3 * measures.volume_m3;
    body.mass = rounded(mass, mass);
    for (int axis = 0; axis < 3; ++axis) body.centre[axis] = rounded(measures.centre_of_mass_m[axis], measures.span_m);
    Eigen::Matrix3d tensor = measures.inertia_per_density_m5;
    const double largest = tensor.cwiseAbs().maxCoeff();
    tensor = tensor.unaryExpr([&](double value) { return rounded(value, largest); });
    const Eigen::Matrix3d off = tensor - Eigen::Matrix3d(tensor.diagonal().asDiagonal());
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
    if (off.norm() > 1e-5 * tensor.norm()) {
        axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor).eigenvectors();
        if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
    }
    body.turn = Quaternion(axes);
    body.inertia = config.density_kg_per_m3 * (axes.transpose() * tensor * axes).diagonal();
    for (auto sphere : sphere_clump(shape, config.surface_tolerance * smallest_diameter(shape))) {
        sphere.a = sphere.b = axes.transpose() * (sphere.a - body.centre);
        body.spheres.push_back(sphere);
    }
    if (body.spheres.size() == 1) {  // LIGGGHTS wants two spheres or more: one inside, which nothing touches
        body.spheres.push_back(body.spheres.front());
        body.spheres.back().radius *= 0.5;
    }
    return body;
}

double contact_time(double mass, const PackingConfig& config) {
    const double kn = config.normal_stiffness_N_per_m / 2.0;
    return std::numbers::pi / std::sqrt(kn / (mass / 2.0) * (1.0 - config.normal_damping * config.normal_damping));
}

// A grain about to be created: its origin, orientation and velocity.
struct Newcomer {
    std::size_t shape;
    Vec3 position;
    Quaternion orientation;
    double vx, vy;
};

double finest_diameter(const std::vector<ShapeShare>& shapes) {
    double least = 1e300;
    for (const auto& share : shapes) least = std::min(least, smallest_diameter(share.shape));
    return least;
}

double largest_span(const std::vector<ShapeShare>& shapes) {
    double largest = 0.0;
    for (const auto& share : shapes) largest = std::max(largest, span(share.shape));
    return largest;
}

// Draws a shape by the number fractions; one shape needs no draw.
std::size_t draw(const std::vector<ShapeShare>& shapes, Random& random) {
    if (shapes.size() == 1) return 0;
    double at = random.uniform(0.0, 1.0);
    for (std::size_t s = 0; s + 1 < shapes.size(); ++s) {
        if (at < shapes[s].number_fraction) return s;
        at -= shapes[s].number_fraction;
    }
    return shapes.size() - 1;
}

// Poses of one batch: random in a slab at the drop height, clear of the walls and of each other. As many as fit.
std::vector<Newcomer> make_batch(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                                 double drop_height, long count, Random& random) {
    constexpr int tries = 300;
    const double slab = largest_span(shapes);
    const double clearance = 0.02 * finest_diameter(shapes);
    std::vector<Newcomer> batch;
    std::vector<std::vector<Capsule>> placed;
    const auto fits = [&](const std::vector<Capsule>& grain) {
        for (const auto& capsule : grain)
            for (const Vec3& end : {capsule.a, capsule.b})
                if (container.wall_distance(end) < capsule.radius + clearance) return false;
        for (const auto& other : placed)
            for (const auto& p : other)
                for (const auto& q : grain)
                    if (gap(p, q) < clearance) return false;
        return true;
    };
    for (long n = 0; n < count; ++n) {
        const std::size_t kind = draw(shapes, random);
        for (int t = 0; t < tries; ++t) {
            const Vec3 low = container.low(), high = container.high();
            Newcomer grain{};
            grain.shape = kind;
            grain.position = Vec3(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                                  drop_height + random.uniform(0.0, slab) - slab / 2.0);
            grain.orientation = random.rotation();
            std::vector<Capsule> capsules;
            for (const auto& capsule : shapes[kind].shape.capsules) capsules.push_back(moved(capsule, grain.position, grain.orientation));
            if (!fits(capsules)) continue;
            grain.vx = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            grain.vy = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            batch.push_back(grain);
            placed.push_back(capsules);
            break;
        }
    }
    return batch;
}

void write_batch(const Path& file, const std::vector<Newcomer>& batch, const std::vector<ClumpBody>& bodies) {
    std::string text = "# Creates one batch, each grain at its own pose.\n";
    const double h = 1e-9;
    for (std::size_t g = 0; g < batch.size(); ++g) {
        const ClumpBody& body = bodies[batch[g].shape];
        const Vec3 x = batch[g].position + batch[g].orientation * body.centre;
        const Quaternion q = batch[g].orientation * body.turn;
        text += fmt::format("region at{0} block {1:.17g} {2:.17g} {3:.17g} {4:.17g} {5:.17g} {6:.17g} units box volume_limit 1e-40\n", g,
                            x.x() - h, x.x() + h, x.y() - h, x.y() + h, x.z() - h, x.z() + h);
        text += fmt::format(
            "fix new{0} all insert/pack seed 32452843 distributiontemplate grains_{8} insert_every once verbose no overlapcheck no all_in "
            "no "
            "&\n"
            "    orientation constant {1:.17g} {2:.17g} {3:.17g} {4:.17g} vel constant {5:.17g} {6:.17g} 0.0 region at{0} "
            "particles_in_region 1 ntry_mc 1000\n",
            g, q.w(), q.x(), q.y(), q.z(), batch[g].vx, batch[g].vy, 0, batch[g].shape + 1);
    }
    text += "run 1\n";
    for (std::size_t g = 0; g < batch.size(); ++g) text += fmt::format("unfix new{0}\nregion at{0} delete\n", g);
    write_text(file, text);
}

struct Run {
    const std::vector<ShapeShare>& shapes;
    const Container& container;
    const PackingConfig& config;
    PourPlan plan;
    std::vector<ClumpBody> bodies;  // by shape
    Path folder;
    std::vector<std::vector<std::size_t>> batches = {};  // the shapes of each batch's grains, in the order of creation
};

void write_batches(Run& run) {
    Random random(run.config.seed);
    for (long left = run.plan.most_grains; left > 0;) {
        const auto batch =
            make_batch(run.shapes, run.container, run.config, run.plan.drop_height_m, std::min(left, run.config.batch_grains), random);
        if (batch.empty())
            throw UserError("no grain fits into the container at the drop height", {.mend = "take a wider container or smaller grains"});
        left -= static_cast<long>(batch.size());
        run.batches.emplace_back();
        for (const auto& grain : batch) run.batches.back().push_back(grain.shape);
        write_batch(run.folder / fmt::format("batch_{}.in", run.batches.size()), batch, run.bodies);
    }
}

void write_parameters(const Run& run) {
    const auto& c = run.config;
    const double d = finest_diameter(run.shapes);
    const double margin = d;
    const Vec3 low = run.container.low(), high = run.container.high();
    const double dt = run.plan.time_step_s;
    double limit = 1e300;  // a sphere; of a mixture the strictest
    for (std::size_t s = 0; s < run.bodies.size(); ++s)
        limit = std::min(limit, c.rest_energy_fraction * run.bodies[s].mass * c.gravity_m_per_s2 * smallest_diameter(run.shapes[s].shape) /
                                    static_cast<double>(run.bodies[s].spheres.size()));
    constexpr long part = 5000;
    std::string text = "# Written by porepack; SI units. The law is Eq. 9: spring s_n/2, dashpot 2 eta sqrt((s_n/2)/m_ij) a mass m_ij.\n";
    const auto number = [&](const char* name, double value) { text += fmt::format("variable {} equal {:.17g}\n", name, value); };
    const auto whole = [&](const char* name, long value) { text += fmt::format("variable {} equal {}\n", name, value); };
    text += fmt::format("variable container string {}\n", run.container.kind == Container::Kind::cylinder ? "cylinder" : "box");
    number("radius", run.container.diameter_m / 2.0);
    number("size_x", run.container.size_m.x());
    number("size_y", run.container.size_m.y());
    number("x_low", low.x() - margin);
    number("x_high", high.x() + margin);
    number("y_low", low.y() - margin);
    number("y_high", high.y() + margin);
    number("z_low", -margin);
    number("z_high", std::max(high.z(), run.plan.drop_height_m + largest_span(run.shapes)) + 4.0 * margin);
    number("neighbour_skin", d);
    number("time_step", dt);
    number("gravity", c.gravity_m_per_s2);
    whole("types", static_cast<long>(run.shapes.size()) + 1);
    whole("wall_type", static_cast<long>(run.shapes.size()) + 1);
    whole("batches", static_cast<long>(run.batches.size()));
    whole("loop_end", static_cast<long>(run.batches.size()) + 2);
    whole("steps_between_batches", std::max(1L, std::lround(c.batch_interval_s / dt)));
    whole("steps_per_line", 2000);
    whole("steps_per_part", part);
    whole("settle_parts", std::max(1L, static_cast<long>(std::ceil(c.settle_time_s / dt / part))));
    number("fill_height", c.grains > 0 ? 1e30 : run.plan.fill_height_m - d / 2.0);
    number("energy_limit_per_sphere", limit);
    const bool spheres = std::any_of(run.shapes.begin(), run.shapes.end(), [](const ShapeShare& share) {
        return share.shape.capsules.size() == 1 && share.shape.capsules.front().a == share.shape.capsules.front().b;
    });
    whole("rotation_counts", spheres ? 0 : 1);
    write_text(run.folder / "parameters.in", text);
}

// The contact law between all types, and a template for each shape.
void write_grains(const Run& run) {
    const auto& c = run.config;
    const std::size_t types = run.bodies.size() + 1;
    // A wall is infinitely heavy; between walls nothing is ever asked.
    const auto effective_mass = [&](std::size_t i, std::size_t j) {
        const double first = run.bodies[std::min(i, types - 2)].mass, second = run.bodies[std::min(j, types - 2)].mass;
        if (i + 1 == types) return second;
        return j + 1 == types ? first : first * second / (first + second);
    };
    std::string text = "# Written by porepack. Types: the shapes in their order, then the walls.\n";
    const auto property = [&](const char* name, const char* global, const auto& value) {
        text += fmt::format("fix {} all property/global {} peratomtypepair {}", name, global, types);
        for (std::size_t i = 0; i < types; ++i)
            for (std::size_t j = 0; j < types; ++j)
                text += fmt::format(" {:.17g}", value(effective_mass(i, j), std::max(i, j) + 1 == types));
        text += "\n";
    };
    const double kn = c.normal_stiffness_N_per_m / 2.0, kt = c.tangential_stiffness_N_per_m / 2.0;
    property("kn", "kn", [&](double, bool) { return kn; });
    property("kt", "kt", [&](double, bool) { return kt; });
    property("gn", "gamman", [&](double mass, bool) { return 2.0 * c.normal_damping * std::sqrt(kn / mass); });
    property("gt", "gammat", [&](double mass, bool) { return 2.0 * c.tangential_damping * std::sqrt(kt / mass); });
    property("mu", "coefficientFriction", [&](double, bool wall) { return wall ? c.wall_friction : c.friction; });
    // LIGGGHTS wants a prime above 10000 as the seed of each template; poses are given, so nothing is drawn from it.
    for (std::size_t s = 0; s < run.bodies.size(); ++s) {
        const ClumpBody& body = run.bodies[s];
        text += fmt::format(
            "fix grain_{0} all particletemplate/multisphere 15485863 atom_type {0} density constant {1:.17g} nspheres {2} ntry 1000 &\n"
            "    spheres file grain_{0}.clump scale 1.0 type {0} mass {3:.17g} inertia_tensor {4:.17g} 0 0 {5:.17g} 0 {6:.17g} "
            "use_density\n"
            "fix grains_{0} all particledistribution/discrete 15485867 1 grain_{0} 1.0\n",
            s + 1, c.density_kg_per_m3, body.spheres.size(), body.mass, body.inertia.x(), body.inertia.y(), body.inertia.z());
        std::string clump;
        for (const auto& sphere : body.spheres)
            clump += fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}\n", sphere.a.x(), sphere.a.y(), sphere.a.z(), sphere.radius);
        write_text(run.folder / fmt::format("grain_{}.clump", s + 1), clump);
    }
    write_text(run.folder / "grains.in", text);
}

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

PourPlan plan_pour(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config) {
    if (container.any_periodic())
        throw UserError("LIGGGHTS pours into a container with walls, this one is periodic",
                        {.mend = "give a packing.json with engine = \"none\", or a container with walls"});
    const double d = finest_diameter(shapes);
    const double extent = largest_span(shapes);
    const Vec3 inner = container.high() - container.low();
    if (extent > std::min(inner.x(), inner.y()) || 2.0 * extent > container.height())
        throw UserError(
            fmt::format("the grain is too large for the container: it spans {:.4g} m, the container is {:.4g} m wide and {:.4g} m high",
                        extent, std::min(inner.x(), inner.y()), container.height()),
            {.allowed = "a container wider than one grain's span and higher than two",
             .mend = "check the units (metres), take a larger container or smaller grains"});
    PourPlan plan;
    double mean_volume = 0.0, largest_volume = 0.0, smallest_volume = 1e300, mean_spheres = 0.0;
    for (const auto& [shape, share] : shapes) {
        const double volume = measure(shape, 1e-6).volume_m3;
        mean_volume += share * volume;
        largest_volume = std::max(largest_volume, volume);
        smallest_volume = std::min(smallest_volume, volume);
        const auto spheres = static_cast<double>(sphere_clump(shape, config.surface_tolerance * smallest_diameter(shape)).size());
        mean_spheres += share * spheres;
    }
    plan.grain_mass_kg = config.density_kg_per_m3 * mean_volume;
    const double static_overlap =
        config.density_kg_per_m3 * largest_volume * config.gravity_m_per_s2 / (config.normal_stiffness_N_per_m / 2.0) / d;
    if (static_overlap > 0.01)
        throw UserError(
            fmt::format("the contacts are too soft: one grain's weight presses a contact in by {:.2g} of its diameter", static_overlap),
            {.allowed = "1 % of the diameter",
             .mend = fmt::format("set normal_stiffness_N_per_m to {:.2g} or more, tangential_stiffness_N_per_m to half of it",
                                 config.normal_stiffness_N_per_m * static_overlap / 0.001)});
    plan.contact_time_s = contact_time(config.density_kg_per_m3 * smallest_volume, config);
    plan.time_step_s = config.time_step_s > 0.0 ? config.time_step_s : plan.contact_time_s / 45.0;
    if (plan.time_step_s > plan.contact_time_s / 30.0)
        throw UserError(fmt::format("the time step {:.3g} s is too long: a contact lasts {:.3g} s", plan.time_step_s, plan.contact_time_s),
                        {.allowed = fmt::format("up to {:.3g} s (1/30 of the contact; longer steps never come to rest or lose grains)",
                                                plan.contact_time_s / 30.0)});
    plan.fill_height_m = config.fill_height_m > 0.0 ? config.fill_height_m : container.height() / 2.0;
    plan.drop_height_m = config.drop_height_m > 0.0 ? config.drop_height_m : container.height() - extent;
    if (config.grains == 0 && plan.fill_height_m > plan.drop_height_m - extent)
        throw UserError(fmt::format("the bed would reach the place where grains are created: fill height {:.4g} m, drop height {:.4g} m",
                                    plan.fill_height_m, plan.drop_height_m),
                        {.allowed = fmt::format("a fill height up to {:.4g} m", plan.drop_height_m - extent),
                         .mend = "take a higher container or a lower fill_height_m"});
    // Poured grains of these shapes fill no more than 3/4 of the space.
    const double most = 0.75 * container.inner_area_m2() * plan.drop_height_m / mean_volume;
    if (static_cast<double>(config.grains) > most)
        throw UserError(fmt::format("{} grains do not fit below the drop height", config.grains),
                        {.allowed = fmt::format("at most about {:.0f}", most), .mend = "take a higher container or fewer grains"});
    const double densest = 0.75 * container.inner_area_m2() * plan.fill_height_m / mean_volume;
    plan.most_grains = config.grains > 0 ? config.grains : std::max(1L, static_cast<long>(densest));
    plan.clump_spheres = std::lround(mean_spheres);
    // From measurements: 0.4 us a sphere and step, on average half of the grains present, about four a batch.
    const double grains = config.grains > 0 ? static_cast<double>(config.grains) : densest / 1.8;
    const double steps = (grains / 4.0 * config.batch_interval_s + 0.6) / plan.time_step_s;
    plan.expected_wall_time_s =
        0.4e-6 * 0.6 * grains * static_cast<double>(plan.clump_spheres) * steps / static_cast<double>(config.processes);
    plan.expected_memory_bytes = 60e6 + 4000.0 * static_cast<double>(plan.most_grains * plan.clump_spheres);
    return plan;
}

PourResult pour_with_liggghts(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                              const Path& templates, const Path& folder) {
    Run run{.shapes = shapes,
            .container = container,
            .config = config,
            .plan = plan_pour(shapes, container, config),
            .bodies = {},
            .folder = folder};
    for (const auto& share : shapes) run.bodies.push_back(clump_body(share.shape, config));
    require_program("liggghts", "liggghts");
    if (config.processes > 1) require_program("mpirun", "openmpi-bin");
    make_folder(folder);
    for (const char* name : {"pour.in", "walls_cylinder.in", "walls_box.in"})
        std::filesystem::copy_file(templates / name, folder / name, std::filesystem::copy_options::overwrite_existing);
    write_batches(run);
    write_parameters(run);
    write_grains(run);

    PourResult result;
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
    if (result.pose_error_m > 1e-6 * finest_diameter(shapes))
        throw EngineError(fmt::format("the poses read back do not give the clump's spheres: off by {:.3g} m", result.pose_error_m),
                          {.where = (folder / "final.bodies").string()});
    return result;
}

}  // namespace porepack
