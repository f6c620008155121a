// The collision of a chunk of nodes, in vector registers; equations in scheme.hpp and docs/theory.md.
#pragma once

#include "lbm/scheme.hpp"
#include "lbm/vectors.hpp"

namespace porepack {

/// A scheme's numbers in the kernel's precision.
template <typename Real>
struct Rates {
    Real plus, minus;
    std::array<Real, 3> force;
    std::array<Real, 9> kick;  ///< of each pair's first direction

    explicit Rates(const Scheme& scheme) : plus(static_cast<Real>(scheme.rate_plus())), minus(static_cast<Real>(scheme.rate_minus())) {
        for (std::size_t a = 0; a < 3; ++a) force[a] = static_cast<Real>(scheme.force[a]);
        for (std::size_t k = 0; k < 9; ++k) kick[k] = static_cast<Real>(scheme.kick(static_cast<int>(2 * k + 1)));
    }
};

/// Rows of populations of chunk_nodes nodes, q after q, are replaced by those after collision.
// Legend: s and d sum and difference of a pair of opposite populations, rho density, j momentum, u velocity.
// `swap` leaves each population in its opposite's row. `fetch` is called once a vector: it brings the next chunk nearer.
template <bool inertia, bool swap, typename Real, typename Fetch>
void collide(Real* const rows, const Rates<Real>& rates, const Fetch& fetch) {
    constexpr std::size_t chunk = chunk_nodes;
    constexpr Real w0 = static_cast<Real>(d3q19::w_rest), w1 = static_cast<Real>(d3q19::w_axis), w2 = static_cast<Real>(d3q19::w_diagonal);
    const Real half = Real(0.5), even = half * (Real(1) - rates.plus), odd = half * (Real(1) - rates.minus);
    const Real plus = rates.plus, minus3 = Real(3) * rates.minus;
    Real* const f = static_cast<Real*>(__builtin_assume_aligned(rows, vector_bytes));
#define PAIR(k) f[(2 * (k) + 1) * chunk + i], f[(2 * (k) + 2) * chunk + i]
    const auto sum = [](Real a, Real b) { return a + b; };
    const auto difference = [](Real a, Real b) { return a - b; };
    for (std::size_t block = 0; block < chunk; block += lanes<Real>) {
        fetch(block);
#pragma omp simd
        for (std::size_t i = block; i < block + lanes<Real>; ++i) {
            const Real f0 = f[i];
            const Real s0 = sum(PAIR(0)), s1 = sum(PAIR(1)), s2 = sum(PAIR(2)), s3 = sum(PAIR(3)), s4 = sum(PAIR(4)), s5 = sum(PAIR(5)),
                       s6 = sum(PAIR(6)), s7 = sum(PAIR(7)), s8 = sum(PAIR(8));
            const Real d0 = difference(PAIR(0)), d1 = difference(PAIR(1)), d2 = difference(PAIR(2)), d3 = difference(PAIR(3)),
                       d4 = difference(PAIR(4)), d5 = difference(PAIR(5)), d6 = difference(PAIR(6)), d7 = difference(PAIR(7)),
                       d8 = difference(PAIR(8));
            Real rho = f0 + ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7)) + s8;
            const Real jx = d0 + ((d3 + d4) + (d5 + d6)), jy = d1 + ((d3 - d4) + (d7 + d8)), jz = d2 + ((d5 - d6) + (d7 - d8));
            Real ux = 0, uy = 0, uz = 0;
            if constexpr (inertia) {
                ux = jx + half * rates.force[0];
                uy = jy + half * rates.force[1];
                uz = jz + half * rates.force[2];
                rho -= Real(1.5) * (ux * ux + uy * uy + uz * uz);
            }
            f[i] = f0 - plus * (f0 - w0 * rho);
            const auto relax = [&](std::size_t k, Real w, Real s, Real d, Real cj, Real cu) {
                const Real e = even * s + plus * w * (inertia ? rho + Real(4.5) * cu * cu : rho);
                const Real o = odd * d + minus3 * w * cj + rates.kick[k];
                f[(2 * k + (swap ? 2 : 1)) * chunk + i] = e + o;
                f[(2 * k + (swap ? 1 : 2)) * chunk + i] = e - o;
            };
            relax(0, w1, s0, d0, jx, ux);
            relax(1, w1, s1, d1, jy, uy);
            relax(2, w1, s2, d2, jz, uz);
            relax(3, w2, s3, d3, jx + jy, ux + uy);
            relax(4, w2, s4, d4, jx - jy, ux - uy);
            relax(5, w2, s5, d5, jx + jz, ux + uz);
            relax(6, w2, s6, d6, jx - jz, ux - uz);
            relax(7, w2, s7, d7, jy + jz, uy + uz);
            relax(8, w2, s8, d8, jy - jz, uy - uz);
        }
    }
#undef PAIR
}

}  // namespace porepack
