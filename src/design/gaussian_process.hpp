// Regression by a Gaussian process with a constant mean: Rasmussen & Williams 2006, Gaussian Processes for Machine Learning, chapters 2, 5.
#pragma once

#include <Eigen/Core>

namespace porepack::design {

struct Estimate {
    double value = 0.0, standard_deviation = 0.0;
};

/// y(x) = m + f(x) + e. f has the covariance s^2 exp(-sum (x_j - x'_j)^2 / (2 l_j^2)); e is independent in each observation: its scatter,
/// and what the coordinates do not explain. m has a flat prior. s, l_j and the standard deviation of e maximise the marginal likelihood,
/// with a weak prior on l_j (log-normal, median twice the scatter of coordinate j in the data).
class GaussianProcess {
public:
    /// One row of `x` per observation. Needs two observations or more.
    GaussianProcess(const Eigen::MatrixXd& x, const Eigen::VectorXd& y);

    /// Of a new observation at `x`: e is part of the standard deviation.
    [[nodiscard]] Estimate at(const Eigen::VectorXd& x) const;

    /// Of observation i from all others, with the same s and l_j (their Eq. 5.12).
    [[nodiscard]] Estimate leave_one_out(Eigen::Index i) const;

    [[nodiscard]] Eigen::VectorXd length_scales() const;  ///< l_j, in the units of x
    [[nodiscard]] double signal() const;                  ///< s
    [[nodiscard]] double noise() const;                   ///< standard deviation of e

private:
    struct Fit {
        Eigen::MatrixXd inverse;  // of the covariance of the observations
        Eigen::VectorXd weights;  // inverse * (y - m)
        double mean = 0.0;
        double log_posterior = 0.0;  // up to a constant
    };
    [[nodiscard]] double covariance(const Eigen::VectorXd& one, const Eigen::VectorXd& other, const Eigen::VectorXd& logs) const;
    [[nodiscard]] Fit fit(const Eigen::VectorXd& logs) const;

    Eigen::VectorXd centre_, scale_;  // of the coordinates in the data
    Eigen::MatrixXd x_;               // (x - centre) / scale
    Eigen::VectorXd y_;
    Eigen::VectorXd logs_;  // ln of s, of the standard deviation of e, of each l_j / scale_j
    Fit fit_;
};

}  // namespace porepack::design
