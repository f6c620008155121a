// The rule of --until-sure on simulated packings: how often its interval holds the mean, and how many packings it takes.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/json.hpp"
#include "core/parallel.hpp"
#include "core/table.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::benchmarks {
namespace {

struct Outcome {
    bool rule = false, plain = false;  // the interval held the mean
    bool next = false;                 // ... the next packing
    bool thirty = false;               // the plain t interval of thirty packings, fixed before, held the mean
    std::size_t packings = 0;
};

// `draw` gives k of the next packing; their mean is `mean`.
Outcome run_sequence(const std::function<double()>& draw, double mean, double wanted) {
    std::vector<double> values;
    Sample sample;
    do {
        values.push_back(draw());
        sample = sample_of(values);
    } while (values.size() < min_packings || relative_half_width(sample, 0.0) > wanted);
    const auto holds = [&](const std::optional<Interval>& interval) { return interval->low <= mean && mean <= interval->high; };
    const double another = draw();
    const auto next = interval_of_next(sample, {}, StudyEnd::when_sure);
    std::vector<double> thirty(30);
    for (double& one : thirty) one = draw();
    return {holds(interval_of_mean(sample, {}, StudyEnd::when_sure)), holds(interval_of_mean(sample, {})),
            next->low <= another && another <= next->high, holds(interval_of_mean(sample_of(thirty), {})), values.size()};
}

struct Scatter {
    std::string name;
    double mean;
    std::function<double(std::mt19937_64&)> draw;
};

Scatter log_normal(const std::string& name, double sigma) {
    return {name, 1.0, [sigma](std::mt19937_64& random) {
                return std::exp(sigma * std::normal_distribution<double>()(random) - 0.5 * sigma * sigma);
            }};
}

// A share of the packings has k `factor` times as large; all scatter by `deviation` besides.
Scatter with_outliers(double share, double factor, double deviation) {
    return {fmt::format("{:g} % of packings with {:g} k, normal {:g} %", 100.0 * share, factor, 100.0 * deviation),
            1.0 + share * (factor - 1.0), [=](std::mt19937_64& random) {
                const double kind = std::bernoulli_distribution(share)(random) ? factor : 1.0;
                return kind * (1.0 + deviation * std::normal_distribution<double>()(random));
            }};
}

// Skewed, with rare outliers, with heavy tails on both sides.
void add_unusual(std::vector<Scatter>& list) {
    list.push_back(log_normal("log-normal, sigma 0.16", 0.16));
    list.push_back(log_normal("log-normal, sigma 0.5", 0.5));
    list.push_back({"gamma, 30 %", 1.0, [](std::mt19937_64& random) { return std::gamma_distribution<double>(1.0 / 0.09, 0.09)(random); }});
    list.push_back({"exponential from 0.8, 20 %", 1.0,
                    [](std::mt19937_64& random) { return 0.8 + 0.2 * std::exponential_distribution<double>()(random); }});
    list.push_back({"normal 10 %, one in ten 40 %", 1.0, [](std::mt19937_64& random) {
                        const double deviation = std::bernoulli_distribution(0.1)(random) ? 0.4 : 0.1;
                        return 1.0 + deviation * std::normal_distribution<double>()(random);
                    }});
    for (const double factor : {0.5, 1.5, 2.0})
        for (const double deviation : {0.05, 0.10}) list.push_back(with_outliers(0.1, factor, deviation));
    list.push_back(with_outliers(0.02, 2.0, 0.10));
}

std::vector<Scatter> scatters(const std::vector<double>& measured) {
    std::vector<Scatter> list;
    for (const double s : {0.05, 0.07, 0.10, 0.12, 0.15, 0.20}) {
        list.push_back({fmt::format("normal, {:g} %", 100.0 * s), 1.0,
                        [s](std::mt19937_64& random) { return 1.0 + s * std::normal_distribution<double>()(random); }});
        list.push_back(log_normal(fmt::format("log-normal, {:g} %", 100.0 * s), std::sqrt(std::log(1.0 + s * s))));
    }
    add_unusual(list);
    if (measured.empty()) return list;
    const Sample sample = sample_of(measured);
    list.push_back({fmt::format("{} packings resampled, {:.2g} %", measured.size(), 100.0 * sample.relative_deviation()), sample.mean,
                    [measured](std::mt19937_64& random) {
                        return measured[std::uniform_int_distribution<std::size_t>(0, measured.size() - 1)(random)];
                    }});
    return list;
}

}  // namespace

Json stopping_benchmark(const std::vector<std::string>& seeds_csv) {
    constexpr std::size_t sequences = 10000;
    std::vector<double> measured;
    for (const std::string& file : seeds_csv)
        for (const auto& row : read_table(file)) measured.push_back(row.at(1));
    Json rows = Json::array();
    for (const Scatter& scatter : scatters(measured))
        for (const double wanted : {0.05, 0.10}) {
            std::vector<Outcome> outcomes(sequences);
            parallel_for(sequences, [&](std::size_t i) {
                std::mt19937_64 random(i);
                outcomes[i] = run_sequence([&] { return scatter.draw(random); }, scatter.mean, wanted);
            });
            long rule = 0, plain = 0, next = 0, thirty = 0;
            std::size_t packings = 0;
            for (const Outcome& one : outcomes) {
                rule += one.rule ? 1 : 0;
                plain += one.plain ? 1 : 0;
                next += one.next ? 1 : 0;
                thirty += one.thirty ? 1 : 0;
                packings += one.packings;
            }
            const auto share = [](auto count) { return static_cast<double>(count) / static_cast<double>(sequences); };
            rows.push_back({{"scatter", scatter.name},
                            {"wanted", wanted},
                            {"covered", share(rule)},
                            {"covered_by_plain_t", share(plain)},
                            {"next_covered", share(next)},
                            {"covered_by_thirty_packings", share(thirty)},
                            {"mean_number_of_packings", share(packings)}});
        }
    return {{"sequences", sequences}, {"rows", rows}};
}

}  // namespace porepack::benchmarks
