// The fast kernel as plain functions on plain memory, so that it can be compiled once per instruction set (kernel.cpp) and chosen when the
// program runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "lbm/flow.hpp"
#include "lbm/kernels/cpu/schedule.hpp"
#include "lbm/kernels/layout/addresses.hpp"
#include "lbm/kernels/layout/chunked_walls.hpp"

namespace porepack::lbm::cpu {

using namespace layout;

/// Bytes of the longest SIMD vector.
inline constexpr std::size_t vector_bytes = 64;
template <typename Real>
inline constexpr std::size_t simd_lanes = vector_bytes / sizeof(Real);

/// A boundary link in the layout of the kernel.
template <typename Real>
struct BoundaryPlace {
    std::uint16_t row;  ///< chunk_nodes q + place in the chunk
    Real sign, added;
};

/// All data that a step reads and writes; CpuFlow owns the memory.
template <typename Real>
struct KernelData {
    Real* store;  ///< populations, chunk by chunk, q after q
    std::size_t nodes, chunks;
    const Addresses::Group* groups;
    const Addresses::Single* singles;
    const std::uint64_t* first_single;  ///< by chunk
    const std::uint64_t* first_wall;    ///< by chunk
    const std::uint16_t *wall_row, *wall_distance;
    const std::uint64_t* first_gap;  ///< by chunk
    const ChunkedWalls::Gap* gaps;
    const std::uint32_t* first_boundary;  ///< by chunk
    const BoundaryPlace<Real>* boundary;
    const Schedule::Part* parts;
    const std::uint32_t* odd_order;
    bool interpolated;
    Model model;
    Real rate_plus, rate_minus;
    Real wall_shift, wall_magic, wall_bound, wall_limit;  ///< WallRule
    Real force[3];
    Real force_term[19];  ///< 3 w c.F, force term of a population
    double force_lu[3];
};

/// The functions of one instruction set.
template <typename Real>
struct KernelFunctions {
    /// These parts of the schedule.
    void (*two_steps)(const KernelData<Real>& data, std::size_t first_part, std::size_t end_part);
    /// Moments of the nodes [first, first + count); `first` is a multiple of chunk_nodes.
    void (*moments)(const KernelData<Real>& data, std::size_t first, Moments* moments, std::size_t count);
    void (*set_moments)(const KernelData<Real>& data, std::size_t first, const Moments* moments, std::size_t count);
    /// Adds to the density of the nodes [first, first + count); velocities and stresses stay.
    void (*add_density)(const KernelData<Real>& data, std::size_t first, const double* added, std::size_t count);
    /// Momentum exchange at the walls of the nodes [first, first + count), three numbers each.
    void (*wall_forces)(const KernelData<Real>& data, std::size_t first, double* forces, std::size_t count);
};

struct InstructionSet {
    const char* name;
    bool (*runs_here)();
    const KernelFunctions<float>* single_precision;
    const KernelFunctions<double>* double_precision;
};
/// All instruction sets of this build, the best last. "baseline" is always the first.
[[nodiscard]] std::span<const InstructionSet> instruction_sets();
/// The best set that this processor supports, or the one named by the environment variable POREPACK_INSTRUCTION_SET. UserError for an
/// unknown name, or a set that the processor does not support.
[[nodiscard]] const InstructionSet& chosen_instruction_set();

}  // namespace porepack::lbm::cpu
