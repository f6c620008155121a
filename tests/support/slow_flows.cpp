#include "support/slow_flows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "lbm/sequence.hpp"
#include "packing/packing.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"
#include "support/known_flows.hpp"
#include "vessels/config.hpp"

namespace porepack::test {
using namespace lbm;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
namespace {

class Generator {
public:
    explicit Generator(unsigned seed) : random_(seed) {}

    SlowFlow next(int kind) {
        switch (kind) {
            case 0:
                return gaps();
            case 1:
                return long_bed();
            case 2:
                return dead_ends();
            case 3:
                return spheres_in_contact();
            default:
                return channels();
        }
    }

private:
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_()) / 4294967296.0; }
    double log_uniform(double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); }
    bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
    int between(int low, int high) { return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1)); }

    static Packing box(const Vec3& size, bool periodic_z) {
        return {.container = vessels::make_box(size, {true, true, periodic_z}), .shapes = {}, .bodies = {}};
    }
    static void add(Packing& packing, const Vec3& at, const Vec3& half_axis, double radius) {
        packing.shapes.push_back({.id = "grain " + std::to_string(packing.shapes.size()), .capsules = {{-half_axis, half_axis, radius}}});
        packing.bodies.push_back({.shape = packing.shapes.size() - 1, .position_m = at});
    }
    /// A row of overlapping rods along y from (x0, z0) to (x1, z1).
    static void wall(Packing& packing, double y, double x0, double z0, double x1, double z1, double radius) {
        const int rods = 1 + static_cast<int>(std::ceil(std::hypot(x1 - x0, z1 - z0) / radius));
        for (int i = 0; i < rods; ++i) {
            const double part = rods > 1 ? static_cast<double>(i) / (rods - 1) : 0.0;
            add(packing, {x0 + part * (x1 - x0), 0.5 * y, z0 + part * (z1 - z0)}, Vec3(0, y, 0), radius);
        }
    }
    SlowFlow flow(const std::string& name, Packing packing, int cells) {
        const double height = packing.container.high().z();
        return {.name = name,
                .space = pore_space_of(std::move(packing)).with_section({0.0, height}),
                .voxel_size_m = 1.0 / cells,
                .relaxation_time = 0.5 + log_uniform(0.1, 1.5),
                .precision = chance(0.5) ? Precision::single_precision : Precision::double_precision,
                .from_coarser_grid = chance(0.5)};
    }

    // Layers of one rod per width of the box: all flow passes the gaps between them.
    SlowFlow gaps() {
        const int cells = between(14, 28), layers = between(1, 3);
        const double thickness = 4.0 / cells, length = std::round(uniform(3.0, 12.0));
        Packing packing = box({1.0, thickness, length}, chance(0.4));
        for (int layer = 0; layer < layers; ++layer) {
            const double gap = std::max(2.2 / cells, log_uniform(0.05, 0.5)), z = length * (layer + uniform(0.3, 0.7)) / layers;
            add(packing, {uniform(0.0, 1.0), 0.5 * thickness, z}, Vec3(0, thickness, 0), 0.5 * (1.0 - gap));
        }
        return flow("gaps", std::move(packing), cells);
    }

    SlowFlow long_bed() {
        const int cells = between(12, 18);
        const double length = std::round(uniform(3.0, 8.0)), diameter = uniform(0.45, 0.7);
        Packing packing = box({1.0, 1.0, length}, chance(0.2));
        if (chance(0.3)) packing.container = parse_container("cylinder:1," + std::to_string(length));
        const double spheres = uniform(0.25, 0.9) * length / (std::numbers::pi / 6.0 * diameter * diameter * diameter);
        const double low = packing.container.low().x();
        for (int i = 0; i < static_cast<int>(spheres); ++i) {
            const double x = low + uniform(0.0, 1.0), y = low + uniform(0.0, 1.0), z = uniform(0.0, length);
            add(packing, {x, y, z}, Vec3::Zero(), 0.5 * diameter);
        }
        const bool periodic = packing.container.periodic()[2];
        SlowFlow bed = flow("long bed", std::move(packing), cells);
        if (!periodic && chance(0.5))
            bed.space =
                bed.space.with_section({std::round(0.4 * length), std::round(0.7 * length)}).with_ends(Ends::in_situ, uniform(0.5, 2.0));
        return bed;
    }

    // A channel along z, and beside it a pocket behind a wall with one opening.
    SlowFlow dead_ends() {
        const int cells = between(18, 30);
        const double thickness = 4.0 / cells, length = std::round(uniform(1.0, 4.0)), radius = 1.5 / cells, x = uniform(0.2, 0.6);
        const double opening = uniform(3.0 / cells, 0.5), at = uniform(0.2, 0.8) * (length - opening);
        Packing packing = box({1.0, thickness, length}, chance(0.5));
        wall(packing, thickness, 0.0, 0.0, 0.0, length, radius);
        wall(packing, thickness, x, at + opening, x, length + at, radius);
        wall(packing, thickness, x, 0.0, 1.0, 0.0, radius);
        for (Body& body : packing.bodies) body.position_m.z() -= body.position_m.z() > length ? length : 0.0;
        return flow("dead end", std::move(packing), cells);
    }

    SlowFlow spheres_in_contact() {
        const int cells = between(16, 30), centres = between(0, 2);
        Packing packing = box(Vec3::Ones(), true);
        const std::vector<std::vector<Vec3>> arrays = {simple_cubic(), body_centred(), face_centred()};
        const double touching = std::array{0.5, 0.25 * std::numbers::sqrt3, 0.25 * std::numbers::sqrt2}[static_cast<std::size_t>(centres)];
        const Vec3 shift(uniform(0.0, 1.0), uniform(0.0, 1.0), uniform(0.0, 1.0));
        const double radius = touching * uniform(0.9, 1.04);
        for (Vec3 at : arrays[static_cast<std::size_t>(centres)]) {
            at += shift;
            for (int a = 0; a < 3; ++a) at[a] -= std::floor(at[a]);
            add(packing, at, Vec3::Zero(), radius);
        }
        return flow("spheres in contact", std::move(packing), cells);
    }

    // Rods along z: channels of different widths, each with its own time to become steady.
    SlowFlow channels() {
        const int cells = between(20, 36), rods = between(2, 7);
        Packing packing = box({1.0, 1.0, 4.0 / cells}, true);
        for (int i = 0; i < rods; ++i) {
            const double x = uniform(0.0, 1.0), y = uniform(0.0, 1.0);
            add(packing, {x, y, 0.0}, Vec3(0, 0, 1), uniform(0.08, 0.3));
        }
        return flow("channels", std::move(packing), cells);
    }

    std::mt19937 random_;
};

