#include "lbm/mean_flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "lbm/solver.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm {
namespace {

constexpr double samples_per_turnover = 10.0, turnovers_of_start = 20.0, fastest_possible_lu = 0.577;  // the speed of sound

struct Moment {
    double mean = 0.0, variance = 0.0;
};
Moment moment_of(std::span<const double> samples) {
    Moment moment;
    const auto n = static_cast<double>(samples.size());
    moment.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / n;
    for (const double x : samples) moment.variance += (x - moment.mean) * (x - moment.mean) / std::max(1.0, n - 1.0);
    return moment;
}

// Number of samples from whose end on the mean has the smallest standard error, in steps of a hundredth.
std::size_t beginning_of(std::span<const double> samples) {
    std::size_t best = 0;
    double minimum = std::numeric_limits<double>::max();
    const std::size_t step = std::max<std::size_t>(1, samples.size() / 100);
    for (std::size_t left_out = 0; 2 * left_out <= samples.size(); left_out += step) {
        const auto rest = samples.subspan(left_out);
        const double error = moment_of(rest).variance / static_cast<double>(rest.size());
        if (error < minimum) {
            minimum = error;
            best = left_out;
        }
    }
    return best;
}

double correlation_of(std::span<const double> samples, const Moment& moment) {
    double sum = 1.0;
    const std::size_t n = samples.size();
    for (std::size_t lag = 1; 2 * lag < n && static_cast<double>(lag) < 5.0 * std::max(1.0, sum); ++lag) {
        double product = 0.0;
        for (std::size_t i = 0; i + lag < n; ++i) product += (samples[i] - moment.mean) * (samples[i + lag] - moment.mean);
        sum += 2.0 * product / (static_cast<double>(n) * moment.variance);
    }
    return std::max(1.0, sum);
}

// Two-sided 95 % quantile of Student's t: Abramowitz & Stegun 26.7.5; 3 % too small for 2 degrees of freedom, 0.1 % for 9.
double students_t(double freedom) {
    constexpr double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z;
    return z + ((z3 + z) / 4.0 +
                ((5.0 * z5 + 16.0 * z3 + 3.0 * z) / 96.0 + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / 384.0 / freedom) / freedom) /
                   freedom;
}

bool is_steady(std::span<const double> samples, double change) {
    const auto window = static_cast<std::size_t>(10.0 * samples_per_turnover);
    if (samples.size() < window) return false;
    const auto last = samples.last(window);
    const auto [low, high] = std::minmax_element(last.begin(), last.end());
    return *high - *low < change * std::abs(last.back());
}

// The samples of a flow, and when they are enough.
class Record {
public:
    Record(const MeanFlowCriterion& criterion, double per_turnover)
        : criterion_(criterion), per_turnover_(per_turnover), next_look_(criterion.min_turnovers) {}

    void add(const FlowSums& sample, std::size_t axis, double velocity) {
        fastest_ = std::max(fastest_, sample.fastest);
        velocity_.push_back(velocity);
        energy_.push_back(sample.squares * sample.nodes / (sample.along * sample.along));
        lateral_.push_back(std::hypot(sample.velocity[(axis + 1) % 3], sample.velocity[(axis + 2) % 3]) / sample.along);
        steady_ = turnovers() > turnovers_of_start && is_steady(velocity_, criterion_.steady_change);
        if (steady_ || turnovers() >= std::min(next_look_, criterion_.max_turnovers)) {
            series_ = mean_of_series(velocity_);
            next_look_ = 1.1 * turnovers();
        }
    }
    [[nodiscard]] bool ended() const { return converged() || turnovers() >= criterion_.max_turnovers; }
    [[nodiscard]] long samples() const { return static_cast<long>(velocity_.size()); }
    [[nodiscard]] double last() const { return velocity_.back(); }
    [[nodiscard]] double turnovers() const { return static_cast<double>(velocity_.size()) / per_turnover_; }
    // Estimate from the half width so far, which falls with the square root of time.
    [[nodiscard]] double turnovers_needed() const {
        double needed = criterion_.max_turnovers;
        if (std::isfinite(series_.half_width) && series_.mean > 0.0)
            needed = std::min(needed, turnovers() * std::pow(series_.half_width / (criterion_.tolerance * series_.mean), 2.0));
        return std::max({needed, criterion_.min_turnovers, turnovers()});
    }
    [[nodiscard]] MeanFlow mean() const {
        const std::size_t from = steady_ ? velocity_.size() - 1 : series_.discarded;
        const auto mean_from = [&](const std::vector<double>& values) {
            return std::accumulate(values.begin() + static_cast<std::ptrdiff_t>(from), values.end(), 0.0) /
                   static_cast<double>(values.size() - from);
        };
        return {.superficial_velocity_lu = mean_from(velocity_),
                .half_width = steady_ ? criterion_.steady_change : series_.half_width / series_.mean,
                .fluctuation = steady_ ? 0.0 : series_.deviation / series_.mean,
                .kinetic_energy_factor = mean_from(energy_),
                .lateral_share = mean_from(lateral_),
                .correlation_turnovers = series_.correlation / per_turnover_,
                .fastest_lu = fastest_,
                .steady = steady_,
                .converged = converged(),
                .turnovers = turnovers(),
                .velocity_lu = velocity_};
    }

private:
    [[nodiscard]] bool converged() const {
        return steady_ || (series_.independent >= 10.0 && series_.half_width < criterion_.tolerance * std::abs(series_.mean));
    }

