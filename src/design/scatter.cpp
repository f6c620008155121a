#include "design/scatter.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>

#include "uncertainty/sample.hpp"

namespace porepack::design {
namespace {

// Of three packings, for which d0 / (d0 + 2) is the weight of s0^2.
constexpr double usual_freedom = 2.0;
// Nodes of the sums over d0 / (d0 + 2) and ln s0. s0 has a standard error of 10 % or more for up to a hundred beds of three packings:
// steps of 0.1 resolve that. The range is for few beds: with a single one of two packings, deviations up to exp(7) times its own matter.
constexpr int weight_nodes = 16;
constexpr double log_step = 0.1, log_low = -5.0, log_high = 7.0;
constexpr double smallest_weight = 1e-6;  // of a node, over that of the likeliest
constexpr double outside = 0.05;          // of an interval of 95 %

// In double precision throughout: twice as fast.
using StudentsT = boost::math::students_t_distribution<double, boost::math::policies::policy<boost::math::policies::promote_double<false>>>;

double freedom_of(const BedScatter& bed) {
    return static_cast<double>(bed.packings - 1);
}

double pooled_variance(const std::vector<BedScatter>& beds) {
    double squares = 0.0, freedom = 0.0;
    for (const BedScatter& bed : beds) {
        squares += freedom_of(bed) * bed.deviation * bed.deviation;
        freedom += freedom_of(bed);
    }
    return freedom > 0.0 ? squares / freedom : 0.0;
}

// ln of the probability density of the beds' s^2 (each s^2/s0^2 has an F distribution), without the factors that hold neither d0 nor s0.
// Packings that are exactly equal are no sample of a scatter; their density would have no bound.
double log_likelihood(const std::vector<BedScatter>& beds, double d0, double variance) {
    double sum = 0.0;
    for (const BedScatter& bed : beds) {
        const double d = freedom_of(bed);
        if (d > 0.0 && bed.deviation > 0.0)
            sum += std::lgamma(0.5 * (d0 + d)) - std::lgamma(0.5 * d0) + 0.5 * d0 * std::log(d0 * variance) -
                   0.5 * (d0 + d) * std::log(d0 * variance + d * bed.deviation * bed.deviation);
    }
    return sum;
}

}  // namespace

ScatterOfBeds::ScatterOfBeds(const std::vector<BedScatter>& beds) {
    const double pooled = pooled_variance(beds);
    if (pooled == 0.0) return;
    const int log_nodes = static_cast<int>(std::lround((log_high - log_low) / log_step));
    double likeliest = -HUGE_VAL;
    for (int i = 0; i < weight_nodes; ++i)
        for (int j = 0; j <= log_nodes; ++j) {
            const double w = (i + 0.5) / weight_nodes, d0 = usual_freedom * w / (1.0 - w);
            const double variance = pooled * std::exp(2.0 * (log_low + log_step * j));
            nodes_.push_back({d0, variance, log_likelihood(beds, d0, variance)});
            likeliest = std::max(likeliest, nodes_.back().weight);
        }
    double sum = 0.0;
    for (Node& node : nodes_) node.weight = std::exp(node.weight - likeliest);
    std::erase_if(nodes_, [](const Node& node) { return node.weight < smallest_weight; });
    for (const Node& node : nodes_) sum += node.weight;
    for (Node& node : nodes_) node.weight /= sum;
}

double ScatterOfBeds::chance_beyond(const BedScatter& bed, double distance) const {
    const double d = freedom_of(bed), squares = d * bed.deviation * bed.deviation;
    double chance = 0.0;
    for (const Node& node : nodes_) {
        const double freedom = node.freedom + d;
        const double error = std::sqrt((node.freedom * node.variance + squares) / freedom / static_cast<double>(bed.packings));
        chance += 2.0 * node.weight * boost::math::cdf(boost::math::complement(StudentsT(freedom), distance / error));
    }
    return chance;
}

double ScatterOfBeds::half_width(const BedScatter& bed) const {
    const double error = 1.0 / std::sqrt(static_cast<double>(bed.packings));
    if (nodes_.empty()) return uncertainty::students_t(freedom_of(bed)) * bed.deviation * error;
    std::uintmax_t steps = 100;
    const auto [low, high] = boost::math::tools::bracket_and_solve_root(
        [&](double distance) { return chance_beyond(bed, distance) - outside; }, 2.0 * error * std::max(bed.deviation, *typical()), 2.0,
        false, boost::math::tools::eps_tolerance<double>(30), steps);
    return 0.5 * (low + high);
}

std::optional<double> ScatterOfBeds::typical() const {
    if (nodes_.empty()) return std::nullopt;
    double log_variance = 0.0;
    for (const Node& node : nodes_) log_variance += node.weight * std::log(node.variance);
    return std::exp(0.5 * log_variance);
}

std::optional<double> ScatterOfBeds::common_weight() const {
    if (nodes_.empty()) return std::nullopt;
    double weight = 0.0;
    for (const Node& node : nodes_) weight += node.weight * node.freedom / (node.freedom + usual_freedom);
    return weight;
}

}  // namespace porepack::design
