// The first lines of the report: k in one sentence that can be cited, where its uncertainty is from, and what would tell more.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/log.hpp"
#include "core/sides.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::report {
namespace {

std::string k_text(double k) {
    return with_powers_of_ten(fmt::format("{:.3g} m²", k));
}

std::string range_text(const Interval& interval) {
    return with_powers_of_ten(fmt::format("{:.2g} to {:.2g} m²", std::max(0.0, interval.low), interval.high));
}

// Of the variance of one packing's k about that of such packings, in the order of the legend.
std::vector<std::pair<std::string, double>> shares_of(const results::Uncertainty& sure) {
    using uncertainty::Part;
    std::vector<std::pair<std::string, double>> shares;
    double all = 0.0;
    for (const auto& [part, name] :
         {std::pair(Part::numerical, "the computation"), {Part::input, "inputs"}, {Part::scatter, "packing to packing"}}) {
        double variance = 0.0;
        for (const uncertainty::BudgetRow& row : sure.budget_of_permeability)
            if (row.part == part) variance += std::pow(row.relative_standard_uncertainty.wider(), 2.0);
        all += variance;
        if (variance > 0.0) shares.emplace_back(name, variance);
    }
    for (auto& [name, share] : shares) share /= all;
    return shares;
}

// Packings in all for a mean within 10 %, if this many scatter like those that are known.
std::size_t packings_for_ten_percent(const results::Seeds& seeds) {
    constexpr std::size_t most = 1000;
    const double relative = seeds.standard_deviation_between_packings_m2 / seeds.permeability_mean_m2;
    std::size_t n = std::max<std::size_t>(2, seeds.packings);
    while (n < most && uncertainty::students_t(static_cast<double>(n - 1)) * relative / std::sqrt(static_cast<double>(n)) > 0.1) ++n;
    return n;
}

std::string more_text(const ReportInput& input) {
    const auto& seeds = input.results.seeds;
    if (!seeds)
        return input.results.pack
                   ? "How much other packings of these grains differ, [packings] seeds = 5 or porepack run --until-sure 0.1 tells."
                   : "";
    const std::size_t wanted = packings_for_ten_percent(*seeds);
    if (wanted <= seeds->packings) return "The scatter between packings allows a mean to ± 10 %; more of them make it narrower.";
    const std::size_t more = wanted - seeds->packings;
    std::string text = fmt::format("About {} more packings would give the mean to ± 10 %", more);
    const auto cost = input.manifests.find("seeds");
    if (cost != input.manifests.end() && seeds->packings > 1)
        text += ", in about " +
                human_time(cost->second.value("wall_time_s", 0.0) / static_cast<double>(seeds->packings - 1) * static_cast<double>(more)) +
                " here";
    return text + ": porepack run --until-sure 0.1.";
}

}  // namespace

Answer answer_of(const ReportInput& input) {
    Answer answer;
    const auto& sure = input.results.uncertainty;
    const results::Statements* k = sure ? find(sure->statements, "permeability_m2") : nullptr;
    if (k == nullptr || !k->this_packing.value) return answer;
    const std::string here = sure_text(input, "permeability_m2", &results::Statements::this_packing),
                      porosity = sure_text(input, "porosity", &results::Statements::this_packing),
                      what = input.results.pack ? "packing" : "solid";
    using results::Statements;
    answer.stated = {statement_label(input, "k", &Statements::this_packing), statement_label(input, "porosity", &Statements::this_packing)};
    const auto& [mean, next] = std::tie(k->mean_of_such_packings, k->next_such_packing);
    if (mean.value && mean.interval) {
        answer.sentences.push_back(
            fmt::format("k of such packings is {} on average, {} with 95 %", k_text(*mean.value), range_text(*mean.interval)) +
            (next.interval ? fmt::format("; of 100 further packings, 95 have {}.", range_text(*next.interval)) : "."));
        answer.sentences.push_back(fmt::format("This {} has {}, and a porosity of {}.", what, here, porosity));
        for (const auto which : {&Statements::mean_of_such_packings, &Statements::next_such_packing})
            answer.stated.push_back(statement_label(input, "k", which));
    } else {
        answer.sentences.push_back(fmt::format("k of this {} is {}; its porosity is {}.", what, here, porosity));
    }
    if (const auto& bed = k->bed_of_measured_porosity; bed && bed->statement.value)
        answer.sentences.push_back(fmt::format("The bed with the measured porosity of {:g} has {}.", bed->measured_porosity,
                                               measured_bed_text(input, "permeability_m2")));
    if (mean.value) answer.shares = shares_of(*sure);
    if (const std::string more = more_text(input); !more.empty()) answer.sentences.push_back(more);
    return answer;
}

}  // namespace porepack::report
