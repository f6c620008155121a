// Lattice Boltzmann on a device: the method, the memory layout and the equations of the fast kernel of the processor (kernels/cpu,
// kernels/layout, docs/theory.md). A group of threads works on a chunk of 128 nodes, whose populations it keeps in shared memory, q after q:
// rows. Populations are of type `real`, sums of type double.
#if defined(DOUBLE)
typedef double real;
#else
typedef float real;
#endif
#define CHUNK 128
#define DIRECTIONS 19
#define ROWS (DIRECTIONS * CHUNK)

// The types of kernels/layout and of device_flow.cpp.
typedef struct {
    u32 first, second;
    u16 first_nodes, second_nodes;
} Group;
typedef struct {
    u8 place, q;
    u16 distance, opposite_distance;
} Gap;
typedef struct {
    u16 row;
    real sign, added;
} End;
typedef struct {
    real rate_plus, rate_minus;
    real wall_shift, wall_magic, wall_bound, wall_limit;
    real force[3];
    real term[9];  // force terms of q = 1, 3, ... 17
} Rates;

// The memory of the populations, in pieces of 2^piece_bits numbers where the driver gives none that is large enough.
#if PIECES > 1
#define STORE                                                                                                                     \
    GLOBAL real *piece0, GLOBAL real *piece1, GLOBAL real *piece2, GLOBAL real *piece3, GLOBAL real *piece4, GLOBAL real *piece5, \
        GLOBAL real *piece6, GLOBAL real *piece7, const u32 piece_bits
#define GIVE_STORE piece0, piece1, piece2, piece3, piece4, piece5, piece6, piece7, piece_bits
#define AT(slot) (*number_at(slot, GIVE_STORE))
FUNCTION GLOBAL real* number_at(const u64 slot, STORE) {
    const u32 piece = (u32)(slot >> piece_bits);
    GLOBAL real* const even = piece < 4 ? (piece < 2 ? piece0 : piece2) : (piece < 6 ? piece4 : piece6);
    GLOBAL real* const odd = piece < 4 ? (piece < 2 ? piece1 : piece3) : (piece < 6 ? piece5 : piece7);
    return ((piece & 1) ? odd : even) + (slot & (((u64)1 << piece_bits) - 1));
}
#else
#define STORE GLOBAL real *store
#define AT(slot) store[slot]
#endif

#define WALLS                                                                                                            \
    GLOBAL const u64 *first_wall, GLOBAL const u16 *wall_row, GLOBAL const u16 *wall_distance, GLOBAL const u64 *first_gap, \
        GLOBAL const Gap *gaps, const u32 interpolated, GLOBAL const u32 *first_end, GLOBAL const End *ends
#define GIVE_WALLS first_wall, wall_row, wall_distance, first_gap, gaps, interpolated, first_end, ends

// The wall links and gaps of a chunk, where they are `counted`.
#define COUNT_WALLS(counted)                                                                           \
    const u32 links = (counted) ? (u32)(first_wall[c + 1] - first_wall[c]) : 0;                 \
    const u32 narrow = (counted) ? (u32)(first_gap[c + 1] - first_gap[c]) : 0;                  \
    GLOBAL const u16* const row = wall_row + first_wall[c];                                     \
    GLOBAL const u16* const distance = wall_distance + first_wall[c];                           \
    GLOBAL const Gap* const gap = gaps + first_gap[c];                                              \
    (void)links, (void)narrow, (void)row, (void)distance, (void)gap;

FUNCTION u32 opposite_row(const u32 row) {
    return row - CHUNK + 2 * (row & CHUNK);
}
FUNCTION u32 opposite(const u32 q) {
    return ((q - 1) ^ 1) + 1;
}
// 6 w c_q.F.
FUNCTION real twice_the_term(const Rates rates, const u32 q) {
    const u32 pair = (q - 1) / 2;
    real term = rates.term[0];
#pragma unroll
    for (u32 k = 1; k < 9; ++k) term = pair == k ? rates.term[k] : term;
    return (q & 1) ? (real)2 * term : (real)-2 * term;
}

