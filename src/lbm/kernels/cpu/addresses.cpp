#include "lbm/kernels/cpu/addresses.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <span>

#include "core/parallel.hpp"
#include "lbm/lattice.hpp"
#include "lbm/neighbours.hpp"

namespace porepack::lbm::cpu {
using namespace core;
using namespace shapes;
namespace {

using d3q19::opposite;

class Tracer {
public:
    explicit Tracer(const Domain& domain) : domain_(domain), neighbours_(domain) {}

    using Slots = std::array<std::array<std::uint32_t, chunk_nodes>, d3q19::directions>;
    // Slots of the populations that arrive at the chunk's nodes; returns the number of nodes.
    std::size_t trace(std::size_t first, Slots& slots) {
        const std::size_t end = std::min(domain_.nodes(), first + chunk_nodes);
        std::array<std::size_t, chunk_nodes> cells;
        domain_.cells.list(first, std::span(cells).first(end - first));
        for (std::size_t node = first; node < end; ++node) {
            const auto& near = neighbours_.of(cells[node - first]);
            for (std::size_t q = 1; q < d3q19::directions; ++q) {
                const auto out = static_cast<std::size_t>(opposite(static_cast<int>(q)));
                slots[q][node - first] =
                    static_cast<std::uint32_t>(near[out] >= 0 ? slot_of(out, static_cast<std::size_t>(near[out])) : slot_of(q, node));
            }
        }
        const auto by_node = [](const BoundaryLink& link, std::size_t node) { return link.node < node; };
        for (auto link = std::lower_bound(domain_.boundary_links.begin(), domain_.boundary_links.end(), first, by_node);
             link != domain_.boundary_links.end() && link->node < end; ++link)
            slots[link->q][link->node - first] =
                static_cast<std::uint32_t>(slot_of(static_cast<std::size_t>(opposite(link->source_q)), link->source));
        return end - first;
    }

private:
    const Domain& domain_;
    Neighbours neighbours_;
};

// The two locations of most SIMD lanes; the other lanes are added to `singles`. All lanes hold slots.
Addresses::Vector gather_vector(std::span<const std::uint32_t> slots, std::size_t place, std::vector<Addresses::Single>& singles) {
    std::array<std::uint32_t, 64> base{};
    std::array<std::uint16_t, 64> lanes{};
    std::size_t bases = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        const auto here = static_cast<std::uint32_t>(slots[i] - i);  // no slot of a direction is below one chunk
        std::size_t b = 0;
        while (b < bases && base[b] != here) ++b;
        if (b == bases) base[bases++] = here;
        lanes[b] = static_cast<std::uint16_t>(lanes[b] | 1U << i);
    }
    for (std::size_t b = 0; b < std::min<std::size_t>(bases, 2); ++b)
        for (std::size_t other = b + 1; other < bases; ++other)
            if (std::popcount(lanes[other]) > std::popcount(lanes[b])) {
                std::swap(base[b], base[other]);
                std::swap(lanes[b], lanes[other]);
            }
    for (std::size_t b = 2; b < bases; ++b)
        for (std::size_t i = 0; i < slots.size(); ++i)
            if ((lanes[b] >> i & 1U) != 0) singles.push_back({slots[i], static_cast<std::uint16_t>(place + i)});
    return {base[0], bases > 1 ? base[1] : base[0], lanes[0], lanes[1]};
}

}  // namespace

Addresses find_addresses(const Domain& domain, std::size_t lanes) {
    const std::size_t chunks = (domain.nodes() + chunk_nodes - 1) / chunk_nodes, a_chunk = (d3q19::directions - 1) * chunk_nodes / lanes;
    Addresses addresses{.slots = slot_of(0, chunks * chunk_nodes), .vectors = {}, .singles = {}, .first_single = {0}};
    addresses.vectors.resize(chunks * a_chunk);
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
            Addresses::Vector* vector = addresses.vectors.data() + c * a_chunk;
            for (std::size_t q = 1; q < d3q19::directions; ++q) {
                for (std::size_t i = 0; i < chunk_nodes; i += lanes, ++vector) {
                    const std::size_t count = i < size ? std::min(lanes, size - i) : 0;
                    *vector = count == 0 ? Addresses::Vector{}
                                         : gather_vector(std::span(slots[q]).subspan(i, count), q * chunk_nodes + i, parts[p].singles);
                }
            }
            parts[p].end.push_back(parts[p].singles.size());
        }
    });
    for (Part& part : parts) {
        for (const std::size_t end : part.end) addresses.first_single.push_back(static_cast<std::uint32_t>(addresses.singles.size() + end));
        addresses.singles.insert(addresses.singles.end(), part.singles.begin(), part.singles.end());
        part = {};
    }
    return addresses;
}

}  // namespace porepack::lbm::cpu
