#include "shapes/config.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace porepack::shapes {
using namespace record;
namespace {

void describe_point(ConfigVisitor& v, const char* key, Vec3& point, const char* meaning) {
    std::vector<double> values(point.data(), point.data() + 3);
    v.numbers(key, values, {3, 3}, {}, meaning);
    point = Vec3(values[0], values[1], values[2]);
}

// The keys of one shape; a mixture's components have them too.
void describe_shape(ConfigVisitor& v, ShapeConfig& c, const std::vector<ShapeKind>& kinds) {
    v.renamed_word("kind", "stl", "surface");
    v.choice("kind", c.kind, kinds,
             "capsules: a union listed in [[shape.capsule]]; mesh: one grain is a closed surface from `file`; library: each grain is one "
             "of the meshes in `folder`; surface: all grains are a "
             "closed surface from `file`; mixture: several shapes, listed in [[shape.component]]; cylinder to prism: grains with faces, "
             "cylinders "
             "with flat ends");
    v.number("sphericity", c.sphericity, {.low = 0.0, .high = 1.0, .low_open = true, .zero_is_auto = true},
             "with volume_m3: determines diameter and length; of a cylinder or prism diameter and height (the higher one of two)");
    v.number("volume_m3", c.volume_m3, Range{.low = 1e-36, .high = 1e18, .zero_is_auto = true}, "volume of one grain");
    v.number("diameter_m", c.diameter_m, length_range_or_auto(),
             "diameter of the capsules (instead of sphericity and volume); of a cylinder, a ring, of the circle around a lobed grain or a "
             "prism");
    v.number("length_m", c.length_m, between(0.0, 1e6), "length of the capsule axes");
    v.number("height_m", c.height_m, length_range_or_auto(), "height of a cylinder, ring, lobed grain or prism");
    v.number("inner_diameter_m", c.inner_diameter_m, length_range_or_auto(), "diameter of a ring's hole");
    v.number("lobe_diameter_m", c.lobe_diameter_m, length_range_or_auto(), "diameter of each lobe of a lobed grain");
    v.integer("lobes", c.lobes, Range{.low = 3, .high = 4, .zero_is_auto = true}, "of a lobed grain; auto: 3");
    v.integer("sides", c.sides, Range{.low = 3, .high = 64, .zero_is_auto = true}, "of a prism's regular polygon");
    v.numbers("size_m", c.size_m, {3, 3}, length_range(), "lengths of a box's edges");
    v.number("side_m", c.side_m, length_range_or_auto(), "length of a cube's edges");
    v.number(
        "rounding_m", c.rounding_m, length_range_or_auto(),
        "radius of the rounded edges of a grain with faces, inside the given sizes; auto: 2 % of the diameter of the sphere of the same "
        "volume");
    v.text("file", c.file, "STL, PLY or OBJ file of a mesh, or of all grains (kind = \"surface\"), relative to the case");
    v.text("folder", c.folder, "library: the folder of its meshes (STL, PLY, OBJ), relative to the case");
    v.choice("library_by", c.library_by, "library: every mesh has the same part in the number of grains, or in their volume");
    v.number("unit_m", c.unit_m, length_range_or_auto(),
             "length of the file's unit in metres: 0.001 for millimetres; a mesh and a library need it; auto: 1 with kind = \"surface\"");
    v.integer("faces", c.faces, Range{.low = 4, .high = 2000, .zero_is_auto = true},
              "number of triangles to which a mesh is simplified; auto: 80, or as many as deviation_m needs");
    v.number("deviation_m", c.deviation_m, length_range_or_auto(),
             "of a mesh: the largest distance between the simplified grain and the file's surface; auto: what the faces give");
    v.integer("arms", c.arms, between(2, 64), "number of arms of a star, evenly distributed");
    v.choice("cavity", c.cavity, "filled: an enclosed void counts as solid (no fluid reaches it); open: it counts as void");
    v.boolean("disconnected", c.disconnected, "true: the capsules of a union may be disconnected and still form one rigid body");
    v.tables(
        "capsule",
        [&](std::size_t count) {
            constexpr std::size_t maximum = 64;
            if (count > maximum && count != keep_size)
                throw UserError(fmt::format("{} capsules are listed", count), {.where = "[[shape.capsule]]", .allowed = "1 to 64"});
            if (count != keep_size) c.capsule.resize(count);
            return c.capsule.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) {
            describe_point(entry, "a_m", c.capsule[i].a, "one end of the axis");
            describe_point(entry, "b_m", c.capsule[i].b, "the other end");
            entry.number("radius_m", c.capsule[i].radius, length_range(), "radius");
        },
        "the capsules of a union (kind = \"capsules\"): a_m, b_m, radius_m");
}

}  // namespace