// WallWeights in lbm/scheme.hpp.
typedef struct {
    real share, shift, b;
} Weights;
FUNCTION Weights weights_at(const u16 distance, const Rates rates) {
    const real x = (real)distance * (real)(1.0 / 65535.0), second = (real)0.75 * x * x, inverse = (real)1 / ((real)1 + (real)2 * x);
    Weights w;
    w.b = ((real)1 - (real)2 * x) * inverse;
    w.shift = rates.wall_shift * inverse * (rates.wall_magic - second);
    w.share = rates.wall_bound < rates.wall_limit * second ? rates.wall_bound / second : rates.wall_limit;
    return w;
}
FUNCTION real known_at(const Weights w, const real in, const real out, const real term) {
    return ((real)1 - w.share) * out - w.share * w.shift * (in - out + term);
}
FUNCTION real stored_at(const Weights w, const real known, const real in, const real out) {
    return known + w.share * ((real)1 + w.shift) * in - w.share * (w.b + w.shift) * out;
}

FUNCTION void arrive_through_ends(const u64 c, const u32 thread, LOCAL real* rows, WALLS) {
    for (u32 l = first_end[c] + thread; l < first_end[c + 1]; l += CHUNK) rows[ends[l].row] = ends[l].sign * rows[ends[l].row] + ends[l].added;
}

// The part of the wall's return that depends on the populations arriving now is added, and with `known` the rest is kept there: one number
// per link, two per gap.
FUNCTION void arrive_at_walls(const u64 c, const u32 thread, LOCAL real* rows, LOCAL real* known, const Rates rates, const int keep, WALLS) {
    COUNT_WALLS(interpolated)
    for (u32 k = thread; k < links; k += CHUNK) {
        const u32 in = row[k], out = opposite_row(in);
        const Weights w = weights_at(distance[k], rates);
        const real arrives = rows[in], returns = rows[out] + w.share * w.b * arrives;
        rows[out] = returns;
        if (keep) known[k] = known_at(w, arrives, returns, twice_the_term(rates, in / CHUNK));
    }
    for (u32 g = thread; keep && g < narrow; g += CHUNK) {
        const real one = rows[gap[g].q * CHUNK + gap[g].place], other = rows[(gap[g].q + 1) * CHUNK + gap[g].place];
        const real term = twice_the_term(rates, gap[g].q);
        known[links + 2 * g] = known_at(weights_at(gap[g].distance, rates), one, other, term);
        known[links + 2 * g + 1] = known_at(weights_at(gap[g].opposite_distance, rates), other, one, -term);
    }
}

// The population leaving towards a wall becomes the value that the wall link stores. `swap`: populations are in their opposite's rows.
FUNCTION void meet_walls(const u64 c, const u32 thread, LOCAL real* rows, LOCAL const real* known, const Rates rates, const int swap, WALLS) {
    COUNT_WALLS(interpolated)
    for (u32 k = thread; k < links; k += CHUNK) {
        const u32 in = row[k], out = opposite_row(in), here = swap ? out : in, there = swap ? in : out;
        rows[here] = stored_at(weights_at(distance[k], rates), known[k], rows[here], rows[there]);
    }
    for (u32 g = thread; g < narrow; g += CHUNK) {
        const Weights a = weights_at(gap[g].distance, rates), b = weights_at(gap[g].opposite_distance, rates);
        const u32 one = (swap ? gap[g].q + 1 : gap[g].q) * CHUNK + gap[g].place, other = (swap ? gap[g].q : gap[g].q + 1) * CHUNK + gap[g].place;
        const real first = stored_at(a, known[links + 2 * g], rows[one], rows[other]),
                   second = stored_at(b, known[links + 2 * g + 1], rows[other], rows[one]);
        const real weight_a = a.share * a.b, weight_b = b.share * b.b, determinant = (real)1 - weight_a * weight_b;
        rows[one] = (first + weight_a * second) / determinant;
        rows[other] = (second + weight_b * first) / determinant;
    }
}

