// Steps after the pour with LIGGGHTS: what is written for them, and the beds that are read back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "pouring/liggghts/liggghts_run.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::liggghts {

std::vector<std::vector<double>> read_dump(const Path& file, std::size_t columns, long* step) {
    std::ifstream in(file);
    std::vector<std::vector<double>> rows;
    bool inside = false, step_follows = false;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("ITEM:")) {
            inside = line.starts_with("ITEM: ENTRIES") || line.starts_with("ITEM: ATOMS");
            if (inside) rows.clear();
            step_follows = line.starts_with("ITEM: TIMESTEP");
            continue;
        }
        if (step_follows && step != nullptr) *step = std::strtol(line.c_str(), nullptr, 10);
        step_follows = false;
        if (!inside) continue;
        std::istringstream numbers(line);
        std::vector<double> row(columns);
        for (double& value : row) numbers >> value;
        if (!numbers) throw EngineError("LIGGGHTS wrote a line that is not a row of numbers: " + line, {.where = file.string()});
        rows.push_back(row);
    }
    std::sort(rows.begin(), rows.end());
    return rows;
}

Packing packing_of(const Run& run, const std::vector<std::vector<double>>& bodies) {
    Packing packing{.container = run.container, .shapes = {}, .bodies = {}};
    for (const auto& share : run.shapes) packing.shapes.push_back(share.shape);
    // Bodies are numbered in the order of their creation.
    std::vector<std::size_t> order;
    for (const auto& batch : run.batches) order.insert(order.end(), batch.begin(), batch.end());
    if (bodies.size() > order.size()) throw EngineError(fmt::format("LIGGGHTS has {} grains of {}", bodies.size(), order.size()));
    for (std::size_t b = 0; b < bodies.size(); ++b) {
        const auto& row = bodies[b];
        const ClumpBody& clump = run.bodies[order[b]];
        Body body{.shape = order[b]};
        // LIGGGHTS works in the clump's principal axes about its centre of mass: its rotation is the shape's times `turn`.
        const Quaternion q(row[4], row[5], row[6], row[7]);
        body.orientation = (q * clump.turn.conjugate()).normalized();
        body.position_m = Vec3(row[1], row[2], row[3]) - body.orientation * clump.centre;
        packing.bodies.push_back(body);
    }
    return packing;
}

// Contacts are those of the spheres that LIGGGHTS saw, not those of the exact grains.
ClumpContacts clump_contacts(const Run& run, const Packing& packing) {
    Packing clumps = packing;
    for (std::size_t s = 0; s < clumps.shapes.size(); ++s) {
        clumps.shapes[s] = {.id = clumps.shapes[s].id};
        for (const Capsule& sphere : run.bodies[s].spheres) {
            const Vec3 centre = run.bodies[s].centre + run.bodies[s].turn * sphere.a;
            clumps.shapes[s].capsules.push_back({centre, centre, sphere.radius});
        }
    }
    const Overlaps overlaps = find_overlaps(clumps);
    return {.coordination_number = 2.0 * static_cast<double>(overlaps.contacts) / static_cast<double>(packing.bodies.size()),
            .largest_overlap_m = overlaps.largest_between_grains_m};
}

