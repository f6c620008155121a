#include "design/gaussian_process.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace porepack::design {
namespace {

constexpr Eigen::Index signal_place = 0, noise_place = 1, first_length = 2;
constexpr double prior_median = 2.0, prior_deviation = 1.0;  // of l_j / scale_j, and of its logarithm

double squared(double x) {
    return x * x;
}

}  // namespace

GaussianProcess::GaussianProcess(const Eigen::MatrixXd& x, const Eigen::VectorXd& y) : y_(y) {
    const auto n = static_cast<double>(x.rows());
    centre_ = x.colwise().mean();
    x_ = x.rowwise() - centre_.transpose();
    scale_ = (x_.colwise().squaredNorm() / n).cwiseSqrt();
    for (Eigen::Index j = 0; j < scale_.size(); ++j)  // a coordinate that is the same in all data, but for rounding
        if (!(scale_[j] > 1e-6 * (1.0 + std::abs(centre_[j])))) scale_[j] = 1.0;
    x_ = x_ * scale_.cwiseInverse().asDiagonal();

    const double deviation = std::sqrt((y.array() - y.mean()).square().sum() / n);
    const double start = std::log(std::max(deviation, 1e-9));
    logs_ = Eigen::VectorXd::Constant(first_length + x.cols(), std::log(prior_median));
    logs_[signal_place] = start;
    logs_[noise_place] = start - std::numbers::ln10;
    fit_ = fit(logs_);
    // Hooke & Jeeves: each parameter in turn, with steps that become smaller. The posterior is smooth and has few parameters.
    for (double step = 1.0; step > 0.01; step *= 0.5)
        for (bool better = true; better;) {
            better = false;
            for (Eigen::Index i = 0; i < logs_.size(); ++i)
                for (const double change : {step, -step}) {
                    Eigen::VectorXd tried = logs_;
                    tried[i] += change;
                    if (std::abs(tried[i] - (i < first_length ? start : std::log(prior_median))) > 12.0) continue;
                    const Fit result = fit(tried);
                    if (result.log_posterior <= fit_.log_posterior + 1e-9) continue;
                    logs_ = tried;
                    fit_ = result;
                    better = true;
                }
        }
}

double GaussianProcess::covariance(const Eigen::VectorXd& one, const Eigen::VectorXd& other, const Eigen::VectorXd& logs) const {
    double sum = 0.0;
    for (Eigen::Index j = 0; j < one.size(); ++j) sum += squared((one[j] - other[j]) * std::exp(-logs[first_length + j]));
    return std::exp(2.0 * logs[signal_place] - 0.5 * sum);
}

GaussianProcess::Fit GaussianProcess::fit(const Eigen::VectorXd& logs) const {
    const Eigen::Index n = x_.rows();
    Eigen::MatrixXd matrix(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j <= i; ++j) matrix(i, j) = matrix(j, i) = covariance(x_.row(i), x_.row(j), logs);
    const double noise = std::exp(2.0 * logs[noise_place]);
    matrix.diagonal().array() += noise + 1e-10 * std::exp(2.0 * logs[signal_place]);
    const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
    Fit result;
    result.inverse = factor.solve(Eigen::MatrixXd::Identity(n, n));
    const Eigen::VectorXd column_sums = result.inverse.rowwise().sum();
    result.mean = column_sums.dot(y_) / column_sums.sum();
    const Eigen::VectorXd rest = y_.array() - result.mean;
    result.weights = result.inverse * rest;
    const double log_determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
    result.log_posterior = -0.5 * (rest.dot(result.weights) + log_determinant + std::log(column_sums.sum()));
    for (Eigen::Index j = first_length; j < logs.size(); ++j)
        result.log_posterior -= 0.5 * squared((logs[j] - std::log(prior_median)) / prior_deviation);
    return result;
}

Estimate GaussianProcess::at(const Eigen::VectorXd& x) const {
    const Eigen::VectorXd place = (x - centre_).cwiseQuotient(scale_);
    Eigen::VectorXd shared(x_.rows());
    for (Eigen::Index i = 0; i < x_.rows(); ++i) shared[i] = covariance(x_.row(i), place, logs_);
    const Eigen::VectorXd solved = fit_.inverse * shared;
    // Their Eq. 2.42: the last term is the uncertainty of the mean.
    const double variance = squared(signal()) + squared(noise()) - shared.dot(solved) + squared(1.0 - solved.sum()) / fit_.inverse.sum();
    return {fit_.mean + shared.dot(fit_.weights), std::sqrt(std::max(variance, squared(noise())))};
}

Estimate GaussianProcess::leave_one_out(Eigen::Index i) const {
    // Of the inverse that also projects out the mean.
    const Eigen::VectorXd sums = fit_.inverse.rowwise().sum();
    const double diagonal = fit_.inverse(i, i) - squared(sums[i]) / sums.sum();
    return {y_[i] - fit_.weights[i] / diagonal, std::sqrt(1.0 / diagonal)};
}

Eigen::VectorXd GaussianProcess::length_scales() const {
    return logs_.tail(logs_.size() - first_length).array().exp() * scale_.array();
}

double GaussianProcess::signal() const {
    return std::exp(logs_[signal_place]);
}

double GaussianProcess::noise() const {
    return std::exp(logs_[noise_place]);
}

}  // namespace porepack::design