// Models of lbm/scheme.hpp.
#define STOKES 0
#define NAVIER_STOKES 1
#define REGULARISED 2
#define RECURSIVE 3

// One node; the equations of kernels/cpu/collide.ipp. Legend: s and d sum and difference of a pair of opposite populations, rho density, j
// momentum, u velocity.
FUNCTION void collide(LOCAL real* f, const u32 i, const Rates rates, const int model, const int swap) {
    const real w0 = (real)(1.0 / 3.0), w1 = (real)(1.0 / 18.0), w2 = (real)(1.0 / 36.0);
    const real plus = rates.rate_plus, f0 = f[i];
    real s[9], d[9];
#pragma unroll
    for (int k = 0; k < 9; ++k) {
        const real a = f[(2 * k + 1) * CHUNK + i], b = f[(2 * k + 2) * CHUNK + i];
        s[k] = a + b;
        d[k] = a - b;
    }
    real rho = f0 + ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7])) + s[8];
    const real jx = d[0] + ((d[3] + d[4]) + (d[5] + d[6])), jy = d[1] + ((d[3] - d[4]) + (d[7] + d[8])),
               jz = d[2] + ((d[5] - d[6]) + (d[7] - d[8]));
    const real ux = jx + (real)0.5 * rates.force[0], uy = jy + (real)0.5 * rates.force[1], uz = jz + (real)0.5 * rates.force[2];
    const real cj[9] = {jx, jy, jz, jx + jy, jx - jy, jx + jz, jx - jz, jy + jz, jy - jz};
    const real cu[9] = {ux, uy, uz, ux + uy, ux - uy, ux + uz, ux - uz, uy + uz, uy - uz};
    if (model == STOKES || model == NAVIER_STOKES) {
        const real even = (real)0.5 * ((real)1 - plus), odd = (real)0.5 * ((real)1 - rates.rate_minus), minus3 = (real)3 * rates.rate_minus;
        if (model == NAVIER_STOKES) rho -= (real)1.5 * (ux * ux + uy * uy + uz * uz);
        f[i] = f0 - plus * (f0 - w0 * rho);
#pragma unroll
        for (int k = 0; k < 9; ++k) {
            const real w = k < 3 ? w1 : w2;
            const real e = even * s[k] + plus * w * (model == NAVIER_STOKES ? rho + (real)4.5 * cu[k] * cu[k] : rho);
            const real o = odd * d[k] + minus3 * w * cj[k] + rates.term[k];
            f[(2 * k + (swap ? 2 : 1)) * CHUNK + i] = e + o;
            f[(2 * k + (swap ? 1 : 2)) * CHUNK + i] = e - o;
        }
        return;
    }
    // p: shear stress; t: moments of third order after collision.
    const real third = rho * (real)(1.0 / 3.0), kept = (real)1 - plus, stay = (real)4.5 * kept;
    real pxx = s[0] + ((s[3] + s[4]) + (s[5] + s[6])) - third - ux * ux, pyy = s[1] + ((s[3] + s[4]) + (s[7] + s[8])) - third - uy * uy,
         pzz = s[2] + ((s[5] + s[6]) + (s[7] + s[8])) - third - uz * uz;
    const real pxy = s[3] - s[4] - ux * uy, pxz = s[5] - s[6] - ux * uz, pyz = s[7] - s[8] - uy * uz;
    const real trace = (real)(1.0 / 3.0) * (pxx + pyy + pzz);
    pxx -= trace;
    pyy -= trace;
    pzz -= trace;
    const real common = rho - (real)1.5 * (ux * ux + uy * uy + uz * uz);
    f[i] = w0 * common;
    const real cpc[9] = {pxx, pyy, pzz, pxx + pyy + (real)2 * pxy, pxx + pyy - (real)2 * pxy, pxx + pzz + (real)2 * pxz,
                         pxx + pzz - (real)2 * pxz, pyy + pzz + (real)2 * pyz, pyy + pzz - (real)2 * pyz};
    real t[9] = {0, 0, 0, 0, 0, 0, 0, 0, 0};
    if (model == RECURSIVE) {
        const real txxy = ux * ux * uy + kept * ((real)2 * ux * pxy + uy * pxx), txxz = ux * ux * uz + kept * ((real)2 * ux * pxz + uz * pxx),
                   tyyx = uy * uy * ux + kept * ((real)2 * uy * pxy + ux * pyy), tyyz = uy * uy * uz + kept * ((real)2 * uy * pyz + uz * pyy),
                   tzzx = uz * uz * ux + kept * ((real)2 * uz * pxz + ux * pzz), tzzy = uz * uz * uy + kept * ((real)2 * uz * pyz + uy * pzz);
        t[0] = -(tyyx + tzzx);
        t[1] = -(txxy + tzzy);
        t[2] = -(txxz + tyyz);
        t[3] = txxy + tyyx;
        t[4] = tyyx - txxy;
        t[5] = txxz + tzzx;
        t[6] = tzzx - txxz;
        t[7] = tyyz + tzzy;
        t[8] = tzzy - tyyz;
    }
