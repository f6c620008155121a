// Gauss' rules, for surfaces whose pieces are smooth.
#pragma once

#include <boost/math/quadrature/gauss.hpp>

namespace porepack::shapes {

/// Calls visit(x, weight) at the points of Gauss' rule with `Points` (even) points on the interval from `low` to `high`.
template <unsigned Points, typename Visit>
void for_gauss_points(double low, double high, const Visit& visit) {
    static_assert(Points % 2 == 0);
    using Rule = boost::math::quadrature::gauss<double, Points>;
    const double middle = 0.5 * (low + high), half = 0.5 * (high - low);
    for (std::size_t i = 0; i < Rule::abscissa().size(); ++i)
        for (const double side : {-1.0, 1.0}) visit(middle + side * half * Rule::abscissa()[i], half * Rule::weights()[i]);
}

}  // namespace porepack::shapes
