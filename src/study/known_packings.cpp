#include "study/known_packings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/log.hpp"
#include "core/table.hpp"
#include "permeability/permeability.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace {

constexpr std::size_t permeability = 0, porosity = 1;  // of the quantities

double measured_part_porosity(const Case& one, const pouring::PackingsConfig& config) {
    if (config.measured_porosity.empty()) return std::numeric_limits<double>::quiet_NaN();
    if (config.measured_part == pouring::MeasuredPart::bed) return one.result<results::Pack>().bed.porosity_bed;
    const pore_space::PoreSpace space = case_pore_space(one);
    if (config.measured_part == pouring::MeasuredPart::section) return space.porosity().value;
    const packing::Section part{config.measured_between_m[0], config.measured_between_m[1]};
    return part.z1_m > space.bed_top_m ? std::numeric_limits<double>::quiet_NaN() : space.with_section(part).porosity().value;
}

Member member_of(const Case& one, const pouring::PackingsConfig& config) {
    results::CaseResults results;
    results.lbm = one.result<results::Lbm>();
    results.tortuosity = one.result<results::Tortuosity>();
    Member member{.seed = one.settings.packing.seed,
                  .friction = one.settings.packing.friction,
                  .measured_part_porosity = measured_part_porosity(one, config),
                  .values = {},
                  .intervals = {},
                  .section_scatter = std::numeric_limits<double>::quiet_NaN()};
    if (const auto scatter = section_scatter_of(one)) member.section_scatter = scatter->relative;
    for (std::size_t i = 0; i < results::reported_quantities.size(); ++i) {
        member.values[i] = results::reported_quantities[i].value(results);
        if (member.values[i]) member.intervals[i] = results::reported_quantities[i].interval(results);
    }
    return member;
}

}  // namespace

KnownPackings::KnownPackings(const Case& c)
    : packing_(c.settings.packing), config_(c.settings.packings), members_{member_of(c, c.settings.packings)} {
    if (many_pours()) add_pour(porosity_of_flow(0));
}

void KnownPackings::add_flow(const Case& member) {
    members_.push_back(member_of(member, config_));
}

double KnownPackings::porosity_of_flow(long index) const {
    return *members_.at(static_cast<std::size_t>(index)).values[porosity];
}

long KnownPackings::flows_of_first_look() const {
    return static_cast<long>(many_pours() ? min_flows : min_packings);
}

std::vector<double> KnownPackings::values_of(std::size_t quantity) const {
    std::vector<double> values;
    for (const Member& one : members_)
        if (one.values[quantity]) values.push_back(*one.values[quantity]);
    return values;
}

Sample KnownPackings::sample(std::size_t quantity) const {
    return sample_of(values_of(quantity));
}

// Of one packing, numerical: the mean of those that are known, on each side.
std::optional<Sides> KnownPackings::mean_half_widths(std::size_t quantity) const {
    Sides sum;
    double count = 0.0;
    for (const Member& one : members_)
        if (const auto& known = one.intervals[quantity]) {
            const Sides half = half_widths(*one.values[quantity], *known);
            sum = {sum.below + half.below, sum.above + half.above};
            count += 1.0;
        }
    return count > 0.0 ? std::optional((1.0 / count) * sum) : std::nullopt;
}

// The wider side decides when the mean is sure.
double KnownPackings::numerical_half_width_m2() const {
    return mean_half_widths(permeability).value_or(Sides{}).wider();
}

// k of the flows on the Kozeny function of their porosity, at the mean of all pours.
// A flow costs far more than a pour. So k is computed for some packings, and the porosity for many: the regression line on the Kozeny
// function transfers the mean porosity of all pours to the mean k. Its error has two independent parts, the scatter about the line and that
// of the mean along the line.
std::optional<RegressedMean> KnownPackings::regressed() const {
    if (!many_pours()) return std::nullopt;
    std::vector<double> x, all;
    for (const Member& one : members_) x.push_back(kozeny_function(*one.values[porosity]));
    for (const double eps : pours_) all.push_back(kozeny_function(eps));
    const auto line = fit_line(x, values_of(permeability));
    return line ? std::optional(RegressedMean{*line, sample_of(all)}) : std::nullopt;
}

double KnownPackings::mean_permeability() const {
    const auto found = regressed();
    return found ? found->mean() : sample(permeability).mean;
}

// Packings cannot help: the numerical part alone is too wide.
bool KnownPackings::too_coarse() const {
    return enough_for_a_look() && numerical_half_width_m2() >= config_.until_sure * mean_permeability();
}

double KnownPackings::reached() const {
    if (const auto found = regressed()) return std::hypot(found->half_width(), numerical_half_width_m2()) / found->mean();
    return relative_half_width(sample(permeability), numerical_half_width_m2());
}