#pragma unroll
    for (int k = 0; k < 9; ++k) {
        const real w = k < 3 ? w1 : w2;
        const real e = w * (common + (real)4.5 * cu[k] * cu[k] + stay * cpc[k]);
        const real o = w * ((real)3 * cj[k] + (real)9 * t[k]) + rates.term[k];
        f[(2 * k + (swap ? 2 : 1)) * CHUNK + i] = e + o;
        f[(2 * k + (swap ? 1 : 2)) * CHUNK + i] = e - o;
    }
}

#define LOAD_CHUNK \
    for (u32 q = 0; q < DIRECTIONS; ++q) rows[q * CHUNK + thread] = AT(c * ROWS + q * CHUNK + thread);
#define STORE_CHUNK \
    for (u32 q = 0; q < DIRECTIONS; ++q) AT(c * ROWS + q * CHUNK + thread) = rows[q * CHUNK + thread];

#define STEP(model, swap)                                                 \
    arrive_through_ends(c, thread, rows, GIVE_WALLS);                     \
    BARRIER;                                                              \
    arrive_at_walls(c, thread, rows, known, rates, 1, GIVE_WALLS);        \
    BARRIER;                                                              \
    collide(rows, thread, rates, model, swap);                            \
    BARRIER;                                                              \
    meet_walls(c, thread, rows, known, rates, swap, GIVE_WALLS);          \
    BARRIER;

// Where population q of a node that is not single is before an odd step: Addresses in kernels/layout.
FUNCTION u64 slot_before(const Group group, const u64 c, const u32 thread, const u32 q) {
    const u64 own = c * ROWS, reach = (u64)1 << 31, base = c > reach / ROWS ? own - reach : 0;
    const u32 i = thread & 15, first = group.first_nodes >> i & 1, second = group.second_nodes >> i & 1;
    if (first == second) return own + q * CHUNK + thread;
    return base + (first ? group.first : group.second) + i;
}
FUNCTION int is_single(const Group group, const u32 thread) {
    return (group.first_nodes & group.second_nodes) >> (thread & 15) & 1;
}

