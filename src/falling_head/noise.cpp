#include "falling_head/noise.hpp"

#include <boost/math/distributions/students_t.hpp>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace porepack::falling_head {
namespace {

using Eigen::Index, Eigen::Matrix2d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::VectorXd;

// In double precision: the tail of each of the models' distributions is computed many times.
using StudentsT = boost::math::students_t_distribution<double, boost::math::policies::policy<boost::math::policies::promote_double<false>>>;

constexpr Index max_means = 128;  // of a curve
constexpr double white_prior = 0.75, slow_part = 0.25, minimum_deviation_m = 1e-8;
constexpr int correlation_times = 7;
constexpr std::array<double, 8> correlated_parts = {0.03, 0.1, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0};  // of the variance

// Means of groups of points.
struct Means {
    MatrixXd jacobian, estimator;  // the latter: sums
    VectorXd residuals;
    struct Curve {
        Index first = 0;
        VectorXd time_s, white;  // white: variance of white noise, relative to that of a mean of the usual number of points
    };
    std::vector<Curve> curves;
    Index priors = 0;
    double max_processor_seconds = 0.0, shortest_s = 0.0, usual_size = 1.0;
};

Means means_of(const LinearisedFit& fit, const MatrixXd& estimator) {
    Means means;
    Index rows = 0, points = 0;
    for (const auto& times : fit.times_s) {
        const auto count = static_cast<Index>(times.size()), groups = std::min(count, max_means);
        const double length_s = times.back() - times.front();
        if (length_s > means.max_processor_seconds) means.shortest_s = length_s / static_cast<double>(groups);
        means.max_processor_seconds = std::max(means.max_processor_seconds, length_s);
        means.curves.push_back({rows, VectorXd(groups), VectorXd(groups)});
        points += count;
        rows += groups;
    }
    means.usual_size = static_cast<double>(points) / static_cast<double>(rows);
    means.priors = fit.residuals.size() - points;
    means.jacobian.resize(rows + means.priors, fit.jacobian.cols());
    means.estimator.resize(rows + means.priors, estimator.cols());
    means.residuals.resize(rows + means.priors);
    Index point = 0;
    for (std::size_t c = 0; c < means.curves.size(); ++c) {
        Means::Curve& curve = means.curves[c];
        const Index groups = curve.time_s.size(), count = static_cast<Index>(fit.times_s[c].size());
        for (Index i = 0; i < groups; ++i) {
            const Index from = i * count / groups, size = (i + 1) * count / groups - from, row = curve.first + i;
            curve.time_s[i] = Eigen::Map<const VectorXd>(fit.times_s[c].data() + from, size).mean();
            curve.white[i] = means.usual_size / static_cast<double>(size);
            means.jacobian.row(row) = fit.jacobian.middleRows(point + from, size).colwise().mean();
            means.residuals[row] = fit.residuals.segment(point + from, size).mean();
            means.estimator.row(row) = estimator.middleRows(point + from, size).colwise().sum();
        }
        point += count;
    }
    means.jacobian.bottomRows(means.priors) = fit.jacobian.bottomRows(means.priors);
    means.residuals.tail(means.priors) = fit.residuals.tail(means.priors);
    means.estimator.bottomRows(means.priors) = estimator.bottomRows(means.priors);
    return means;
}

enum class Shape { exponential, smooth };

// From each mean of a curve to the next. A state is the correlated noise and, where it is smooth, its scaled rate; both have variance 1.
// Both correlations belong to Markov processes: exp(-lag), and (1 + x) exp(-x) with x = 2 lag for the smooth one, whose state includes its
// rate. A filter along the curve then replaces the factorisation of the full covariance matrix: the cost is linear in the number of points.
using Transitions = std::vector<Matrix2d>;

Transitions transitions(const Means::Curve& curve, Shape shape, double time_s) {
    Transitions steps;
    for (Index i = 1; i < curve.time_s.size(); ++i) {
        const double lag = (curve.time_s[i] - curve.time_s[i - 1]) / time_s, x = 2.0 * lag;
        Matrix2d& step = steps.emplace_back(Matrix2d::Zero());
        if (shape == Shape::exponential)
            step(0, 0) = std::exp(-lag);
        else
            step = (Matrix2d() << 1.0 + x, x, -x, 1.0 - x).finished() * std::exp(-x);
    }
    return steps;
}

// A model of the noise; its weight is its probability given the residuals.
struct Model {
    double time_s = 0.0, correlated = 0.0, prior = white_prior;
    double log_likelihood = 0.0, weight = 0.0;
    VectorXd variance;  // of the noise in each parameter
};

// Kalman filter: turns the rows of a curve into independent ones of variance 1. Returns half of the logarithm of the covariance's
// determinant.
double whiten(Eigen::Ref<MatrixXd> rows, const Means::Curve& curve, const Transitions& steps, double correlated) {
    Eigen::Matrix<double, 2, Eigen::Dynamic> state = Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, rows.cols());
    Matrix2d spread = correlated * Matrix2d::Identity();
    double half_logarithm = 0.0;
    for (Index i = 0; i < rows.rows(); ++i) {
        if (i > 0) {
            const Matrix2d& step = steps[static_cast<std::size_t>(i) - 1];
            state = step * state;
            // The process is stationary: without data the spread returns to `correlated` times the identity.
            spread = step * (spread - correlated * Matrix2d::Identity()) * step.transpose() + correlated * Matrix2d::Identity();
        }
        const double variance = spread(0, 0) + (1.0 - correlated) * curve.white[i] + 1e-9;  // smooth noise alone: nearly singular
        const Vector2d gain = spread.col(0) / variance;
        rows.row(i) -= state.row(0);
        state += gain * rows.row(i);
        spread -= variance * gain * gain.transpose();
        rows.row(i) /= std::sqrt(variance);
        half_logarithm += 0.5 * std::log(variance);
    }
    return half_logarithm;
}

