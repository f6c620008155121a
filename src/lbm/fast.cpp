// The fast kernel: one copy of the populations, moved in place, in chunks of nodes that fit into the first-level cache.
// A chunk's populations are gathered a vector at a time, collided in vector registers, and scattered back; one sweep through
// memory makes two steps.
#include <cmath>

#include "lbm/chunked_walls.hpp"
#include "lbm/collide.hpp"
#include "lbm/flow.hpp"
#include "lbm/turns.hpp"

namespace porepack {
namespace {

using d3q19::directions;
using d3q19::opposite;

constexpr std::size_t chunk = chunk_nodes;
static_assert(chunk == Flow::chunk);
// A chunk's populations, q after q.
template <typename Real>
struct alignas(vector_bytes) Buffer {
    Real f[directions * chunk];
    [[nodiscard]] Real* row(int q) { return f + static_cast<std::size_t>(q) * chunk; }
};

template <typename Real>
[[nodiscard]] Real* row_of(Real* rows, int q) {
    return rows + static_cast<std::size_t>(q) * chunk;
}

template <typename Real>
class FastFlow : public Flow {
public:
    FastFlow(const Domain& domain, const Scheme& scheme)
        : nodes_(domain.nodes()),
          scheme_(scheme),
          rates_(scheme),
          plus_(static_cast<Real>(scheme.tau - 0.5)),
          magic_(static_cast<Real>(scheme.magic)),
          addresses_(find_addresses(domain, lanes<Real>)),
          turns_(addresses_, chunks()),
          walls_(domain),
          store_(addresses_.slots + directions * chunk) {
        for (int q = 1; q < directions; ++q) kick_[static_cast<std::size_t>(q)] = static_cast<Real>(2.0 * scheme.kick(q));
        std::size_t link = 0;
        for (std::size_t c = 0; c <= chunks(); ++c) {
            first_open_.push_back(static_cast<std::uint32_t>(open_.size()));
            for (; link < domain.open_links.size() && domain.open_links[link].node < (c + 1) * chunk; ++link)
                open_.push_back({static_cast<std::uint16_t>(domain.open_links[link].q * chunk + domain.open_links[link].node - c * chunk),
                                 static_cast<Real>(domain.open_links[link].sign), static_cast<Real>(domain.open_links[link].added)});
        }
#pragma omp parallel for schedule(static)
        for (std::size_t c = 0; c < chunks(); ++c) std::memset(store_.data() + slot_of(0, c * chunk), 0, directions * chunk * sizeof(Real));
        std::memset(store_.data() + addresses_.slots, 0, vector_bytes);
    }

    void advance_two_steps() override {
        scheme_.inertia ? two_steps<true>() : two_steps<false>();
    }

    void moments(std::size_t first, std::span<Moments> moments) const override {
        Buffer<Real> buffer;
        AtWalls at;
        for (std::size_t done = 0; done < moments.size(); done += chunk) {
            const std::size_t c = (first + done) / chunk;
            gather_own(c, buffer);
            arrive(c, buffer.f, at);
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

    void set_moments(std::size_t first, std::span<const Moments> moments) override {
        AtWalls at;
        for (std::size_t done = 0; done < moments.size(); done += chunk) {
            const std::size_t c = (first + done) / chunk;
            Real* const rows = store_.data() + slot_of(0, c * chunk);
            for (std::size_t i = 0; i < std::min(chunk, moments.size() - done); ++i) {
                auto momentum = moments[done + i].velocity;
                for (std::size_t a = 0; a < 3; ++a) momentum[a] -= 0.5 * scheme_.force[a];
                for (int q = 0; q < directions; ++q)
                    row_of(rows, q)[i] = static_cast<Real>(Scheme::equilibrium(q, moments[done + i].density, momentum));
            }
            before_arrival(c, rows, at);
        }
    }

    void set_open_links(std::span<const double> added) override {
        for (std::size_t l = 0; l < open_.size(); ++l) open_[l].added = static_cast<Real>(added[l]);
    }

    [[nodiscard]] std::span<std::byte> state() override {
        return std::as_writable_bytes(std::span(store_.data(), store_.size()));
    }

    [[nodiscard]] std::array<double, 3> drag() const override {
        double x = 0.0, y = 0.0, z = 0.0;
#pragma omp parallel for schedule(static) reduction(+ : x, y, z)
        for (std::size_t c = 0; c < chunks(); ++c) {
            Buffer<Real> before;
            AtWalls at;
            gather_own(c, before);
            arrive(c, before.f, at);
            Buffer<Real> after = before;
            const auto nothing = [](std::size_t) {};
            scheme_.inertia ? collide<true, false>(after.f, rates_, nothing) : collide<false, false>(after.f, rates_, nothing);
            const auto give = [&](int q, std::size_t i) {
                const double given = static_cast<double>(after.row(q)[i]) + static_cast<double>(before.row(opposite(q))[i]);
                x += d3q19::c[static_cast<std::size_t>(q)][0] * given;
                y += d3q19::c[static_cast<std::size_t>(q)][1] * given;
                z += d3q19::c[static_cast<std::size_t>(q)][2] * given;
            };
            for (std::uint64_t l = walls_.first[c]; l < walls_.first[c + 1]; ++l) give(walls_.row[l] / chunk, walls_.row[l] % chunk);
            for (std::uint64_t g = walls_.first_gap[c]; g < walls_.first_gap[c + 1]; ++g) {
                give(walls_.gaps[g].q, walls_.gaps[g].place);
                give(opposite(walls_.gaps[g].q), walls_.gaps[g].place);
            }
        }
        return {x, y, z};
    }

    [[nodiscard]] double bytes() const override {
        return static_cast<double>(store_.size() * sizeof(Real)) + addresses_.bytes() + walls_.bytes() +
               static_cast<double>(sizeof(OpenPlace) * open_.size());
    }

private:
    static constexpr std::size_t most_links = (directions - 1) * chunk;
    [[nodiscard]] std::size_t chunks() const {
        return (nodes_ + chunk - 1) / chunk;
    }

    void gather_own(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.f, store_.data() + slot_of(0, c * chunk), directions * chunk * sizeof(Real));
    }

    void gather_far(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.row(0), store_.data() + slot_of(0, c * chunk), chunk * sizeof(Real));
        const Addresses::Vector* at = vectors_of(c);
        for (std::size_t i = chunk; i < directions * chunk; i += lanes<Real>, ++at) read(buffer.f + i, store_.data(), *at);
        for (std::uint32_t s = addresses_.first_single[c]; s < addresses_.first_single[c + 1]; ++s)
            buffer.f[addresses_.singles[s].place] = store_.data()[addresses_.singles[s].slot];
    }

