#include "lbm/kernels/layout/addresses.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <compare>
#include <span>
#include <utility>

#include "core/parallel.hpp"
#include "lbm/lattice.hpp"
#include "lbm/neighbours.hpp"
#include "lbm/uses.hpp"

namespace porepack::lbm::layout {
namespace {

using d3q19::opposite;

// Nodes of other slabs begin with a chunk of their own.
std::size_t stored(const Domain& domain, std::int64_t node) {
    const auto here = static_cast<std::size_t>(node), own = domain.nodes();
    return here < own ? here : chunks_for(own) * chunk_nodes + here - own;
}

// By the node of the lower or upper slab in whose slots they are, ascending, then by the direction from it: an order that both slabs know.
std::array<SharedSlots, 2> find_shared(const Domain& domain) {
    std::array<SharedSlots, 2> shared;
    const Grid& grid = domain.grid;
    for (const std::size_t side : {0U, 1U}) {
        if (domain.beyond[side].empty() || domain.cells.empty()) continue;
        const std::size_t plane = static_cast<std::size_t>(grid.cells[0]) * static_cast<std::size_t>(grid.cells[1]),
                          first_cell = side == 0 ? 0 : grid.size() - plane;
        const auto first = static_cast<std::size_t>(domain.cells.rank(first_cell)),
                   end = side == 0 && grid.cells[2] > 1 ? static_cast<std::size_t>(domain.cells.rank(plane)) : domain.nodes();
        const auto low = static_cast<std::int64_t>(domain.first_beyond(side)), high = low + domain.beyond[side].size();
        struct Far {
            std::int64_t node;
            int q;  // from it
            auto operator<=>(const Far&) const = default;
        };
        std::vector<Far> far;
        Neighbours neighbours(domain);
        std::vector<std::size_t> cells(end - first);
        domain.cells.list(first, cells);
        for (std::size_t node = first; node < end; ++node) {
            const auto& near = neighbours.of(cells[node - first]);
            for (int q = 1; q < d3q19::directions; ++q) {
                const std::int64_t there = near[static_cast<std::size_t>(q)];
                if (there < low || there >= high) continue;
                shared[side].own.push_back(slot_of(static_cast<std::size_t>(opposite(q)), node));
                far.push_back({there, opposite(q)});
            }
        }
        std::sort(far.begin(), far.end());
        for (const Far& one : far)
            shared[side].beyond.push_back(slot_of(static_cast<std::size_t>(opposite(one.q)), stored(domain, one.node)));
    }
    return shared;
}

class Tracer {
public:
    explicit Tracer(const Domain& domain) : domain_(domain), neighbours_(domain) {}

