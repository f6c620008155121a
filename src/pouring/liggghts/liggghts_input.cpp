// Writes the input of a LIGGGHTS run: poses, parameters, contact law and clumps.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "pouring/batches.hpp"
#include "pouring/grain_body.hpp"
#include "pouring/liggghts/liggghts_run.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::liggghts {
ClumpBody clump_body(const Shape& shape, const PackingConfig& config) {
    const GrainBody grain = grain_body(shape, config.density_kg_per_m3);
    ClumpBody body{.spheres = {}, .mass = grain.mass_kg, .inertia = grain.inertia_kg_m2, .centre = grain.centre_m, .turn = grain.turn};
    for (Capsule sphere : clump_spheres_for(shape, config)) {
        // About the centre of mass, in the principal axes: the inertia tensor in the template is then diagonal.
        sphere.a = sphere.b = grain.turn.conjugate() * (sphere.a - body.centre);
        body.spheres.push_back(sphere);
    }
    if (body.spheres.size() == 1) {  // LIGGGHTS needs two spheres or more: one inside, without contacts
        body.spheres.push_back(body.spheres.front());
        body.spheres.back().radius *= 0.5;
    }
    return body;
}

namespace {

void write_batch(const Path& file, const Batch& batch, const std::vector<ClumpBody>& bodies) {
    std::string text = "# Creates one batch, each grain at its given pose.\n";
    // LIGGGHTS places grains at random in a region. A region of 2 nm fixes the place; `orientation constant` fixes the rotation.
    const double h = 1e-9;
    for (std::size_t g = 0; g < batch.size(); ++g) {
        const ClumpBody& body = bodies[batch[g].shape];
        const Vec3 x = batch[g].position_m + batch[g].orientation * body.centre;
        const Quaternion q = batch[g].orientation * body.turn;
        text += fmt::format("region at{0} block {1:.17g} {2:.17g} {3:.17g} {4:.17g} {5:.17g} {6:.17g} units box volume_limit 1e-40\n", g,
                            x.x() - h, x.x() + h, x.y() - h, x.y() + h, x.z() - h, x.z() + h);
        text += fmt::format(
            "fix new{0} all insert/pack seed 32452843 distributiontemplate grains_{8} insert_every once verbose no overlapcheck no all_in "
            "no "
            "&\n"
            "    orientation constant {1:.17g} {2:.17g} {3:.17g} {4:.17g} vel constant {5:.17g} {6:.17g} {7:.17g} region at{0} "
            "particles_in_region 1 ntry_mc 1000\n",
            g, q.w(), q.x(), q.y(), q.z(), batch[g].velocity_m_per_s.x(), batch[g].velocity_m_per_s.y(), batch[g].velocity_m_per_s.z(),
            batch[g].shape + 1);
    }
    // One step creates the batch; its regions and fixes are of no further use.
    text += "run 1\n";
    for (std::size_t g = 0; g < batch.size(); ++g) text += fmt::format("unfix new{0}\nregion at{0} delete\n", g);
    write_text(file, text);
}

}  // namespace

void write_batches(Run& run, const Pour& pour) {
    for (const Batch& batch : pour.batches) {
        run.batches.emplace_back();
        for (const auto& grain : batch) run.batches.back().push_back(grain.shape);
        write_batch(run.folder / fmt::format("batch_{}.in", run.batches.size()), batch, run.bodies);
    }
    // The energy that the pour supplies is bounded by the potential energy of each grain's highest point and its initial kinetic energy.
    run.top_m = pour.top_m;
    for (const Batch& batch : pour.batches)
        for (const Newcomer& grain : batch)
            run.max_energy_J +=
                run.bodies[grain.shape].mass * (run.config.gravity_m_per_s2 * (grain.position_m.z() + maximum_feret_diameter(run.shapes)) +
                                                0.5 * grain.velocity_m_per_s.squaredNorm());
    // A vessel that is shaken throws grains about with some times its speed.
    double mass = 0.0;
    for (const Batch& batch : pour.batches)
        for (const Newcomer& grain : batch) mass += run.bodies[grain.shape].mass;
    for (const ProtocolStep& step : run.protocol.step) {
        double speed = 0.0;
        if (step.height_m > 0.0)
            speed = fall_speed(step, run.config.gravity_m_per_s2);
        else if (step.kind == StepKind::tap || step.kind == StepKind::vibrate)
            speed = peak_acceleration(step).norm() / (2.0 * std::numbers::pi * step.frequency_Hz);
        run.max_energy_J += 50.0 * mass * speed * speed;
    }
}

