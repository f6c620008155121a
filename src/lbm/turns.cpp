#include "lbm/turns.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "lbm/lattice.hpp"

namespace porepack {
namespace {

constexpr std::size_t chunks_a_turn = 128;

// Turn of the last chunk that a chunk's odd step reaches.
std::vector<std::uint32_t> last_turns(const Addresses& addresses, std::size_t chunks) {
    std::vector<std::uint32_t> last(chunks);
    const std::size_t vectors = addresses.vectors.size() / std::max<std::size_t>(1, chunks);
#pragma omp parallel for schedule(static)
    for (std::size_t c = 0; c < chunks; ++c) {
        std::size_t far = slot_of(0, c * chunk_nodes);
        const auto reach = [&](std::uint32_t first, std::uint16_t lanes) {
            if (lanes != 0) far = std::max<std::size_t>(far, first + static_cast<std::size_t>(std::bit_width(lanes)) - 1);
        };
        for (std::size_t v = c * vectors; v < (c + 1) * vectors; ++v) {
            reach(addresses.vectors[v].first, addresses.vectors[v].first_lanes);
            reach(addresses.vectors[v].second, addresses.vectors[v].second_lanes);
        }
        for (std::uint32_t s = addresses.first_single[c]; s < addresses.first_single[c + 1]; ++s)
            far = std::max<std::size_t>(far, addresses.singles[s].slot);
        last[c] = static_cast<std::uint32_t>(far / (d3q19::directions * chunk_nodes * chunks_a_turn));
    }
    return last;
}

}  // namespace

Turns::Turns(const Addresses& addresses, std::size_t chunks) : odd_order(chunks) {
    const std::vector<std::uint32_t> last = last_turns(addresses, chunks);
    std::iota(odd_order.begin(), odd_order.end(), 0U);
    std::stable_sort(odd_order.begin(), odd_order.end(), [&](std::uint32_t a, std::uint32_t b) { return last[a] < last[b]; });
    std::size_t odd = 0;
    for (std::size_t t = 0; t <= (chunks + chunks_a_turn - 1) / chunks_a_turn; ++t) {
        Turn turn{std::min(chunks, t * chunks_a_turn), std::min(chunks, (t + 1) * chunks_a_turn), odd, odd};
        while (turn.odd_end < chunks && last[odd_order[turn.odd_end]] < t) ++turn.odd_end;
        odd = turn.odd_end;
        turns.push_back(turn);
    }
}

}  // namespace porepack