    using Slots = std::array<std::array<std::uint64_t, chunk_nodes>, d3q19::directions>;
    // Slots of the populations that arrive at the chunk's nodes; returns the number of nodes.
    std::size_t trace(std::size_t first, Slots& slots) {
        const std::size_t end = std::min(domain_.nodes(), first + chunk_nodes);
        std::array<std::size_t, chunk_nodes> cells;
        domain_.cells.list(first, std::span(cells).first(end - first));
        for (std::size_t node = first; node < end; ++node) {
            const auto& near = neighbours_.of(cells[node - first]);
            for (std::size_t q = 1; q < d3q19::directions; ++q) {
                const auto out = static_cast<std::size_t>(opposite(static_cast<int>(q)));
                slots[q][node - first] = near[out] >= 0 ? slot_of(out, stored(domain_, near[out])) : slot_of(q, node);
            }
        }
        const auto by_node = [](const BoundaryLink& link, std::size_t node) { return link.node < node; };
        for (auto link = std::lower_bound(domain_.boundary_links.begin(), domain_.boundary_links.end(), first, by_node);
             link != domain_.boundary_links.end() && link->node < end; ++link)
            slots[link->q][link->node - first] = slot_of(static_cast<std::size_t>(opposite(link->source_q)), link->source);
        return end - first;
    }

private:
    const Domain& domain_;
    Neighbours neighbours_;
};

// The two locations of most nodes besides their own slots, `own` for the first node; the others are added to `singles`.
Addresses::Group make_group(std::span<const std::uint64_t> slots, std::uint64_t base, std::uint64_t own, std::size_t place,
                            std::vector<Addresses::Single>& singles) {
    std::array<std::uint32_t, group_nodes> location{};
    std::array<std::uint16_t, group_nodes> nodes{};
    std::size_t locations = 0;
    std::uint16_t single = 0;
    const auto add = [](std::uint16_t& set, std::size_t i) { set = static_cast<std::uint16_t>(set | 1U << i); };
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (slots[i] == own + i) continue;
        const std::uint64_t offset = slots[i] - i - base;  // wraps where the slot is below the base
        if (offset >> 32U != 0) {
            add(single, i);
            continue;
        }
        const auto here = static_cast<std::uint32_t>(offset);
        std::size_t l = 0;
        while (l < locations && location[l] != here) ++l;
        if (l == locations) location[locations++] = here;
        add(nodes[l], i);
    }
    for (std::size_t l = 0; l < std::min<std::size_t>(locations, 2); ++l)
        for (std::size_t other = l + 1; other < locations; ++other)
            if (std::popcount(nodes[other]) > std::popcount(nodes[l])) {
                std::swap(location[l], location[other]);
                std::swap(nodes[l], nodes[other]);
            }
    for (std::size_t l = 2; l < locations; ++l) single = static_cast<std::uint16_t>(single | nodes[l]);
    for (std::size_t i = 0; i < slots.size(); ++i)
        if ((single >> i & 1U) != 0) singles.push_back(slots[i] << Addresses::place_bits | (place + i));
    // The kernel may read places of which it needs nothing.
    const auto anywhere = static_cast<std::uint32_t>(own - base);
    const std::uint32_t first = locations > 0 ? location[0] : anywhere;
    return {first, locations > 1 ? location[1] : first, static_cast<std::uint16_t>(nodes[0] | single),
            static_cast<std::uint16_t>(nodes[1] | single)};
}

}  // namespace

void make_groups(std::span<const std::uint64_t> slots, std::size_t chunk, std::size_t q, Addresses::Group* groups,
                 std::vector<Addresses::Single>& singles) {
    const std::uint64_t base = base_of(chunk), own = slot_of(q, chunk * chunk_nodes);
    for (std::size_t i = 0; i < chunk_nodes; i += group_nodes, ++groups)
        *groups = make_group(i < slots.size() ? slots.subspan(i, std::min(group_nodes, slots.size() - i)) : slots.first(0), base, own + i,
                             q * chunk_nodes + i, singles);
}

Addresses find_addresses(const Domain& domain) {
    const std::size_t chunks = chunks_for(domain.nodes()),
                      nodes_beyond = static_cast<std::size_t>(domain.beyond[0].size() + domain.beyond[1].size());
    constexpr std::size_t pairs = d3q19::directions - 1;
    constexpr std::size_t groups_per_chunk = chunk_nodes / group_nodes;
    Addresses addresses{.slots = slot_of(0, (chunks + chunks_for(nodes_beyond)) * chunk_nodes),
                        .shared = find_shared(domain),
                        .groups = {},
                        .singles = {},
                        .first_single = {0}};
    addresses.groups.resize(chunks * pairs * groups_per_chunk);
    constexpr std::size_t share = 256;
    struct Part {
        std::vector<Addresses::Single> singles;
        std::vector<std::size_t> end;  // by chunk
    };
    std::vector<Part> parts((chunks + share - 1) / share);
    parallel_for(parts.size(), [&](std::size_t p) {
        Tracer tracer(domain);
        Tracer::Slots slots;
        for (std::size_t c = p * share; c < std::min(chunks, (p + 1) * share); ++c) {
            const std::size_t size = tracer.trace(c * chunk_nodes, slots);
            for (std::size_t q = 1; q < d3q19::directions; ++q)
                make_groups(std::span(slots[q]).first(size), c, q, addresses.groups.data() + (c * pairs + q - 1) * groups_per_chunk,
                            parts[p].singles);
            parts[p].end.push_back(parts[p].singles.size());
        }
    });
    std::size_t singles = 0;
    for (const Part& part : parts) singles += part.singles.size();
    addresses.singles.reserve(singles);
    addresses.first_single.reserve(chunks + 1);
    for (Part& part : parts) {
        for (const std::size_t end : part.end) addresses.first_single.push_back(addresses.singles.size() + end);
        addresses.singles.insert(addresses.singles.end(), part.singles.begin(), part.singles.end());
        part = {};
    }
    return addresses;
}

}  // namespace porepack::lbm::layout
