// The schedule by which one sweep through memory makes two steps.
#pragma once

#include "lbm/kernels/cpu/addresses.hpp"

namespace porepack::lbm::cpu {

/// The odd step of a chunk follows when the even steps of all chunks that it accesses are done, while they are still in a
/// cache: memory is read and written once per two steps.
struct Schedule {
    /// Even steps of the chunks [even, even_end), and odd steps of those in odd_order[odd, odd_end), which access only chunks of
    /// earlier parts.
    struct Part {
        std::size_t even, even_end, odd, odd_end;
    };
    std::vector<Part> parts;
    std::size_t parts_alone = 0;  ///< the first of them: the others access nodes of other slabs
    std::vector<std::uint32_t> odd_order;

    Schedule(const Addresses& addresses, std::size_t chunks);
};

}  // namespace porepack::lbm::cpu
