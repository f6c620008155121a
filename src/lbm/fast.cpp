// The fast kernel: one copy of the populations, moved in place, in chunks of nodes that fit into the first-level cache.
// A chunk's populations are gathered from few contiguous segments, collided in vector registers, and scattered back.
#include <sys/mman.h>

#include <cmath>
#include <cstring>
#include <new>
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "lbm/addresses.hpp"
#include "lbm/chunked_walls.hpp"
#include "lbm/flow.hpp"

namespace porepack {
namespace {

using d3q19::directions;
using d3q19::opposite;

constexpr std::size_t chunk = chunk_nodes;
static_assert(chunk == Flow::chunk);
constexpr std::size_t vector_bytes = 64;
template <typename Real>
constexpr std::size_t lanes = vector_bytes / sizeof(Real);

// A chunk's populations, q after q. Copies may run over the end of a row by less than a vector.
template <typename Real>
struct alignas(vector_bytes) Buffer {
    Real f[directions * chunk + lanes<Real>];
    [[nodiscard]] Real* row(int q) { return f + static_cast<std::size_t>(q) * chunk; }
};

// Whole vectors, whatever the length: what is written too much is overwritten next.
template <typename Real>
inline void copy_in(Real* to, const Real* from, std::size_t length) {
    for (std::size_t i = 0; i < length; i += lanes<Real>) std::memcpy(to + i, from + i, vector_bytes);
}

template <typename Real>
inline void copy_out(Real* to, const Real* from, std::size_t length) {
    std::size_t i = 0;
    for (; i + lanes<Real> <= length; i += lanes<Real>) std::memcpy(to + i, from + i, vector_bytes);
#if defined(__AVX512F__)
    const auto rest = static_cast<unsigned>(length - i);
    if constexpr (sizeof(Real) == 8)
        _mm512_mask_storeu_pd(to + i, static_cast<__mmask8>((1U << rest) - 1U), _mm512_loadu_pd(from + i));
    else
        _mm512_mask_storeu_ps(to + i, static_cast<__mmask16>((1U << rest) - 1U), _mm512_loadu_ps(from + i));
#else
    for (; i < length; ++i) to[i] = from[i];
#endif
}

template <typename Real>
Real* row_of(Real* rows, int q) {
    return rows + static_cast<std::size_t>(q) * chunk;
}

// Memory that each thread touches first itself, in large pages where the system gives them.
template <typename Real>
class Populations {
public:
    explicit Populations(std::size_t count) : count_(count) {
        constexpr std::size_t page = std::size_t{1} << 21;
        bytes_ = (count * sizeof(Real) + page - 1) / page * page;
        data_ = static_cast<Real*>(::operator new (bytes_, std::align_val_t{page}));
        madvise(data_, bytes_, MADV_HUGEPAGE);
    }
    Populations(const Populations&) = delete;
    Populations& operator=(const Populations&) = delete;
    ~Populations() { ::operator delete (data_, std::align_val_t{std::size_t{1} << 21}); }
    [[nodiscard]] Real* data() { return data_; }
    [[nodiscard]] const Real* data() const { return data_; }
    [[nodiscard]] std::size_t size() const { return count_; }

private:
    std::size_t count_, bytes_;
    Real* data_;
};

template <typename Real>
struct Rates {
    Real plus, minus;
    std::array<Real, 3> force;
    std::array<Real, 9> kick;  // of each pair's first direction
};

// Legend: s and d sum and difference of a pair of opposite populations, rho density, j momentum, u velocity.
// `swap` leaves each population in its opposite's row. `fetch` is called once a vector: it brings the next chunk nearer.
template <bool inertia, bool swap, typename Real, typename Fetch>
void collide(Real* const rows, const Rates<Real>& rates, const Fetch& fetch) {
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

template <typename Real>
class FastFlow : public Flow {
public:
    FastFlow(const Domain& domain, const Scheme& scheme)
        : nodes_(domain.nodes()),
          scheme_(scheme),
          plus_(static_cast<Real>(scheme.tau - 0.5)),
          magic_(static_cast<Real>(scheme.magic)),
          addresses_(find_addresses(domain)),
          walls_(domain),
          store_(addresses_.slots + directions * chunk) {
        rates_ = {static_cast<Real>(scheme.rate_plus()), static_cast<Real>(scheme.rate_minus()), {}, {}};
        for (std::size_t a = 0; a < 3; ++a) rates_.force[a] = static_cast<Real>(scheme.force[a]);
        for (std::size_t k = 0; k < 9; ++k) rates_.kick[k] = static_cast<Real>(scheme.kick(static_cast<int>(2 * k + 1)));
        std::size_t link = 0;
        for (std::size_t c = 0; c <= chunks(); ++c) {
            first_open_.push_back(static_cast<std::uint32_t>(open_.size()));
            for (; link < domain.open_links.size() && domain.open_links[link].node < (c + 1) * chunk; ++link)
                open_.push_back({static_cast<std::uint8_t>(domain.open_links[link].node - c * chunk), domain.open_links[link].q});
        }
#pragma omp parallel for schedule(static)
        for (std::size_t c = 0; c < chunks(); ++c) std::memset(store_.data() + slot_of(0, c * chunk), 0, directions * chunk * sizeof(Real));
        std::memset(store_.data() + addresses_.slots, 0, vector_bytes);
    }

    void advance_two_steps() override {
        scheme_.inertia ? even_step<true>() : even_step<false>();
        scheme_.inertia ? odd_step<true>() : odd_step<false>();
    }

    void moments(std::size_t first, std::span<Moments> moments) const override {
        Buffer<Real> buffer;
        std::array<Real, most_links> stored;
        for (std::size_t done = 0; done < moments.size(); done += chunk) {
            const std::size_t c = (first + done) / chunk;
            gather_own(c, buffer);
            arrive(c, buffer.f, stored);
            alignas(vector_bytes) std::array<std::array<double, chunk>, 4> sums{};
            for (int q = 0; q < directions; ++q) {
                const auto& e = d3q19::c[static_cast<std::size_t>(q)];
                const Real* row = buffer.row(q);
                for (std::size_t i = 0; i < chunk; ++i) {
                    const double f = row[i];
                    sums[0][i] += e[0] * f;
                    sums[1][i] += e[1] * f;
                    sums[2][i] += e[2] * f;
                    sums[3][i] += f;
                }
            }
            for (std::size_t i = 0; i < std::min(chunk, moments.size() - done); ++i) {
                moments[done + i] = {sums[3][i], {sums[0][i], sums[1][i], sums[2][i]}};
                for (std::size_t a = 0; a < 3; ++a) moments[done + i].velocity[a] += 0.5 * scheme_.force[a];
            }
        }
    }

    [[nodiscard]] std::array<double, 3> drag() const override {
        double x = 0.0, y = 0.0, z = 0.0;
#pragma omp parallel for schedule(static) reduction(+ : x, y, z)
        for (std::size_t c = 0; c < chunks(); ++c) {
            Buffer<Real> before;
            std::array<Real, most_links> stored;
            gather_own(c, before);
            arrive(c, before.f, stored);
            Buffer<Real> after = before;
            const auto nothing = [](std::size_t) {};
            scheme_.inertia ? collide<true, false>(after.f, rates_, nothing) : collide<false, false>(after.f, rates_, nothing);
            const auto give = [&](int q, std::size_t i) {
                const double given = static_cast<double>(after.row(q)[i]) + static_cast<double>(before.row(opposite(q))[i]);
                x += d3q19::c[static_cast<std::size_t>(q)][0] * given;
                y += d3q19::c[static_cast<std::size_t>(q)][1] * given;
                z += d3q19::c[static_cast<std::size_t>(q)][2] * given;
            };
            std::uint64_t l = walls_.first[c];
            for (int q = 1; q < directions; ++q)
                for (int k = 0; k < walls_.count[c][static_cast<std::size_t>(q)]; ++k, ++l) give(q, walls_.place[l]);
            for (std::uint64_t g = walls_.first_gap[c]; g < walls_.first_gap[c + 1]; ++g) {
                give(walls_.gaps[g].q, walls_.gaps[g].place);
                give(opposite(walls_.gaps[g].q), walls_.gaps[g].place);
            }
        }
        return {x, y, z};
    }

    [[nodiscard]] double bytes() const override {
        return static_cast<double>(store_.size() * sizeof(Real)) + addresses_.bytes() + walls_.bytes() +
               2.0 * static_cast<double>(open_.size());
    }

private:
    static constexpr std::size_t most_links = (directions - 1) * chunk;
    [[nodiscard]] std::size_t chunks() const {
        return (nodes_ + chunk - 1) / chunk;
    }
    [[nodiscard]] std::size_t size_of(std::size_t c) const {
        return std::min(chunk, nodes_ - c * chunk);
    }

    void gather_own(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.f, store_.data() + slot_of(0, c * chunk), directions * chunk * sizeof(Real));
    }

    void gather_far(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.row(0), store_.data() + slot_of(0, c * chunk), chunk * sizeof(Real));
        const std::size_t size = size_of(c);
        std::uint64_t segment = addresses_.first_segment[c];
        for (int q = 1; q < directions; ++q) {
            Real* row = buffer.row(q);
            for (std::size_t at = 0; at < size; ++segment) {
                copy_in(row + at, store_.data() + addresses_.slot[segment], addresses_.length[segment]);
                at += addresses_.length[segment];
            }
        }
    }

