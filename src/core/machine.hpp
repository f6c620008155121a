// Properties of this machine: processor, memory, threads.
#pragma once

#include <cstdint>
#include <string>

namespace porepack::inline core {

[[nodiscard]] std::string host_name();
[[nodiscard]] std::string processor_name();
/// Memory that a new allocation can get without swapping, in bytes (the smaller of the machine's and the control group's).
[[nodiscard]] double available_memory_bytes();
/// For programs, at their start: a large block of memory goes back to the system as soon as it is freed. (The C library keeps those of up
/// to 32 MB otherwise, and they count as used.)
void return_large_blocks();

/// For programs, at their start: throws MachineError where the stack is limited (ulimit -s) to less than the kernels and libraries need.
void require_stack();

/// Largest resident memory of this process since the start or the last reset, in bytes.
[[nodiscard]] double peak_memory_bytes();
/// Also gives freed memory back to the system, so that it does not count for the next stage.
void reset_peak_memory();
/// Cores that this process may use: those of its affinity, at most its control group's quota.
[[nodiscard]] int usable_cores();
/// Number of threads of parallel loops.
[[nodiscard]] int thread_count();
/// 0: OMP_NUM_THREADS, else usable_cores().
void set_thread_count(int threads);

/// Time that work which reads and writes memory takes here, relative to the machine of the expected times (two threads that together move
/// 6.5e10 bytes per second): measured once, in about 0.3 s.
[[nodiscard]] double slowness();

/// Throws UserError with the numbers when `bytes` will not fit, before anything is allocated.
void require_memory(double bytes, const std::string& what, const std::string& fix);

}  // namespace porepack::inline core
