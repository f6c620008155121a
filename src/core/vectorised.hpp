// For functions whose loops run on several numbers at once. Sanitizers cannot run a function that exists several times.
#pragma once

/// Compiled once per instruction set of x86-64; the widest that the machine has runs. Without fused operations (components.cmake) all give
/// the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define POREPACK_VECTORISED __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define POREPACK_VECTORISED
#endif