    void scatter_far(std::size_t c, const Buffer<Real>& buffer) {
        std::memcpy(store_.data() + slot_of(0, c * chunk), buffer.f, chunk * sizeof(Real));
        const Addresses::Vector* at = vectors_of(c);
        for (int q = 1; q < directions; ++q) {
            const Real* const row = row_of(buffer.f, opposite(q));
            for (std::size_t i = 0; i < chunk; i += lanes<Real>, ++at) write(store_.data(), row + i, *at);
        }
        for (std::uint32_t s = addresses_.first_single[c]; s < addresses_.first_single[c + 1]; ++s)
            store_.data()[addresses_.singles[s].slot] = buffer.f[opposite_row(addresses_.singles[s].place)];
    }

    static constexpr std::size_t vectors_a_chunk = (directions - 1) * chunk / lanes<Real>;
    [[nodiscard]] const Addresses::Vector* vectors_of(std::size_t c) const {
        return addresses_.vectors.data() + c * vectors_a_chunk;
    }

    [[nodiscard]] WallWeights<Real> weights(std::uint16_t distance) const {
        return {static_cast<Real>(distance) * Real(1.0 / 65535.0), plus_, magic_};
    }

    // The weights of a chunk's wall links, and what they know before collision: known + to_wall f*_q - from_wall f*_o is stored.
    struct AtWalls {
        alignas(vector_bytes) std::array<Real, most_links + lanes<Real>> arriving, rest, shift, to_wall, from_wall, known;
        void weigh(std::size_t k, const WallWeights<Real>& w) {
            arriving[k] = w.share * w.b;
            rest[k] = Real(1) - w.share;
            shift[k] = w.share * w.shift;
            to_wall[k] = w.share * (Real(1) + w.shift);
            from_wall[k] = w.share * (w.b + w.shift);
        }
        void know(std::size_t k, Real in, Real out, Real kick) { known[k] = rest[k] * out - shift[k] * (in - out + kick); }
        [[nodiscard]] Real stored(std::size_t k, Real in, Real out) const { return known[k] + to_wall[k] * in - from_wall[k] * out; }
    };
    [[nodiscard]] static std::int32_t opposite_row(std::int32_t row) {
        constexpr auto one = static_cast<std::int32_t>(chunk);
        return row - one + 2 * (row & one);
    }

    // Populations as they arrive, in `rows`, with the part of what walls return that depends on what arrives there now.
    void arrive(std::size_t c, Real* rows, AtWalls& at) const {
        for (std::uint32_t l = first_open_[c]; l < first_open_[c + 1]; ++l)
            rows[open_[l].row] = open_[l].sign * rows[open_[l].row] + open_[l].added;
        if (scheme_.walls == Walls::bounce_back) return;
        const std::size_t count = walls_.first[c + 1] - walls_.first[c];
        const std::uint16_t *const row = walls_.row.data() + walls_.first[c], *const distance = walls_.distance.data() + walls_.first[c];
        // Weights a vector at a time; gathers and scatters are faster one by one.
        for (std::size_t block = 0; block < count; block += lanes<Real>)
#pragma omp simd
            for (std::size_t k = block; k < block + lanes<Real>; ++k) at.weigh(k, weights(distance[k]));
#pragma GCC unroll 4
        for (std::size_t k = 0; k < count; ++k) {
            const std::int32_t in = row[k], out = opposite_row(in);
            const Real arrives = rows[in], returns = rows[out] + at.arriving[k] * arrives;
            rows[out] = returns;
            at.know(k, arrives, returns, kick_[static_cast<std::size_t>(in) / chunk]);
        }
        for (std::size_t g = walls_.first_gap[c], k = count; g < walls_.first_gap[c + 1]; ++g, k += 2) {
            const auto& gap = walls_.gaps[g];
            const Real one = row_of(rows, gap.q)[gap.place], other = row_of(rows, gap.q + 1)[gap.place], kick = kick_[gap.q];
            at.weigh(k, weights(gap.distance));
            at.weigh(k + 1, weights(gap.opposite_distance));
            at.know(k, one, other, kick);
            at.know(k + 1, other, one, -kick);
        }
    }

