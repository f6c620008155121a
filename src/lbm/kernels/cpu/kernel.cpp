// The fast kernel: one copy of the populations, moved in place, in chunks of nodes that fit into the first-level cache.
// A chunk's populations are gathered a SIMD vector at a time, collided in registers, and scattered back; one sweep through memory makes two
// steps. This file is compiled once per instruction set, POREPACK_SET being its name. All that it defines lies in a namespace of that name,
// and it instantiates nothing of other headers: the linker keeps one copy of an inline function, and that must not be one which older
// processors cannot run (a test looks at the object files).
#include <cstring>
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "lbm/kernels/cpu/kernel.hpp"

namespace porepack::lbm::cpu::POREPACK_SET {
namespace {

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

// Reads a vector from its places; lanes that come from a third one hold anything.
template <typename Real>
inline void read(Real* to, const Real* store, const Addresses::Vector& at) {
#if defined(__AVX512F__)
    if constexpr (sizeof(Real) == 8)
        _mm512_store_pd(to,
                        _mm512_mask_loadu_pd(_mm512_loadu_pd(store + at.first), static_cast<__mmask8>(at.second_lanes), store + at.second));
    else
        _mm512_store_ps(to, _mm512_mask_loadu_ps(_mm512_loadu_ps(store + at.first), at.second_lanes, store + at.second));
#else
    for (std::size_t i = 0; i < simd_lanes<Real>; ++i) to[i] = store[((at.second_lanes >> i & 1U) != 0 ? at.second : at.first) + i];
#endif
}

template <typename Real>
inline void write(Real* store, const Real* from, const Addresses::Vector& at) {
#if defined(__AVX512F__)
    if constexpr (sizeof(Real) == 8) {
        const __m512d vector = _mm512_load_pd(from);
        _mm512_mask_storeu_pd(store + at.first, static_cast<__mmask8>(at.first_lanes), vector);
        _mm512_mask_storeu_pd(store + at.second, static_cast<__mmask8>(at.second_lanes), vector);
    } else {
        const __m512 vector = _mm512_load_ps(from);
        _mm512_mask_storeu_ps(store + at.first, at.first_lanes, vector);
        _mm512_mask_storeu_ps(store + at.second, at.second_lanes, vector);
    }
#else
    for (std::size_t i = 0; i < simd_lanes<Real>; ++i) {
        if ((at.first_lanes >> i & 1U) != 0) store[at.first + i] = from[i];
        if ((at.second_lanes >> i & 1U) != 0) store[at.second + i] = from[i];
    }
#endif
}

// The collision of a chunk; equations in scheme.hpp and docs/theory.md. Rows of populations are replaced by those after collision.
// Legend: s and d sum and difference of a pair of opposite populations, rho density, j momentum, u velocity.
// `swap` leaves each population in its opposite's row. `fetch` is called once per vector: it brings the next chunk nearer.
template <bool inertia, bool swap, typename Real, typename Fetch>
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
            Real ux = 0, uy = 0, uz = 0;
            if constexpr (inertia) {
                ux = jx + half * fx;
                uy = jy + half * fy;
                uz = jz + half * fz;
                rho -= Real(1.5) * (ux * ux + uy * uy + uz * uz);
            }
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
        }
    }
#undef PAIR
}

