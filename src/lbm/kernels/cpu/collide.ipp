// The parts of the fast kernel that work on one chunk: collision and walls. Part of kernel.cpp, once per instruction set; includes nothing.

constexpr int directions = d3q19::directions;
constexpr std::size_t chunk = chunk_nodes;

[[nodiscard]] constexpr int opposite(int q) {
    return q == 0 ? 0 : q % 2 == 1 ? q + 1 : q - 1;
}
[[nodiscard]] constexpr std::size_t slot_of(std::size_t q, std::size_t node) {
    return (node / chunk * directions + q) * chunk + node % chunk;
}
[[nodiscard]] constexpr int opposite_row(int row) {
    constexpr int one = static_cast<int>(chunk);
    return row - one + 2 * (row & one);
}
template <typename T>
[[nodiscard]] constexpr T smaller(T a, T b) {
    return b < a ? b : a;
}

// Velocities c_q and weights w_q as plain numbers, made by the compiler.
struct Lattice {
    int c[directions][3];
    double w[directions];
    constexpr Lattice() : c(), w() {
        for (int q = 0; q < directions; ++q) {
            for (int a = 0; a < 3; ++a) c[q][a] = d3q19::c[static_cast<std::size_t>(q)][static_cast<std::size_t>(a)];
            w[q] = d3q19::w(q);
        }
    }
};
constexpr Lattice lattice;

// A chunk's populations, q after q.
template <typename Real>
struct alignas(vector_bytes) Buffer {
    Real f[directions * chunk];
};

// One vector of the nodes of a group: where they are, and which.
template <typename Real>
struct Vector {
    std::size_t first, second;
    std::uint16_t from_first, from_second, from_own;  // see Addresses::Group

    inline Vector(const Addresses::Group& group, std::size_t part)
        : first(group.first + part * simd_lanes<Real>), second(group.second + part * simd_lanes<Real>) {
        const unsigned one = static_cast<unsigned>(group.first_nodes) >> (part * simd_lanes<Real>),
                       other = static_cast<unsigned>(group.second_nodes) >> (part * simd_lanes<Real>);
        from_first = static_cast<std::uint16_t>(one & ~other);
        from_second = static_cast<std::uint16_t>(other & ~one);
        from_own = static_cast<std::uint16_t>(~(one | other));
    }
};

// Reads a vector from its places; singles hold anything.
template <typename Real>
inline void read(Real* to, const Real* base, const Real* own, const Vector<Real>& at) {
#if defined(__AVX512F__)
    if constexpr (sizeof(Real) == 8) {
        const __m512d vector =
            _mm512_mask_loadu_pd(_mm512_loadu_pd(base + at.first), static_cast<__mmask8>(at.from_second), base + at.second);
        _mm512_store_pd(to, _mm512_mask_loadu_pd(vector, static_cast<__mmask8>(at.from_own), own));
    } else {
        const __m512 vector = _mm512_mask_loadu_ps(_mm512_loadu_ps(base + at.first), at.from_second, base + at.second);
        _mm512_store_ps(to, _mm512_mask_loadu_ps(vector, at.from_own, own));
    }
#else
    for (std::size_t i = 0; i < simd_lanes<Real>; ++i) {
        const Real* const place = (at.from_own >> i & 1U) != 0 ? own : base + ((at.from_second >> i & 1U) != 0 ? at.second : at.first);
        to[i] = place[i];
    }
#endif
}

template <typename Real>
inline void write(Real* base, Real* own, const Real* from, const Vector<Real>& at) {
#if defined(__AVX512F__)
    if constexpr (sizeof(Real) == 8) {
        const __m512d vector = _mm512_load_pd(from);
        _mm512_mask_storeu_pd(base + at.first, static_cast<__mmask8>(at.from_first), vector);
        _mm512_mask_storeu_pd(base + at.second, static_cast<__mmask8>(at.from_second), vector);
        _mm512_mask_storeu_pd(own, static_cast<__mmask8>(at.from_own), vector);
    } else {
        const __m512 vector = _mm512_load_ps(from);
        _mm512_mask_storeu_ps(base + at.first, at.from_first, vector);
        _mm512_mask_storeu_ps(base + at.second, at.from_second, vector);
        _mm512_mask_storeu_ps(own, at.from_own, vector);
    }
#else
    for (std::size_t i = 0; i < simd_lanes<Real>; ++i) {
        if ((at.from_first >> i & 1U) != 0) base[at.first + i] = from[i];
        if ((at.from_second >> i & 1U) != 0) base[at.second + i] = from[i];
        if ((at.from_own >> i & 1U) != 0) own[i] = from[i];
    }
#endif
}

