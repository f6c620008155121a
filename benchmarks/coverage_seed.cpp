// Coverage of every kind of interval on cases of known answer that a seed draws.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/binomial_interval.hpp"
#include "benchmarks/gray_run.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/least_squares.hpp"
#include "falling_head/simulated_noise.hpp"
#include "lbm/permeability.hpp"
#include "support/turned_arrays.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Case {
    std::string name = {};
    double exact = 0.0, value = 0.0;
    std::optional<Interval> interval = {};
    std::string no_interval_because = {};

    [[nodiscard]] double error() const { return value / exact - 1.0; }
    [[nodiscard]] double half_width() const { return 0.5 * (interval->high - interval->low) / exact; }
    /// Relative distance of the exact answer from the interval; 0 inside.
    [[nodiscard]] double missed_by() const { return std::max({0.0, interval->low / exact - 1.0, 1.0 - interval->high / exact}); }
};

double between(std::mt19937& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}
double log_between(std::mt19937& random, double low, double high) {
    return std::exp(between(random, std::log(low), std::log(high)));
}
int one_of(std::mt19937& random, int count) {
    return std::uniform_int_distribution<int>(0, count - 1)(random);
}

KnownFlow random_flow(std::mt19937& random, double height = 0.25) {
    const std::vector<KnownFlow> flows = random_known_flows(static_cast<unsigned>(random()), height);
    return flows[static_cast<std::size_t>(one_of(random, static_cast<int>(flows.size())))];
}

double solid_fraction(const KnownFlow& flow) {
    return 1.0 - flow.space().porosity().value;
}

// For a given voxel size: the box is high enough for coarse grids as well. The flow through dilute arrays becomes steady so slowly that one
// of them takes minutes.
KnownFlow random_flow_not_dilute(std::mt19937& random) {
    while (true)
        if (KnownFlow flow = random_flow(random, 1.0); solid_fraction(flow) > 0.09) return flow;
}

// As in the gray benchmark, not cylinders of 0.7: their gaps are narrower than a voxel.
KnownFlow random_array_to_scan(std::mt19937& random) {
    while (true)
        if (KnownFlow flow = random_flow_not_dilute(random); !flow.packing.bodies.empty() && solid_fraction(flow) < 0.69) return flow;
}

void set_flow(Case& c, const KnownFlow& flow, const LbmResult& result) {
    c.exact = flow.permeability_m2;
    c.value = result.permeability_m2;
    c.interval = result.interval_m2();
}

// Each draws a case and names it before it computes it.

void exact_walls(std::mt19937& random, Case& c) {
    const KnownFlow flow = random_flow(random);
    c.name = flow.name;
    set_flow(c, flow, lbm_permeability(flow.space(), 0.1, {.direction = flow.direction, .tolerance = 0.02}));
}

void gray_walls(std::mt19937& random, Case& c) {
    const KnownFlow flow = random_array_to_scan(random);
    const double voxels = between(random, 8.0, 20.0), blur = between(random, 0.5, 1.5), noise = between(random, 0.0, 0.06);
    c.name = fmt::format("{}, {:.1f} voxels per diameter, blur {:.2f}, noise {:.3f}", flow.name, voxels, blur, noise);
    set_flow(c, flow, gray_run(flow, voxels, {blur, noise, static_cast<unsigned>(random())}).result);
}

void bounce_back_walls(std::mt19937& random, Case& c) {
    const KnownFlow flow = random_flow_not_dilute(random);
    const double voxels = between(random, 8.0, 20.0);
    c.name = fmt::format("{}, {:.1f} voxels per diameter", flow.name, voxels);
    set_flow(c, flow, lbm_permeability(flow.space(), flow.diameter_m / voxels, {.direction = flow.direction, .walls = Walls::bounce_back}));
}

void tortuosity_factor(std::mt19937& random, Case& c) {
    using Grain = TurnedArray::Grain;
    using Turn = TurnedArray::Turn;
    const auto grain = static_cast<Grain>(one_of(random, 3));
    const int chance = one_of(random, 10);
    const TurnedArray array = random_array(grain, chance == 0 ? Turn::about_z : chance == 1 ? Turn::about_odd_axis : Turn::none, random);
    const auto axis = static_cast<Axis>(one_of(random, 3));
    const double cells = between(random, 8.0, 16.0);
    c.name = fmt::format("{} {:.3f}{}, along {}, {:.1f} cells per diameter",
                         grain == Grain::rod            ? "rods"
                         : grain == Grain::simple_cubic ? "simple cubic spheres"
                                                        : "body-centred spheres",
                         array.solid_fraction, array.turn == Turn::none ? "" : ", turned", name_of(axis), cells);
    const DiffusiveEstimate found = diffusive_tortuosity(array.space(), array.diameter() / cells, axis);
    c.exact = array.exact(axis);
    c.value = found.value();
    c.interval = found.interval();
    c.no_interval_because = found.no_limit_because;
}

