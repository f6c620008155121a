// Along a line with the parameter t, a point at the distance rho from the axis lies in the torus where
//     g(t) = |x|^2 + R^2 - r^2 - 2 R rho < 0.
// rho^2 = alpha t^2 + 2 beta t + gamma is a parabola, and g'' = 2 - 2 R D / rho^3 with D = alpha gamma - beta^2: g is convex but for one
// interval about the lowest rho, whose ends are known in closed form. So g is monotone between at most seven known points, and each root
// is bracketed: none is missed, and none is found twice.
#include "shapes/torus.hpp"

#include <algorithm>
#include <array>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>

namespace porepack::shapes {
using core::Interval;
using geometry::Vec3;
namespace {

// The root of a monotone function between two points at which its signs differ.
template <typename F>
double root_between(const F& f, double low, double at_low, double high, double at_high) {
    if (at_low == 0.0) return low;
    if (at_high == 0.0) return high;
    boost::uintmax_t steps = 60;
    const auto [a, b] =
        boost::math::tools::toms748_solve(f, low, high, at_low, at_high, boost::math::tools::eps_tolerance<double>(51), steps);
    return 0.5 * (a + b);
}

}  // namespace

void add_torus_parts(double R, double r, const Vec3& origin, const Vec3& direction, std::vector<Interval>& parts) {
    const double b = origin.dot(direction), c = origin.squaredNorm();
    const double half2 = b * b - c + (R + r) * (R + r);
    if (half2 <= 0.0 || r <= 0.0) return;
    const double first = -b - std::sqrt(half2), last = -b + std::sqrt(half2);
    const double z0 = origin.z() + first * direction.z(), z1 = origin.z() + last * direction.z();
    if (std::min(z0, z1) >= r || std::max(z0, z1) <= -r) return;

    const double alpha = direction.head<2>().squaredNorm(), beta = origin.head<2>().dot(direction.head<2>());
    const double cross = origin.x() * direction.y() - origin.y() * direction.x(), D = cross * cross;
    const auto rho = [&](double t) {
        const double x = origin.x() + t * direction.x(), y = origin.y() + t * direction.y();
        return std::sqrt(x * x + y * y);
    };
    const auto g = [&](double t) {
        const double away = rho(t) - R, z = origin.z() + t * direction.z();
        return away * away + z * z - r * r;
    };
    const auto slope = [&](double t) {
        const double at = rho(t), fall = alpha * t + beta;
        return 2.0 * (t + b) - (at > 0.0 ? 2.0 * R * fall / at : 0.0);
    };
    // The points between which g is monotone, ascending.
    std::array<double, 8> at{};
    std::size_t count = 0;
    at[count++] = first;
    std::array<double, 4> bends = {first, last, last, last};  // convex, concave, convex
    std::size_t pieces = 1;
    if (alpha > 1e-24) {
        const double width2 = alpha * std::cbrt(R * R * D * D) - D, middle = -beta / alpha;
        const double width = width2 > 0.0 ? std::sqrt(width2) / alpha : 0.0;
        if (width2 >= 0.0 && middle - width < last && middle + width > first) {
            bends = {first, std::max(first, middle - width), std::min(last, middle + width), last};
            pieces = 3;
        }
    }
    for (std::size_t piece = 0; piece < pieces; ++piece) {
        const double low = bends[piece], high = bends[piece + 1];
        if (!(high > low)) continue;
        const bool kink = pieces == 3 && D == 0.0;  // rho reaches 0 between the pieces: the slope jumps there
        const double inside = 1e-12 * (high - low);
        const double slope_low = slope(kink && piece == 2 ? low + inside : low),
                     slope_high = slope(kink && piece == 0 ? high - inside : high);
        if (slope_low * slope_high < 0.0) at[count++] = root_between(slope, low, slope_low, high, slope_high);
        at[count++] = high;
    }
    double from = at[0], g_from = g(from), entry = from;
    bool inside = g_from < 0.0;
    for (std::size_t i = 1; i < count; ++i) {
        const double to = at[i], g_to = g(to);
        if ((g_from < 0.0) != (g_to < 0.0)) {
            const double root = root_between(g, from, g_from, to, g_to);
            if (inside) parts.push_back({entry, root});
            entry = root;
            inside = !inside;
        }
        from = to;
        g_from = g_to;
    }
    if (inside) parts.push_back({entry, from});
}

}  // namespace porepack::shapes