namespace {

Path bed_file(const Run& run, long step, long row, const char* kind) {
    return run.folder / fmt::format("after.{}.{}.{}", step, row, kind);
}

// Two triangles, wider than the vessel, at z = 0.
void write_plate(const Run& run) {
    const Vec3 low = run.container.low(), high = run.container.high(), margin = 0.1 * (high - low);
    const double x0 = low.x() - margin.x(), x1 = high.x() + margin.x(), y0 = low.y() - margin.y(), y1 = high.y() + margin.y();
    write_triangles({.points_m = {{x0, y0, 0.0}, {x1, y0, 0.0}, {x1, y1, 0.0}, {x0, y1, 0.0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}},
                    run.folder / "plate.stl");
}

struct Parts {
    long number = 1, periods = 1;  ///< whole periods of each
};
/// Taps, or the parts of a vibration, after each of which the bed is written.
Parts parts_of(const ProtocolStep& step, double dt) {
    if (step.kind != StepKind::vibrate) return {.number = std::max(1L, step.number)};
    const long all = whole_periods(step, dt), periods = (all + rows_of_vibration - 1) / rows_of_vibration;
    return {.number = (all + periods - 1) / periods, .periods = periods};
}

std::string shaking(const ProtocolStep& step, double dt) {
    const Vec3 peak = peak_acceleration(step);
    const long period = period_steps(step, dt);
    return fmt::format("variable period_steps equal {}\nvariable shaken_steps equal {}\n", period, parts_of(step, dt).periods * period) +
           fmt::format("variable peak_x equal {:.17g}\nvariable peak_y equal {:.17g}\nvariable peak_z equal {:.17g}\n", peak.x(), peak.y(),
                       peak.z());
}

std::string repeated_step(const Run& run, const ProtocolStep& step, long done) {
    const bool falls = step.kind == StepKind::tap && step.height_m > 0.0;
    if (step.kind == StepKind::tap && done >= parts_of(step, run.plan.time_step_s).number) return "";
    std::string text = fmt::format("variable first_repeat equal {}\nvariable repeats equal {}\nvariable rest_factor equal {}\n", done + 1,
                                   parts_of(step, run.plan.time_step_s).number, step.kind == StepKind::tap ? tap_rest_factor : 1.0);
    if (falls)
        text += fmt::format("variable fall_speed equal {:.17g}\n", fall_speed(step, run.config.gravity_m_per_s2));
    else
        text += shaking(step, run.plan.time_step_s);
    if (step.kind == StepKind::vibrate) return text + "include step_vibrate.in\n";
    return text + fmt::format("variable strike delete\nvariable strike string {}\ninclude step_tap.in\n", falls ? "fall" : "shake");
}

std::string plate_step(const Run& run, const ProtocolStep& step) {
    const double d = finest_diameter(run.shapes), g = run.config.gravity_m_per_s2;
    std::string text = fmt::format("variable plate_gap equal {:.17g}\nvariable plate_speed equal {:.17g}\nvariable stays equal {}\n",
                                   1e-3 * d, plate_speed_m_per_s(step, d, g), step.stays ? 1 : 0);
    if (step.to_height_m > 0.0) return text + fmt::format("variable to_height equal {:.17g}\ninclude step_lower.in\n", step.to_height_m);
    // The plate's way down does not count as time in which the bed comes to rest.
    const double check = std::max(500.0, 0.005 / run.plan.time_step_s);
    text += fmt::format("variable way_parts equal {}\n",
                        2 + static_cast<long>(run.container.height() / plate_speed_m_per_s(step, d, g) / run.plan.time_step_s / check));
    return text + fmt::format("variable plate_force equal {:.17g}\ninclude step_press.in\n", plate_mass_kg(step, run.container, g) * g);
}

// Height of the plate and force on it.
void add_plate(const Run& run, long step, ProtocolRow& row) {
    const Path file = bed_file(run, step, 1, "plate");
    std::ifstream in(file);
    if (!(in >> row.lid_height_m >> row.lid_force_N))
        throw EngineError("LIGGGHTS did not write the plate's height and force", {.where = file.string()});
    row.pressure_Pa = row.lid_force_N / run.container.inner_area_m2();
}

}  // namespace

void write_protocol(const Run& run, const Snapshot& snapshot) {
    std::string text = "# Written by porepack; SI units. What is done to the bed after the pour: the steps of [protocol].\n";
    if (run.protocol.none()) return write_text(run.folder / "protocol.in", text);
    write_plate(run);
    // The bed of the pour.
    if (!snapshot.in_protocol())
        text +=
            "variable still equal ${calm}\nvariable step_number equal 0\nvariable row equal 1\ninclude require_rest.in\n"
            "include after.in\n";
    for (long i = snapshot.finished; i < static_cast<long>(run.protocol.step.size()); ++i) {
        const ProtocolStep& step = run.protocol.step[static_cast<std::size_t>(i)];
        text += fmt::format("\n# Step {}: {}\nvariable step_number equal {}\nvariable finished equal {}\nvariable rest_factor equal 1\n",
                            i + 1, name_of(step.kind), i + 1, i);
        switch (step.kind) {
            case StepKind::settle:
                text += "include step_settle.in\n";
                break;
            case StepKind::tap:
            case StepKind::vibrate:
                text += repeated_step(run, step, i == snapshot.finished ? snapshot.repeated : 0);
                break;
            case StepKind::lid:
            case StepKind::compress:
                text += plate_step(run, step);
                break;
        }
    }
    // Between taps grains may roll on; at the end they do not.
    if (run.protocol.step.back().kind == StepKind::tap) text += "variable rest_factor equal 1\ninclude rest.in\ninclude require_rest.in\n";
    write_text(run.folder / "protocol.in", text);
}

std::vector<ProtocolRow> read_protocol(const Run& run) {
    std::vector<ProtocolRow> rows;
    const double feret = maximum_feret_diameter(run.shapes);
    for (long s = 0; s <= static_cast<long>(run.protocol.step.size()); ++s) {
        const ProtocolStep& step = run.protocol.step[static_cast<std::size_t>(std::max(0L, s - 1))];
        const bool repeats = s > 0 && (step.kind == StepKind::tap || step.kind == StepKind::vibrate);
        const long parts = repeats ? parts_of(step, run.plan.time_step_s).number : 0;
        for (long n = 1; std::filesystem::exists(bed_file(run, s, n, "bodies")); ++n) {
            long time_step = 0;
            const Packing packing = packing_of(run, read_dump(bed_file(run, s, n, "bodies"), 11, &time_step));
            const BedState bed = bed_state(packing, feret);
            ProtocolRow row{.step = s,
                            .kind = step.kind,
                            .repeat = n <= parts ? n : 0,
                            .time_s = static_cast<double>(time_step) * run.plan.time_step_s,
                            .bed_height_m = bed.height_m,
                            .porosity = bed.porosity,
                            .coordination_number = clump_contacts(run, packing).coordination_number};
            if (s > 0 && n == 1 && (step.kind == StepKind::lid || step.kind == StepKind::compress)) add_plate(run, s, row);
            rows.push_back(row);
        }
        if (rows.empty() || rows.back().step != s)
            throw EngineError(fmt::format("LIGGGHTS did not write the bed after step {} of [protocol]", s),
                              {.where = bed_file(run, s, 1, "bodies").string()});
    }
    return rows;
}

}  // namespace porepack::pouring::liggghts
