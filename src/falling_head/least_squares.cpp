#include "falling_head/least_squares.hpp"

#include <fmt/format.h>
#include <Eigen/Core>
#include <unsupported/Eigen/NonLinearOptimization>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "falling_head/noise.hpp"

namespace porepack::falling_head {
namespace {

// Parameters: 1/k, 1/k_in, deviations of what is uncertain, then first level and first speed of each curve. All scaled to order one or to
// metres.
constexpr Eigen::Index viscous = 0, inertial = 1, offset = 2, scale = 3, viscosity = 4, coefficient = 5, exponent = 6, first_curve = 7;

// Standard deviations of the uncertain parameters; 0: known.
std::array<double, first_curve> uncertainties(const FallingHeadConfig& c) {
    return {0.0,
            0.0,
            c.level_offset_uncertainty_m,
            c.scale_uncertainty,
            c.viscosity_uncertainty,
            c.column_inertia ? c.inertia_coefficient_uncertainty : 0.0,
            c.inertial_exponent_uncertainty};
}

constexpr std::size_t max_points = 5000;  // of a curve in the fit

// Means of groups of consecutive frames, for long curves: their information is the same, and within a group the level is a straight line.
LevelCurve averaged(const LevelCurve& curve) {
    const std::size_t frames = curve.time_s.size(), group = (frames + max_points - 1) / max_points;
    if (group == 1) return curve;
    LevelCurve means{.name = curve.name, .packing = curve.packing, .time_s = {}, .level_m = {}};
    for (std::size_t first = 0; first + group <= frames; first += group) {
        const auto mean_of = [&](const std::vector<double>& values) {
            const auto from = values.begin() + static_cast<std::ptrdiff_t>(first);
            return std::accumulate(from, from + static_cast<std::ptrdiff_t>(group), 0.0) / static_cast<double>(group);
        };
        means.time_s.push_back(mean_of(curve.time_s));
        means.level_m.push_back(mean_of(curve.level_m));
    }
    return means;
}

class Problem {
public:
    Problem(std::span<const LevelCurve> curves, const FallingHeadConfig& config)
        : curves_(curves), given_(config), uncertainty_(uncertainties(config)) {
        const Column check(config);  // before anything else: messages about the configuration
        double head = 0.0, speed = 0.0, noise = 0.0;
        for (const LevelCurve& curve : curves) {
            const double drop = curve.level_m.front() - curve.level_m.back();
            head += config.gravity_m_per_s2 * (0.5 * (curve.level_m.front() + curve.level_m.back()) + config.sample_length_m) /
                    static_cast<double>(curves.size());
            speed += drop / (curve.time_s.back() - curve.time_s.front()) / static_cast<double>(curves.size());
            noise += noise_of(curve) / static_cast<double>(curves.size());
            first_row_.push_back(rows_);
            rows_ += static_cast<Eigen::Index>(curve.time_s.size());
        }
        noise_ = weight_ = noise;
        points_ = rows_;
        // Units of the resistances: those that alone would need the whole head at the mean speed. The fit starts with shares of 0.2 and
        // 0.8.
        viscous_unit_ = head / (config.sample_length_m * config.kinematic_viscosity_m2_per_s * speed);
        inertial_unit_ = head / (config.sample_length_m * speed * speed);
        at_.resize(first_curve + 2 * static_cast<Eigen::Index>(curves.size()));
        at_[viscous] = 0.2;
        at_[inertial] = 0.8;
        for (Eigen::Index p = offset; p < first_curve; ++p) at_[p] = 0.0;
        for (std::size_t c = 0; c < curves.size(); ++c) {
            const LevelCurve& curve = curves[c];
            const std::size_t near = std::min<std::size_t>(curve.time_s.size() - 1, std::max<std::size_t>(2, curve.time_s.size() / 10));
            at_[level_of(c)] = curve.level_m.front();
            at_[level_of(c) + 1] =
                std::max(0.1 * speed, (curve.level_m.front() - curve.level_m[near]) / (curve.time_s[near] - curve.time_s.front()));
        }
        free_ = {viscous, inertial};
        constexpr double negligible = 1e-12;  // metres, or relative
        for (Eigen::Index p = offset; p < first_curve; ++p)
            if (uncertainty_[static_cast<std::size_t>(p)] > negligible) {
                ++rows_;
                free_.push_back(p);
                uncertain_.push_back(p);
            }
        for (std::size_t c = 0; c < curves.size(); ++c) {
            free_.push_back(level_of(c));
            if (config.column_inertia) free_.push_back(level_of(c) + 1);
        }
        if (points_ <= static_cast<Eigen::Index>(free_.size()))
            throw NumericalError(fmt::format("{} points are too few for {} unknowns", points_, free_.size()),
                                 {.fix = "record more frames, or widen window_m"});
    }

