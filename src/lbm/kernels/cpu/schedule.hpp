// The order in which a sweep through memory makes two steps.
#pragma once

#include "lbm/kernels/cpu/addresses.hpp"

namespace porepack::lbm::cpu {

/// The odd step of a chunk follows as soon as the even steps of all chunks that it reaches are done, while they still lie in a
/// cache: memory is read and written once for two steps.
struct Schedule {
    /// Even steps of the chunks [even, even_end), and odd steps of those in odd_order[odd, odd_end), which reach only chunks of
    /// earlier parts.
    struct Part {
        std::size_t even, even_end, odd, odd_end;
    };
    std::vector<Part> parts;
    std::vector<std::uint32_t> odd_order;

    Schedule(const Addresses& addresses, std::size_t chunks);
};

}  // namespace porepack::lbm::cpu
