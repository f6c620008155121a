#include "permeability/causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/error.hpp"
#include "permeability/falling_head.hpp"
#include "permeability/paper_evaluation.hpp"

namespace porepack {
namespace {

// The apparatus of Eq. 18: nothing but the sample.
FallingHeadConfig bare(FallingHeadConfig config) {
    config.column_inertia = false;
    config.mesh_opening_m = config.mesh_wire_m = config.loss_coefficient = config.level_offset_m = config.noise_m = 0.0;
    config.mesh_free_share = 1.0;
    return config;
}

struct Scenario {
    FallingHeadConfig apparatus;
    Resistance resistance;
};

class Study {
public:
    Study(const SampleTruth& truth, const FallingHeadConfig& config) : truth_(truth), full_(config), bare_(bare(config)) {
        if (full_.mesh_opening_m > 0.0 && full_.mesh_wire_m == 0.0) full_.mesh_wire_m = 0.2 * full_.mesh_opening_m;
    }

    [[nodiscard]] Scenario base() const { return {bare_, sample(1.0, 1.0)}; }
    [[nodiscard]] Resistance sample(double viscous, double inertial) const {
        return {viscous / truth_.permeability_m2, inertial / truth_.inertial_permeability_m};
    }
    [[nodiscard]] const FallingHeadConfig& full() const { return full_; }

    // k true / k by the paper's evaluation, which knows the bare apparatus.
    [[nodiscard]] Cause factor(const std::string& name, const std::string& what, const Scenario& scenario) const {
        return factor(name, what, scenario, bare_);
    }
    [[nodiscard]] Cause factor(const std::string& name, const std::string& what, const Scenario& scenario,
                               const FallingHeadConfig& thought) const {
        Cause cause{.name = name, .what = what, .factor = {}};
        const PaperEvaluation paper = evaluate(scenario, thought);
        if (paper.sound) cause.factor = truth_.permeability_m2 / paper.permeability_m2;
        cause.low = cause.high = cause.factor.value_or(0.0);
        cause.note = paper.fault;
        return cause;
    }
    [[nodiscard]] PaperEvaluation evaluate(const Scenario& scenario, const FallingHeadConfig& thought) const {
        return evaluate_as_paper(take_window(simulate_curve(scenario.resistance, scenario.apparatus), thought), thought);
    }

    [[nodiscard]] Cause noise(const std::string& name, Scenario scenario, double noise_m) const {
        constexpr int trials = 400;
        scenario.apparatus.noise_m = noise_m;
        std::vector<double> factors;
        int failed = 0;
        for (int trial = 1; trial <= trials; ++trial) {
            scenario.apparatus.seed = trial;
            const PaperEvaluation paper = evaluate(scenario, bare_);
            if (paper.sound)
                factors.push_back(truth_.permeability_m2 / paper.permeability_m2);
            else
                ++failed;
        }
        Cause cause{.name = name, .what = fmt::format("{:g} mm, one standard deviation, each picture", 1e3 * noise_m), .factor = {}};
        cause.note = fmt::format("{} of {} curves give no k", failed, trials);
        if (factors.size() < 20) return cause;
        std::sort(factors.begin(), factors.end());
        const auto at = [&](double share) { return factors[static_cast<std::size_t>(share * static_cast<double>(factors.size() - 1))]; };
        cause.factor = at(0.5);
        cause.low = at(0.16);
        cause.high = at(0.84);
        return cause;
    }

