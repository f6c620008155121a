#include "shapes/config.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace porepack {
namespace {

void describe_point(ConfigVisitor& v, const char* key, Vec3& point, const char* meaning) {
    std::vector<double> values(point.data(), point.data() + 3);
    v.numbers(key, values, {3, 3}, {}, meaning);
    point = Vec3(values[0], values[1], values[2]);
}

}  // namespace

void describe(ConfigVisitor& v, ShapeConfig& c) {
    v.choice("kind", c.kind, {"tetrapod", "dolos", "tetrahedron", "sphere", "rod", "capsules", "stl"},
             "capsules: a union listed in [[shape.capsule]]; stl: the grains are a closed surface of your own (`file`)");
    v.number("sphericity", c.sphericity, {.low = 0.0, .high = 1.0, .low_open = true, .zero_is_auto = true},
             "with volume_m3: determines diameter and length");
    v.number("volume_m3", c.volume_m3, positive_or_auto(), "volume of one grain");
    v.number("diameter_m", c.diameter_m, positive_or_auto(), "diameter of the capsules (instead of sphericity and volume)");
    v.number("length_m", c.length_m, not_negative(), "length of the capsules' axes");
    v.choice("cavity", c.cavity, {"filled", "open"}, "does an enclosed void count as solid (no fluid reaches it) or as void?");
    v.text("file", c.file, "STL file (kind = \"stl\"), relative to the case");
    v.number("unit_m", c.unit_m, positive(), "length of the STL file's unit in metres: 0.001 for millimetres");
    v.tables(
        "capsule",
        [&](std::size_t count) {
            if (count < 100000) c.capsule.resize(count);
            return c.capsule.size();
        },
        [&](std::size_t i, ConfigVisitor& entry) {
            describe_point(entry, "a_m", c.capsule[i].a, "one end of the axis");
            describe_point(entry, "b_m", c.capsule[i].b, "the other end");
            entry.number("radius_m", c.capsule[i].radius, positive(), "radius");
        },
        "the capsules of a union (kind = \"capsules\"): a_m, b_m, radius_m");
}

Shape make_shape(const ShapeConfig& c) {
    Shape shape;
    const bool by_sphericity = c.sphericity > 0.0, by_size = c.diameter_m > 0.0;
    if (c.kind == "stl") throw UserError("the shape is an STL file, not a union of capsules", {.mend = "start the chain at the stl stage"});
    if (c.kind == "capsules") {
        shape.id = "capsules";
        shape.capsules = c.capsule;
        if (shape.capsules.empty())
            throw UserError("kind is \"capsules\", but no [[shape.capsule]] is given",
                            {.mend = "add a table [[shape.capsule]] with a_m, b_m and radius_m for each capsule"});
    } else if (!c.capsule.empty()) {
        throw UserError("capsules are given, but kind is \"" + c.kind + "\"", {.mend = "set kind = \"capsules\""});
    } else if (by_sphericity && by_size) {
        throw UserError("both sphericity and diameter_m are given: they may contradict each other",
                        {.mend = "give sphericity and volume_m3, or diameter_m and length_m"});
    } else if (by_sphericity || (c.kind == "sphere" && c.volume_m3 > 0.0 && !by_size)) {
        if (c.volume_m3 == 0.0) throw UserError("sphericity needs volume_m3 beside it", {.mend = "add volume_m3, for instance 7.33e-7"});
        const Dimensions size =
            dimensions_for(c.kind, by_sphericity ? c.sphericity : 1.0, c.volume_m3, c.cavity == "open" ? Cavity::open : Cavity::filled);
        shape = make_preset(c.kind, size.diameter_m, size.length_m);
    } else if (by_size) {
        if (c.kind == "sphere" && c.length_m > 0.0)
            throw UserError("a sphere has no length", {.mend = "remove length_m, or choose kind = \"rod\""});
        shape = make_preset(c.kind, c.diameter_m, c.length_m);
    } else {
        throw UserError("the shape's size is missing", {.mend = "give sphericity and volume_m3, or diameter_m and length_m"});
    }
    shape.cavity = c.cavity == "open" ? Cavity::open : Cavity::filled;
    validate(shape);
    find_cavities(shape);
    return shape;
}

}  // namespace porepack