// A wall at the fraction x of a link; WallWeights in scheme.hpp explains it.
template <typename Real>
struct Weights {
    Real share, shift, b;
    inline Weights(Real x, Real plus, Real magic) {
        const Real second = Real(0.75) * x * x;
        const Real inverse = Real(1) / (Real(1) + Real(2) * x);
        b = (Real(1) - Real(2) * x) * inverse;
        shift = Real(2) * inverse * (magic - second) / plus;
        const Real bound = Real(0.6) * (Real(0.5) * plus + magic);
        share = bound < second ? bound / second : Real(1);
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

template <typename Real>
struct Sweep {
    const KernelData<Real>& data;

    [[nodiscard]] inline Real* chunk_rows(std::size_t c) const { return data.store + slot_of(0, c * chunk); }
    static constexpr std::size_t vectors_per_chunk = (directions - 1) * chunk / simd_lanes<Real>;
    [[nodiscard]] inline const Addresses::Vector* vectors_of(std::size_t c) const { return data.vectors + c * vectors_per_chunk; }
    [[nodiscard]] inline Weights<Real> weights(std::uint16_t distance) const {
        return {static_cast<Real>(distance) * Real(1.0 / 65535.0), data.lambda_plus, data.magic};
    }

    inline void gather_far(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.f, chunk_rows(c), chunk * sizeof(Real));
        const Addresses::Vector* at = vectors_of(c);
        for (std::size_t i = chunk; i < directions * chunk; i += simd_lanes<Real>, ++at) read(buffer.f + i, data.store, *at);
        for (std::uint32_t s = data.first_single[c]; s < data.first_single[c + 1]; ++s)
            buffer.f[data.singles[s].place] = data.store[data.singles[s].slot];
    }

    inline void scatter_far(std::size_t c, const Buffer<Real>& buffer) const {
        std::memcpy(chunk_rows(c), buffer.f, chunk * sizeof(Real));
        const Addresses::Vector* at = vectors_of(c);
        for (int q = 1; q < directions; ++q) {
            const Real* const row = buffer.f + static_cast<std::size_t>(opposite(q)) * chunk;
            for (std::size_t i = 0; i < chunk; i += simd_lanes<Real>, ++at) write(data.store, row + i, *at);
        }
        for (std::uint32_t s = data.first_single[c]; s < data.first_single[c + 1]; ++s)
            data.store[data.singles[s].slot] = buffer.f[opposite_row(data.singles[s].place)];
    }

    // Populations as they arrive, in `rows`, with the part of what walls return that depends on what arrives there now.
    inline void arrive(std::size_t c, Real* rows, AtWalls<Real>& at) const {
        for (std::uint32_t l = data.first_boundary[c]; l < data.first_boundary[c + 1]; ++l) {
            const BoundaryPlace<Real>& place = data.boundary[l];
            rows[place.row] = place.sign * rows[place.row] + place.added;
        }
        if (!data.interpolated) return;
        const std::size_t count = data.first_wall[c + 1] - data.first_wall[c];
        const std::uint16_t *const row = data.wall_row + data.first_wall[c], *const distance = data.wall_distance + data.first_wall[c];
        // Weights a vector at a time; gathers and scatters are faster one by one.
        for (std::size_t block = 0; block < count; block += simd_lanes<Real>)
#pragma omp simd
            for (std::size_t k = block; k < block + simd_lanes<Real>; ++k) at.weigh(k, weights(distance[k]));
#pragma GCC unroll 4
        for (std::size_t k = 0; k < count; ++k) {
            const int in = row[k], out = opposite_row(in);
            const Real arrives = rows[in], returns = rows[out] + at.arriving[k] * arrives;
            rows[out] = returns;
            at.know(k, arrives, returns, Real(2) * data.force_term[in / static_cast<int>(chunk)]);
        }
        for (std::uint64_t g = data.first_gap[c], k = count; g < data.first_gap[c + 1]; ++g, k += 2) {
            const auto& gap = data.gaps[g];
            const Real one = rows[gap.q * chunk + gap.place], other = rows[(gap.q + 1) * chunk + gap.place],
                       term = Real(2) * data.force_term[gap.q];
            at.weigh(k, weights(gap.distance));
            at.weigh(k + 1, weights(gap.opposite_distance));
            at.know(k, one, other, term);
            at.know(k + 1, other, one, -term);
        }
    }

    // Undoes the part of arrive() that changes `rows`.
    inline void before_arrival(std::size_t c, Real* rows) const {
        for (std::uint32_t l = data.first_boundary[c]; l < data.first_boundary[c + 1]; ++l) {
            const BoundaryPlace<Real>& place = data.boundary[l];
            rows[place.row] = place.sign * (rows[place.row] - place.added);
        }
        if (!data.interpolated) return;
        for (std::uint64_t l = data.first_wall[c]; l < data.first_wall[c + 1]; ++l) {
            const Weights<Real> w = weights(data.wall_distance[l]);
            const int in = data.wall_row[l];
            rows[opposite_row(in)] -= w.share * w.b * rows[in];
        }
    }

    // What leaves towards a wall becomes what the wall stores.
    template <bool swap>
    inline void meet_walls(std::size_t c, Real* rows, const AtWalls<Real>& at) const {
        if (!data.interpolated) return;
        const std::size_t count = data.first_wall[c + 1] - data.first_wall[c];
        const std::uint16_t* const row = data.wall_row + data.first_wall[c];
#pragma GCC unroll 4
        for (std::size_t k = 0; k < count; ++k) {
            const int here = row[k], there = opposite_row(here);
            rows[swap ? there : here] = at.stored(k, rows[swap ? there : here], rows[swap ? here : there]);
        }
        for (std::uint64_t g = data.first_gap[c], k = count; g < data.first_gap[c + 1]; ++g, k += 2) {
            const auto& gap = data.gaps[g];
            Real &one = rows[(swap ? gap.q + 1 : gap.q) * chunk + gap.place], &other = rows[(swap ? gap.q : gap.q + 1) * chunk + gap.place];
            const Real first = at.stored(k, one, other), second = at.stored(k + 1, other, one);
            const Real weight_a = at.arriving[k], weight_b = at.arriving[k + 1], determinant = Real(1) - weight_a * weight_b;
            one = (first + weight_a * second) / determinant;
            other = (second + weight_b * first) / determinant;
        }
    }

    // The chunk itself is the buffer.
    template <bool inertia>
    void even_step(std::size_t c) const {
        Real* const rows = chunk_rows(c);
        const Real* const next = chunk_rows(c + 1);
        AtWalls<Real> at;
        arrive(c, rows, at);
        collide<inertia, true>(rows, data, [&](std::size_t block) {
            for (std::size_t q = 0; q < directions; ++q) __builtin_prefetch(next + q * chunk + block);
        });
        meet_walls<true>(c, rows, at);
    }

    template <bool inertia>
    void odd_step(std::size_t c, std::size_t next) const {
        Buffer<Real> buffer;
        AtWalls<Real> at;
        gather_far(c, buffer);
        arrive(c, buffer.f, at);
        const Addresses::Vector* vector = vectors_of(next);
        const Real* const store = data.store;
        const Real* const rest = chunk_rows(next);
        collide<inertia, false>(buffer.f, data, [&](std::size_t block) {
            __builtin_prefetch(rest + block);
            for (const Addresses::Vector* const end = vector + directions - 1; vector != end; ++vector) {
                __builtin_prefetch(store + vector->first);
                __builtin_prefetch(store + vector->second);
            }
        });
        meet_walls<false>(c, buffer.f, at);
        scatter_far(c, buffer);
    }

    // Both steps in one sweep: the odd step of a chunk follows as soon as the even steps of all chunks that it reaches are done, while they
    // still lie in a cache. So memory is read and written once for two steps.
    template <bool inertia>
    void two_steps() const {
#pragma omp parallel
        for (std::size_t p = 0; p < data.part_count; ++p) {
            const Schedule::Part& part = data.parts[p];
#pragma omp for schedule(static) nowait
            for (std::size_t c = part.even; c < part.even_end; ++c) even_step<inertia>(c);
#pragma omp for schedule(static)
            for (std::size_t i = part.odd; i < part.odd_end; ++i)
                odd_step<inertia>(data.odd_order[i], data.odd_order[smaller(i + 1, data.chunks - 1)]);
        }
    }

    void moments(std::size_t first, Moments* moments, std::size_t count) const {
        Buffer<Real> buffer;
        AtWalls<Real> at;
        for (std::size_t done = 0; done < count; done += chunk) {
            const std::size_t c = (first + done) / chunk;
            std::memcpy(buffer.f, chunk_rows(c), directions * chunk * sizeof(Real));
            arrive(c, buffer.f, at);
            alignas(vector_bytes) double sums[4][chunk] = {};
            for (int q = 0; q < directions; ++q) {
                const int* const e = lattice.c[q];
                const Real* const row = buffer.f + static_cast<std::size_t>(q) * chunk;
                for (std::size_t i = 0; i < chunk; ++i) {
                    const double f = row[i];
                    sums[0][i] += e[0] * f;
                    sums[1][i] += e[1] * f;
                    sums[2][i] += e[2] * f;
                    sums[3][i] += f;
                }
            }
            for (std::size_t i = 0; i < smaller(chunk, count - done); ++i) {
                double* const out = reinterpret_cast<double*>(moments + done + i);  // density, then velocity
                out[0] = sums[3][i];
                for (std::size_t a = 0; a < 3; ++a) out[1 + a] = sums[a][i] + 0.5 * data.force_lu[a];
            }
        }
    }

    void set_moments(std::size_t first, const Moments* moments, std::size_t count) const {
        for (std::size_t done = 0; done < count; done += chunk) {
            const std::size_t c = (first + done) / chunk;
            Real* const rows = chunk_rows(c);
            for (std::size_t i = 0; i < smaller(chunk, count - done); ++i) {
                const double* const in = reinterpret_cast<const double*>(moments + done + i);
                double j[3];
                for (std::size_t a = 0; a < 3; ++a) j[a] = in[1 + a] - 0.5 * data.force_lu[a];
                for (int q = 0; q < directions; ++q) {
                    const int* const e = lattice.c[q];
                    rows[static_cast<std::size_t>(q) * chunk + i] =
                        static_cast<Real>(lattice.w[q] * (in[0] + 3.0 * (e[0] * j[0] + e[1] * j[1] + e[2] * j[2])));
                }
            }
            before_arrival(c, rows);
        }
    }

    // Momentum exchange at the walls of one chunk.
    void drag(std::size_t c, double* force) const {
        Buffer<Real> before, after;
        AtWalls<Real> at;
        std::memcpy(before.f, chunk_rows(c), directions * chunk * sizeof(Real));
        arrive(c, before.f, at);
        std::memcpy(after.f, before.f, sizeof(before.f));
        const auto nothing = [](std::size_t) {};
        if (data.inertia)
            collide<true, false>(after.f, data, nothing);
        else
            collide<false, false>(after.f, data, nothing);
        const auto give = [&](int q, std::size_t i) {
            const double given = static_cast<double>(after.f[static_cast<std::size_t>(q) * chunk + i]) +
                                 static_cast<double>(before.f[static_cast<std::size_t>(opposite(q)) * chunk + i]);
            for (int a = 0; a < 3; ++a) force[a] += lattice.c[q][a] * given;
        };
        for (std::uint64_t l = data.first_wall[c]; l < data.first_wall[c + 1]; ++l)
            give(data.wall_row[l] / static_cast<int>(chunk), data.wall_row[l] % chunk);
        for (std::uint64_t g = data.first_gap[c]; g < data.first_gap[c + 1]; ++g) {
            give(data.gaps[g].q, data.gaps[g].place);
            give(opposite(data.gaps[g].q), data.gaps[g].place);
        }
    }
};

template <typename Real>
void two_steps(const KernelData<Real>& data) {
    const Sweep<Real> sweep{data};
    data.inertia ? sweep.template two_steps<true>() : sweep.template two_steps<false>();
}

template <typename Real>
void moments(const KernelData<Real>& data, std::size_t first, Moments* moments, std::size_t count) {
    Sweep<Real>{data}.moments(first, moments, count);
}

template <typename Real>
void set_moments(const KernelData<Real>& data, std::size_t first, const Moments* moments, std::size_t count) {
    Sweep<Real>{data}.set_moments(first, moments, count);
}

template <typename Real>
void drag(const KernelData<Real>& data, double* force) {
    double x = 0.0, y = 0.0, z = 0.0;
#pragma omp parallel for schedule(static) reduction(+ : x, y, z)
    for (std::size_t c = 0; c < data.chunks; ++c) {
        double part[3] = {0.0, 0.0, 0.0};
        Sweep<Real>{data}.drag(c, part);
        x += part[0];
        y += part[1];
        z += part[2];
    }
    force[0] += x;
    force[1] += y;
    force[2] += z;
}

}  // namespace

extern const KernelFunctions<float> single_precision;
extern const KernelFunctions<double> double_precision;
constexpr KernelFunctions<float> single_precision = {two_steps<float>, moments<float>, set_moments<float>, drag<float>};
constexpr KernelFunctions<double> double_precision = {two_steps<double>, moments<double>, set_moments<double>, drag<double>};

}  // namespace porepack::lbm::cpu::lbm::cpu::POREPACK_SET
