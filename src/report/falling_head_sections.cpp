// Flow with inertia, the falling-head test, and why a measured k may differ from the computed one.
#include <algorithm>
#include <optional>
#include <string>

#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace {

// "n = 0.14 (0.05 to 0.2)"
std::string parameter_text(const char* name, const permeability::LawParameter& parameter) {
    return fmt::format("{} = {} ({} to {})", name, number_text(parameter.value, "{:.3g}"), number_text(parameter.interval.low, "{:.3g}"),
                       number_text(parameter.interval.high, "{:.3g}"));
}

// What the flows show of weak and strong inertia.
void add_laws(ReportSection& section, const std::string& solver, const permeability::InertialLaws& laws) {
    const auto add = [&](const std::optional<permeability::FittedLaw>& law, const std::string& name, const char* exponent) {
        if (!law) return;
        section.rows.push_back(
            {solver,
             fmt::format("{}, Re {} to {}", name, number_text(law->reynolds_from, "{:.3g}"), number_text(law->reynolds_to, "{:.3g}")),
             law->exponent ? parameter_text(exponent, *law->exponent) : parameter_text("b", law->coefficient),
             "misfit over error " + number_text(law->misfit, "{:.2g}")});
    };
    add(laws.weak, "k/k apparent - 1 = a Re²", "exponent if fitted");
    add(laws.forchheimer, "k/k apparent - 1 = c + b Re", "");
    add(laws.power, "k/k apparent - 1 = c + b Re^(1-n)", "n");
}

template <typename Flows>
void add_flows(ReportSection& section, const std::string& solver, const Flows& flows, const permeability::ForchheimerFit& fit,
               const std::optional<std::string>& stopped_by, const permeability::InertialLaws& laws) {
    for (const auto& flow : flows)
        section.rows.push_back({solver, number_text(flow.reynolds, "{:.3g}"), number_text(flow.permeability_m2),
                                fmt::format("{:.4f}", flow.permeability_m2 / fit.permeability_m2)});
    section.rows.push_back(
        {solver, "k_in = " + number_text(fit.inertial_permeability_m) + " m",
         fmt::format("{} to {} m", number_text(fit.inertial_interval_m.low), number_text(fit.inertial_interval_m.high)),
         "onset (5 %) at Re " + number_text(fit.onset_reynolds, "{:.2g}") + (stopped_by ? "; then " + stopped_by->substr(0, 60) : "")});
    add_laws(section, solver, laws);
}

}  // namespace

ReportSection inertia_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Flow with inertia"};
    section.header = {"solver", "Re = U d/nu", "k apparent (m²)", "k apparent / k"};
    if (!input.results.forchheimer) return section;
    const results::Forchheimer& found = *input.results.forchheimer;
    add_flows(section, "lattice Boltzmann", found.lbm.grids.back().flows, found.lbm.fit, found.lbm.stopped_by, found.lbm.laws);
    if (const auto& foam = found.openfoam; foam && foam->fit)
        add_flows(section, "OpenFOAM", foam->flows, *foam->fit, foam->stopped_by, foam->laws.value_or(permeability::InertialLaws{}));
    section.rows.push_back({"Ergun", "k_in = " + number_text(found.ergun_inertial_permeability_m) + " m", "", ""});
    section.intro = fmt::format("1/k_apparent = 1/k + (U/nu)/k_in (Forchheimer); d = {} m. Beyond the largest steady Re k_in is {}.",
                                number_text(found.length_m), found.beyond_largest_reynolds);
    if (take_file(input, "forchheimer/forchheimer.svg", folder))
        section.pictures.emplace_back("forchheimer.svg", "Apparent permeability against the Reynolds number.");
    return section;
}

ReportSection falling_head_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Falling head"};
    section.header = {"water level above the sample (m)", "passed after, Eq. 18 (s)", "with the inertia of the water and the screens (s)"};
    if (!input.results.falling_head) return section;
    const results::FallingHead& test = *input.results.falling_head;
    for (std::size_t i = 0; i < test.levels_m.size(); ++i)
        section.rows.push_back({number_text(test.levels_m[i]), number_text(test.times_s.at(i), "{:.5g}"),
                                number_text(test.times_full_equation_s.at(i), "{:.5g}")});
    if (test.inertial_permeability_from)
        section.intro =
            fmt::format("With k = {} m² ({}), k_in = {} m ({}), a sample of {} m, a start {} m above it, and the inertia coefficient {}.",
                        number_text(test.permeability_m2), test.permeability_from.value_or(""), number_text(test.inertial_permeability_m),
                        *test.inertial_permeability_from, number_text(test.sample_length_m), number_text(test.start_level_m),
                        number_text(test.inertia_coefficient, "{:.3g}"));
    if (take_file(input, "falling-head/falling_head.csv", folder) && draw_plot(folder / "falling_head.svg", "falling_head"))
        section.pictures.emplace_back("falling_head.svg", "Predicted water level over time.");
    if (take_file(input, "causes/effects.svg", folder))
        section.pictures.emplace_back("effects.svg", "Change of the water level by each effect.");
    return section;
}

ReportSection causes_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Measured against computed"};
    section.header = {"cause", "range", "k true / k by the paper's evaluation, at both ends", "range from"};
    if (!input.results.causes) return section;
    const results::Causes& found = *input.results.causes;
    const auto factor = [](std::optional<double> value) { return value ? number_text(value, "{:.2f}") : std::string("no k"); };
    for (const results::Cause& cause : found.causes)
        section.rows.push_back({cause.cause + ": " + cause.what,
                                fmt::format("{} to {}{}", number_text(cause.range.low, "{:.2g}"), number_text(cause.range.high, "{:.2g}"),
                                            cause.unit.empty() ? "" : " " + cause.unit),
                                fmt::format("{}, {}", factor(cause.factors[0]), factor(cause.factors[1])),
                                (cause.evidence == "judged" ? "judged: " : "") + cause.source});
    for (const results::JointCauses& one : found.joint) {
        std::string text = fmt::format("{} ({} to {})", factor(one.median), factor(one.interval[0]), factor(one.interval[1]));
        if (one.reaches) text += fmt::format("; {:.1f} % reach it", 100.0 * *one.reaches);
        section.rows.push_back(
            {one.what + ", at random", fmt::format("{} draws", one.draws), text, fmt::format("no k in {:.0f} %", 100.0 * one.without_k)});
    }
    section.intro = fmt::format(
        "Each test is simulated with the cause and evaluated without correction for it. Where Eq. 18 holds exactly, the evaluation gives "
        "{}. "
        "The viscous loss is only {} of the head.",
        number_text(found.evaluation_alone, "{:.2f}"), number_text(found.viscous_share_of_head, "{:.2g}"));
    if (found.to_explain) section.intro += fmt::format(" To explain: k computed / k measured = {}.", number_text(found.to_explain));
    if (take_file(input, "causes/causes.svg", folder))
        section.pictures.emplace_back("causes.svg", "k true / k by the paper's evaluation, for each cause at both ends of its range.");
    if (take_file(input, "causes/joint.svg", folder))
        section.pictures.emplace_back("joint.svg", "All causes at random: share of the draws with a larger factor.");
    return section;
}

}  // namespace porepack::report