bool KnownPackings::sure() const {
    return config_.until_sure > 0.0 && enough_for_a_look() && reached() <= config_.until_sure;
}

long KnownPackings::flows_expected() const {
    // The half widths add in quadrature: packings may use what the numerical part leaves of the limit.
    const double k = mean_permeability(), numerical = numerical_half_width_m2() / k;
    if (const auto found = regressed())
        return static_cast<long>(flows_for(found->line.residual_deviation / k, std::abs(found->line.slope) * found->pours.deviation / k,
                                           std::sqrt(config_.until_sure * config_.until_sure - numerical * numerical),
                                           static_cast<std::size_t>(config_.pours_per_flow)));
    return static_cast<long>(
        packings_for(sample(permeability).relative_deviation(), config_.until_sure, numerical).value_or(config_.max_packings));
}

// Where friction varies between the packings: the line of a quantity on it, at the friction of the case.
std::optional<MeanAtInput> KnownPackings::at_friction(std::size_t quantity) const {
    if (!(packing_.friction_uncertainty > 0.0)) return std::nullopt;
    std::vector<double> friction, values;
    for (const Member& one : members_)
        if (one.values[quantity]) {
            friction.push_back(one.friction);
            values.push_back(*one.values[quantity]);
        }
    const auto line = fit_line(friction, values);
    return line ? std::optional(MeanAtInput{*line, packing_.friction, packing_.friction_uncertainty}) : std::nullopt;
}

KnownPackings::Estimate KnownPackings::estimate(std::size_t quantity) const {
    // Friction that varies between the packings would count as scatter, so its line comes first. Then the line on the pours, for k alone;
    // else the plain sample. The interval of the sample also depends on how the number of packings was decided.
    const Sides numerical = mean_half_widths(quantity).value_or(Sides{});
    if (const auto found = at_friction(quantity))
        return {found->mean(), found->line.residual_deviation, found->interval_of_mean(numerical), found->interval_of_next(numerical)};
    if (const auto found = regressed(); found && quantity == permeability)
        return {found->mean(), found->deviation(), found->interval_of_mean(numerical), found->interval_of_next(numerical)};
    const StudyEnd end = config_.until_sure > 0.0 ? StudyEnd::when_sure : StudyEnd::at_number;
    const Sample s = many_pours() && quantity == porosity ? sample_of(pours_) : sample(quantity);
    return {s.mean, s.deviation, interval_of_mean(s, numerical, end), interval_of_next(s, numerical, end)};
}

results::SeedsQuantity KnownPackings::quantity(std::size_t quantity) const {
    const Estimate e = estimate(quantity);
    const std::size_t packings = many_pours() && quantity == porosity ? pours_.size() : values_of(quantity).size();
    const std::optional<Sides> numerical = mean_half_widths(quantity);
    results::SeedsQuantity found{.packings = packings, .mean = e.mean, .interval_of_mean = e.of_mean, .interval_of_next = e.of_next};
    if (packings > 1) {
        found.standard_deviation = e.deviation;
        found.standard_deviation_interval = interval_of_deviation(e.deviation, static_cast<double>(packings) - 1.0);
    }
    if (numerical) {
        found.numerical_half_width = numerical->wider();
        found.numerical_interval = about(e.mean, *numerical);
    }
    return found;
}

// k of the bed whose porosity was measured, by the line of ln k on the logarithm of the Kozeny function; or why it is not known.
results::MeasuredBed KnownPackings::measured_bed() const {
    const double value = config_.measured_porosity[0], u = config_.measured_porosity[1];
    std::vector<double> porosities, x, y;
    for (const Member& one : members_) {
        porosities.push_back(one.measured_part_porosity);
        x.push_back(std::log(kozeny_function(one.measured_part_porosity)));
        // In logarithms a Kozeny law is a line of slope 1; the fitted slope shows the deviation from it.
        y.push_back(std::log(*one.values[permeability]));
    }
    const std::string part(name_of(config_.measured_part));
    results::MeasuredBed bed{.porosity = value, .standard_uncertainty = u, .part = part, .packings = members_.size()};
    const auto refuse = [&](const std::string& why) {
        log_warning("k of the bed of measured porosity: " + why);
        bed.why = why;
        return bed;
    };
    if (std::any_of(porosities.begin(), porosities.end(), [](double eps) { return std::isnan(eps); }))
        return refuse(fmt::format("the level of {:g} m lies above the top of at least one of the packings: choose levels inside the bed",
                                  config_.measured_between_m[1]));
    const auto [low, high] = std::minmax_element(porosities.begin(), porosities.end());
    bed.porosity_range = Interval{*low, *high};
    // No extrapolation: the line is known only between the porosities of the packings.
    if (value < *low || value > *high)
        return refuse(fmt::format(
            "the packings do not bracket it: their porosities ({}) are {:.4f} to {:.4f}, and {:g} was measured. Check `measured_part`. "
            "More packings reach further, and {} [packing] friction gives {} beds; friction_uncertainty makes them differ",
            part, *low, *high, value, value < *low ? "lower" : "higher", value < *low ? "denser" : "looser"));
    const auto line = fit_line(x, y);
    if (!line) return refuse("all packings have the same porosity");
    const double k = mean_permeability();
    const Sides numerical = (1.0 / k) * mean_half_widths(permeability).value_or(Sides{});
    const BedEstimate found = bed_of_porosity(*line, value, u, numerical);
    bed.permeability_m2 = found.permeability_m2;
    bed.interval_m2 = found.interval_m2;
    bed.slope = line->slope;
    bed.standard_deviation_about_line = line->residual_deviation;
    bed.standard_deviation_of_ln_k = sample_of(y).deviation;
    return bed;
}

