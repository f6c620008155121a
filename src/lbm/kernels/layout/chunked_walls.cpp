#include "lbm/kernels/layout/chunked_walls.hpp"

#include <algorithm>

namespace porepack::lbm::layout {

using d3q19::opposite;

ChunkedWalls::ChunkedWalls(const Domain& domain) {
    const std::size_t chunks = chunks_for(domain.nodes());
    first.reserve(chunks + 1);
    first_gap.reserve(chunks + 1);
    const auto narrow =
        static_cast<std::size_t>(std::count_if(domain.walls.begin(), domain.walls.end(), [](const WallLink& l) { return l.narrow; }));
    row.reserve(domain.walls.size() - narrow);
    distance.reserve(domain.walls.size() - narrow + 16);
    gaps.reserve(narrow / 2);
    const WallLink* link = domain.walls.data();
    const WallLink* const end = link + domain.walls.size();
    for (std::size_t c = 0; c < chunks; ++c) {
        first.push_back(row.size());
        first_gap.push_back(gaps.size());
        for (; link != end && link->node < (c + 1) * chunk_nodes; ++link) {
            const std::size_t place = link->node - c * chunk_nodes;
            if (!link->narrow) {
                row.push_back(static_cast<std::uint16_t>(link->q * chunk_nodes + place));
                distance.push_back(link->distance);
            } else if (link->q % 2 == 1) {
                const WallLink* other = link;  // the opposite direction follows it
                while (other->q != opposite(link->q)) ++other;
                gaps.push_back({static_cast<std::uint8_t>(place), link->q, link->distance, other->distance});
            }
        }
    }
    first.push_back(row.size());
    first_gap.push_back(gaps.size());
    distance.resize(row.size() + 16);
}

double ChunkedWalls::bytes() const {
    return static_cast<double>(first.size() * 16 + row.size() * 4 + gaps.size() * sizeof(Gap));
}

}  // namespace porepack::lbm::layout