#define STEPS(name, model)                                                                                                                  \
    KERNEL(CHUNK) even_step_##name(STORE, const Rates rates, WALLS LOCAL_ARGUMENT(real, memory)) {                                          \
        LOCAL_MEMORY(real, memory)                                                                                                          \
        LOCAL real *const rows = memory, *const known = memory + ROWS;                                                                      \
        const u64 c = GROUP;                                                                                                                \
        const u32 thread = THREAD;                                                                                                          \
        LOAD_CHUNK                                                                                                                          \
        BARRIER;                                                                                                                            \
        STEP(model, 1)                                                                                                                      \
        STORE_CHUNK                                                                                                                         \
    }                                                                                                                                       \
    KERNEL(CHUNK) odd_step_##name(STORE, const Rates rates, WALLS, GLOBAL const Group *groups, GLOBAL const u64 *singles,                   \
                                  GLOBAL const u64 *first_single LOCAL_ARGUMENT(real, memory)) {                                            \
        LOCAL_MEMORY(real, memory)                                                                                                          \
        LOCAL real *const rows = memory, *const known = memory + ROWS;                                                                      \
        const u64 c = GROUP;                                                                                                                \
        const u32 thread = THREAD;                                                                                                          \
        GLOBAL const Group* const group = groups + c * ((DIRECTIONS - 1) * CHUNK / 16) + thread / 16;                                       \
        rows[thread] = AT(c * ROWS + thread);                                                                                               \
        for (u32 q = 1; q < DIRECTIONS; ++q) {                                                                                                  \
            const Group here = group[(q - 1) * (CHUNK / 16)];                                                                               \
            if (!is_single(here, thread)) rows[q * CHUNK + thread] = AT(slot_before(here, c, thread, q));                                   \
        }                                                                                                                                   \
        BARRIER;                                                                                                                            \
        for (u64 s = first_single[c] + thread; s < first_single[c + 1]; s += CHUNK) rows[singles[s] & 4095] = AT(singles[s] >> 12);         \
        BARRIER;                                                                                                                            \
        STEP(model, 0)                                                                                                                      \
        AT(c * ROWS + thread) = rows[thread];                                                                                               \
        for (u32 q = 1; q < DIRECTIONS; ++q) {                                                                                              \
            const Group here = group[(q - 1) * (CHUNK / 16)];                                                                               \
            if (!is_single(here, thread)) AT(slot_before(here, c, thread, q)) = rows[opposite(q) * CHUNK + thread];                         \
        }                                                                                                                                   \
        for (u64 s = first_single[c] + thread; s < first_single[c + 1]; s += CHUNK) AT(singles[s] >> 12) = rows[opposite_row((u32)(singles[s] & 4095))]; \
    }                                                                                                                                       \
    KERNEL(CHUNK) wall_forces_##name(STORE, const Rates rates, WALLS, const u64 first_chunk, GLOBAL double *forces LOCAL_ARGUMENT(real, memory)) { \
        LOCAL_MEMORY(real, memory)                                                                                                          \
        LOCAL real *const rows = memory, *const known = memory + ROWS;                                                                      \
        const u64 c = first_chunk + GROUP;                                                                                                  \
        const u32 thread = THREAD;                                                                                                          \
        LOAD_CHUNK                                                                                                                          \
        BARRIER;                                                                                                                            \
        arrive_through_ends(c, thread, rows, GIVE_WALLS);                                                                                   \
        BARRIER;                                                                                                                            \
        arrive_at_walls(c, thread, rows, known, rates, 0, GIVE_WALLS);                                                                      \
        BARRIER;                                                                                                                            \
        exchange_momentum(c, thread, rows, known, rates, model, forces + GROUP * (3 * CHUNK), GIVE_WALLS);                                  \
    }

// x, y and z of velocity q: 0, 1 or -1.
FUNCTION int velocity_of(const u32 q, const u32 axis) {
    if (q == 0) return 0;
    const u32 pair = (q - 1) / 2;
    const int sign = (q & 1) ? 1 : -1;
    if (pair < 3) return pair == axis ? sign : 0;
    // Pairs 3 to 8: (1, 1, 0), (1, -1, 0), (1, 0, 1), (1, 0, -1), (0, 1, 1), (0, 1, -1).
    const u32 first = pair < 7 ? 0 : 1, second = pair < 5 ? 1 : 2;
    if (axis == first) return sign;
    return axis == second ? ((pair & 1) ? sign : -sign) : 0;
}
FUNCTION real weight_of(const u32 q) {
    return q == 0 ? (real)(1.0 / 3.0) : q < 7 ? (real)(1.0 / 18.0) : (real)(1.0 / 36.0);
}

