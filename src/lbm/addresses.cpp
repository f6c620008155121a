#include "lbm/addresses.hpp"

#include <algorithm>

#include "core/parallel.hpp"
#include "lbm/lattice.hpp"

namespace porepack {
namespace {

using d3q19::opposite;

struct Segments {
    std::vector<std::uint64_t> end;  // by chunk
    std::vector<std::uint32_t> slot;
    std::vector<std::uint8_t> length;
};

class Tracer {
public:
    explicit Tracer(const Domain& domain) : domain_(domain) {}

    // Slots of the populations q that arrive at the chunk's nodes.
    void trace(std::size_t first, int q, std::vector<std::uint32_t>& slots) const {
        const std::size_t end = std::min(domain_.nodes(), first + chunk_nodes);
        const auto own = static_cast<std::size_t>(q), other = static_cast<std::size_t>(opposite(q));
        slots.clear();
        std::int64_t near = -1;
        for (std::size_t node = first; node < end; ++node) {
            auto from = place_in_grid(domain_.grid, static_cast<std::size_t>(domain_.cell[node]));
            int turns = 0;
            std::int64_t source = -1;
            if (step_in_grid(domain_.grid, domain_.drive, from, d3q19::c[other], turns)) {
                // Mostly the one after the last one's.
                const std::int64_t guess = near + 1;
                const auto wanted = static_cast<std::int32_t>(domain_.grid.index(from[0], from[1], from[2]));
                const bool guessed = near >= 0 && guess < static_cast<std::int64_t>(domain_.nodes()) &&
                                     domain_.cell[static_cast<std::size_t>(guess)] == wanted;
                source = guessed ? guess : domain_.node_at(from);
            }
            if (source >= 0) near = source;
            slots.push_back(
                static_cast<std::uint32_t>(source >= 0 ? slot_of(other, static_cast<std::size_t>(source)) : slot_of(own, node)));
        }
        const auto by_node = [](const OpenLink& link, std::size_t node) { return link.node < node; };
        for (auto link = std::lower_bound(domain_.open_links.begin(), domain_.open_links.end(), first, by_node);
             link != domain_.open_links.end() && link->node < end; ++link)
            if (link->q == q)
                slots[link->node - first] =
                    static_cast<std::uint32_t>(slot_of(static_cast<std::size_t>(opposite(link->source_q)), link->source));
    }

private:
    const Domain& domain_;
};

void add_segments(const std::vector<std::uint32_t>& slots, Segments& segments) {
    for (std::size_t i = 0; i < slots.size(); ++i) {
        if (i > 0 && slots[i] == slots[i - 1] + 1)
            ++segments.length.back();
        else {
            segments.slot.push_back(slots[i]);
            segments.length.push_back(1);
        }
    }
}

}  // namespace

Addresses find_addresses(const Domain& domain) {
    const std::size_t chunks = (domain.nodes() + chunk_nodes - 1) / chunk_nodes;
    Addresses addresses{.slots = slot_of(0, chunks * chunk_nodes), .first_segment = {0}, .slot = {}, .length = {}};
    const Tracer tracer(domain);
    constexpr std::size_t share = 256;
    std::vector<Segments> parts((chunks + share - 1) / share);
    parallel_for(parts.size(), [&](std::size_t p) {
        std::vector<std::uint32_t> slots;
        for (std::size_t c = p * share; c < std::min(chunks, (p + 1) * share); ++c) {
            for (int q = 1; q < d3q19::directions; ++q) {
                tracer.trace(c * chunk_nodes, q, slots);
                add_segments(slots, parts[p]);
            }
            parts[p].end.push_back(parts[p].slot.size());
        }
    });
    std::size_t total = 0;
    for (const Segments& part : parts) total += part.slot.size();
    addresses.slot.reserve(total);
    addresses.length.reserve(total);
    for (Segments& part : parts) {
        for (const std::uint64_t end : part.end) addresses.first_segment.push_back(addresses.slot.size() + end);
        addresses.slot.insert(addresses.slot.end(), part.slot.begin(), part.slot.end());
        addresses.length.insert(addresses.length.end(), part.length.begin(), part.length.end());
        part = {};
    }
    return addresses;
}

}  // namespace porepack