    void scatter_far(std::size_t c, Buffer<Real>& buffer) {
        const std::size_t size = size_of(c);
        std::memcpy(store_.data() + slot_of(0, c * chunk), buffer.row(0), size * sizeof(Real));
        std::uint64_t segment = addresses_.first_segment[c];
        for (int q = 1; q < directions; ++q) {
            const Real* row = buffer.row(opposite(q));
            for (std::size_t at = 0; at < size; ++segment) {
                copy_out(store_.data() + addresses_.slot[segment], row + at, addresses_.length[segment]);
                at += addresses_.length[segment];
            }
        }
    }

    [[nodiscard]] WallWeights<Real> weights(std::uint16_t distance) const {
        return {static_cast<Real>(distance) * Real(1.0 / 65535.0), plus_, magic_};
    }
    // The part of what a wall stores that is known before collision; `in` goes to the wall, `out` comes from it.
    static Real known(const WallWeights<Real>& w, Real in, Real out, Real kick) {
        return (Real(1) - w.share) * out - w.share * w.shift * (in - out + kick);
    }
    static Real added(const WallWeights<Real>& w, Real in, Real out) {
        return w.share * ((Real(1) + w.shift) * in - (w.b + w.shift) * out);
    }

    // Populations as they arrive, in `buffer`; the part of what walls store that is known before collision, in `stored`.
    void arrive(std::size_t c, Real* rows, std::array<Real, most_links>& stored) const {
        for (std::uint32_t l = first_open_[c]; l < first_open_[c + 1]; ++l) {
            Real& value = rows[open_[l].q * chunk + open_[l].place];
            value = -value;
        }
        if (scheme_.walls == Walls::bounce_back) return;
        std::size_t l = walls_.first[c], s = 0;
        for (int q = 1; q < directions; ++q) {
            const std::size_t count = walls_.count[c][static_cast<std::size_t>(q)];
            const Real* in = row_of(rows, q);
            Real* out = row_of(rows, opposite(q));
            const Real kick = static_cast<Real>(2.0 * scheme_.kick(q));
            for (std::size_t k = 0; k < count; ++k) {
                const std::size_t i = walls_.place[l + k];
                const WallWeights<Real> w = weights(walls_.distance[l + k]);
                out[i] += w.share * w.b * in[i];
                stored[s + k] = known(w, in[i], out[i], kick);
            }
            l += count;
            s += count;
        }
        for (std::uint64_t g = walls_.first_gap[c]; g < walls_.first_gap[c + 1]; ++g, s += 2) {
            const auto& gap = walls_.gaps[g];
            const Real one = row_of(rows, gap.q)[gap.place], other = row_of(rows, gap.q + 1)[gap.place];
            const Real kick = static_cast<Real>(2.0 * scheme_.kick(gap.q));
            stored[s] = known(weights(gap.distance), one, other, kick);
            stored[s + 1] = known(weights(gap.opposite_distance), other, one, -kick);
        }
    }