// Variance of the weighted sum of the means of a curve.
double variance_of_sum(const Eigen::Ref<const VectorXd>& weights, const Means::Curve& curve, const Transitions& steps, double correlated) {
    Vector2d before = Vector2d::Zero();  // covariance of the state with the sum of all earlier terms
    double sum = 0.0;
    for (Index i = 0; i < weights.size(); ++i) {
        if (i > 0) before = steps[static_cast<std::size_t>(i) - 1] * (before + weights[i - 1] * Vector2d::UnitX());
        sum += weights[i] * (weights[i] * (correlated + (1.0 - correlated) * curve.white[i]) + 2.0 * correlated * before[0]);
    }
    return sum;
}

// `basis` spans the columns of the Jacobian of the means; there are transitions for each curve.
void judge(Model& model, const std::vector<Transitions>& steps, const Means& means, const MatrixXd& basis, double freedom) {
    // Restricted likelihood: with whitened rows, generalised least squares becomes ordinary. The logarithms of the determinants of the
    // covariance and of the normal matrix enter, and the variance is profiled out. The fit itself stays as it is; the model tells how large
    // its error is.
    MatrixXd rows(basis.rows(), basis.cols() + 1);
    rows << basis, means.residuals;
    double half_logarithm = 0.0;
    model.variance = VectorXd::Zero(means.estimator.cols());
    for (std::size_t c = 0; c < means.curves.size(); ++c) {
        const Means::Curve& curve = means.curves[c];
        const Index n = curve.time_s.size();
        half_logarithm += whiten(rows.middleRows(curve.first, n), curve, steps[c], model.correlated);
        for (Index p = 0; p < model.variance.size(); ++p)
            model.variance[p] += variance_of_sum(means.estimator.col(p).segment(curve.first, n), curve, steps[c], model.correlated);
    }
    const auto white_basis = rows.leftCols(basis.cols());
    const auto white = rows.col(basis.cols());
    const Eigen::LLT<MatrixXd> normal(white_basis.transpose() * white_basis);
    half_logarithm += normal.matrixLLT().diagonal().array().log().sum();
    const VectorXd explained = normal.matrixL().solve(white_basis.transpose() * white);
    const double minimum = freedom * minimum_deviation_m * minimum_deviation_m / means.usual_size;
    const double squares = std::max(minimum, white.squaredNorm() - explained.squaredNorm());
    model.log_likelihood = std::log(model.prior) - half_logarithm - 0.5 * freedom * std::log(squares);
    model.variance *= squares / freedom;
}

// The times are a geometric series: equal probabilities of all times give each the weight of its own length.
std::vector<Model> judged_models(const Means& means, const MatrixXd& basis, double freedom) {
    std::vector<Model> models(1);
    const auto steps_of = [&](Shape shape, double time_s) {
        std::vector<Transitions> steps;
        for (const Means::Curve& curve : means.curves) steps.push_back(transitions(curve, shape, time_s));
        return steps;
    };
    // The first model is white: its correlated part is zero, and the transitions have no effect.
    judge(models[0], steps_of(Shape::exponential, means.shortest_s), means, basis, freedom);
    std::vector<double> times;
    for (int i = 0; i < correlation_times; ++i)
        times.push_back(means.shortest_s * std::pow(means.max_processor_seconds / means.shortest_s, i / (correlation_times - 1.0)));
    const double sum = std::accumulate(times.begin(), times.end(), 0.0) * 2.0 * static_cast<double>(correlated_parts.size());
    for (const Shape shape : {Shape::exponential, Shape::smooth})
        for (const double time : times) {
            const std::vector<Transitions> steps = steps_of(shape, time);
            for (const double part : correlated_parts) {
                models.push_back({.time_s = time, .correlated = part, .prior = (1.0 - white_prior) * time / sum});
                judge(models.back(), steps, means, basis, freedom);
            }
        }
    double best = models[0].log_likelihood, total = 0.0;
    for (const Model& model : models) best = std::max(best, model.log_likelihood);
    for (Model& model : models) total += model.weight = std::exp(model.log_likelihood - best);
    for (Model& model : models) model.weight /= total;
    return models;
}