// White noise, one part whose correlation time is between a frame and 100 of them (a test of the paper's bed has about 130), or two such
// parts of which one is at least ten times as slow.
Noise random_noise(std::mt19937& random, std::string& name) {
    const double deviation_m = log_between(random, 0.1e-3, 2e-3);
    const int scales = one_of(random, 3);
    const double fast = scales == 2 ? log_between(random, 1.0, 10.0) : log_between(random, 1.0, 100.0),
                 slow = log_between(random, 10.0 * fast, 100.0);
    const auto part = [](double share, double frames) { return AutoregressivePart{share, std::exp(-1.0 / frames)}; };
    const double share = between(random, 0.1, scales == 2 ? 0.5 : 1.0);
    name = fmt::format("noise of {:.1f} mm, ", 1e3 * deviation_m);
    if (scales == 0) {
        name += "white";
        return correlated_noise(deviation_m, {});
    }
    name += fmt::format("{:.0f} % over {:.1f} frames", 100.0 * share, fast);
    if (scales == 1) return correlated_noise(deviation_m, {part(share, fast)});
    const double slow_share = between(random, 0.1, 0.5);
    name += fmt::format(", {:.0f} % over {:.0f} frames", 100.0 * slow_share, slow);
    return correlated_noise(deviation_m, {part(share, fast), part(slow_share, slow)});
}

void falling_head_test(std::mt19937& random, Case& c) {
    const FallingHeadConfig config;
    const double k_m2 = log_between(random, 3e-7, 2e-6), k_in_m = log_between(random, 2e-3, 8e-3);
    const Noise noise = random_noise(random, c.name);
    c.name = fmt::format("k {:.2e} m2, k_in {:.2e} m, {}", k_m2, k_in_m, c.name);
    NoiseSource source(random());
    const LevelCurve exact = simulate_curve({1.0 / k_m2, 1.0 / k_in_m}, config);
    const FittedValue found = fit_falling_head(noisy_runs(exact, noise, 3, source, config), config).inverse_permeability_per_m2;
    c.exact = 1.0 / k_m2;
    c.value = found.value;
    c.interval = found.interval;
}

struct Kind {
    const char* name;
    void (*compute)(std::mt19937&, Case&);
};
constexpr Kind kinds[] = {{"k, exact walls, tolerance 0.02", exact_walls},
                          {"k, walls from gray values", gray_walls},
                          {"k, bounce-back walls", bounce_back_walls},
                          {"tortuosity factor", tortuosity_factor},
                          {"1/k of falling-head tests", falling_head_test}};

Case computed(const Kind& kind, std::mt19937& random) {
    Case c;
    try {
        kind.compute(random, c);
        if (!c.interval && c.no_interval_because.empty()) c.no_interval_because = "the result has none";
    } catch (const Error& error) {
        if (error.code() == ExitCode::machine) throw;  // memory, or interrupted
        c.no_interval_because = error.what();
    }
    if (c.interval)
        log_info("{}: {}: error {:+.2f} %, half width {:.2f} %{}", kind.name, c.name, 100.0 * c.error(), 100.0 * c.half_width(),
                 c.missed_by() > 0.0 ? ", missed" : "");
    else
        log_warning(fmt::format("{}: {}: {}", kind.name, c.name, c.no_interval_because));
    return c;
}

// Each case has a generator of its own, so that a smaller number of cases is the beginning of a larger one.
Json coverage_of(const Kind& kind, unsigned seed, int count) {
    const std::clock_t start = std::clock();
    std::vector<double> errors, half_widths;
    Json missed = Json::array(), without = Json::array();
    for (int i = 0; i < count; ++i) {
        std::seed_seq words{seed, static_cast<unsigned>(&kind - kinds), static_cast<unsigned>(i)};
        std::mt19937 random(words);
        const Case c = computed(kind, random);
        if (!c.interval) {
            without.push_back({{"case", c.name}, {"because", c.no_interval_because}});
            continue;
        }
        errors.push_back(std::abs(c.error()));
        half_widths.push_back(c.half_width());
        if (c.missed_by() > 0.0)
            missed.push_back({{"case", c.name}, {"error", c.error()}, {"half_width", c.half_width()}, {"missed_by", c.missed_by()}});
    }
    Json json{{"kind", kind.name}, {"cases", count}, {"without_interval", without.size()}};
    const auto judged = static_cast<long>(errors.size()), held = judged - static_cast<long>(missed.size());
    json["held"] = held;
    json["missed"] = missed.size();
    if (judged > 0) {
        const Interval interval = binomial_interval(held, judged);
        const double error = median(errors), half_width = median(half_widths);
        json.update({{"probability_interval", {interval.low, interval.high}},
                     {"median_error", error},
                     {"median_half_width", half_width},
                     {"ratio", half_width / error}});
    }
    json.update({{"cpu_seconds", static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC},
                 {"misses", missed},
                 {"cases_without_interval", without}});
    return json;
}

}  // namespace

Json coverage_seed_benchmark(unsigned seed, int count) {
    Json list = Json::array();
    for (const Kind& kind : kinds) list.push_back(coverage_of(kind, seed, count));
    return {{"seed", seed}, {"kinds", list}};
}

}  // namespace porepack::benchmarks