    // What leaves towards a wall becomes what the wall stores.
    template <bool swap>
    void meet_walls(std::size_t c, Real* rows, const std::array<Real, most_links>& stored) const {
        if (scheme_.walls == Walls::bounce_back) return;
        std::size_t l = walls_.first[c], s = 0;
        for (int q = 1; q < directions; ++q) {
            const std::size_t count = walls_.count[c][static_cast<std::size_t>(q)];
            Real* in = row_of(rows, swap ? opposite(q) : q);
            const Real* out = row_of(rows, swap ? q : opposite(q));
            for (std::size_t k = 0; k < count; ++k) {
                const std::size_t i = walls_.place[l + k];
                in[i] = added(weights(walls_.distance[l + k]), in[i], out[i]) + stored[s + k];
            }
            l += count;
            s += count;
        }
        for (std::uint64_t g = walls_.first_gap[c]; g < walls_.first_gap[c + 1]; ++g, s += 2) {
            const auto& gap = walls_.gaps[g];
            Real &one = row_of(rows, swap ? gap.q + 1 : gap.q)[gap.place], &other = row_of(rows, swap ? gap.q : gap.q + 1)[gap.place];
            const auto a = weights(gap.distance), b = weights(gap.opposite_distance);
            const Real first = added(a, one, other) + stored[s], second = added(b, other, one) + stored[s + 1];
            const Real weight_a = a.share * a.b, weight_b = b.share * b.b, determinant = Real(1) - weight_a * weight_b;
            one = (first + weight_a * second) / determinant;
            other = (second + weight_b * first) / determinant;
        }
    }

