// The intervals of `porepack design` on simulated beds that do not scatter equally, beside those of the pooled deviation.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/members_json.hpp"
#include "core/parallel.hpp"
#include "core/table.hpp"
#include "design/scatter.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::benchmarks {
namespace {

using Random = std::mt19937_64;

double normal(Random& random) {
    return std::normal_distribution<double>()(random);
}

// The standard deviation of ln k of a bed. The first three have the spread of the 24 beds of cases/paper_study; the model is the first.
struct Spread {
    const char* name;
    std::function<double(Random&)> draw;
};
const std::vector<Spread>& spreads() {
    static const std::vector<Spread> list = {
        {"inverse chi squared", [](Random& random) { return 0.038 * std::sqrt(2.2 / std::chi_squared_distribution<double>(2.2)(random)); }},
        {"log-normal", [](Random& random) { return 0.049 * std::exp(0.65 * normal(random)); }},
        {"log-uniform, 0.6 to 28 %",
         [](Random& random) { return std::exp(std::uniform_real_distribution<double>(std::log(0.006), std::log(0.28))(random)); }},
        {"3 %, one in five 15 %", [](Random& random) { return std::bernoulli_distribution(0.2)(random) ? 0.15 : 0.03; }},
        {"all 6 %", [](Random&) { return 0.06; }}};
    return list;
}

double pooled_half_width(const std::vector<BedScatter>& beds, long packings) {
    double squares = 0.0, freedom = 0.0;
    for (const BedScatter& bed : beds) {
        squares += static_cast<double>(bed.packings - 1) * bed.deviation * bed.deviation;
        freedom += static_cast<double>(bed.packings - 1);
    }
    return uncertainty::students_t(freedom) * std::sqrt(squares / freedom / static_cast<double>(packings));
}

double median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2), values.end());
    return values[values.size() / 2];
}

// Shares of the beds, by falling true deviation, whose interval holds the mean; and half widths of a bed that is not chosen.
struct Study {
    std::vector<bool> shrunk, pooled;
    double shrunk_width, pooled_width;
};

Study simulate(const Spread& spread, std::size_t count, long packings, Random& random) {
    std::vector<double> true_deviations(count), errors;
    for (double& one : true_deviations) one = spread.draw(random);
    std::vector<BedScatter> beds;
    const auto n = static_cast<double>(packings);
    std::sort(true_deviations.rbegin(), true_deviations.rend());
    for (const double sigma : true_deviations) {
        errors.push_back(sigma / std::sqrt(n) * normal(random));
        beds.push_back({sigma * std::sqrt(std::chi_squared_distribution<double>(n - 1.0)(random) / (n - 1.0)), packings});
    }
    const ScatterOfBeds scatter(beds);
    const double pooled = pooled_half_width(beds, packings);
    Study study{.shrunk = {}, .pooled = {}, .shrunk_width = 0.0, .pooled_width = pooled};
    for (std::size_t i = 0; i < count; ++i) {
        study.shrunk.push_back(scatter.chance_beyond(beds[i], std::abs(errors[i])) >= 0.05);
        study.pooled.push_back(std::abs(errors[i]) <= pooled);
    }
    study.shrunk_width = scatter.half_width(beds[std::uniform_int_distribution<std::size_t>(0, count - 1)(random)]);
    return study;
}

Json coverage_row(const Spread& spread, std::size_t count, long packings) {
    constexpr std::size_t studies = 1000;
    std::vector<Study> all(studies);
    parallel_for(studies, [&](std::size_t i) {
        Random random(i);
        all[i] = simulate(spread, count, packings, random);
    });
    const auto share = [&](std::vector<bool> Study::*held, std::size_t first) {
        double sum = 0.0;
        for (const Study& one : all)
            sum += static_cast<double>(std::count((one.*held).begin(), (one.*held).begin() + static_cast<long>(first), true));
        return sum / static_cast<double>(studies * first);
    };
    const auto width = [&](double Study::*half_width) {
        std::vector<double> values;
        for (const Study& one : all) values.push_back(one.*half_width);
        return median(values);
    };
    const auto shares = [&](std::vector<bool> Study::*held, double half_width) {
        return Json({{"all", share(held, count)},
                     {"quarter_of_largest_scatter", share(held, (count + 3) / 4)},
                     {"largest_scatter", share(held, 1)},
                     {"median_half_width", half_width}});
    };
    return {{"scatter", spread.name},
            {"beds", count},
            {"packings", packings},
            {"covered", shares(&Study::shrunk, width(&Study::shrunk_width))},
            {"covered_by_pooled", shares(&Study::pooled, width(&Study::pooled_width))}};
}

// Half widths of each bed of a study's table, and the ranges of 90 % of them beside random selections of nine or more of the others.
Json rows_of_table(const std::string& file) {
    std::vector<std::string> names;
    std::vector<BedScatter> beds;
    const TextTable table = read_text_table(file);
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(std::find(table.columns.begin(), table.columns.end(), name) - table.columns.begin());
    };
    const std::size_t point = column("point"), current = column("current"), packings = column("packings"), k = column("permeability_m2"),
                      deviation = column("permeability_standard_deviation_m2");
    for (const auto& row : table.rows)
        if (row.at(current) == "yes" && !row.at(deviation).empty()) {
            names.push_back(row[point]);
            beds.push_back({std::stod(row[deviation]) / std::stod(row[k]), std::stol(row[packings])});
        }
    const ScatterOfBeds all(beds);
    Json rows = Json::array();
    for (std::size_t i = 0; i < beds.size(); ++i) {
        Random random(i);
        std::vector<double> shrunk, pooled;
        for (int selection = 0; selection < 200; ++selection) {
            std::vector<BedScatter> others = beds, chosen = {beds[i]};
            others.erase(others.begin() + static_cast<long>(i));
            std::shuffle(others.begin(), others.end(), random);
            const std::size_t least = std::min<std::size_t>(9, others.size());
            others.resize(std::uniform_int_distribution<std::size_t>(least, others.size())(random));
            chosen.insert(chosen.end(), others.begin(), others.end());
            shrunk.push_back(ScatterOfBeds(chosen).half_width(beds[i]));
            pooled.push_back(pooled_half_width(chosen, beds[i].packings));
        }
        const auto range = [](std::vector<double> values) {  // 90 % of them
            std::sort(values.begin(), values.end());
            return Json({values[values.size() / 20], values[values.size() - 1 - values.size() / 20]});
        };
        const auto own = static_cast<double>(beds[i].packings);
        rows.push_back({{"point", names[i]},
                        {"deviation", beds[i].deviation},
                        {"half_width", all.half_width(beds[i])},
                        {"range", range(shrunk)},
                        {"pooled_half_width", pooled_half_width(beds, beds[i].packings)},
                        {"pooled_range", range(pooled)},
                        {"own_half_width", uncertainty::students_t(own - 1.0) * beds[i].deviation / std::sqrt(own)}});
    }
    return {{"typical_deviation", json_of(all.typical())}, {"common_weight", json_of(all.common_weight())}, {"beds", rows}};
}

}  // namespace

Json design_scatter_benchmark(const std::vector<std::string>& study_csv) {
    Json result = {{"rows", Json::array()}, {"tables", Json::array()}};
    for (const std::string& file : study_csv) result["tables"].push_back(rows_of_table(file));
    for (const std::size_t count : {24, 6})
        for (const Spread& spread : spreads())
            for (const long packings : {2, 3, 5}) result["rows"].push_back(coverage_row(spread, count, packings));
    return result;
}

}  // namespace porepack::benchmarks
