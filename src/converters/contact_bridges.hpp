// Contacts of grains, and the treatment of their meshes there; only for the sources of this folder that include CGAL.
#pragma once

#include <vector>

#include "converters/cgal_mesh.hpp"
#include "packing/grains.hpp"

namespace porepack::converters {

/// Two capsules of different grains in contact or nearly so: the segment of the first one's axis that is nearest to the
/// second (a point unless they are parallel), and the direction towards it.
struct GrainContact {
    std::size_t first, second;  ///< images
    shapes::Capsule first_capsule, second_capsule;
    shapes::Vec3 from, to, normal;
    double gap;  ///< between the surfaces; negative where they overlap
};

/// All contacts of images with a gap below `reach`, each once.
[[nodiscard]] std::vector<GrainContact> find_contacts(const std::vector<packing::Grains::Image>& images, double reach);

/// A box that joins two grains at their contact, wide enough to contain the lens in which they overlap. After a fault (`variant` > 0) it is
/// wider: it also contains the lens of the deviations, where facets cross at a grazing angle.
[[nodiscard]] Mesh bridge_mesh(const GrainContact& contact, double contact_gap, double deviation, int variant);

/// Near a grain that is not in contact, a grain's corners are moved onto its exact surface: the facets between them then lie
/// inside, so that separate grains stay separate. After a fault (`variant` > 0) corners farther away are moved too: where only one end of
/// long thin facets moves, they can cross each other.
void keep_apart(Mesh& mesh, const shapes::Capsule& own, const GrainContact& contact, double deviation, int variant);

/// Initial number of thinnings per image: of overlapping capsules on one line (a rod through a periodic face and its image)
/// one is thinner, otherwise their facets would coincide and CGAL would crash.
[[nodiscard]] std::vector<int> thin_coaxial(std::size_t images, const std::vector<GrainContact>& contacts);

/// Groups of images joined by contacts: only those need Boolean operations.
[[nodiscard]] std::vector<std::vector<std::size_t>> clusters_of(std::size_t images, const std::vector<GrainContact>& contacts,
                                                                double contact_gap);

}  // namespace porepack::converters
