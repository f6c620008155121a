// Vectors of populations in memory.
#pragma once

#include <sys/mman.h>

#include <cstring>
#include <new>
#if defined(__AVX512F__)
#include <immintrin.h>
#endif

#include "lbm/addresses.hpp"

namespace porepack {

inline constexpr std::size_t vector_bytes = 64;
template <typename Real>
inline constexpr std::size_t lanes = vector_bytes / sizeof(Real);

/// Reads a vector from its places; lanes that come from a third one hold anything.
template <typename Real>
inline void read(Real* to, const Real* store, const Addresses::Vector& at) {
#if defined(__AVX512F__)
    if constexpr (sizeof(Real) == 8)
        _mm512_store_pd(to,
                        _mm512_mask_loadu_pd(_mm512_loadu_pd(store + at.first), static_cast<__mmask8>(at.second_lanes), store + at.second));
    else
        _mm512_store_ps(to, _mm512_mask_loadu_ps(_mm512_loadu_ps(store + at.first), at.second_lanes, store + at.second));
#else
    for (std::size_t i = 0; i < lanes<Real>; ++i) to[i] = store[((at.second_lanes >> i & 1U) != 0 ? at.second : at.first) + i];
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
    for (std::size_t i = 0; i < lanes<Real>; ++i) {
        if ((at.first_lanes >> i & 1U) != 0) store[at.first + i] = from[i];
        if ((at.second_lanes >> i & 1U) != 0) store[at.second + i] = from[i];
    }
#endif
}

/// Memory that each thread touches first itself, in large pages where the system gives them.
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

}  // namespace porepack