    // Undoes the part of arrive() that changes `rows`.
    void before_arrival(std::size_t c, Real* rows, AtWalls& at) const {
        for (std::uint32_t l = first_open_[c]; l < first_open_[c + 1]; ++l)
            rows[open_[l].row] = open_[l].sign * (rows[open_[l].row] - open_[l].added);
        if (scheme_.walls == Walls::bounce_back) return;
        for (std::uint64_t l = walls_.first[c]; l < walls_.first[c + 1]; ++l) {
            at.weigh(0, weights(walls_.distance[l]));
            const std::int32_t in = walls_.row[l];
            rows[opposite_row(in)] -= at.arriving[0] * rows[in];
        }
    }

    // What leaves towards a wall becomes what the wall stores.
    template <bool swap>
    void meet_walls(std::size_t c, Real* rows, const AtWalls& at) const {
        if (scheme_.walls == Walls::bounce_back) return;
        const std::size_t count = walls_.first[c + 1] - walls_.first[c];
        const std::uint16_t* const row = walls_.row.data() + walls_.first[c];
#pragma GCC unroll 4
        for (std::size_t k = 0; k < count; ++k) {
            const std::int32_t here = row[k], there = opposite_row(here);
            rows[swap ? there : here] = at.stored(k, rows[swap ? there : here], rows[swap ? here : there]);
        }
        for (std::size_t g = walls_.first_gap[c], k = count; g < walls_.first_gap[c + 1]; ++g, k += 2) {
            const auto& gap = walls_.gaps[g];
            Real &one = row_of(rows, swap ? gap.q + 1 : gap.q)[gap.place], &other = row_of(rows, swap ? gap.q : gap.q + 1)[gap.place];
            const Real first = at.stored(k, one, other), second = at.stored(k + 1, other, one);
            const Real weight_a = at.arriving[k], weight_b = at.arriving[k + 1], determinant = Real(1) - weight_a * weight_b;
            one = (first + weight_a * second) / determinant;
            other = (second + weight_b * first) / determinant;
        }
    }

    // Both steps in one sweep: the odd step of a chunk follows as soon as the even steps of all chunks that it reaches are done,
    // while they still lie in a cache. So memory is read and written once for two steps.
    template <bool inertia>
    void two_steps() {
#pragma omp parallel
        for (const Turns::Turn& turn : turns_.turns) {
#pragma omp for schedule(static) nowait
            for (std::size_t c = turn.even; c < turn.even_end; ++c) even_step<inertia>(c);
#pragma omp for schedule(static)
            for (std::size_t i = turn.odd; i < turn.odd_end; ++i)
                odd_step<inertia>(turns_.odd_order[i], turns_.odd_order[std::min(i + 1, chunks() - 1)]);
        }
    }

    // The chunk itself is the buffer.
    template <bool inertia>
    void even_step(std::size_t c) {
        Real* const rows = store_.data() + slot_of(0, c * chunk);
        const Real* const next = store_.data() + slot_of(0, (c + 1) * chunk);
        AtWalls at;
        arrive(c, rows, at);
        collide<inertia, true>(rows, rates_, [&](std::size_t block) {
            for (std::size_t q = 0; q < directions; ++q) __builtin_prefetch(next + q * chunk + block);
        });
        meet_walls<true>(c, rows, at);
    }

    template <bool inertia>
    void odd_step(std::size_t c, std::size_t next) {
        Buffer<Real> buffer;
        AtWalls at;
        gather_far(c, buffer);
        arrive(c, buffer.f, at);
        const Addresses::Vector* vector = vectors_of(next);
        const Real* const store = store_.data();
        const Real* const rest = store + slot_of(0, next * chunk);
        collide<inertia, false>(buffer.f, rates_, [&](std::size_t block) {
            __builtin_prefetch(rest + block);
            for (const Addresses::Vector* const end = vector + directions - 1; vector != end; ++vector) {
                __builtin_prefetch(store + vector->first);
                __builtin_prefetch(store + vector->second);
            }
        });
        meet_walls<false>(c, buffer.f, at);
        scatter_far(c, buffer);
    }

    struct OpenPlace {
        std::uint16_t row;
        Real sign, added;
    };
    std::size_t nodes_;
    Scheme scheme_;
    Rates<Real> rates_;
    Real plus_, magic_;                    // Lambda+ and Lambda
    std::array<Real, directions> kick_{};  // 6 w c.F
    Addresses addresses_;
    Turns turns_;
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
