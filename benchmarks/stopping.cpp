// The rule of --until-sure on simulated packings: how often its interval holds the mean, and how many packings it takes.
#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <random>

#include "benchmarks/benchmarks.hpp"
#include "core/parallel.hpp"
#include "core/table.hpp"
#include "permeability/sample.hpp"

namespace porepack::benchmarks {
using namespace core;
using namespace permeability;
namespace {

struct Outcome {
    bool rule = false, plain = false;  // the interval held the mean
    bool next = false;                 // ... the next packing
    std::size_t packings = 0;
};

// `draw` gives k of the next packing; their mean is `mean`.
Outcome run_sequence(const std::function<double()>& draw, double mean, double wanted) {
    std::vector<double> values;
    Sample sample;
    do {
        values.push_back(draw());
        sample = sample_of(values);
    } while (values.size() < least_packings || relative_half_width(sample, 0.0) > wanted);
    const auto holds = [&](const std::optional<Interval>& interval) { return interval->low <= mean && mean <= interval->high; };
    const double another = draw();
    const auto next = interval_of_next(sample, {}, StudyEnd::when_sure);
    return {holds(interval_of_mean(sample, {}, StudyEnd::when_sure)), holds(interval_of_mean(sample, {})),
            next->low <= another && another <= next->high, values.size()};
}

struct Scatter {
    std::string name;
    double mean;
    std::function<double(std::mt19937_64&)> draw;
};

std::vector<Scatter> scatters(const std::vector<double>& measured) {
    std::vector<Scatter> list;
    for (const double s : {0.05, 0.07, 0.10, 0.12, 0.15, 0.20}) {
        list.push_back({fmt::format("normal, {:g} %", 100.0 * s), 1.0,
                        [s](std::mt19937_64& random) { return 1.0 + s * std::normal_distribution<double>()(random); }});
        const double sigma = std::sqrt(std::log(1.0 + s * s));
        list.push_back({fmt::format("log-normal, {:g} %", 100.0 * s), 1.0, [sigma](std::mt19937_64& random) {
                            return std::exp(sigma * std::normal_distribution<double>()(random) - 0.5 * sigma * sigma);
                        }});
    }
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
            long rule = 0, plain = 0, next = 0;
            std::size_t packings = 0;
            for (const Outcome& one : outcomes) {
                rule += one.rule ? 1 : 0;
                plain += one.plain ? 1 : 0;
                next += one.next ? 1 : 0;
                packings += one.packings;
            }
            const auto share = [](auto count) { return static_cast<double>(count) / static_cast<double>(sequences); };
            rows.push_back({{"scatter", scatter.name},
                            {"wanted", wanted},
                            {"covered", share(rule)},
                            {"covered_by_plain_t", share(plain)},
                            {"next_covered", share(next)},
                            {"mean_number_of_packings", share(packings)}});
        }
    return {{"sequences", sequences}, {"rows", rows}};
}

}  // namespace porepack::benchmarks