void describe(ConfigVisitor& v, ShapeConfig& c) {
    std::vector<ShapeKind> kinds;
    for (const auto& kind : choices_of(c.kind)) kinds.push_back(kind.value);
    std::vector<ShapeKind> of_components = kinds;
    std::erase_if(of_components,
                  [](ShapeKind kind) { return kind == ShapeKind::surface || kind == ShapeKind::library || kind == ShapeKind::mixture; });
    describe_shape(v, c, kinds);
    v.tables(
        "component",
        [&](std::size_t count) {
            constexpr std::size_t maximum = 32;
            if (count > maximum && count != keep_size)
                throw UserError(fmt::format("{} components are listed", count), {.where = "[[shape.component]]", .allowed = "2 to 32"});
            if (count != keep_size) c.component.resize(count);
            return c.component.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) {
            entry.number("number_fraction", c.component[i].number_fraction, {.low = 0.0, .high = 1.0, .low_open = true},
                         "number fraction of the grains");
            describe_shape(entry, c.component[i], of_components);
        },
        "the shapes of a mixture (kind = \"mixture\"): number_fraction and the keys of a shape");
}

Shape make_shape(const ShapeConfig& c) {
    Shape shape;
    const bool by_sphericity = c.sphericity > 0.0, by_size = c.diameter_m > 0.0;
    if (c.kind == ShapeKind::mixture) throw UserError("a mixture is not one shape", {.fix = "choose one of its components"});
    if (c.kind == ShapeKind::surface)
        throw UserError("the shape is the surface of all grains, not one grain", {.fix = "start at the stl stage"});
    if (c.kind == ShapeKind::library) throw UserError("a library is not one shape", {.fix = "choose one of its meshes: kind = \"mesh\""});
    if (c.kind == ShapeKind::mesh) {
        require_mesh_keys(c);
        if (c.from_file == nullptr) throw UserError("kind = \"mesh\" is not possible here", {.fix = "give a shape by its sizes"});
        return {.id = "mesh", .body = c.from_file};
    }
    if (has_faces(c.kind)) return {.id = std::string(name_of(c.kind)), .body = make_faced(c).body};
    refuse_keys_of_faces(c);
    if (c.kind == ShapeKind::capsules) {
        shape.id = "capsules";
        shape.capsules = c.capsule;
        if (shape.capsules.empty())
            throw UserError("kind is \"capsules\", but no [[shape.capsule]] is given",
                            {.fix = "add a table [[shape.capsule]] with a_m, b_m and radius_m for each capsule"});
    } else if (!c.capsule.empty()) {
        throw UserError("capsules are given, but kind is \"" + std::string(name_of(c.kind)) + "\"", {.fix = "set kind = \"capsules\""});
    } else if (by_sphericity && by_size) {
        throw UserError("both sphericity and diameter_m are given: they may contradict each other",
                        {.fix = "give sphericity and volume_m3, or diameter_m and length_m"});
    } else if (by_sphericity || (c.kind == ShapeKind::sphere && c.volume_m3 > 0.0 && !by_size)) {
        if (c.volume_m3 == 0.0) throw UserError("sphericity also needs volume_m3", {.fix = "add volume_m3, for instance 7.33e-7"});
        const Dimensions size = dimensions_for(c.kind, by_sphericity ? c.sphericity : 1.0, c.volume_m3, c.cavity, c.arms);
        shape = make_preset(c.kind, size.diameter_m, size.length_m, c.arms);
    } else if (by_size) {
        if (c.kind == ShapeKind::sphere && c.length_m > 0.0)
            throw UserError("a sphere has no length", {.fix = "remove length_m, or choose kind = \"rod\""});
        shape = make_preset(c.kind, c.diameter_m, c.length_m, c.arms);
    } else {
        throw UserError("the shape's size is missing", {.fix = "give sphericity and volume_m3, or diameter_m and length_m"});
    }
    shape.cavity = c.cavity;
    shape.may_be_disconnected = c.disconnected;
    validate(shape);
    find_cavities(shape);
    return shape;
}

std::vector<ShapeShare> make_shapes(const ShapeConfig& c) {
    if (c.kind != ShapeKind::mixture) {
        if (!c.component.empty())
            throw UserError("components are given, but kind is \"" + std::string(name_of(c.kind)) + "\"",
                            {.fix = "set kind = \"mixture\""});
        return {{make_shape(c), 1.0}};
    }
    if (c.component.size() < 2)
        throw UserError(fmt::format("a mixture needs two shapes or more, {} is given", c.component.size()),
                        {.fix = "add tables [[shape.component]] with number_fraction and the keys of a shape"});
    if (!c.file.empty() || !c.folder.empty() || c.library_by != LibraryBy::number || c.unit_m > 0.0 || c.faces > 0 || c.deviation_m > 0.0 ||
        c.rounding_m > 0.0)
        throw UserError("`file`, `folder`, `unit_m`, `faces`, `deviation_m` and `rounding_m` have no effect on a mixture as a whole",
                        {.where = "[shape]", .fix = "write them into the tables [[shape.component]]"});
    std::vector<ShapeShare> shares;
    double sum = 0.0;
    for (std::size_t i = 0; i < c.component.size(); ++i) {
        shares.push_back({make_shape(c.component[i]), c.component[i].number_fraction});
        shares.back().shape.id += fmt::format("_{}", i + 1);
        sum += c.component[i].number_fraction;
    }
    if (std::abs(sum - 1.0) > 1e-6)
        throw UserError(fmt::format("the number fractions of a mixture add up to {:g}", sum),
                        {.where = "[[shape.component]]", .allowed = "1"});
    return shares;
}

}  // namespace porepack::shapes
