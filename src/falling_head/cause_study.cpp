// Simulated falling-head tests, evaluated as in the paper: each cause alone, and all together.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "falling_head/causes.hpp"
#include "falling_head/falling_head.hpp"
#include "falling_head/paper_evaluation.hpp"

namespace porepack::falling_head {
namespace {

// The apparatus of Eq. 18: nothing but the sample.
FallingHeadConfig bare(FallingHeadConfig config) {
    config.column_inertia = false;
    config.screen_opening_m = config.screen_wire_m = config.loss_coefficient = config.column_friction_per_m = 0.0;
    config.level_offset_m = config.scale_error = config.noise_m = config.inertial_exponent = 0.0;
    config.screen_free_fraction = 1.0;
    return config;
}

class Evaluator {
public:
    Evaluator(const SampleTruth& truth, const FallingHeadConfig& config) : k_(truth.permeability_m2), assumed_(bare(config)) {
        base_ = {assumed_, {1.0 / truth.permeability_m2, 1.0 / truth.inertial_permeability_m}};
    }
    [[nodiscard]] const Scenario& base() const { return base_; }
    // k true / k by the paper's evaluation. None as well where the curve is no test: the water does not reach the end of the window.
    [[nodiscard]] std::optional<double> factor(const Scenario& scenario) const {
        try {
            const LevelCurve curve = take_window(simulate_curve(scenario.resistance, scenario.apparatus), assumed_);
            const PaperEvaluation paper = evaluate_as_paper(curve, assumed_);
            return paper.sound ? std::optional(k_ / paper.permeability_m2) : std::nullopt;
        } catch (const UserError&) {
            return std::nullopt;
        } catch (const NumericalError&) {
            return std::nullopt;
        }
    }

private:
    double k_;
    FallingHeadConfig assumed_;
    Scenario base_;
};

double at_quantile(const std::vector<double>& ascending, double share) {
    return ascending[static_cast<std::size_t>(share * static_cast<double>(ascending.size() - 1))];
}

CauseFactors alone(const UncertainCause& cause, const Evaluator& evaluator) {
    const auto at = [&](double value) {
        Scenario scenario = evaluator.base();
        cause.apply(scenario, value);
        return scenario;
    };
    const Scenario noisy = at(cause.high);
    if (noisy.apparatus.noise_m == 0.0)
        return {.cause = cause, .at_low = evaluator.factor(at(cause.low)), .at_high = evaluator.factor(noisy)};
    constexpr std::size_t curves = 400;
    std::vector<double> factors;
    for (std::size_t i = 0; i < curves; ++i) {
        Scenario scenario = noisy;
        scenario.apparatus.seed = static_cast<long>(i) + 1;
        if (const auto factor = evaluator.factor(scenario)) factors.push_back(*factor);
    }
    if (factors.size() < curves / 2) return {.cause = cause, .at_low = std::nullopt, .at_high = std::nullopt};
    std::sort(factors.begin(), factors.end());
    return {.cause = cause, .at_low = at_quantile(factors, 0.16), .at_high = at_quantile(factors, 0.84)};
}

// All causes at random. The common ones take their numbers from `shared`, the others from `own`.
Scenario draw_scenario(const std::vector<UncertainCause>& causes, const Scenario& base, double range_factor, std::mt19937_64& shared,
                       std::mt19937_64& own) {
    Scenario scenario = base;
    for (const UncertainCause& cause : causes) {
        const double centre = cause.absent ? std::clamp(*cause.absent, cause.low, cause.high) : 0.5 * (cause.low + cause.high);
        std::uniform_real_distribution<double> value(centre + range_factor * (cause.low - centre),
                                                     centre + range_factor * (cause.high - centre));
        cause.apply(scenario, std::clamp(value(cause.common ? shared : own), cause.minimum, cause.maximum));
    }
    return scenario;
}

JointFactors together(const std::string& what, const std::vector<UncertainCause>& causes, const Evaluator& evaluator, double range_factor,
                      double wanted, long draws) {
    std::vector<std::optional<double>> found(static_cast<std::size_t>(draws));
    parallel_for(found.size(), [&](std::size_t draw) {
        std::mt19937_64 random(draw + 1);
        Scenario base = evaluator.base();
        base.apparatus.seed = static_cast<long>(draw) + 1;
        found[draw] = evaluator.factor(draw_scenario(causes, base, range_factor, random, random));
    });
    JointFactors result{.what = what, .range_factor = range_factor, .draws = draws, .low = {}, .median = {}, .high = {}, .reaches = {}};
    for (const auto& factor : found)
        if (factor) result.factors.push_back(*factor);
    std::sort(result.factors.begin(), result.factors.end());
    const double total = static_cast<double>(draws);
    result.without_k = 1.0 - static_cast<double>(result.factors.size()) / total;
    if (wanted > 0.0)
        result.reaches =
            static_cast<double>(result.factors.end() - std::lower_bound(result.factors.begin(), result.factors.end(), wanted)) / total;
    if (result.factors.size() >= 40) {
        result.low = at_quantile(result.factors, 0.025);
        result.median = at_quantile(result.factors, 0.5);
        result.high = at_quantile(result.factors, 0.975);
    }
    return result;
}

}  // namespace

CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor, long draws) {
    const Evaluator evaluator(truth, config);
    const std::vector<UncertainCause> causes = uncertain_causes(truth, config);
    CauseStudy result;
    result.evaluation_alone = evaluator.factor(evaluator.base()).value_or(1.0);
    for (const UncertainCause& cause : causes) result.causes.push_back(alone(cause, evaluator));
    const auto draw = [&](const char* what, const std::vector<UncertainCause>& drawn, double range_factor) {
        result.joint.push_back(together(what, drawn, evaluator, range_factor, factor, draws));
    };
    draw("all causes", causes, 1.0);
    draw("all causes, ranges halved", causes, 0.5);
    draw("all causes, ranges doubled", causes, 2.0);
    draw("all but the first: 1/k_in is constant", {causes.begin() + 1, causes.end()}, 1.0);

    const FallingHead ideal(truth.permeability_m2, truth.inertial_permeability_m, evaluator.base().apparatus);
    const double bottom = std::min(config.window_m[0], config.window_m[1]), top = std::max(config.window_m[0], config.window_m[1]);
    const double middle = 0.5 * (bottom + top), L = config.sample_length_m;
    result.speed_top_m_per_s = ideal.speed_at(top);
    result.speed_bottom_m_per_s = ideal.speed_at(bottom);
    result.viscous_share =
        config.kinematic_viscosity_m2_per_s * ideal.speed_at(middle) / truth.permeability_m2 / (config.gravity_m_per_s2 * (middle + L) / L);
    result.darcy_alone = 1.0 / result.viscous_share;
    return result;
}

std::vector<PairedFactors> study_common_causes(const std::array<TestedSample, 2>& samples, long draws) {
    std::vector<PairedFactors> all;
    for (const double range_factor : {1.0, 0.5, 2.0}) {
        PairedFactors paired{.range_factor = range_factor, .draws = std::vector<PairedDraw>(static_cast<std::size_t>(draws))};
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const TestedSample& sample = samples[i];
            const Evaluator evaluator(sample.truth, sample.apparatus);
            const std::vector<UncertainCause> causes = uncertain_causes(sample.truth, sample.apparatus);
            parallel_for(paired.draws.size(), [&](std::size_t draw) {
                std::mt19937_64 shared(draw + 1), own((i + 1) * 1000003 + draw);
                Scenario base = evaluator.base();
                base.apparatus.seed = static_cast<long>(2 * draw + i) + 1;
                const Scenario scenario = draw_scenario(causes, base, range_factor, shared, own);
                paired.draws[draw].exponent = scenario.apparatus.inertial_exponent;
                paired.draws[draw].factors[i] = evaluator.factor(scenario);
            });
        }
        all.push_back(std::move(paired));
    }
    return all;
}

}  // namespace porepack::falling_head