long Run::grains_after(long batch) const {
    long count = 0;
    for (long b = 0; b < std::min(batch, static_cast<long>(batches.size())); ++b)
        count += static_cast<long>(batches[static_cast<std::size_t>(b)].size());
    return count;
}

long Run::spheres_after(long batch) const {
    long count = 0;
    for (long b = 0; b < std::min(batch, static_cast<long>(batches.size())); ++b)
        for (const std::size_t shape : batches[static_cast<std::size_t>(b)]) count += static_cast<long>(bodies[shape].spheres.size());
    return count;
}

std::string wall_script(const Container& container) {
    const auto walls = container.vessel().walls();
    if (!walls || container.vessel().fills_bounds()) return walls ? "box" : "";
    if (walls->mesh != nullptr) return "mesh";
    if (!walls->planes.empty() || walls->round.empty() || walls->round.front().inside) return "";
    if (walls->round.size() == 1) return walls->round.front().slope == 0.0 ? "cylinder" : "mesh";
    return walls->round.size() == 2 && walls->round.back().inside && walls->round.front().slope == 0.0 ? "annulus" : "";
}

void write_triangles(const TriangleMesh& mesh, const Path& path) {
    std::string text = "solid sides\n";
    for (const auto& triangle : mesh.triangles) {
        const auto corner = [&](std::size_t i) -> const Vec3& { return mesh.points_m[static_cast<std::size_t>(triangle[i])]; };
        const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
        text += fmt::format("facet normal {:.9g} {:.9g} {:.9g}\nouter loop\n", normal.x(), normal.y(), normal.z());
        for (std::size_t i = 0; i < 3; ++i)
            text += fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", corner(i).x(), corner(i).y(), corner(i).z());
        text += "endloop\nendfacet\n";
    }
    write_text(path, text + "endsolid sides\n");
}

namespace {

// Facets of a cone from the floor to `top`, whose cross-section has the area of the circle. A sphere checks all facets within its skin
// in each step, so they are few, and four times as high as wide.
void write_cone(const VesselWalls::Round& wall, double top, const Path& path) {
    constexpr int around = 64;
    const double step = 2.0 * std::numbers::pi / around, widest = std::max(wall.radius_m, wall.radius_m + wall.slope * top);
    const int layers = std::max(1, static_cast<int>(std::lround(top / (4.0 * step * widest))));
    const auto corner = [&](int layer, int n) {
        const double z = top * layer / layers, r = (wall.radius_m + wall.slope * z) * std::sqrt(step / std::sin(step));
        return Vec3(r * std::cos(n * step), r * std::sin(n * step), z);
    };
    TriangleMesh mesh;
    for (int layer = 0; layer <= layers; ++layer)
        for (int n = 0; n < around; ++n) mesh.points_m.push_back(corner(layer, n));
    for (int layer = 0; layer < layers; ++layer)
        for (int n = 0; n < around; ++n) {
            const int here = layer * around + n, next = layer * around + (n + 1) % around;
            mesh.triangles.push_back({here, next, next + around});
            mesh.triangles.push_back({here, next + around, here + around});
        }
    write_triangles(mesh, path);
}

}  // namespace

