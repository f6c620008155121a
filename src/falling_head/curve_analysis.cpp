#include "falling_head/curve_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"

namespace porepack::falling_head {
namespace {

void require_different(const std::vector<LevelCurve>& curves) {
    for (std::size_t c = 1; c < curves.size(); ++c)
        for (std::size_t before = 0; before < c; ++before)
            if (curves[before].time_s == curves[c].time_s && curves[before].level_m == curves[c].level_m)
                throw UserError("the same levels twice: " + curves[before].name + " and " + curves[c].name,
                                {.fix = "remove one of them: it would count as a second test"});
}

// A fit whose residuals exceed the noise of the levels is not reliable, whatever its interval.
bool misses(const FallingHeadFit& fit, const std::string& name, std::vector<std::string>& warnings) {
    if (fit.noise_unknown())
        warnings.push_back(
            fmt::format("{}: the noise has a part nearly as slow as the test (probability {:.0f} %), whose size this test cannot tell: the "
                        "intervals are {:.2g} times as wide as with independent frames, {:.2g} times if the part is certain; record longer "
                        "tests or more runs, or remove the slow part (drift, sloshing)",
                        name, 100.0 * fit.slow_probability, fit.widening, fit.widening * fit.slow_widening));
    else if (fit.noise_correlated() && fit.widening > 1.5)
        warnings.push_back(
            fmt::format("{}: the residuals are correlated (neighbouring frames: {:.2f}), so the intervals are {:.2g} times as wide as with "
                        "independent frames; either the frames' noise is correlated, or the equation lacks something: see analysis.svg",
                        name, fit.residual_correlation, fit.widening));
    if (fit.residual_m <= 3.0 * std::max(fit.noise_m, 1e-6)) return false;
    warnings.push_back(fmt::format("{}: the equation misses the levels by {:.2g} mm, their noise is {:.2g} mm: see analysis.svg", name,
                                   1e3 * fit.residual_m, 1e3 * fit.noise_m));
    return true;
}

Scatter scatter_of(const FallingHeadAnalysis& analysis, FittedValue FallingHeadFit::*member) {
    const auto packings = static_cast<double>(analysis.packings.size());
    Scatter scatter;
    double within = 0.0;
    std::vector<double> means;
    for (const PackingAnalysis& packing : analysis.packings) {
        double mean = 0.0;
        const auto value = [&](std::size_t c) { return (analysis.curves[c].fit.*member).value; };
        for (const std::size_t c : packing.curves) mean += value(c) / static_cast<double>(packing.curves.size());
        for (const std::size_t c : packing.curves) within += std::pow(value(c) - mean, 2);
        means.push_back(mean);
        scatter.mean += mean / packings;
    }
    double between = 0.0;
    for (const double mean : means) between += std::pow(mean - scatter.mean, 2);
    if (const std::size_t freedom = analysis.curves.size() - means.size(); freedom > 0)
        scatter.within_packings = std::sqrt(within / static_cast<double>(freedom));
    if (means.size() > 1) scatter.between_packings = std::sqrt(between / static_cast<double>(means.size() - 1));
    return scatter;
}

void summarise_paper(FallingHeadAnalysis& analysis) {
    double sum = 0.0, squares = 0.0;
    for (const CurveAnalysis& curve : analysis.curves) {
        if (!curve.as_paper.sound) continue;
        const double k = curve.as_paper.permeability_m2;
        sum += k;
        squares += k * k;
        ++analysis.curves_with_paper_k;
    }
    const auto n = static_cast<double>(analysis.curves_with_paper_k);
    if (n > 0.0) analysis.paper_mean_m2 = sum / n;
    if (n > 1.0) analysis.paper_deviation_m2 = std::sqrt(std::max(0.0, squares - sum * sum / n) / (n - 1.0));
}

}  // namespace

FallingHeadAnalysis analyse_curves(const std::vector<LevelCurve>& curves, const FallingHeadConfig& config) {
    require_different(curves);
    FallingHeadAnalysis analysis;
    std::map<std::string, PackingAnalysis> packings;
    for (const LevelCurve& curve : curves) {
        analysis.warnings.insert(analysis.warnings.end(), curve.warnings.begin(), curve.warnings.end());
        CurveAnalysis one{
            .curve = curve, .as_paper = evaluate_as_paper(curve, config), .fit = fit_falling_head(std::span(&curve, 1), config)};
        one.doubtful = misses(one.fit, curve.name, analysis.warnings) || curve.doubtful;
        PackingAnalysis& packing = packings[curve.packing];
        packing.packing = curve.packing;
        packing.curves.push_back(analysis.curves.size());
        packing.doubtful = packing.doubtful || one.doubtful;
        analysis.curves.push_back(std::move(one));
    }
    for (auto& [name, packing] : packings) {
        packing.fit = analysis.curves[packing.curves.front()].fit;
        if (packing.curves.size() > 1) {
            std::vector<LevelCurve> group;
            for (const std::size_t c : packing.curves) group.push_back(analysis.curves[c].curve);
            packing.fit = fit_falling_head(group, config);
            packing.doubtful = misses(packing.fit, "all curves of the packing " + name, analysis.warnings) || packing.doubtful;
        }
        analysis.packings.push_back(packing);
    }
    analysis.inverse_permeability_per_m2 = scatter_of(analysis, &FallingHeadFit::inverse_permeability_per_m2);
    analysis.inverse_inertial_permeability_per_m = scatter_of(analysis, &FallingHeadFit::inverse_inertial_permeability_per_m);
    summarise_paper(analysis);
    return analysis;
}

}  // namespace porepack::falling_head