// What the populations before and after a collision give to the walls; `rows` are lost.
FUNCTION void exchange_momentum(const u64 c, const u32 thread, LOCAL real* rows, LOCAL real* given, const Rates rates, const int model,
                                GLOBAL double* forces, WALLS) {
    COUNT_WALLS(1)
    for (u32 k = thread; k < links; k += CHUNK) given[k] = rows[opposite_row(row[k])];
    for (u32 g = thread; g < narrow; g += CHUNK) {
        given[links + 2 * g] = rows[(gap[g].q + 1) * CHUNK + gap[g].place];
        given[links + 2 * g + 1] = rows[gap[g].q * CHUNK + gap[g].place];
    }
    BARRIER;
    collide(rows, thread, rates, model, 0);
    BARRIER;
    for (u32 k = thread; k < links; k += CHUNK) given[k] += rows[row[k]];
    for (u32 g = thread; g < narrow; g += CHUNK) {
        given[links + 2 * g] += rows[gap[g].q * CHUNK + gap[g].place];
        given[links + 2 * g + 1] += rows[(gap[g].q + 1) * CHUNK + gap[g].place];
    }
    BARRIER;
    for (u32 q = 0; q < DIRECTIONS; ++q) rows[q * CHUNK + thread] = 0;
    BARRIER;
    for (u32 k = thread; k < links; k += CHUNK) rows[row[k]] = given[k];
    for (u32 g = thread; g < narrow; g += CHUNK) {
        rows[gap[g].q * CHUNK + gap[g].place] = given[links + 2 * g];
        rows[(gap[g].q + 1) * CHUNK + gap[g].place] = given[links + 2 * g + 1];
    }
    BARRIER;
    for (u32 axis = 0; axis < 3; ++axis) {
        double sum = 0;
        for (u32 q = 1; q < DIRECTIONS; ++q) sum += (double)velocity_of(q, axis) * (double)rows[q * CHUNK + thread];
        forces[3 * thread + axis] = sum;
    }
}

STEPS(stokes, STOKES)
STEPS(navier_stokes, NAVIER_STOKES)
STEPS(regularised, REGULARISED)
STEPS(recursive, RECURSIVE)

// Density and velocity of the nodes of some chunks; x, y and z of half the force.
KERNEL(CHUNK) moments(STORE, const Rates rates, WALLS, const u64 first_chunk, GLOBAL double *of_nodes, const double half_x, const double half_y,
                      const double half_z LOCAL_ARGUMENT(real, rows)) {
    LOCAL_MEMORY(real, rows)
    const u64 c = first_chunk + GROUP;
    const u32 thread = THREAD;
    LOAD_CHUNK
    BARRIER;
    arrive_through_ends(c, thread, rows, GIVE_WALLS);
    BARRIER;
    arrive_at_walls(c, thread, rows, rows, rates, 0, GIVE_WALLS);
    BARRIER;
    double density = 0, velocity[3] = {half_x, half_y, half_z};
    for (u32 q = 0; q < DIRECTIONS; ++q) {
        const double f = rows[q * CHUNK + thread];
        density += f;
        for (u32 axis = 0; axis < 3; ++axis) velocity[axis] += velocity_of(q, axis) * f;
    }
    GLOBAL double* const node = of_nodes + 4 * (GROUP * CHUNK + thread);
    node[0] = density;
    for (u32 axis = 0; axis < 3; ++axis) node[1 + axis] = velocity[axis];
}

// Undoes what arriving changes: the walls' returns, then the ends.
#define BEFORE_ARRIVAL                                                                                                                      \
    for (u32 k = thread; k < links; k += CHUNK) {                                                                                           \
        const Weights w = weights_at(distance[k], rates);                                                                                   \
        rows[opposite_row(row[k])] -= w.share * w.b * rows[row[k]];                                                                         \
    }                                                                                                                                       \
    BARRIER;                                                                                                                                \
    for (u32 l = first_end[c] + thread; l < first_end[c + 1]; l += CHUNK) rows[ends[l].row] = ends[l].sign * (rows[ends[l].row] - ends[l].added); \
    BARRIER;