double KnownPackings::standard_error_m2() const {
    if (const auto found = regressed())
        return std::hypot(found->line.residual_deviation * std::sqrt(found->line.relative_variance_at(found->pours.mean)),
                          found->line.slope * found->pours.deviation / std::sqrt(static_cast<double>(pours_.size())));
    return estimate(permeability).deviation / std::sqrt(static_cast<double>(members_.size()));
}

void KnownPackings::write_tables(const Path& folder) const {
    std::vector<std::string> columns = {"seed"};
    for (const results::Quantity& quantity : results::reported_quantities) columns.emplace_back(quantity.name);
    columns.insert(columns.end(),
                   {"permeability_low_m2", "permeability_high_m2", "section_scatter", "friction", "porosity_of_measured_part"});
    Table table(columns);
    for (const Member& one : members_) {
        const auto& v = one.values;
        const auto& k = one.intervals[permeability];
        table.add(one.seed, v[0], v[1], v[2], v[3], v[4], v[5], k ? std::optional(k->low) : std::nullopt,
                  k ? std::optional(k->high) : std::nullopt, one.section_scatter, one.friction, one.measured_part_porosity);
    }
    table.write(folder / "seeds.csv");
    if (!many_pours()) return;
    Table pours({"seed", "porosity"});
    long seed = packing_.seed;
    for (const double eps : pours_) pours.add(seed++, eps);
    pours.write(folder / "pours.csv");
}

results::Seeds KnownPackings::result(bool out_of_time) const {
    const Estimate k = estimate(permeability), eps = estimate(porosity);
    results::Seeds seeds{
        .packings = members_.size(),
        .porosity_mean = eps.mean,
        .porosity_standard_deviation = eps.deviation,
        .permeability_mean_m2 = k.mean,
        .standard_deviation_between_packings_m2 = k.deviation,
        .standard_error_of_mean_m2 = standard_error_m2(),
        .unseen_share = unseen_share(members_.size()),
        .meaning =
            "intervals of 95 %: Student's t for the scatter between packings, and the numerical half widths of one packing, added in "
            "quadrature on each side where they are known. They presume that these packings show the scatter: packings of another "
            "kind, up to unseen_share of all, may all be absent with a probability of 5 %"};
    if (mean_half_widths(permeability)) seeds.numerical_half_width_m2 = numerical_half_width_m2();
    for (std::size_t i = 0; i < results::reported_quantities.size(); ++i)
        if (!values_of(i).empty()) seeds.quantities.emplace_back(results::reported_quantities[i].name, quantity(i));
    if (const auto found = regressed())
        seeds.pours = {.packings = pours_.size(),
                       .relative_deviation_about_line = found->line.residual_deviation / found->mean(),
                       .relative_deviation_along_line = std::abs(found->line.slope) * found->pours.deviation / found->mean()};
    if (const auto found = at_friction(permeability))
        seeds.friction = {.value = found->input,
                          .standard_uncertainty = found->input_uncertainty,
                          .relative_effect_on_permeability = found->effect() / found->mean()};
    if (!config_.measured_porosity.empty()) seeds.measured_porosity = measured_bed();
    if (config_.until_sure > 0.0) seeds.until_sure = until_sure(out_of_time);
    return seeds;
}

results::UntilSure KnownPackings::until_sure(bool out_of_time) const {
    results::UntilSure until{.until_sure = config_.until_sure, .relative_half_width = reached(), .sure = sure()};
    if (until.sure) return until;
    until.stopped_by = too_coarse() ? "numerical" : out_of_time ? "max_time_s" : "max_packings";
    log_warning(fmt::format("the mean of k is known to {:.2g} %, not to {:g} %: {} was reached", 100.0 * reached(),
                            100.0 * config_.until_sure, *until.stopped_by));
    return until;
}

}  // namespace porepack::study
