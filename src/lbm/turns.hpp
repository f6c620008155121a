// The order in which a sweep through memory makes two steps.
#pragma once

#include "lbm/addresses.hpp"

namespace porepack {

/// The odd step of a chunk follows as soon as the even steps of all chunks that it reaches are done, while they still lie in a
/// cache: memory is read and written once for two steps.
struct Turns {
    /// Even steps of the chunks [even, even_end), and odd steps of those in odd_order[odd, odd_end), which reach only chunks of
    /// earlier turns.
    struct Turn {
        std::size_t even, even_end, odd, odd_end;
    };
    std::vector<Turn> turns;
    std::vector<std::uint32_t> odd_order;

    Turns(const Addresses& addresses, std::size_t chunks);
};

}  // namespace porepack
