#include "lbm/chunked_walls.hpp"

namespace porepack {

using d3q19::directions;
using d3q19::opposite;

ChunkedWalls::ChunkedWalls(const Domain& domain) {
    const std::size_t chunks = (domain.nodes() + chunk_nodes - 1) / chunk_nodes;
    first.reserve(chunks + 1);
    count.resize(chunks);
    std::array<std::vector<const WallLink*>, directions> by_direction;
    const WallLink* link = domain.walls.data();
    const WallLink* const end = link + domain.walls.size();
    for (std::size_t c = 0; c < chunks; ++c) {
        first.push_back(place.size());
        first_gap.push_back(gaps.size());
        for (auto& list : by_direction) list.clear();
        for (; link != end && link->node < (c + 1) * chunk_nodes; ++link) {
            if (!link->narrow) {
                by_direction[link->q].push_back(link);
            } else if (link->q % 2 == 1) {
                const WallLink* other = link;  // the opposite direction follows it
                while (other->q != opposite(link->q)) ++other;
                gaps.push_back({static_cast<std::uint8_t>(link->node - c * chunk_nodes), link->q, link->distance, other->distance});
            }
        }
        for (std::size_t q = 1; q < directions; ++q) {
            count[c][q] = static_cast<std::uint8_t>(by_direction[q].size());
            for (const WallLink* one : by_direction[q]) {
                place.push_back(static_cast<std::uint8_t>(one->node - c * chunk_nodes));
                distance.push_back(one->distance);
            }
        }
    }
    first.push_back(place.size());
    first_gap.push_back(gaps.size());
}

double ChunkedWalls::bytes() const {
    return static_cast<double>(first.size() * 16 + count.size() * directions + place.size() * 3 + gaps.size() * sizeof(Gap));
}

}  // namespace porepack
