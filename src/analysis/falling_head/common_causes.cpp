#include "analysis/falling_head/common_causes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "core/members_json.hpp"
#include "core/table.hpp"
#include "falling_head/causes.hpp"
#include "record/toml_file.hpp"
#include "results/falling_head.hpp"

namespace porepack::analysis {
namespace {

constexpr double near = 1.25;  // a factor within 1/near to near times the one to be explained counts as given

// Resolved values as the flags that give them.
Flags flags_of(const Json& resolved_values) {
    Flags flags;
    for (const auto& [key, value] : resolved_values.items()) {
        std::string text = value.is_string() ? value.get<std::string>() : value.dump();
        std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
        flags[key] = text;
    }
    return flags;
}

TestedSample sample_of(const Path& file) {
    const Json json = read_json(file);
    TestedSample sample;
    if (!json.contains("sample") || !json.contains("apparatus"))
        throw UserError("this is no result of the causes of a falling-head test",
                        {.where = file.string(),
                         .allowed = "result.json of the stage causes, with `sample` and `apparatus`",
                         .fix = "porepack falling-head causes CASE (results of before version 0.2 must be computed again)"});
    const auto causes = from_json_members<results::Causes>(json, file.string());
    sample.truth = causes.sample;
    sample.apparatus = config_from_flags<FallingHeadConfig>(flags_of(causes.apparatus));
    sample.factor = causes.to_explain.value_or(0.0);
    return sample;
}

std::vector<std::string> names_of_common(const TestedSample& sample) {
    std::vector<std::string> names;
    for (const UncertainCause& cause : uncertain_causes(sample.truth, sample.apparatus))
        if (cause.common) names.push_back(cause.name);
    return names;
}

using Factors = std::array<double, 2>;

bool reaches(const PairedDraw& draw, std::size_t sample, const Factors& wanted) {
    return draw.factors[sample] && *draw.factors[sample] >= wanted[sample];
}
bool is_near(const PairedDraw& draw, std::size_t sample, const Factors& wanted) {
    return draw.factors[sample] && std::abs(std::log(*draw.factors[sample] / wanted[sample])) <= std::log(near);
}

std::optional<double> median_of(const std::vector<PairedDraw>& draws, std::size_t sample) {
    std::vector<double> found;
    for (const PairedDraw& draw : draws)
        if (draw.factors[sample]) found.push_back(*draw.factors[sample]);
    if (found.size() < 10) return std::nullopt;
    return median(std::move(found));
}

// Of the logarithms of both factors, over the draws with both.
std::optional<double> correlation_of(const std::vector<PairedDraw>& draws) {
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
    for (const PairedDraw& draw : draws) {
        if (!draw.factors[0] || !draw.factors[1]) continue;
        const double a = std::log(*draw.factors[0]), b = std::log(*draw.factors[1]);
        n += 1.0;
        x += a;
        y += b;
        xx += a * a;
        yy += b * b;
        xy += a * b;
    }
    const double spread = (n * xx - x * x) * (n * yy - y * y);
    return n >= 10.0 && spread > 0.0 ? std::optional((n * xy - x * y) / std::sqrt(spread)) : std::nullopt;
}

results::CommonShares shares_of(const std::vector<PairedDraw>& draws, const Factors& wanted) {
    const auto share = [&](const auto& counts) {
        return static_cast<double>(std::count_if(draws.begin(), draws.end(), counts)) / static_cast<double>(draws.size());
    };
    const auto each = [&](const auto& test) {
        return std::array{share([&](const PairedDraw& d) { return test(d, 0); }), share([&](const PairedDraw& d) { return test(d, 1); })};
    };
    const auto at_least = [&](const PairedDraw& d, std::size_t i) { return reaches(d, i, wanted); };
    const auto about = [&](const PairedDraw& d, std::size_t i) { return is_near(d, i, wanted); };
    return {.draws = draws.size(),
            .medians = {median_of(draws, 0), median_of(draws, 1)},
            .reach = each(at_least),
            .reach_both = share([&](const PairedDraw& d) { return at_least(d, 0) && at_least(d, 1); }),
            .near = each(about),
            .near_both = share([&](const PairedDraw& d) { return about(d, 0) && about(d, 1); })};
}

double largest_exponent(const PairedFactors& paired) {
    double largest = 0.0;
    for (const PairedDraw& draw : paired.draws) largest = std::max(largest, draw.exponent);
    return std::ceil(100.0 * largest) / 100.0;
}

// The draws of one width of the ranges: all, and by n in steps of a tenth of its range.
results::CommonPairs result_of(const PairedFactors& paired, const Factors& wanted) {
    results::CommonPairs pairs{
        .shares = shares_of(paired.draws, wanted), .range_factor = paired.range_factor, .correlation = correlation_of(paired.draws)};
    constexpr int bands = 10;
    const double width = largest_exponent(paired) / bands;
    for (int band = 0; band < bands; ++band) {
        std::vector<PairedDraw> inside;
        std::copy_if(paired.draws.begin(), paired.draws.end(), std::back_inserter(inside),
                     [&](const PairedDraw& draw) { return draw.exponent >= band * width && draw.exponent < (band + 1) * width; });
        if (!inside.empty()) pairs.by_exponent.push_back({shares_of(inside, wanted), {band * width, (band + 1) * width}});
    }
    return pairs;
}

}  // namespace

std::vector<Path> results_of_causes(const std::vector<Path>& samples) {
    std::vector<Path> files;
    for (const Path& sample : samples)
        files.push_back(std::filesystem::is_directory(sample) ? sample / "results" / "causes" / "result.json" : sample);
    return files;
}

Outcome<results::CommonCauses> compare_causes(const std::vector<Path>& samples, const std::vector<double>& factors) {
    const std::vector<Path> files = results_of_causes(samples);
    const std::array<TestedSample, 2> both = {sample_of(files.at(0)), sample_of(files.at(1))};
    if (names_of_common(both[0]) != names_of_common(both[1]))
        throw UserError("the two samples were not tested in one apparatus: only one of them has screens or a loss coefficient",
                        {.where = files[1].string()});
    const Factors wanted = factors.empty() ? Factors{both[0].factor, both[1].factor} : Factors{factors.at(0), factors.at(1)};
    if (!(wanted[0] > 0.0 && wanted[1] > 0.0))
        throw UserError(
            "there is no factor to be explained",
            {.where = "computed_over_measured", .fix = "--factors 2.8,2.3, or [falling_head] computed_over_measured in both cases"});
    log_info("common causes: simulated tests of both samples, evaluated as in the paper");
    const std::vector<PairedFactors> found = study_common_causes(both);
    Table table({"range_factor", "draw", "inertial_exponent", "factor_1", "factor_2"});
    table.digits = 5;
    for (const PairedFactors& paired : found)
        for (std::size_t i = 0; i < paired.draws.size(); ++i)
            table.add(paired.range_factor, i, paired.draws[i].exponent, paired.draws[i].factors[0], paired.draws[i].factors[1]);
    results::CommonCauses result{.samples = {files[0].string(), files[1].string()},
                                 .to_explain = wanted,
                                 .common = names_of_common(both[0]),
                                 .near_within_factor = near};
    for (const PairedFactors& paired : found) result.pairs.push_back(result_of(paired, wanted));
    return {result,
            {.tables = {{"common_causes.csv", table}},
             .plots = {{"common_causes.svg",
                        "common_causes",
                        {{"wanted_1", wanted[0]}, {"wanted_2", wanted[1]}, {"near", near}, {"largest", largest_exponent(found.front())}},
                        {.width = 620, .height = 520}}}}};
}

}  // namespace porepack::analysis