// Of the 95 % interval of a sum of Student's t distributions about zero.
template <typename Variance>
double half_width(const std::vector<Model>& models, double freedom, const Variance& variance) {
    const StudentsT t(freedom);
    double widest = 0.0;
    for (const Model& model : models) widest = std::max(widest, std::sqrt(variance(model)));
    // Bisection: the widest of the distributions bounds the width of the weighted sum.
    double low = 0.0, high = widest * boost::math::quantile(t, 0.975);
    while (high - low > 1e-4 * high) {
        const double middle = 0.5 * (low + high);
        double outside = 0.0;
        for (const Model& model : models)
            if (model.weight > 1e-6) outside += model.weight * boost::math::cdf(complement(t, middle / std::sqrt(variance(model))));
        (outside > 0.025 ? low : high) = middle;
    }
    return high;
}

// A prior's row counts like a mean: its error is as large.
void scale_priors(Means& means, double prior_deviation) {
    if (means.priors == 0) return;
    const Index noisy = means.residuals.size() - means.priors;
    const double mean_deviation = std::max(minimum_deviation_m, means.residuals.head(noisy).norm() / std::sqrt(static_cast<double>(noisy)));
    means.jacobian.bottomRows(means.priors) *= mean_deviation / prior_deviation;
    means.residuals.tail(means.priors) *= mean_deviation / prior_deviation;
}

// Those with a correlation time above a quarter of the longest curve, given that one of them is true.
std::vector<Model> slow_only(std::vector<Model> models, double max_processor_seconds) {
    std::erase_if(models, [&](const Model& model) { return model.time_s <= slow_part * max_processor_seconds; });
    double sum = 0.0;
    for (const Model& model : models) sum += model.weight;
    for (Model& model : models) model.weight /= std::max(1e-300, sum);
    return models;
}

}  // namespace

NoiseJudgement judge_noise(const LinearisedFit& fit, Index parameters) {
    // A start speed that decays immediately gives a column of zeros.
    const MatrixXd inverse = (fit.jacobian.transpose() * fit.jacobian).completeOrthogonalDecomposition().pseudoInverse();
    // Column p of the estimator holds the weights with which the rows enter parameter p; those of the points of a group are summed.
    const MatrixXd estimator = fit.jacobian * inverse.leftCols(parameters);
    Means means = means_of(fit, estimator);
    scale_priors(means, fit.prior_deviation);
    const Eigen::ColPivHouseholderQR<MatrixXd> factors(means.jacobian);
    // An orthonormal basis of the columns: parameters without effect drop out, and units do not matter.
    const MatrixXd basis = factors.householderQ() * MatrixXd::Identity(means.jacobian.rows(), factors.rank());
    const auto freedom = static_cast<double>(means.jacobian.rows() - factors.rank());
    const std::vector<Model> models = judged_models(means, basis, freedom), slow = slow_only(models, means.max_processor_seconds);

    const Index points = fit.residuals.size() - means.priors;
    const auto points_freedom = static_cast<double>(fit.residuals.size() - factors.rank());
    const double white_m = std::max(minimum_deviation_m, fit.residuals.head(points).norm() / std::sqrt(points_freedom)) *
                           boost::math::quantile(StudentsT(points_freedom), 0.975);
    NoiseJudgement judgement{.widths = {}, .white_probability = models[0].weight};
    for (const Model& model : models)
        if (model.time_s > slow_part * means.max_processor_seconds) judgement.slow_probability += model.weight;
    for (Index p = 0; p < parameters; ++p) {
        const double prior = std::pow(fit.prior_deviation, 2) * estimator.col(p).tail(means.priors).squaredNorm();
        const auto noise = [&](const Model& model) { return model.variance[p]; };
        const auto both = [&](const Model& model) { return noise(model) + prior; };
        judgement.widths.push_back({.value = half_width(models, freedom, both),
                                    .if_slow = half_width(slow, freedom, both),
                                    .widening = half_width(models, freedom, noise) / (white_m * estimator.col(p).head(points).norm())});
    }
    return judgement;
}

}  // namespace porepack::falling_head
