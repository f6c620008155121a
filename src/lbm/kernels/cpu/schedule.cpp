#include "lbm/kernels/cpu/schedule.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "lbm/lattice.hpp"

namespace porepack::lbm::cpu {
namespace {

constexpr std::size_t chunks_per_part = 128;

std::size_t parts_of(std::size_t chunks) {
    return (chunks + chunks_per_part - 1) / chunks_per_part;
}

// Part of the last chunk that the odd step of a chunk accesses; the number of parts where that is a node of another slab.
std::vector<std::uint32_t> last_parts(const Addresses& addresses, std::size_t chunks) {
    std::vector<std::uint32_t> last(chunks);
    const std::size_t groups = addresses.groups.size() / std::max<std::size_t>(1, chunks);
#pragma omp parallel for schedule(static)
    for (std::size_t c = 0; c < chunks; ++c) {
        std::size_t far = slot_of(0, c * chunk_nodes);
        const auto reach = [&](std::uint32_t first, std::uint16_t nodes, std::uint16_t others) {
            const auto alone = static_cast<std::uint16_t>(nodes & ~others);
            if (alone != 0) far = std::max<std::size_t>(far, base_of(c) + first + static_cast<std::size_t>(std::bit_width(alone)) - 1);
        };
        for (std::size_t g = c * groups; g < (c + 1) * groups; ++g) {
            const Addresses::Group& group = addresses.groups[g];
            reach(group.first, group.first_nodes, group.second_nodes);
            reach(group.second, group.second_nodes, group.first_nodes);
        }
        for (std::uint64_t s = addresses.first_single[c]; s < addresses.first_single[c + 1]; ++s)
            far = std::max<std::size_t>(far, addresses.singles[s] >> Addresses::place_bits);
        const std::size_t chunk = far / (d3q19::directions * chunk_nodes);
        last[c] = static_cast<std::uint32_t>(chunk < chunks ? chunk / chunks_per_part : parts_of(chunks));
    }
    return last;
}

}  // namespace

Schedule::Schedule(const Addresses& addresses, std::size_t chunks) : odd_order(chunks) {
    const std::vector<std::uint32_t> last = last_parts(addresses, chunks);
    std::iota(odd_order.begin(), odd_order.end(), 0U);
    std::stable_sort(odd_order.begin(), odd_order.end(), [&](std::uint32_t a, std::uint32_t b) { return last[a] < last[b]; });
    std::size_t odd = 0;
    parts_alone = parts_of(chunks) + 1;
    for (std::size_t t = 0; t <= parts_alone; ++t) {
        Part part{std::min(chunks, t * chunks_per_part), std::min(chunks, (t + 1) * chunks_per_part), odd, odd};
        while (part.odd_end < chunks && last[odd_order[part.odd_end]] < t) ++part.odd_end;
        odd = part.odd_end;
        parts.push_back(part);
    }
}

}  // namespace porepack::lbm::cpu