// Local equilibrium of the first `nodes` nodes of some chunks.
KERNEL(CHUNK) set_moments(STORE, const Rates rates, WALLS, const u64 first_chunk, GLOBAL const double *of_nodes, const u64 nodes,
                          const double half_x, const double half_y, const double half_z LOCAL_ARGUMENT(real, rows)) {
    LOCAL_MEMORY(real, rows)
    const u64 c = first_chunk + GROUP, node = GROUP * CHUNK + THREAD;
    const u32 thread = THREAD;
    COUNT_WALLS(interpolated)
    for (u32 q = 0; q < DIRECTIONS; ++q) {
        if (node >= nodes) {
            rows[q * CHUNK + thread] = AT(c * ROWS + q * CHUNK + thread);
            continue;
        }
        const double jx = of_nodes[4 * node + 1] - half_x, jy = of_nodes[4 * node + 2] - half_y, jz = of_nodes[4 * node + 3] - half_z;
        const double w = q == 0 ? 1.0 / 3.0 : q < 7 ? 1.0 / 18.0 : 1.0 / 36.0;
        rows[q * CHUNK + thread] = (real)(w * (of_nodes[4 * node] + 3.0 * (velocity_of(q, 0) * jx + velocity_of(q, 1) * jy + velocity_of(q, 2) * jz)));
    }
    BARRIER;
    BEFORE_ARRIVAL
    STORE_CHUNK
}

// Adds to the density of the first `nodes` nodes of some chunks. What is stored depends linearly on the arriving populations: each gets w
// times the density, as it would be before it arrives.
KERNEL(CHUNK) add_density(STORE, const Rates rates, WALLS, const u64 first_chunk, GLOBAL const double *of_nodes, const u64 nodes
                          LOCAL_ARGUMENT(real, memory)) {
    LOCAL_MEMORY(real, memory)
    LOCAL real *const rows = memory, *const added = memory + ROWS;
    const u64 c = first_chunk + GROUP, node = GROUP * CHUNK + THREAD;
    const u32 thread = THREAD;
    COUNT_WALLS(interpolated)
    added[thread] = node < nodes ? (real)of_nodes[node] : (real)0;
    BARRIER;
    for (u32 q = 0; q < DIRECTIONS; ++q) rows[q * CHUNK + thread] = AT(c * ROWS + q * CHUNK + thread) + weight_of(q) * added[thread];
    BARRIER;
    for (u32 l = first_end[c] + thread; l < first_end[c + 1]; l += CHUNK)
        rows[ends[l].row] += (ends[l].sign - (real)1) * weight_of(ends[l].row / CHUNK) * added[ends[l].row % CHUNK];
    BARRIER;
    for (u32 k = thread; k < links; k += CHUNK) {
        const Weights w = weights_at(distance[k], rates);
        rows[opposite_row(row[k])] -= w.share * w.b * weight_of(row[k] / CHUNK) * added[row[k] % CHUNK];
    }
    BARRIER;
    STORE_CHUNK
}

// Sums over blocks of nodes that lie in one layer: layer_blocks.hpp. The last quantity is a maximum, NaN where one is.
#define QUANTITIES 12
#define MAXIMUM 11
FUNCTION double combined(const u32 quantity, const double a, const double b) {
    if (quantity != MAXIMUM) return a + b;
    return b > a || b != b ? b : a;
}

// The blocks of a batch in the lists of all batches: LayerBlocks::Batch.
#define BATCH GLOBAL const u32 *orders, const u64 first_order, const u32 ordered, GLOBAL const u32 *firsts_in_block, const u64 first_block
#define OPEN_BATCH                                        \
    GLOBAL const u32* const order = orders + first_order; \
    GLOBAL const u32* const first_in_block = firsts_in_block + first_block;