void write_parameters(const Run& run, const Snapshot& snapshot) {
    const auto& c = run.config;
    const double d = finest_diameter(run.shapes);
    const double top = std::max(run.container.high().z(), run.top_m) + 3.0 * d;
    const std::string script = wall_script(run.container);
    const auto walls = run.container.vessel().walls();
    double margin = d;
    const Vec3 low = run.container.low(), high = run.container.high();
    if (walls->mesh != nullptr) {
        write_triangles(walls->mesh->sides(0.0, top), run.folder / "sides.stl");
    } else if (script == "mesh") {
        const auto& cone = walls->round.front();
        // Its tip, if it lies within reach, is no end of the surface.
        const double end = cone.slope < 0.0 ? std::min(top, -0.99 * cone.radius_m / cone.slope) : top;
        write_cone(cone, end, run.folder / "sides.stl");
        margin += std::max(0.0, cone.radius_m + cone.slope * end - high.x());
    }
    const double dt = run.plan.time_step_s;
    // Per sphere, because the script knows the number of spheres, not that of grains.
    double limit = 1e300;  // per sphere; for a mixture the lowest
    for (std::size_t s = 0; s < run.bodies.size(); ++s)
        limit = std::min(limit, c.rest_energy_fraction * run.bodies[s].mass * c.gravity_m_per_s2 * smallest_diameter(run.shapes[s].shape) /
                                    static_cast<double>(run.bodies[s].spheres.size()));
    constexpr long part = 5000;
    std::string text = "# Written by porepack; SI units. Contact law, Eq. 9: stiffness s_n/2, dashpot 2 eta sqrt((s_n/2)/m_ij) per m_ij.\n";
    const auto number = [&](const char* name, double value) { text += fmt::format("variable {} equal {:.17g}\n", name, value); };
    const auto whole = [&](const char* name, long value) { text += fmt::format("variable {} equal {}\n", name, value); };
    text += fmt::format("variable container string {}\n", script);
    number("radius", walls->round.empty() ? 0.0 : walls->round.front().radius_m);
    number("inner_radius", walls->round.size() < 2 ? 0.0 : walls->round.back().radius_m);
    number("size_x", script == "box" ? run.container.size().x() : 0.0);
    number("size_y", script == "box" ? run.container.size().y() : 0.0);
    number("x_low", low.x() - margin);
    number("x_high", high.x() + margin);
    number("y_low", low.y() - margin);
    number("y_high", high.y() + margin);
    number("z_low", -d);
    number("z_high", top + d);
    number("neighbour_skin", d);
    number("time_step", dt);
    number("gravity", c.gravity_m_per_s2);
    whole("types", static_cast<long>(run.shapes.size()) + 1);
    whole("wall_type", static_cast<long>(run.shapes.size()) + 1);
    whole("batches", static_cast<long>(run.batches.size()));
    whole("steps_between_batches", std::max(1L, std::lround(c.batch_interval_s / dt)));
    whole("steps_per_line", 2000);
    whole("steps_per_part", part);
    const long settle_parts = std::max(2L, static_cast<long>(std::ceil(c.settle_time_s / dt / part)));
    whole("settle_parts", settle_parts);
    number("fill_height", c.grains > 0 ? 1e30 : run.plan.fill_height_m - d / 2.0);
    number("energy_limit_per_sphere", limit);
    // A sphere may spin in place without end: where there are spheres, the criterion of rest leaves the rotation out.
    const bool spheres = std::any_of(run.shapes.begin(), run.shapes.end(), [](const ShapeShare& share) {
        return share.shape.capsules.size() == 1 && share.shape.capsules.front().a == share.shape.capsules.front().b;
    });
    whole("rotation_counts", spheres ? 0 : 1);
    const long check = std::max(500L, std::lround(0.005 / dt));  // of rest, after a step
    whole("steps_per_check", check);
    whole("rest_parts", std::max(2L, static_cast<long>(std::ceil(c.settle_time_s / dt / static_cast<double>(check)))));
    const auto shakes = [](const ProtocolStep& step) { return step.kind == StepKind::tap || step.kind == StepKind::vibrate; };
    whole("shaken", std::any_of(run.protocol.step.begin(), run.protocol.step.end(), shakes) ? 1 : 0);
    whole("last_steps", !run.protocol.none() && run.protocol.step.back().stays ? 4 * check : 0);
    whole("steps_per_snapshot", std::max(1L, std::lround(c.snapshot_interval_s / dt)));
    // Start of the run; a run by hand starts from the beginning: new, none, and zeros.
    text += fmt::format("variable begin string {}\n", snapshot.step > 0 ? "again" : "new");
    text += fmt::format("variable snapshot string {}\n", snapshot.file);
    whole("snapshot_step", snapshot.step);
    whole("poured", snapshot.poured);
    whole("settled", snapshot.settled);
    whole("calm", snapshot.calm);
    whole("in_protocol", snapshot.in_protocol() ? 1 : 0);
    whole("finished", snapshot.finished);
    whole("repeated", snapshot.repeated);
    const auto batches = static_cast<long>(run.batches.size());
    // Once settling has begun no batch follows, even where not all of them were poured.
    whole("first_batch", snapshot.settled > 0 ? batches + 1 : snapshot.poured + 1);
    whole("first_part", std::min(snapshot.settled + 1, settle_parts));
    write_text(run.folder / "parameters.in", text);
}

// The contact law between all types, and one template per shape.
void write_grains(const Run& run) {
    const auto& c = run.config;
    const std::size_t types = run.bodies.size() + 1;
    // A wall has infinite mass; values between two walls are never used.
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
    // LIGGGHTS needs a prime above 10000 as the seed of each template; the poses are given, so the seed has no effect.
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

}  // namespace porepack::pouring::liggghts
