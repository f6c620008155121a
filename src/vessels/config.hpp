// Table [container] of case.toml, and the kinds of vessels: what is read from a case, from packing.json and from the command line.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/json_fwd.hpp"
#include "geometry/triangle_wall.hpp"
#include "record/config.hpp"
#include "vessels/container.hpp"

namespace porepack::vessels {

/// The keys of all kinds; each kind allows some of them. 0 and empty lists: not given.
struct ContainerConfig {
    std::string kind = "cylinder";
    double diameter_m = 0.0;
    double inner_diameter_m = 0.0;
    double top_diameter_m = 0.0;
    double height_m = 0.0;
    std::vector<double> size_m;
    std::vector<bool> periodic = {false, false, false};
    std::string file;
    double unit_m = 0.0;
    std::shared_ptr<const geometry::TriangleMesh> mesh;  ///< of the file, in metres; not a key
};

/// Names of the kinds, in the order of the documentation.
[[nodiscard]] const std::vector<std::string>& kinds_of_vessels();

inline void describe(record::ConfigVisitor& v, ContainerConfig& c) {
    v.word("kind", c.kind, kinds_of_vessels(),
           "upright cylinder, annulus (between two cylinders) or cone (a frustum; axis x = y = 0), box (corner at the origin), or mesh (a "
           "closed surface in a file); floor at z = 0");
    v.number("diameter_m", c.diameter_m, record::length_range_or_auto(),
             "inner diameter of the cylinder; of an annulus that of its outer wall; of a cone at the floor");
    v.number("inner_diameter_m", c.inner_diameter_m, record::length_range_or_auto(), "diameter of an annulus's inner wall");
    v.number("top_diameter_m", c.top_diameter_m, record::length_range_or_auto(), "inner diameter of a cone at height_m");
    v.number("height_m", c.height_m, record::length_range_or_auto(), "inner height of a cylinder, annulus or cone");
    v.numbers("size_m", c.size_m, {3, 3}, record::length_range(), "inner size of the box");
    v.text("file", c.file,
           "kind mesh: STL, PLY or OBJ file with the closed surface of the inner space, normals outward; its highest horizontal faces are "
           "the opening; inserts are part of it. It is moved along z to begin at 0");
    v.number("unit_m", c.unit_m, record::length_range_or_auto(), "length of the file's unit in metres: 0.001 for millimetres");
    v.booleans("periodic", c.periodic, 3, "true where the box is periodic along x, y, z");
}

/// Throws UserError for a key that the kind needs, or that has no effect on it, or where the mesh is faulty.
[[nodiscard]] Container make_container(const ContainerConfig& config);
/// "cylinder:D,H, ...": what parse_container() takes, in metres.
[[nodiscard]] std::string container_forms();
/// "a cylinder has its axis at x = y = 0, ...": where each kind lies.
[[nodiscard]] std::string container_frames();
/// "a cylinder 100 mm wide and 0.7 m high": of the table [container]; "its container" where sizes are not given.
[[nodiscard]] std::string container_text(const core::Json& container, const std::function<std::string(double)>& length_text);
/// Of one of the container_forms(). Throws UserError with the allowed forms.
[[nodiscard]] Container parse_container(const std::string& text);
/// What to_json() writes. Throws UserError with `where`, the name of the file.
[[nodiscard]] Container container_from_json(const core::Json& json, const std::string& where);

}  // namespace porepack::vessels