// One group per block of the batch that `of_nodes` are of.
KERNEL(CHUNK) sum_blocks(GLOBAL const double *of_nodes, BATCH, const u32 axis, GLOBAL double *sums LOCAL_ARGUMENT(double, memory)) {
    LOCAL_MEMORY(double, memory)
    OPEN_BATCH
    const u32 thread = THREAD;
    double sum[QUANTITIES] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    for (u32 i = first_in_block[GROUP] + thread; i < first_in_block[GROUP + 1]; i += CHUNK) {
        GLOBAL const double* const node = of_nodes + 4 * (u64)(ordered ? order[i] : i);
        const double density = node[0], x = node[1], y = node[2], z = node[3], along = node[1 + axis], square = x * x + y * y + z * z;
        sum[0] += 1.0;
        sum[1] += along;
        sum[2] += along * density;
        sum[3] += 0.5 * square;
        sum[4] += along * (0.5 * square);
        sum[5] += density * density / 6.0;
        sum[6] += density;
        sum[7] += sqrt(square);
        sum[8] += x;
        sum[9] += y;
        sum[10] += z;
        sum[MAXIMUM] = combined(MAXIMUM, sum[MAXIMUM], square);
    }
    for (u32 v = 0; v < QUANTITIES; ++v) memory[v * CHUNK + thread] = sum[v];
    for (u32 apart = CHUNK / 2; apart > 0; apart /= 2) {
        BARRIER;
        if (thread < apart)
            for (u32 v = 0; v < QUANTITIES; ++v)
                memory[v * CHUNK + thread] = combined(v, memory[v * CHUNK + thread], memory[v * CHUNK + thread + apart]);
    }
    BARRIER;
    if (thread < QUANTITIES) sums[GROUP * QUANTITIES + thread] = memory[thread * CHUNK];
}

// One thread per listed layer of a batch and quantity: the blocks of each layer are added to it in their order. `totals` by quantity.
KERNEL(CHUNK) add_blocks(GLOBAL const double *sums, GLOBAL const u32 *all_layers, const u64 first_layer, GLOBAL const u32 *first_blocks,
                         const u64 first_first, const u32 listed, const u32 layers, GLOBAL double *totals) {
    GLOBAL const u32* const layer = all_layers + first_layer;
    GLOBAL const u32* const first_block = first_blocks + first_first;
    const u64 i = GROUP * CHUNK + THREAD;
    const u32 number = (u32)(i / QUANTITIES), v = (u32)(i % QUANTITIES);
    if (number >= listed) return;
    GLOBAL double* const place = totals + (u64)v * layers + layer[number];
    double total = *place;
    for (u32 b = first_block[number]; b < first_block[number + 1]; ++b) total = combined(v, total, sums[(u64)b * QUANTITIES + v]);
    *place = total;
}

// Each node gets what its layer gets.
KERNEL(CHUNK) spread_over_blocks(GLOBAL const double *of_layers, GLOBAL const u32 *layers_of_blocks, const u64 first_layer, BATCH,
                                 GLOBAL double *of_nodes) {
    OPEN_BATCH
    const double added = of_layers[layers_of_blocks[first_layer + GROUP]];
    for (u32 i = first_in_block[GROUP] + THREAD; i < first_in_block[GROUP + 1]; i += CHUNK) of_nodes[ordered ? order[i] : i] = added;
}

// The sum of three numbers per node.
KERNEL(CHUNK) add_forces(GLOBAL const double *forces, const u64 nodes, GLOBAL double *total LOCAL_ARGUMENT(double, memory)) {
    LOCAL_MEMORY(double, memory)
    const u32 thread = THREAD;
    double sum[3] = {0, 0, 0};
    for (u64 i = thread; i < nodes; i += CHUNK)
        for (u32 axis = 0; axis < 3; ++axis) sum[axis] += forces[3 * i + axis];
    for (u32 axis = 0; axis < 3; ++axis) memory[axis * CHUNK + thread] = sum[axis];
    for (u32 apart = CHUNK / 2; apart > 0; apart /= 2) {
        BARRIER;
        if (thread < apart)
            for (u32 axis = 0; axis < 3; ++axis) memory[axis * CHUNK + thread] += memory[axis * CHUNK + thread + apart];
    }
    BARRIER;
    if (thread < 3) total[thread] += memory[thread * CHUNK];
}
