#include "study/seeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/log.hpp"
#include "core/table.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::study {
using namespace core;
using namespace lbm;
using namespace pipeline;
using namespace stages;
namespace {

// The same case with another seed, as far as k.
Json lbm_of_seed(const Case& c, long seed) {
    if (seed == c.settings.packing.seed) return c.result_of("lbm");
    Case one = c;
    one.settings.packing.seed = seed;
    one.settings.packing.seeds = 1;
    one.settings.lbm.fields = FieldFiles::none;
    one.output = c.results() / fmt::format("seed_{}", seed);
    log_info("seed {}:", seed);
    return run_pipeline(case_pipeline(one), "lbm");
}

// Standard deviation of one packing, not of the mean.
std::pair<double, double> mean_and_deviation(const std::vector<double>& values) {
    const auto n = static_cast<double>(values.size());
    const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
    double squares = 0.0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    return {mean, std::sqrt(squares / (n - 1.0))};
}

Json run_seeds(const Case& c, const Path& folder) {
    const long first = c.settings.packing.seed;
    std::vector<double> values, half_widths, porosities;
    Table table({"seed", "porosity", "permeability_m2", "half_width_m2"});
    for (long seed = first; seed < first + c.settings.packing.seeds; ++seed) {
        const Json lbm = lbm_of_seed(c, seed);
        const Json& interval = lbm.at("permeability_interval_m2");
        values.push_back(lbm.at("permeability_m2").get<double>());
        half_widths.push_back(interval.is_array() ? 0.5 * (interval.at(1).get<double>() - interval.at(0).get<double>()) : 0.0);
        porosities.push_back(lbm.at("porosity").get<double>());
        table.add(seed, porosities.back(), values.back(), half_widths.back());
    }
    table.write(folder / "seeds.csv");
    const auto n = static_cast<double>(values.size());
    const auto [mean, deviation] = mean_and_deviation(values);
    const auto [porosity, porosity_deviation] = mean_and_deviation(porosities);
    return {{"packings", values.size()},
            {"porosity_mean", porosity},
            {"porosity_standard_deviation", porosity_deviation},
            {"permeability_mean_m2", mean},
            {"standard_deviation_between_packings_m2", deviation},
            {"standard_error_of_mean_m2", deviation / std::sqrt(n)},
            {"numerical_half_width_m2", *std::max_element(half_widths.begin(), half_widths.end())},
            {"meaning", "scatter between packings, and numerical uncertainty of one packing (the maximum), given separately"}};
}

}  // namespace

Stage make_seeds_stage(const Case& c) {
    return {.name = "seeds",
            .needs = {"lbm"},
            .configuration = {{"packing", {{"seeds", c.settings.packing.seeds}}}},
            .outputs = {"seeds.csv"},
            .run = [c](const Path& folder) { return run_seeds(c, folder); },
            .expect = [n = c.settings.packing.seeds -
                           1] { return Expectation{.text = fmt::format("{} more packings, each like pack and lbm", n)}; }};
}

}  // namespace porepack::study