    // Interface required by Eigen's Levenberg-Marquardt.
    using Scalar = double;
    using InputType = Eigen::VectorXd;
    using ValueType = Eigen::VectorXd;
    using JacobianType = Eigen::MatrixXd;
    [[nodiscard]] int values() const { return static_cast<int>(rows_); }
    [[nodiscard]] int inputs() const { return static_cast<int>(free_.size()); }
    // A prior is one more row of the sum of squares: the deviation over its uncertainty, in units of the residuals' standard deviation.
    int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& residuals) {
        set(x);
        for (std::size_t c = 0; c < curves_.size(); ++c) fill(c, residuals);
        for (std::size_t u = 0; u < uncertain_.size(); ++u) residuals[prior_row(u)] = prior(uncertain_[u]) * at_[uncertain_[u]];
        return 0;
    }
    int df(const Eigen::VectorXd& x, Eigen::MatrixXd& jacobian) {
        set(x);
        jacobian.setZero();
        // Central differences; the start values of a curve change only its own rows.
        Eigen::VectorXd up(rows_), down(rows_);
        for (std::size_t j = 0; j < free_.size(); ++j) {
            const Eigen::Index p = free_[j];
            const double step = p == viscous || p == inertial ? 1e-3 : p >= first_curve && (p - first_curve) % 2 == 1 ? 1e-3 : 1e-4;
            const double here = at_[p];
            for (std::size_t c = 0; c < curves_.size(); ++c) {
                if (p >= first_curve && (p - first_curve) / 2 != static_cast<Eigen::Index>(c)) continue;
                at_[p] = here + step;
                fill(c, up);
                at_[p] = here - step;
                fill(c, down);
                at_[p] = here;
                const Eigen::Index first = first_row_[c], count = static_cast<Eigen::Index>(curves_[c].time_s.size());
                jacobian.col(static_cast<Eigen::Index>(j)).segment(first, count) = (up - down).segment(first, count) / (2.0 * step);
            }
            for (std::size_t u = 0; u < uncertain_.size(); ++u)
                if (uncertain_[u] == p) jacobian(prior_row(u), static_cast<Eigen::Index>(j)) = prior(p);
        }
        return 0;
    }

    // Fits the free parameters from their present values; returns the sum of squares.
    double solve() {
        Eigen::VectorXd x = get();
        Eigen::LevenbergMarquardt<Problem> method(*this);
        method.parameters.ftol = method.parameters.xtol = 1e-11;
        method.parameters.maxfev = 200;
        method.minimize(x);
        Eigen::VectorXd residuals(rows_);
        (*this)(x, residuals);
        return residuals.squaredNorm();
    }

    // Weighs the uncertain parameters against residuals of this standard deviation. False if there are none, or nothing changes.
    bool weigh(double residual_m) {
        if (uncertain_.empty() || residual_m <= noise_) return false;
        weight_ = residual_m;
        return true;
    }