// The collision of a chunk; equations in scheme.hpp and docs/theory.md. Rows of populations are replaced by those after collision.
// Legend: s and d sum and difference of a pair of opposite populations, rho density, j momentum, u velocity.
// `swap` leaves each population in its opposite's row. `fetch` is called once per vector: it brings the next chunk nearer.
template <Model model, bool swap, typename Real, typename Fetch>
inline void collide(Real* const rows, const KernelData<Real>& data, const Fetch& fetch) {
    constexpr Real w0 = static_cast<Real>(d3q19::w_rest), w1 = static_cast<Real>(d3q19::w_axis), w2 = static_cast<Real>(d3q19::w_diagonal);
    const Real half = Real(0.5), even = half * (Real(1) - data.rate_plus), odd = half * (Real(1) - data.rate_minus);
    const Real plus = data.rate_plus, minus3 = Real(3) * data.rate_minus;
    const Real fx = data.force[0], fy = data.force[1], fz = data.force[2];
    Real term[9];
    for (int k = 0; k < 9; ++k) term[k] = data.force_term[2 * k + 1];
    Real* const f = static_cast<Real*>(__builtin_assume_aligned(rows, vector_bytes));
#define PAIR(k) f[(2 * (k) + 1) * chunk + i], f[(2 * (k) + 2) * chunk + i]
    const auto sum = [](Real a, Real b) { return a + b; };
    const auto difference = [](Real a, Real b) { return a - b; };
    for (std::size_t block = 0; block < chunk; block += simd_lanes<Real>) {
        fetch(block);
#pragma omp simd
        for (std::size_t i = block; i < block + simd_lanes<Real>; ++i) {
            const Real f0 = f[i];
            const Real s0 = sum(PAIR(0)), s1 = sum(PAIR(1)), s2 = sum(PAIR(2)), s3 = sum(PAIR(3)), s4 = sum(PAIR(4)), s5 = sum(PAIR(5)),
                       s6 = sum(PAIR(6)), s7 = sum(PAIR(7)), s8 = sum(PAIR(8));
            const Real d0 = difference(PAIR(0)), d1 = difference(PAIR(1)), d2 = difference(PAIR(2)), d3 = difference(PAIR(3)),
                       d4 = difference(PAIR(4)), d5 = difference(PAIR(5)), d6 = difference(PAIR(6)), d7 = difference(PAIR(7)),
                       d8 = difference(PAIR(8));
            Real rho = f0 + ((s0 + s1) + (s2 + s3)) + ((s4 + s5) + (s6 + s7)) + s8;
            const Real jx = d0 + ((d3 + d4) + (d5 + d6)), jy = d1 + ((d3 - d4) + (d7 + d8)), jz = d2 + ((d5 - d6) + (d7 - d8));
            const Real ux = jx + half * fx, uy = jy + half * fy, uz = jz + half * fz;
            if constexpr (model == Model::stokes || model == Model::navier_stokes) {
                constexpr bool inertia = model == Model::navier_stokes;
                if constexpr (inertia) rho -= Real(1.5) * (ux * ux + uy * uy + uz * uz);
                f[i] = f0 - plus * (f0 - w0 * rho);
                const auto relax = [&](std::size_t k, Real w, Real s, Real d, Real cj, Real cu) {
                    const Real e = even * s + plus * w * (inertia ? rho + Real(4.5) * cu * cu : rho);
                    const Real o = odd * d + minus3 * w * cj + term[k];
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
            } else {
                // p: shear stress; t: moments of third order after collision, t_xxy etc.; see the reference kernel.
                const Real third = rho * Real(1.0 / 3.0), kept = Real(1) - plus, stay = Real(4.5) * kept;
                Real pxx = s0 + ((s3 + s4) + (s5 + s6)) - third - ux * ux, pyy = s1 + ((s3 + s4) + (s7 + s8)) - third - uy * uy,
                     pzz = s2 + ((s5 + s6) + (s7 + s8)) - third - uz * uz;
                const Real pxy = s3 - s4 - ux * uy, pxz = s5 - s6 - ux * uz, pyz = s7 - s8 - uy * uz;
                const Real trace = Real(1.0 / 3.0) * (pxx + pyy + pzz);
                pxx -= trace;
                pyy -= trace;
                pzz -= trace;
                const Real common = rho - Real(1.5) * (ux * ux + uy * uy + uz * uz);
                f[i] = w0 * common;
                const auto moment = [&](Real ua, Real ub, Real pab, Real paa) {
                    return model == Model::recursive ? ua * ua * ub + kept * (Real(2) * ua * pab + ub * paa) : Real(0);
                };
                const Real txxy = moment(ux, uy, pxy, pxx), txxz = moment(ux, uz, pxz, pxx), tyyx = moment(uy, ux, pxy, pyy),
                           tyyz = moment(uy, uz, pyz, pyy), tzzx = moment(uz, ux, pxz, pzz), tzzy = moment(uz, uy, pyz, pzz);
                const auto set = [&](std::size_t k, Real w, Real cj, Real cu, Real cpc, Real t) {
                    const Real e = w * (common + Real(4.5) * cu * cu + stay * cpc);
                    const Real o = w * (Real(3) * cj + Real(9) * t) + term[k];
                    f[(2 * k + (swap ? 2 : 1)) * chunk + i] = e + o;
                    f[(2 * k + (swap ? 1 : 2)) * chunk + i] = e - o;
                };
                set(0, w1, jx, ux, pxx, -(tyyx + tzzx));
                set(1, w1, jy, uy, pyy, -(txxy + tzzy));
                set(2, w1, jz, uz, pzz, -(txxz + tyyz));
                set(3, w2, jx + jy, ux + uy, pxx + pyy + Real(2) * pxy, txxy + tyyx);
                set(4, w2, jx - jy, ux - uy, pxx + pyy - Real(2) * pxy, tyyx - txxy);
                set(5, w2, jx + jz, ux + uz, pxx + pzz + Real(2) * pxz, txxz + tzzx);
                set(6, w2, jx - jz, ux - uz, pxx + pzz - Real(2) * pxz, tzzx - txxz);
                set(7, w2, jy + jz, uy + uz, pyy + pzz + Real(2) * pyz, tyyz + tzzy);
                set(8, w2, jy - jz, uy - uz, pyy + pzz - Real(2) * pyz, tzzy - tyyz);
            }
        }
    }
#undef PAIR
}

// A wall at the fraction x of a link; WallWeights in scheme.hpp explains it.
template <typename Real>
struct Weights {
    Real share, shift, b;
    inline Weights(Real x, const KernelData<Real>& data) {
        const Real second = Real(0.75) * x * x;
        const Real inverse = Real(1) / (Real(1) + Real(2) * x);
        b = (Real(1) - Real(2) * x) * inverse;
        shift = data.wall_shift * inverse * (data.wall_magic - second);
        share = data.wall_bound < data.wall_limit * second ? data.wall_bound / second : data.wall_limit;
    }
};

// The weights of a chunk's wall links, and what they know before collision: known + to_wall f*_q - from_wall f*_o is stored.
template <typename Real>
struct AtWalls {
    static constexpr std::size_t capacity = (directions - 1) * chunk + simd_lanes<Real>;
    alignas(vector_bytes) Real arriving[capacity];
    alignas(vector_bytes) Real rest[capacity];
    alignas(vector_bytes) Real shift[capacity];
    alignas(vector_bytes) Real to_wall[capacity];
    alignas(vector_bytes) Real from_wall[capacity];
    alignas(vector_bytes) Real known[capacity];
    inline void weigh(std::size_t k, const Weights<Real>& w) {
        arriving[k] = w.share * w.b;
        rest[k] = Real(1) - w.share;
        shift[k] = w.share * w.shift;
        to_wall[k] = w.share * (Real(1) + w.shift);
        from_wall[k] = w.share * (w.b + w.shift);
    }
    inline void know(std::size_t k, Real in, Real out, Real term) { known[k] = rest[k] * out - shift[k] * (in - out + term); }
    [[nodiscard]] inline Real stored(std::size_t k, Real in, Real out) const { return known[k] + to_wall[k] * in - from_wall[k] * out; }
};
