// The fast kernel: one copy of the populations, streamed in place, in chunks of nodes that fit into the L1 cache.
// The populations of a chunk are gathered one SIMD vector at a time, collided in registers, and scattered back; one sweep makes two
// steps. This file is compiled once per instruction set with the name POREPACK_SET. All its definitions are in a namespace of that name,
// and it instantiates nothing of other headers: the linker keeps one copy of an inline function, and that copy must run on older
// processors (a test examines the object files).
#include <cstring>
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "lbm/kernels/cpu/kernel.hpp"

namespace porepack::lbm::cpu::POREPACK_SET {
namespace {

#include "lbm/kernels/cpu/collide.ipp"

template <typename Real>
struct Sweep {
    const KernelData<Real>& data;

    [[nodiscard]] inline Real* chunk_rows(std::size_t c) const { return data.store + slot_of(0, c * chunk); }
    static constexpr std::size_t groups = (directions - 1) * chunk / group_nodes;  // of a chunk
    static constexpr std::size_t vectors = group_nodes / simd_lanes<Real>;         // of a group
    static constexpr std::uint64_t place_mask = (std::uint64_t{1} << Addresses::place_bits) - 1;
    [[nodiscard]] inline const Addresses::Group* groups_of(std::size_t c) const { return data.groups + c * groups; }
    // Where the slots of a chunk's groups are counted from.
    [[nodiscard]] inline Real* base_of_chunk(std::size_t c) const {
        constexpr std::size_t reach = std::size_t{1} << 31U;
        const std::size_t own = slot_of(0, c * chunk);
        return data.store + (own > reach ? own - reach : 0);
    }
    [[nodiscard]] inline Weights<Real> weights(std::uint16_t distance) const {
        return {static_cast<Real>(distance) * Real(1.0 / 65535.0), data};
    }

    inline void gather_far(std::size_t c, Buffer<Real>& buffer) const {
        std::memcpy(buffer.f, chunk_rows(c), chunk * sizeof(Real));
        const Addresses::Group* at = groups_of(c);
        const Real* const base = base_of_chunk(c);
        const Real* const own = chunk_rows(c);
        for (std::size_t i = chunk; i < directions * chunk; ++at)
            for (std::size_t part = 0; part < vectors; ++part, i += simd_lanes<Real>)
                read(buffer.f + i, base, own + i, Vector<Real>(*at, part));
        for (std::uint64_t s = data.first_single[c]; s < data.first_single[c + 1]; ++s)
            buffer.f[data.singles[s] & place_mask] = data.store[data.singles[s] >> Addresses::place_bits];
    }

    inline void scatter_far(std::size_t c, const Buffer<Real>& buffer) const {
        std::memcpy(chunk_rows(c), buffer.f, chunk * sizeof(Real));
        const Addresses::Group* at = groups_of(c);
        Real* const base = base_of_chunk(c);
        for (int q = 1; q < directions; ++q) {
            const Real* const row = buffer.f + static_cast<std::size_t>(opposite(q)) * chunk;
            Real* const own = chunk_rows(c) + static_cast<std::size_t>(q) * chunk;
            for (std::size_t i = 0; i < chunk; ++at)
                for (std::size_t part = 0; part < vectors; ++part, i += simd_lanes<Real>)
                    write(base, own + i, row + i, Vector<Real>(*at, part));
        }
        for (std::uint64_t s = data.first_single[c]; s < data.first_single[c + 1]; ++s)
            data.store[data.singles[s] >> Addresses::place_bits] = buffer.f[opposite_row(static_cast<int>(data.singles[s] & place_mask))];
    }

    inline void arrive_through_ends(std::size_t c, Real* rows) const {
        for (std::uint32_t l = data.first_boundary[c]; l < data.first_boundary[c + 1]; ++l) {
            const BoundaryPlace<Real>& place = data.boundary[l];
            rows[place.row] = place.sign * rows[place.row] + place.added;
        }
    }