    // Of the residuals of neighbouring frames, all curves together.
    [[nodiscard]] double residual_correlation(const LinearisedFit& fit) const {
        double products = 0.0, squares = 0.0;
        for (std::size_t c = 0; c < curves_.size(); ++c) {
            const auto part = fit.residuals.segment(first_row_[c], static_cast<Eigen::Index>(curves_[c].time_s.size()));
            products += part.head(part.size() - 1).dot(part.tail(part.size() - 1));
            squares += part.squaredNorm();
        }
        return squares > 0.0 ? products / squares : 0.0;
    }

    [[nodiscard]] LinearisedFit linearised() {
        LinearisedFit fit{.jacobian = Eigen::MatrixXd(rows_, static_cast<Eigen::Index>(free_.size())),
                          .residuals = Eigen::VectorXd(rows_),
                          .times_s = {},
                          .prior_deviation = weight_};
        df(get(), fit.jacobian);
        (*this)(get(), fit.residuals);
        for (const LevelCurve& curve : curves_) fit.times_s.push_back(curve.time_s);
        return fit;
    }

    // Resistances are scaled to the head that they need: beyond this number of heads there is no bound.
    static constexpr double farthest = 1000.0;

    // The bound of parameter p on the side `sign` where the sum of squares is higher by `rise`; `width` is the linear estimate. Infinite if
    // it is not found.
    // Profile likelihood: p is held at a distance from its best value, all others are fitted again, and the secant method finds the
    // distance at which the sum of squares has risen by `rise`. The linear estimate is the first trial; the bound also holds where the
    // problem is not linear.
    double bound(Eigen::Index p, double sign, double minimum, double rise, double width) {
        const Eigen::VectorXd best = at_;
        const std::vector<Eigen::Index> all = free_;
        std::erase(free_, p);
        const auto excess = [&](double distance) {
            at_[p] = best[p] + sign * distance;
            return std::sqrt(std::max(0.0, solve() - minimum) / rise) - 1.0;
        };
        // sqrt of the increase is nearly linear in the distance, and zero at zero distance.
        double near = 0.0, at_near = -1.0, far = width, at_far = excess(far);
        for (int i = 0; i < 12 && std::abs(at_far) > 2e-3 && far < farthest; ++i) {
            double next = far - at_far * (far - near) / (at_far - at_near);
            next = std::clamp(next, 0.2 * far, 3.0 * far);
            near = far;
            at_near = at_far;
            far = next;
            at_far = excess(far);
            if (at_far == at_near) break;
        }
        free_ = all;
        at_ = best;
        return std::abs(at_far) < 0.05 && far < farthest ? best[p] + sign * far : sign * std::numeric_limits<double>::infinity();
    }

