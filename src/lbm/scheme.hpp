// Parameters of collision and walls. Chosen once, outside all loops; equations in docs/theory.md.
#pragma once

#include <array>

#include "core/choice.hpp"
#include "lbm/lattice.hpp"

namespace porepack::lbm {

enum class Walls {
    bounce_back,  ///< half-way between two nodes, independent of the wall position
    interpolated  ///< at the exact distance
};
constexpr std::array<core::Choice<Walls>, 2> choices_of(Walls) {
    return {{{Walls::interpolated, "interpolated"}, {Walls::bounce_back, "bounce_back"}}};
}

/// The equilibrium, and what a collision keeps of the rest.
enum class Model {
    stokes,         ///< linear equilibrium, two relaxation times: creeping flow
    navier_stokes,  ///< full equilibrium, two relaxation times: flow with inertia, as long as the grid resolves its gradients well
    regularised,    ///< full equilibrium; of the rest, only the shear stress is kept (after Latt & Chopard 2006)
    recursive       ///< the same with moments of third order, which follow from velocity and stress (Malaspinas 2015): the most stable
};

/// What the weights of interpolated walls follow from, besides the distance; see WallWeights.
struct WallRule {
    double shift;  ///< 2 / (tau - 1/2), or 0: without the term that is exact for a parabola
    double magic;
    double bound, limit;  ///< `share` is at most bound / (3/4 x^2), and `limit`
};

struct Scheme {
    /// Relaxation time of the symmetric part: viscosity (tau - 1/2)/3. It changes the number of steps, and with two relaxation times not
    /// the steady state; Sequence searches the fastest value.
    double tau = 1.2;
    /// Magic parameter Lambda = (tau - 1/2)(tau_minus - 1/2). It moves the walls of bounce-back a little and has nearly no effect on
    /// interpolated walls (docs/theory.md).
    double magic = 1.0 / 12.0;
    Walls walls = Walls::interpolated;  ///< bounce-back where the walls are not known exactly (an image)
    Model model = Model::stokes;
    std::array<double, 3> force = {0, 0, 0};  ///< on each node, lattice units

    [[nodiscard]] bool inertia() const { return model != Model::stokes; }
    [[nodiscard]] bool two_relaxation_times() const { return model == Model::stokes || model == Model::navier_stokes; }
    [[nodiscard]] double viscosity_lu() const { return (tau - 0.5) / 3.0; }
    [[nodiscard]] double rate_plus() const { return 1.0 / tau; }
    /// Of the antisymmetric part. Where only the stress is kept, it is 1.
    [[nodiscard]] double rate_minus() const { return two_relaxation_times() ? 1.0 / (0.5 + magic / (tau - 0.5)) : 1.0; }
    [[nodiscard]] WallRule wall_rule() const;
    /// 3 w c.F, force term of a population.
    [[nodiscard]] double force_term(int q) const {
        const auto& c = d3q19::c[static_cast<std::size_t>(q)];
        return 3.0 * d3q19::w(q) * (c[0] * force[0] + c[1] * force[1] + c[2] * force[2]);
    }
    /// w (rho + 3 c.j), linear.
    [[nodiscard]] static double equilibrium(int q, double density, const std::array<double, 3>& momentum) {
        const auto& c = d3q19::c[static_cast<std::size_t>(q)];
        return d3q19::w(q) * (density + 3.0 * (c[0] * momentum[0] + c[1] * momentum[1] + c[2] * momentum[2]));
    }
};

/// A wall at a fraction x of the link along q, with o the opposite direction; f are the populations before, f* after collision:
/// stored = share ((1 + shift) f*_q - (b + shift) f*_o - shift (f_q - f_o + 6 w c_q.F)) + (1 - share) f_o, and one step later
/// f_o = stored + share b f_q.
/// From the family of Ginzburg, Verhaeghe & d'Humieres (2008): central linear interpolation, b = (1 - 2x)/(1 + 2x), with a local
/// term that moves the weight of the second derivative from Lambda to 3/4 x^2, which is exact for a parabola between walls
/// across a lattice axis; so Lambda is free for the bulk, and the position of the grid has little effect. `share` under-relaxes
/// where the explicit form would overshoot; the steady state does not change. In a gap of one node the populations from both
/// walls are computed together.
template <typename Real>
struct WallWeights {
    Real share, shift, b;

    WallWeights(Real x, const WallRule& rule) {
        const Real second = Real(0.75) * x * x;
        const Real inverse = Real(1) / (Real(1) + Real(2) * x);
        b = (Real(1) - Real(2) * x) * inverse;
        shift = static_cast<Real>(rule.shift) * inverse * (static_cast<Real>(rule.magic) - second);
        const auto bound = static_cast<Real>(rule.bound), limit = static_cast<Real>(rule.limit);
        share = bound < limit * second ? bound / second : limit;
    }
};

}  // namespace porepack::lbm