    MeanFlowCriterion criterion_;
    double per_turnover_, next_look_;
    std::vector<double> velocity_, energy_, lateral_;
    SeriesMean series_{.half_width = std::numeric_limits<double>::infinity()};
    double fastest_ = 0.0;
    bool steady_ = false;
};

}  // namespace

SeriesMean mean_of_series(std::span<const double> samples) {
    SeriesMean result{.half_width = std::numeric_limits<double>::infinity()};
    if (samples.empty()) return result;
    result.discarded = beginning_of(samples);
    const auto rest = samples.subspan(result.discarded);
    const Moment moment = moment_of(rest);
    result.mean = moment.mean;
    result.deviation = std::sqrt(moment.variance);
    result.correlation = moment.variance > 0.0 ? correlation_of(rest, moment) : 1.0;
    result.independent = static_cast<double>(rest.size()) / result.correlation;
    if (result.independent >= 3.0) {
        result.half_width = students_t(result.independent - 1.0) * result.deviation / std::sqrt(result.independent);
    }
    return result;
}

MeanFlow average_in_time(Flow& flow, const Domain& domain, double area_cells, const MeanFlowCriterion& criterion) {
    const long apart = std::max(2L, 2 * std::lround(0.5 * criterion.turnover_steps / samples_per_turnover));
    const auto layers = static_cast<double>(domain.layers());
    const double all_nodes = static_cast<double>(domain.all_nodes);
    const auto axis = static_cast<std::size_t>(domain.drive.axis);
    std::vector<double> added(domain.layers());
    const Stopwatch watch;
    Progress line("lattice Boltzmann, mean in time");
    Record record(criterion, criterion.turnover_steps / static_cast<double>(apart));
    const bool alone = domain.slabs->parts() == 1;
    while (!record.ended()) {
        for (long step = 0; step < apart && !(alone && interrupted()); step += 2) flow.advance_two_steps();
        if (any_of(*domain.slabs, interrupted())) throw Interrupted();
        const FlowSums sample = flow.sums(domain, 0, static_cast<int>(domain.layers()) - 1);
        if (!(sample.fastest < fastest_possible_lu))  // NaN too
            throw FlowDiverged(fmt::format("the flow diverged within {} steps", apart * (record.samples() + 1)),
                               {.fix = "use smaller voxels, or a more stable collision"});
        std::fill(added.begin(), added.end(), -sample.density / all_nodes);
        flow.add_to_layers(domain, added);
        record.add(sample, axis, sample.along / (area_cells * layers));
        line.update(std::min(0.99, record.turnovers() / record.turnovers_needed()),
                    fmt::format("turnover {:.1f}, velocity {:.4g}", record.turnovers(), record.last()));
    }
    MeanFlow mean = record.mean();
    mean.steps = apart * record.samples();
    mean.seconds = watch.seconds();
    return mean;
}

}  // namespace porepack::lbm