    // Of curve c at times that are not before its first.
    [[nodiscard]] std::vector<double> levels(std::size_t c, std::span<const double> times_s) {
        return Column(apparatus()).levels(resistance(), curves_[c].time_s.front(), at_[level_of(c)], at_[level_of(c) + 1], times_s);
    }
    [[nodiscard]] Resistance resistance() const { return {viscous_unit_ * at_[viscous], inertial_unit_ * at_[inertial]}; }
    [[nodiscard]] double unit(Eigen::Index p) const { return p == viscous ? viscous_unit_ : inertial_unit_; }
    [[nodiscard]] double at(Eigen::Index p) const { return at_[p]; }
    // The apparatus with the fitted values of what is uncertain.
    [[nodiscard]] FallingHeadConfig apparatus() const {
        FallingHeadConfig fitted = given_;
        fitted.level_offset_m += at_[offset];
        fitted.scale_error += std::clamp(at_[scale], -0.5, 0.5);
        fitted.kinematic_viscosity_m2_per_s *= std::exp(at_[viscosity]);
        fitted.inertia_coefficient = std::max(0.1, inertia_coefficient(given_) + at_[coefficient]);
        fitted.inertial_exponent = std::clamp(given_.inertial_exponent + at_[exponent], -1.0, 0.95);
        return fitted;
    }
    [[nodiscard]] double noise() const { return noise_; }
    [[nodiscard]] Eigen::Index points() const { return points_; }
    [[nodiscard]] Eigen::Index freedom() const { return rows_ - static_cast<Eigen::Index>(free_.size()); }

private:
    [[nodiscard]] double prior(Eigen::Index p) const { return weight_ / uncertainty_[static_cast<std::size_t>(p)]; }
    [[nodiscard]] Eigen::Index prior_row(std::size_t u) const {
        return rows_ - static_cast<Eigen::Index>(uncertain_.size()) + static_cast<Eigen::Index>(u);
    }
    static Eigen::Index level_of(std::size_t curve) { return first_curve + 2 * static_cast<Eigen::Index>(curve); }
    void set(const Eigen::VectorXd& x) {
        for (std::size_t j = 0; j < free_.size(); ++j) at_[free_[j]] = x[static_cast<Eigen::Index>(j)];
    }
    [[nodiscard]] Eigen::VectorXd get() const {
        Eigen::VectorXd x(static_cast<Eigen::Index>(free_.size()));
        for (std::size_t j = 0; j < free_.size(); ++j) x[static_cast<Eigen::Index>(j)] = at_[free_[j]];
        return x;
    }
    void fill(std::size_t c, Eigen::VectorXd& residuals) {
        check_interrupt();
        const LevelCurve& curve = curves_[c];
        const Eigen::Index first = first_row_[c];
        std::vector<double> model;
        try {
            model = levels(c, curve.time_s);
        } catch (const NumericalError&) {
            model.assign(curve.time_s.size(), 1e3);  // resistances for which the equation has no solution
        }
        for (std::size_t i = 0; i < model.size(); ++i) residuals[first + static_cast<Eigen::Index>(i)] = model[i] - curve.level_m[i];
    }

    std::span<const LevelCurve> curves_;
    FallingHeadConfig given_;
    std::array<double, first_curve> uncertainty_;
    double noise_ = 0.0, weight_ = 0.0, viscous_unit_ = 1.0, inertial_unit_ = 1.0;
    Eigen::VectorXd at_;
    std::vector<Eigen::Index> free_, uncertain_, first_row_;
    Eigen::Index rows_ = 0, points_ = 0;
};

}  // namespace

