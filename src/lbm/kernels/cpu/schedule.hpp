// The schedule by which one sweep through memory makes two steps.
#pragma once

#include <cstdint>
#include <vector>

#include "lbm/kernels/layout/addresses.hpp"

namespace porepack::lbm::cpu {

/// The odd step of a chunk follows when the even steps of all chunks that it accesses are done, while they are still in a
/// cache: memory is read and written once per two steps.
/// Of a slab, the chunks at its borders, whose odd steps access nodes of other slabs, and the chunks that these access make their even
/// steps first. So there is always something to do while messages are under way: of what the even steps at the borders give, and of what
/// the odd steps there give.
struct Schedule {
    /// Even steps of the chunks [even, even_end), and odd steps of those in odd_order[odd, odd_end), which access only chunks of
    /// earlier parts.
    struct Part {
        std::size_t even, even_end, odd, odd_end;
    };
    std::vector<Part>
        parts;  ///< [0, inside): even steps at the borders; [inside, border): all else; [border, parts.size()): odd steps at the borders
    std::size_t inside = 0, border = 0;
    std::vector<std::uint32_t> odd_order;

    Schedule(const layout::Addresses& addresses, std::size_t chunks);
};

}  // namespace porepack::lbm::cpu