    // The level offset that makes `scenario` give this factor: 1/k evaluated is nearly linear in it.
    [[nodiscard]] std::optional<double> explaining_offset(Scenario scenario, double factor_wanted) const {
        const auto excess = [&](double offset_m) -> std::optional<double> {
            scenario.apparatus.level_offset_m = offset_m;
            const Cause cause = factor("", "", scenario);
            return cause.factor ? std::optional(*cause.factor - factor_wanted) : std::nullopt;
        };
        double low = -0.03, high = 0.03;
        // A level truly higher than it is read gives k larger and larger, and then none.
        while (!excess(high) && low < high - 1e-4) high -= 1e-3;
        const auto at_low = excess(low), at_high = excess(high);
        if (!at_low || !at_high || *at_low * *at_high > 0.0) return std::nullopt;
        while (high - low > 1e-6) {
            const double middle = 0.5 * (low + high);
            const auto here = excess(middle);
            if (!here) return std::nullopt;
            (*here * *at_low > 0.0 ? low : high) = middle;
        }
        return low;
    }

private:
    SampleTruth truth_;
    FallingHeadConfig full_, bare_;
};

}  // namespace

LevelCurve simulate_curve(const Resistance& resistance, const FallingHeadConfig& config) {
    const Column column(config);
    const double bottom = 0.9 * std::min(config.window_m[0], config.window_m[1]);
    const double slowest = column.steady_speed(resistance, bottom);
    if (!(slowest > 0.0))
        throw UserError("the level does not fall to the window's end",
                        {.mend = "check window_m, level_offset_m and sample_length_m (metres)"});
    // Long enough: at the slowest speed all the way, and as long again to get moving.
    const double longest = 2.0 * (config.start_level_m - bottom) / slowest + 2.0;
    if (longest * config.frames_per_s > 5e7)
        throw UserError(fmt::format("the test takes up to {:.3g} s: too many pictures", longest),
                        {.mend = "lower frames_per_s, or check k and k_in: SI units"});
    LevelCurve curve{.name = "simulated", .packing = {}, .time_s = {}, .level_m = {}};
    const auto frames = static_cast<std::size_t>(longest * config.frames_per_s) + 2;
    curve.time_s.reserve(frames);
    for (std::size_t i = 0; i < frames; ++i) curve.time_s.push_back(static_cast<double>(i) / config.frames_per_s);
    curve.level_m = column.levels(resistance, 0.0, config.start_level_m, 0.0, curve.time_s);
    const auto past = std::find_if(curve.level_m.begin(), curve.level_m.end(), [&](double level) { return level < bottom; });
    curve.level_m.erase(past, curve.level_m.end());
    curve.time_s.resize(curve.level_m.size());
    if (config.noise_m > 0.0) {
        std::mt19937_64 random(static_cast<std::uint64_t>(config.seed));
        std::normal_distribution<double> noise(0.0, config.noise_m);
        for (double& level : curve.level_m) level += noise(random);
    }
    return curve;
}

ProfileFactors profile_factors(const std::vector<double>& layers, double central) {
    ProfileFactors factors{0.0, 0.0};
    const auto cube = [](double e) { return e * e * e; };
    for (const double e : layers) {
        factors.viscous += (1.0 - e) * (1.0 - e) / cube(e);
        factors.inertial += (1.0 - e) / cube(e);
    }
    const auto count = static_cast<double>(layers.size());
    factors.viscous *= cube(central) / ((1.0 - central) * (1.0 - central)) / count;
    factors.inertial *= cube(central) / (1.0 - central) / count;
    return factors;
}

CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor) {
    const Study study(truth, config);
    const Scenario base = study.base();
    const FallingHeadConfig& full = study.full();
    CauseStudy result;
    auto& list = result.causes;
    list.push_back(study.factor("evaluation itself", "Eq. 18 obeyed exactly: what the quadratic does", base));
    const auto with = [&](const std::string& name, const std::string& what, const auto& change) {
        Scenario changed = base;
        change(changed);
        list.push_back(study.factor(name, what, changed));
    };
    // The water in the sample moves like a column of m sample lengths, which is at least 1/porosity: straight pores.
    const double least_m = 1.0 / truth.porosity;
    for (const double m : {std::max(least_m, sample_inertia(full)), least_m})
        with("inertia of the water",
             fmt::format("it starts at rest and has to be slowed down; m = {:.2f}{}", m, m == least_m ? ", the least" : ""),
             [m](Scenario& s) {
                 s.apparatus.column_inertia = true;
                 s.apparatus.sample_inertia = m;
             });
    if (full.mesh_opening_m > 0.0) {
        const auto meshes = [&](long below, long above, double wire) {
            return [&full, below, above, wire](Scenario& s) {
                s.apparatus.mesh_opening_m = full.mesh_opening_m;
                s.apparatus.mesh_wire_m = wire;
                s.apparatus.meshes_below = below;
                s.apparatus.meshes_above = above;
            };
        };
        for (const double wire : {0.5 * full.mesh_wire_m, full.mesh_wire_m}) {
            const std::string size = fmt::format("wires of {:g} mm", 1e3 * wire);
            with("mesh below", size, meshes(1, 0, wire));
            if (full.meshes_below > 1) with("second mesh below", size + ", both together", meshes(full.meshes_below, 0, wire));
            if (full.meshes_above > 0) with("mesh on top", size, meshes(0, full.meshes_above, wire));
        }
        with("mesh below, half covered", "grains cover half of the openings", [&](Scenario& s) {
            meshes(full.meshes_below, 0, full.mesh_wire_m)(s);
            s.apparatus.mesh_free_share = 0.5;
        });
    }
    if (full.loss_coefficient > 0.0)
        with("inlet and outlet", fmt::format("they take {:g} v^2/2", full.loss_coefficient),
             [&](Scenario& s) { s.apparatus.loss_coefficient = full.loss_coefficient; });
    with("structure at the ends", "by the packing's porosity profile",
         [&](Scenario& s) { s.resistance = study.sample(truth.ends_viscous, truth.ends_inertial); });
    with("grains aligned at the mesh", "lowest layer, one grain high, 0.1 less porous",
         [&](Scenario& s) { s.resistance = study.sample(truth.aligned_viscous, truth.aligned_inertial); });
    for (const double offset : {-2e-3, 2e-3})
        with("level offset", fmt::format("true level {:+g} mm", 1e3 * offset), [&](Scenario& s) { s.apparatus.level_offset_m = offset; });
    // Where the scale hangs decides: with levels read from the sample's top the head is wrong too, on the tube only the length.
    for (const bool from_top : {true, false})
        for (const double longer : {-5e-3, 5e-3})
            with("sample height",
                 fmt::format("true height {:+g} mm, level read {}", 1e3 * longer, from_top ? "from its top" : "on a fixed scale"),
                 [&](Scenario& s) {
                     s.apparatus.sample_length_m += longer;
                     if (!from_top) s.apparatus.level_offset_m -= longer;
                 });
    list.push_back(study.noise("noise of the pictures", base, 1e-3));
    for (const auto& window : {std::vector<double>{0.1, 0.7}, std::vector<double>{0.7, 1.3}}) {
        FallingHeadConfig thought = base.apparatus;
        thought.window_m = window;
        list.push_back(study.factor(
            "window", fmt::format("{:g} to {:g} m instead of {:g} to {:g} m", window[0], window[1], config.window_m[0], config.window_m[1]),
            base, thought));
    }
    with("turbulent coefficients", "1/k x 1.24, 1/k_in x 0.84 (Fand et al. 1987)",
         [&](Scenario& s) { s.resistance = study.sample(1.24, 0.84); });
    {
        // Darcy's law alone at the middle of the window.
        const FallingHead darcy_free(truth.permeability_m2, truth.inertial_permeability_m, base.apparatus);
        const double middle = 0.5 * (config.window_m[0] + config.window_m[1]), L = config.sample_length_m;
        const double v = darcy_free.speed_at(middle), head = config.gravity_m_per_s2 * (middle + L) / L;
        result.viscous_share = config.kinematic_viscosity_m2_per_s * v / truth.permeability_m2 / head;
        const double found = 1.0 / result.viscous_share;
        list.push_back(
            {.name = "Darcy's law alone", .what = "no inertial term in the evaluation", .factor = found, .low = found, .high = found});
    }
    Scenario all = base;
    all.apparatus.column_inertia = true;
    all.apparatus.mesh_opening_m = full.mesh_opening_m;
    all.apparatus.mesh_wire_m = full.mesh_wire_m;
    all.apparatus.mesh_free_share = full.mesh_free_share;
    all.apparatus.loss_coefficient = full.loss_coefficient;
    all.resistance = study.sample(truth.ends_viscous, truth.ends_inertial);
    const auto together = [&](const std::string& name, const std::string& what, const auto& change) {
        Scenario changed = all;
        change(changed);
        result.together.push_back(study.factor(name, what, changed));
    };
    together("together", "inertia of the water, all meshes, structure at the ends", [](Scenario&) {});
    for (const double offset : {-2e-3, 2e-3})
        together("together, with an offset", fmt::format("the same, true level {:+g} mm", 1e3 * offset),
                 [&](Scenario& s) { s.apparatus.level_offset_m = offset; });
    const auto most = [&](Scenario& s) {
        s.apparatus.level_offset_m = -2e-3;
        s.apparatus.mesh_free_share = 0.5;
        // The aligned layer is one of those at the ends: both add.
        s.resistance = study.sample(1.24 * (truth.ends_viscous + truth.aligned_viscous - 1.0),
                                    0.84 * (truth.ends_inertial + truth.aligned_inertial - 1.0));
    };
    together("together, most", "the same, level -2 mm, meshes half covered, aligned, turbulent", most);
    together("together, most, height too", "and sample -5 mm, level read from its top", [&](Scenario& s) {
        most(s);
        s.apparatus.sample_length_m -= 5e-3;
    });
    result.together.push_back(study.noise("together, with noise", all, 1e-3));
    if (factor > 0.0) {
        result.explaining_offset_m = study.explaining_offset(base, factor);
        result.explaining_offset_with_all_m = study.explaining_offset(all, factor);
    }
    return result;
}

}  // namespace porepack
