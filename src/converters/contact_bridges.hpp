// Contacts of grains, and the treatment of their meshes there; only for the sources of this folder that include CGAL.
#pragma once

#include <utility>
#include <vector>

#include "converters/cgal_mesh.hpp"
#include "packing/grains.hpp"

namespace porepack::converters {

/// Two capsules of different grains in contact or nearly so. A grain with faces has there a ball that lies in it and touches its surface.
struct GrainContact {
    std::size_t first, second;  ///< images
    shapes::Capsule first_capsule, second_capsule;
    shapes::Vec3 nearest;  ///< point of the first one's axis
    shapes::Vec3 normal;   ///< from there towards the second
    double gap;            ///< between the surfaces; negative where they overlap
    bool with_faces = false;
};

/// All contacts of images with a gap below `reach`, each once; of a grain with faces and another, only the nearest place.
[[nodiscard]] std::vector<GrainContact> find_contacts(const packing::Grains& grains, double reach);

/// A box that joins two grains at their contact.
struct Bridge {
    shapes::Vec3 middle, half_size;
    Eigen::Matrix3d axes;  ///< columns: along the contact, across it, from the first grain to the second
    [[nodiscard]] bool contains(const shapes::Vec3& x) const {
        return ((axes.transpose() * (x - middle)).cwiseAbs().array() < half_size.array()).all();
    }
};
/// Wide enough to contain the lens in which the grains overlap. After a fault (`variant` > 0) it is wider: it also contains the lens of the
/// deviations, where facets cross at a grazing angle.
[[nodiscard]] Bridge bridge_of(const GrainContact& contact, double contact_gap, double deviation, int variant);
/// Vertices 0 to 3 lie in the first grain, 4 to 7 in the second.
[[nodiscard]] Mesh bridge_mesh(const Bridge& bridge);

/// Where the grain is near one of `others`, its corners are moved onto its exact surface: the facets between them then lie inside, so that
/// grains meet only where their exact surfaces do. The other corners are moved outward, so that the mesh keeps its volume. After a fault
/// (`variant` > 0) corners farther away are moved too, and those in creases.
void keep_apart(Mesh& mesh, const shapes::PlacedShape& grain, const std::vector<shapes::PlacedShape>& others, double deviation,
                int variant);

/// Initial number of thinnings per image: of overlapping capsules on one line (a rod through a periodic face and its image), and of grains
/// with faces that meet without gap or overlap, one is thinner, otherwise their facets would coincide and CGAL would crash.
[[nodiscard]] std::vector<int> thin_coincident(std::size_t images, const std::vector<GrainContact>& contacts, double contact_gap);

/// Groups of images that are joined, directly or through others.
[[nodiscard]] std::vector<std::vector<std::size_t>> clusters_of(std::size_t images,
                                                                const std::vector<std::pair<std::size_t, std::size_t>>& joined);

}  // namespace porepack::converters