    // Arriving populations, in `rows`, with the part of the wall's return that depends on the populations arriving now.
    inline void arrive(std::size_t c, Real* rows, AtWalls<Real>& at) const {
        arrive_through_ends(c, rows);
        if (!data.interpolated) return;
        const std::size_t count = data.first_wall[c + 1] - data.first_wall[c];
        const std::uint16_t *const row = data.wall_row + data.first_wall[c], *const distance = data.wall_distance + data.first_wall[c];
        // Weights one vector at a time; gathers and scatters are faster one by one.
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

    // visit(in, part) for the wall links of a chunk: the population returning from the wall gets this part of the one in row `in`.
    template <typename Visit>
    inline void for_returns(std::size_t c, const Visit& visit) const {
        if (!data.interpolated) return;
        const std::size_t begin = data.first_wall[c], links = data.first_wall[c + 1] - begin;
        alignas(vector_bytes) Real part[simd_lanes<Real>];
        for (std::size_t block = 0; block < links; block += simd_lanes<Real>) {
#pragma omp simd
            for (std::size_t k = 0; k < simd_lanes<Real>; ++k) {
                const Weights<Real> w = weights(data.wall_distance[begin + block + k]);
                part[k] = w.share * w.b;
            }
            for (std::size_t k = 0; k < smaller(simd_lanes<Real>, links - block); ++k) visit(data.wall_row[begin + block + k], part[k]);
        }
    }

    // Undoes the part of arrive() that changes `rows`, in the opposite order.
    inline void before_arrival(std::size_t c, Real* rows) const {
        for_returns(c, [&](int in, Real part) { rows[opposite_row(in)] -= part * rows[in]; });
        for (std::uint32_t l = data.first_boundary[c]; l < data.first_boundary[c + 1]; ++l) {
            const BoundaryPlace<Real>& place = data.boundary[l];
            rows[place.row] = place.sign * (rows[place.row] - place.added);
        }
    }

    // The population leaving towards a wall becomes the value that the wall link stores.
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

    // Fetches the part of a chunk that belongs to a block of nodes if its memory is read in order, into the first or second cache.
    template <int first_or_second>
    static inline void fetch(const Real* chunk_memory, std::size_t block) {
        for (std::size_t q = 0; q < directions; ++q)
            __builtin_prefetch(chunk_memory + block * directions + q * simd_lanes<Real>, 0, 4 - first_or_second);
    }

    // The chunk itself is the buffer.
    template <Model model>
    void even_step(std::size_t c) const {
        Real* const rows = chunk_rows(c);
        const Real* const next = chunk_rows(c + 1);
        AtWalls<Real> at;
        arrive(c, rows, at);
        collide<model, true>(rows, data, [&](std::size_t block) { fetch<1>(next, block); });
        meet_walls<true>(c, rows, at);
    }

    // `next` is the chunk of the next odd step, `later` one of the even steps after them: memory is read while this step computes.
    template <Model model>
    void odd_step(std::size_t c, std::size_t next, std::size_t later) const {
        Buffer<Real> buffer;
        AtWalls<Real> at;
        gather_far(c, buffer);
        arrive(c, buffer.f, at);
        const Addresses::Group* group = groups_of(next);
        const Real *const rest = chunk_rows(next), *const base = base_of_chunk(next), *const next_even = chunk_rows(later);
        collide<model, false>(buffer.f, data, [&](std::size_t block) {
            fetch<2>(next_even, block);
            __builtin_prefetch(rest + block);
            const Addresses::Group* const end = group + (directions - 1) / vectors;
            for (; group != end; ++group)
                for (std::size_t part = 0; part < vectors; ++part) {
                    __builtin_prefetch(base + group->first + part * simd_lanes<Real>);
                    __builtin_prefetch(base + group->second + part * simd_lanes<Real>);
                }
        });
        meet_walls<false>(c, buffer.f, at);
        scatter_far(c, buffer);
    }

    // Both steps in one sweep: the odd step of a chunk follows when the even steps of all chunks that it accesses are done, while they
    // are still in a cache. Memory is then read and written once per two steps.
    template <Model model>
    void two_steps(std::size_t first_part, std::size_t end_part) const {
#pragma omp parallel
        for (std::size_t p = first_part; p < end_part; ++p) {
            const Schedule::Part& part = data.parts[p];
#pragma omp for schedule(static) nowait
            for (std::size_t c = part.even; c < part.even_end; ++c) even_step<model>(c);
#pragma omp for schedule(static)
            for (std::size_t i = part.odd; i < part.odd_end; ++i)
                odd_step<model>(data.odd_order[i], data.odd_order[smaller(i + 1, data.chunks - 1)],
                                smaller(part.even_end + (i - part.odd), data.chunks - 1));
        }
    }

    // Of what is stored, and then of what the walls return besides.
    void moments(std::size_t first, Moments* moments, std::size_t count) const {
        Buffer<Real> buffer;
        for (std::size_t done = 0; done < count; done += chunk) {
            const std::size_t c = (first + done) / chunk;
            const Real* rows = chunk_rows(c);
            for (std::size_t block = 0; block < chunk; block += simd_lanes<Real>) fetch<2>(chunk_rows(c + 1), block);
            if (data.first_boundary[c] != data.first_boundary[c + 1]) {
                std::memcpy(buffer.f, rows, directions * chunk * sizeof(Real));
                arrive_through_ends(c, buffer.f);
                rows = buffer.f;
            }
            alignas(vector_bytes) double sums[4][chunk];  // momentum, density
#pragma omp simd
            for (std::size_t i = 0; i < chunk; ++i) {
                double sum = 0.0, x = 0.0, y = 0.0, z = 0.0;
#pragma GCC unroll 19
                for (int q = 0; q < directions; ++q) {
                    const double f = rows[static_cast<std::size_t>(q) * chunk + i];
                    sum += f;
                    if (lattice.c[q][0] != 0) x += lattice.c[q][0] * f;
                    if (lattice.c[q][1] != 0) y += lattice.c[q][1] * f;
                    if (lattice.c[q][2] != 0) z += lattice.c[q][2] * f;
                }
                sums[0][i] = x;
                sums[1][i] = y;
                sums[2][i] = z;
                sums[3][i] = sum;
            }
            for_returns(c, [&](int in, Real part) {
                const double returned = part * rows[in];
                const int* const e = lattice.c[opposite(in / static_cast<int>(chunk))];
                const int i = in % static_cast<int>(chunk);
                for (std::size_t axis = 0; axis < 3; ++axis) sums[axis][i] += e[axis] * returned;
                sums[3][i] += returned;
            });
            for (std::size_t i = 0; i < smaller(chunk, count - done); ++i) {
                double* const out = reinterpret_cast<double*>(moments + done + i);  // density, then velocity
                out[0] = sums[3][i];
                for (std::size_t axis = 0; axis < 3; ++axis) out[1 + axis] = sums[axis][i] + 0.5 * data.force_lu[axis];
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

    // What is stored depends linearly on the arriving populations: each gets w times the density, as before_arrival() would pass it on.
    void add_density(std::size_t first, const double* added, std::size_t count) const {
        for (std::size_t done = 0; done < count; done += chunk) {
            const std::size_t c = (first + done) / chunk;
            Real* const rows = chunk_rows(c);
            alignas(vector_bytes) Real density[chunk] = {};
            for (std::size_t i = 0; i < smaller(chunk, count - done); ++i) density[i] = static_cast<Real>(added[done + i]);
            const auto share_of = [&](int row) {
                return static_cast<Real>(lattice.w[row / static_cast<int>(chunk)]) * density[row % static_cast<int>(chunk)];
            };
            // An inflow that changes sign on its way takes the density away.
            for (std::uint32_t l = data.first_boundary[c]; l < data.first_boundary[c + 1]; ++l) {
                const BoundaryPlace<Real>& place = data.boundary[l];
                rows[place.row] += (place.sign - Real(1)) * share_of(place.row);
            }
            for (int q = 0; q < directions; ++q) {
                Real* const row = rows + static_cast<std::size_t>(q) * chunk;
                const auto w = static_cast<Real>(lattice.w[q]);
                for (std::size_t i = 0; i < chunk; ++i) row[i] += w * density[i];
            }
            for_returns(c, [&](int in, Real part) { rows[opposite_row(in)] -= part * share_of(in); });
        }
    }

    // Momentum exchange at the walls, three numbers per node.
    void wall_forces(std::size_t first, double* forces, std::size_t count) const {
        for (std::size_t done = 0; done < count; done += chunk) {
            alignas(vector_bytes) double of_chunk[3 * chunk] = {};
            wall_forces_of_chunk((first + done) / chunk, of_chunk);
            std::memcpy(forces + 3 * done, of_chunk, 3 * smaller(chunk, count - done) * sizeof(double));
        }
    }

    void wall_forces_of_chunk(std::size_t c, double* force) const {
        if (data.first_wall[c] == data.first_wall[c + 1] && data.first_gap[c] == data.first_gap[c + 1]) return;
        Buffer<Real> before, after;
        AtWalls<Real> at;
        std::memcpy(before.f, chunk_rows(c), directions * chunk * sizeof(Real));
        arrive(c, before.f, at);
        std::memcpy(after.f, before.f, sizeof(before.f));
        const auto nothing = [](std::size_t) {};
        switch (data.model) {
            case Model::stokes:
                collide<Model::stokes, false>(after.f, data, nothing);
                break;
            case Model::navier_stokes:
                collide<Model::navier_stokes, false>(after.f, data, nothing);
                break;
            case Model::regularised:
                collide<Model::regularised, false>(after.f, data, nothing);
                break;
            case Model::recursive:
                collide<Model::recursive, false>(after.f, data, nothing);
                break;
        }
        const auto give = [&](int q, std::size_t i) {
            const double given = static_cast<double>(after.f[static_cast<std::size_t>(q) * chunk + i]) +
                                 static_cast<double>(before.f[static_cast<std::size_t>(opposite(q)) * chunk + i]);
            for (std::size_t a = 0; a < 3; ++a) force[3 * i + a] += lattice.c[q][a] * given;
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
void two_steps(const KernelData<Real>& data, std::size_t first_part, std::size_t end_part) {
    const Sweep<Real> sweep{data};
    switch (data.model) {
        case Model::stokes:
            return sweep.template two_steps<Model::stokes>(first_part, end_part);
        case Model::navier_stokes:
            return sweep.template two_steps<Model::navier_stokes>(first_part, end_part);
        case Model::regularised:
            return sweep.template two_steps<Model::regularised>(first_part, end_part);
        case Model::recursive:
            return sweep.template two_steps<Model::recursive>(first_part, end_part);
    }
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
void add_density(const KernelData<Real>& data, std::size_t first, const double* added, std::size_t count) {
    Sweep<Real>{data}.add_density(first, added, count);
}

template <typename Real>
void wall_forces(const KernelData<Real>& data, std::size_t first, double* forces, std::size_t count) {
    Sweep<Real>{data}.wall_forces(first, forces, count);
}

}  // namespace

extern const KernelFunctions<float> single_precision;
extern const KernelFunctions<double> double_precision;
constexpr KernelFunctions<float> single_precision = {two_steps<float>, moments<float>, set_moments<float>, add_density<float>,
                                                     wall_forces<float>};
constexpr KernelFunctions<double> double_precision = {two_steps<double>, moments<double>, set_moments<double>, add_density<double>,
                                                      wall_forces<double>};

}  // namespace porepack::lbm::cpu::POREPACK_SET
