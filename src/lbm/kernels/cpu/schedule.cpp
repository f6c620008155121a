#include "lbm/kernels/cpu/schedule.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

#include "lbm/lattice.hpp"

namespace porepack::lbm::cpu {
using namespace layout;
namespace {

constexpr std::size_t chunks_per_part = 128;

// The chunks that the odd step of a chunk accesses, and whether it accesses nodes of other slabs.
struct Reach {
    std::uint32_t first, last;
    bool beyond;
};

std::vector<Reach> reaches(const Addresses& addresses, std::size_t chunks) {
    std::vector<Reach> all(chunks);
    const std::size_t groups = addresses.groups.size() / std::max<std::size_t>(1, chunks);
#pragma omp parallel for schedule(static)
    for (std::size_t c = 0; c < chunks; ++c) {
        Reach& of_chunk = all[c] = {static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(c), false};
        const auto access = [&](std::size_t slot) {
            const auto chunk = static_cast<std::uint32_t>(slot / (d3q19::directions * chunk_nodes));
            of_chunk.beyond = of_chunk.beyond || chunk >= chunks;
            if (chunk >= chunks) return;
            of_chunk.first = std::min(of_chunk.first, chunk);
            of_chunk.last = std::max(of_chunk.last, chunk);
        };
        const auto access_group = [&](std::uint32_t first, std::uint16_t nodes, std::uint16_t others) {
            const auto alone = static_cast<std::uint16_t>(nodes & ~others);
            if (alone == 0) return;
            access(base_of(c) + first + static_cast<std::size_t>(std::countr_zero(alone)));
            access(base_of(c) + first + static_cast<std::size_t>(std::bit_width(alone)) - 1);
        };
        for (std::size_t g = c * groups; g < (c + 1) * groups; ++g) {
            const Addresses::Group& group = addresses.groups[g];
            access_group(group.first, group.first_nodes, group.second_nodes);
            access_group(group.second, group.second_nodes, group.first_nodes);
        }
        for (std::uint64_t s = addresses.first_single[c]; s < addresses.first_single[c + 1]; ++s)
            access(addresses.singles[s] >> Addresses::place_bits);
    }
    return all;
}

}  // namespace

Schedule::Schedule(const Addresses& addresses, std::size_t chunks) : odd_order(chunks) {
    const std::vector<Reach> all = reaches(addresses, chunks);
    // The chunks below `low` and from `high` on make their even steps first.
    std::size_t low = 0, high = chunks;
    for (std::size_t c = 0; c < chunks; ++c) {
        if (!all[c].beyond) continue;
        if (c < chunks / 2)
            low = std::max<std::size_t>(low, all[c].last + 1);
        else
            high = std::min<std::size_t>(high, all[c].first);
    }
    if (high < low) high = low;
    parts = {{0, low, 0, 0}, {high, chunks, 0, 0}};
    inside = parts.size();
    // Number of the part in which a chunk makes its even step; of those at the borders 0.
    const auto part_of = [&](std::size_t chunk) { return chunk < low || chunk >= high ? 0 : inside + (chunk - low) / chunks_per_part; };
    const std::size_t last_of_all = inside + (high - low + chunks_per_part - 1) / chunks_per_part;
    std::vector<std::size_t> needs(chunks);  // by chunk, last part of the chunks that it accesses
    for (std::size_t c = 0; c < chunks; ++c)
        needs[c] = all[c].beyond ? last_of_all : part_of(std::min<std::size_t>(all[c].last, std::max<std::size_t>(high, 1) - 1));
    std::iota(odd_order.begin(), odd_order.end(), 0U);
    std::stable_sort(odd_order.begin(), odd_order.end(), [&](std::uint32_t a, std::uint32_t b) { return needs[a] < needs[b]; });
    std::size_t odd = 0;
    for (std::size_t t = inside; t <= last_of_all + 1; ++t) {
        const auto end_of = [&](std::size_t part) { return std::min(high, low + part * chunks_per_part); };
        Part part{end_of(t - inside), end_of(t - inside + 1), odd, odd};
        while (part.odd_end < chunks && needs[odd_order[part.odd_end]] < t) ++part.odd_end;
        odd = part.odd_end;
        parts.push_back(part);
    }
    border = parts.size() - 1;
}

}  // namespace porepack::lbm::cpu