FallingHeadFit fit_falling_head(std::span<const LevelCurve> curves, const FallingHeadConfig& config) {
    std::vector<LevelCurve> fitted_curves;
    for (const LevelCurve& curve : curves) fitted_curves.push_back(averaged(curve));
    Problem problem(fitted_curves, config);
    // Priors are weighed against the residuals, whose size is known only after a fit, and their correlation only after another: hence up to
    // three fits.
    double minimum = problem.solve();
    const auto variance_of = [&] { return std::max(1e-16, minimum / static_cast<double>(problem.freedom())); };
    if (problem.weigh(std::sqrt(variance_of()))) minimum = problem.solve();
    LinearisedFit linear = problem.linearised();
    NoiseJudgement noise = judge_noise(linear, 2);
    const double variance = variance_of();
    if (!std::isfinite(minimum) || std::sqrt(variance) > 1.0)
        throw NumericalError("no falling-head equation is close to the data",
                             {.where = curves.front().name, .fix = "check the curve: units, jumps, a rising water level?"});
    // Correlated levels tell less, against the priors.
    if (problem.weigh(std::sqrt(variance) * noise.widths[viscous].widening)) {
        minimum = problem.solve();
        linear = problem.linearised();
        noise = judge_noise(linear, 2);
    }
    // A start speed that decays immediately gives a column of zeros.
    const Eigen::MatrixXd inverse = (linear.jacobian.transpose() * linear.jacobian).completeOrthogonalDecomposition().pseudoInverse();
    const FallingHeadConfig apparatus = problem.apparatus();
    FallingHeadFit fit{.correlation = inverse(0, 1) / std::sqrt(inverse(0, 0) * inverse(1, 1)),
                       .level_offset_m = apparatus.level_offset_m,
                       .scale_error = apparatus.scale_error,
                       .kinematic_viscosity_m2_per_s = apparatus.kinematic_viscosity_m2_per_s,
                       .inertia_coefficient = apparatus.inertia_coefficient,
                       .inertial_exponent = apparatus.inertial_exponent,
                       .residual_correlation = problem.residual_correlation(linear),
                       .widening = noise.widths[viscous].widening,
                       .slow_widening = noise.widths[viscous].if_slow / noise.widths[viscous].value,
                       .slow_probability = noise.slow_probability,
                       .white_probability = noise.white_probability,
                       .residual_m = std::sqrt(variance),
                       .noise_m = problem.noise(),
                       .points = static_cast<long>(problem.points()),
                       .levels_m = {}};
    const auto fitted = [&](Eigen::Index p) {
        // In a linear problem this rise lies at the distance `width`: the noise model gives the width, the profile its asymmetry.
        const double width = noise.widths[static_cast<std::size_t>(p)].value, rise = width * width / inverse(p, p);
        return FittedValue{problem.unit(p) * problem.at(p),
                           {problem.unit(p) * problem.bound(p, -1.0, minimum, rise, width),
                            problem.unit(p) * problem.bound(p, 1.0, minimum, rise, width)}};
    };
    fit.inverse_permeability_per_m2 = fitted(viscous);
    fit.inverse_inertial_permeability_per_m = fitted(inertial);
    // Averaged over the fall of the level, not over time: slow parts of the curve would dominate otherwise.
    double share = 0.0, weight = 0.0;
    for (std::size_t c = 0; c < curves.size(); ++c) {
        fit.levels_m.push_back(problem.levels(c, curves[c].time_s));
        const auto& level = fit.levels_m.back();
        const auto& time = curves[c].time_s;
        for (std::size_t i = 1; i < level.size(); ++i) {
            const double fall = level[i - 1] - level[i], speed = fall / (time[i] - time[i - 1]);
            share += fall * config.kinematic_viscosity_m2_per_s * fit.inverse_permeability_per_m2.value * speed * config.sample_length_m /
                     (config.gravity_m_per_s2 * (level[i] + fit.level_offset_m + config.sample_length_m));
            weight += fall;
        }
    }
    fit.viscous_share = share / weight;
    return fit;
}

std::optional<double> FallingHeadFit::permeability_m2() const {
    const double inverse = inverse_permeability_per_m2.value;
    return inverse > 0.0 ? std::optional(1.0 / inverse) : std::nullopt;
}

Interval FallingHeadFit::permeability_interval_m2() const {
    const auto& [low, high] = inverse_permeability_per_m2.interval;
    constexpr double infinite = std::numeric_limits<double>::infinity();
    return {high > 0.0 ? 1.0 / high : infinite, low > 0.0 ? 1.0 / low : infinite};
}

namespace {

std::string verdict_on(const FittedValue& fitted, const char* name, const char* unit) {
    const auto& [low, high] = fitted.interval;
    if (high <= 0.0)
        return fmt::format("no {} explains the data: 1/{} comes out negative; is the level off, or the sample's length?", name, name);
    if (low <= 0.0 && !std::isfinite(high)) return fmt::format("this test says nothing about {}", name);
    if (low <= 0.0) return fmt::format("this test bounds {} only from below: {} > {:.3g} {} (95 %)", name, name, 1.0 / high, unit);
    return fmt::format("{} = {:.4g} {} is determined to -{:.3g}/+{:.3g} % (95 %)", name, 1.0 / fitted.value, unit,
                       100.0 * (1.0 - fitted.value / high), 100.0 * (fitted.value / low - 1.0));
}

}  // namespace

std::string FallingHeadFit::verdict() const {
    return verdict_on(inverse_permeability_per_m2, "k", "m2");
}

std::string FallingHeadFit::inertial_verdict() const {
    return verdict_on(inverse_inertial_permeability_per_m, "k_in", "m");
}

}  // namespace porepack::falling_head
