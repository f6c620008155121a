#pragma once

#include <boost/math/distributions/binomial.hpp>

#include "core/interval.hpp"

namespace porepack::benchmarks {

/// The exact (Clopper-Pearson) 95 % interval of a probability, from `held` of `cases`.
[[nodiscard]] inline core::Interval binomial_interval(long held, long cases) {
    using Binomial = boost::math::binomial_distribution<>;
    const auto n = static_cast<double>(cases), k = static_cast<double>(held);
    return {held == 0 ? 0.0 : Binomial::find_lower_bound_on_p(n, k, 0.025),
            held == cases ? 1.0 : Binomial::find_upper_bound_on_p(n, k, 0.025)};
}

}  // namespace porepack::benchmarks
