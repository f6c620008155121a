// Table [container] of case.toml.
#pragma once

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "packing/packing.hpp"
#include "record/config.hpp"

namespace porepack::packing {

struct ContainerConfig {
    Container::Kind kind = Container::Kind::cylinder;
    double diameter_m = 0.0;
    double height_m = 0.0;
    std::vector<double> size_m;
    std::vector<bool> periodic = {false, false, false};
};

inline void describe(record::ConfigVisitor& v, ContainerConfig& c) {
    v.choice("kind", c.kind, "upright cylinder (axis x = y = 0) or box (corner at the origin); floor at z = 0");
    v.number("diameter_m", c.diameter_m, record::length_range_or_auto(), "inner diameter of the cylinder");
    v.number("height_m", c.height_m, record::length_range_or_auto(), "inner height of the cylinder");
    v.numbers("size_m", c.size_m, {3, 3}, record::length_range(), "inner size of the box");
    v.booleans("periodic", c.periodic, 3, "true where the box is periodic along x, y, z");
}

[[nodiscard]] inline Container make_container(const ContainerConfig& c) {
    Container container;
    const auto only_for = [](bool given, const char* key, const char* kind) {
        if (given)
            throw core::UserError(fmt::format("`{}` has no effect here: it belongs to kind = \"{}\"", key, kind),
                                  {.where = "[container]", .fix = "remove it, or change kind"});
    };
    const bool any_periodic = std::find(c.periodic.begin(), c.periodic.end(), true) != c.periodic.end();
    only_for(c.kind == Container::Kind::cylinder && !c.size_m.empty(), "size_m", "box");
    only_for(c.kind == Container::Kind::cylinder && any_periodic, "periodic", "box");
    only_for(c.kind == Container::Kind::box && c.diameter_m != 0.0, "diameter_m", "cylinder");
    only_for(c.kind == Container::Kind::box && c.height_m != 0.0, "height_m", "cylinder");
    if (c.kind == Container::Kind::cylinder) {
        if (c.diameter_m == 0.0 || c.height_m == 0.0)
            throw core::UserError("a cylinder needs diameter_m and height_m", {.where = "[container]"});
        container.diameter_m = c.diameter_m;
        container.height_m = c.height_m;
        return container;
    }
    if (c.size_m.empty()) throw core::UserError("a box needs size_m", {.where = "[container]", .fix = "size_m = [x, y, z] in metres"});
    container.kind = Container::Kind::box;
    container.size_m = shapes::Vec3(c.size_m[0], c.size_m[1], c.size_m[2]);
    for (std::size_t i = 0; i < 3; ++i) container.periodic[i] = c.periodic[i];
    return container;
}

}  // namespace porepack::packing