// The flow at rest, or started from the flow on the coarser grid.
struct Prepared {
    Domain domain;
    FlowSection section;
    Scheme scheme;
    std::unique_ptr<Flow> flow;

    Prepared(const SlowFlow& slow, double voxel_size_m) {
        const PhaseImage image = slow.space.voxelise_at(voxel_size_m);
        const std::optional<FlowWalls> walls = slow.space.walls();
        const Drive drive = choose_drive(slow.space.container, Axis::z);
        domain = build_domain(image, drive, &*walls);
        section = flow_section(image.grid, slow.space.container, slow.space.section, drive);
        scheme = scheme_of({.relaxation_time = slow.relaxation_time}, true, drive);
        flow = make_flow(slow.precision == Precision::single_precision ? Kernel::cpu_single : Kernel::cpu_double, domain, scheme);
    }
};

}  // namespace

std::optional<SlowRun::Stop> SlowRun::stop(double tolerance) const {
    for (std::size_t i = 1; i < history.size(); ++i) {
        const ConvergencePoint &last = history[i - 1], &now = history[i];
        if (std::max(last.iteration_error, now.iteration_error) >= tolerance || std::min(last.permeability_lu, now.permeability_lu) <= 0.0)
            continue;
        return Stop{now.step, now.iteration_error + drift_per_imbalance * now.flow_imbalance,
                    std::abs(steady_permeability_lu / now.permeability_lu - 1.0)};
    }
    return std::nullopt;
}

SlowRun run_until_constant(const SlowFlow& slow, long max_steps) {
    Prepared prepared(slow, slow.voxel_size_m);
    if (slow.from_coarser_grid) {
        Prepared coarse(slow, 1.5 * slow.voxel_size_m);
        (void)run_to_steady(*coarse.flow, coarse.domain, coarse.scheme, coarse.section, {.tolerance = 1e-3});
        const FlowField field = take_field(*coarse.flow, std::move(coarse.domain), coarse.scheme);
        start_from(*prepared.flow, prepared.domain, prepared.scheme, field);
    }
    SlowRun result{.nodes = prepared.domain.nodes()};
    StokesRun run;
    const double small = slow.precision == Precision::single_precision ? 1e-5 : 1e-7;
    try {
        for (long steps = std::min(2000L, max_steps); !result.constant && run.steps < max_steps;
             steps = std::min(max_steps, steps * 3 / 2 / 40 * 40)) {
            const double before = run.permeability_lu;
            run = run_to_steady(*prepared.flow, prepared.domain, prepared.scheme, prepared.section, {.tolerance = 0.0, .max_steps = steps},
                                std::move(run));
            result.constant = before > 0.0 && std::abs(run.permeability_lu / before - 1.0) < small;
        }
    } catch (const NumericalError&) {
        return result;  // diverged
    }
    result.steps = run.steps;
    result.history = std::move(run.history);
    // Single precision: the mean of the last tenth, against rounding noise.
    const std::size_t n = result.history.size(), from = slow.precision == Precision::single_precision ? n - n / 10 - 1 : n - 1;
    for (std::size_t i = from; i < n; ++i)
        result.steady_permeability_lu += result.history[i].permeability_lu / static_cast<double>(n - from);
    return result;
}

std::vector<SlowFlow> random_slow_flows(unsigned seed, int count) {
    Generator generator(seed);
    std::vector<SlowFlow> flows;
    for (int i = 0; i < count; ++i) flows.push_back(generator.next(i % 5));
    return flows;
}

}  // namespace porepack::test
