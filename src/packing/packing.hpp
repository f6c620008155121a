// A packing: grains at rest in a container. Read from and written to packing.json (docs/files.md, docs/schema/).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/files.hpp"
#include "core/json_fwd.hpp"
#include "shapes/distance.hpp"
#include "shapes/shape.hpp"
#include "vessels/container.hpp"

namespace porepack::packing {

struct Body {
    std::size_t shape = 0;
    shapes::Vec3 position_m = shapes::Vec3::Zero();                   ///< of the origin of the shape's frame, not of the centre of mass
    shapes::Quaternion orientation = shapes::Quaternion::Identity();  ///< from the shape's frame to the world
};

struct Packing {
    vessels::Container container;
    std::vector<shapes::Shape> shapes;
    std::vector<Body> bodies;
    bool overlap_allowed = false;  ///< grains may overlap each other and the walls at will (Boolean models); else see require_no_overlap()
};

/// Reads .json and .json.gz; checks schema, numbers and plausibility. Throws UserError with the position in the file.
[[nodiscard]] Packing read_packing(const core::Path& path);
/// The same packing gives the same bytes.
void write_packing(const core::Path& path, const Packing& packing);

/// Minimum capsule diameter, or thickness of a body, of all shapes.
[[nodiscard]] double finest_diameter(const Packing& packing);
/// Means over a packing's grains.
struct GrainMeans {
    double equivalent_diameter_m;  ///< of the sphere of the mean volume
    double sauter_diameter_m;      ///< 6 volume / area: sphericity times the equal-volume diameter
};
[[nodiscard]] GrainMeans grain_means(const Packing& packing);
[[nodiscard]] shapes::PlacedShape placed(const Packing& packing, const Body& body);
/// All capsules of one body in the world frame; none of a grain with faces.
[[nodiscard]] std::vector<shapes::Capsule> world_capsules(const Packing& packing, const Body& body);

/// Maximum overlap of two grains' exact surfaces, and of a grain with the wall, in metres (0 when nothing overlaps).
struct Overlaps {
    double largest_between_grains_m = 0.0;
    double mean_between_grains_m = 0.0;  ///< over the contacts
    double largest_with_wall_m = 0.0;
    long contacts = 0;
    std::array<std::size_t, 2> grains = {0, 0};  ///< bodies with the largest overlap
    std::size_t grain_at_wall = 0;               ///< body with the largest overlap with the wall
};
[[nodiscard]] Overlaps find_overlaps(const Packing& packing);

/// Soft contacts of a pour overlap by less than this fraction of the thickness of the thinnest grain.
inline constexpr double largest_overlap_of_diameter = 0.1;
/// Throws UserError with the bodies when grains overlap each other or a wall by more than this fraction of it.
/// `where` names the file.
void require_no_overlap(const Packing& packing, const std::string& where);

}  // namespace porepack::packing