    // The chunk itself is the buffer.
    template <bool inertia>
    void even_step() {
#pragma omp parallel for schedule(static)
        for (std::size_t c = 0; c < chunks(); ++c) {
            Real* const rows = store_.data() + slot_of(0, c * chunk);
            const Real* const next = store_.data() + slot_of(0, (c + 1) * chunk);
            std::array<Real, most_links> stored;
            arrive(c, rows, stored);
            collide<inertia, true>(rows, rates_, [&](std::size_t block) {
                for (std::size_t q = 0; q < directions; ++q) __builtin_prefetch(next + q * chunk + block);
            });
            meet_walls<true>(c, rows, stored);
        }
    }

    template <bool inertia>
    void odd_step() {
#pragma omp parallel for schedule(static)
        for (std::size_t c = 0; c < chunks(); ++c) {
            Buffer<Real> buffer;
            std::array<Real, most_links> stored;
            gather_far(c, buffer);
            arrive(c, buffer.f, stored);
            const std::size_t next = std::min(c + 1, chunks() - 1);
            std::uint64_t segment = addresses_.first_segment[next];
            const std::uint64_t end = addresses_.first_segment[next + 1];
            const std::uint64_t share = (end - segment) * lanes<Real> / chunk + 1;
            const Real* const rest = store_.data() + slot_of(0, next * chunk);
            collide<inertia, false>(buffer.f, rates_, [&](std::size_t block) {
                __builtin_prefetch(rest + block);
                for (const std::uint64_t until = std::min(end, segment + share); segment < until; ++segment) {
                    const Real* const from = store_.data() + addresses_.slot[segment];
                    for (const Real* line = from; line < from + addresses_.length[segment]; line += lanes<Real>) __builtin_prefetch(line);
                    __builtin_prefetch(from + addresses_.length[segment] - 1);
                }
            });
            meet_walls<false>(c, buffer.f, stored);
            scatter_far(c, buffer);
        }
    }

    struct OpenPlace {
        std::uint8_t place, q;
    };
    std::size_t nodes_;
    Scheme scheme_;
    Rates<Real> rates_;
    Real plus_, magic_;  // Lambda+ and Lambda
    Addresses addresses_;
    ChunkedWalls walls_;
    std::vector<OpenPlace> open_;
    std::vector<std::uint32_t> first_open_;
    Populations<Real> store_;
};

}  // namespace

template <typename Real>
std::unique_ptr<Flow> make_fast_flow(const Domain& domain, const Scheme& scheme) {
    return std::make_unique<FastFlow<Real>>(domain, scheme);
}
template std::unique_ptr<Flow> make_fast_flow<float>(const Domain&, const Scheme&);
template std::unique_ptr<Flow> make_fast_flow<double>(const Domain&, const Scheme&);

std::unique_ptr<Flow> make_flow(Kernel kernel, const Domain& domain, const Scheme& scheme) {
    if (kernel == Kernel::reference) return make_reference_flow(domain, scheme);
    return kernel == Kernel::fast_single ? make_fast_flow<float>(domain, scheme) : make_fast_flow<double>(domain, scheme);
}

}  // namespace porepack
