// Presets of grains with faces. The given sizes are those of the grain with sharp edges; the rounding takes a little of its volume away,
// which one scale gives back.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "shapes/config.hpp"

namespace porepack::shapes {
using namespace core;
namespace {

using Body = std::shared_ptr<const RoundedBody>;

struct Key {
    const char* name;
    bool given;
};

// The keys that only grains with faces have, and the two that they share with others.
std::vector<Key> size_keys(const ShapeConfig& c) {
    return {{"diameter_m", c.diameter_m > 0.0},
            {"inner_diameter_m", c.inner_diameter_m > 0.0},
            {"lobe_diameter_m", c.lobe_diameter_m > 0.0},
            {"lobes", c.lobes > 0},
            {"sides", c.sides > 0},
            {"height_m", c.height_m > 0.0},
            {"size_m", !c.size_m.empty()},
            {"side_m", c.side_m > 0.0}};
}

struct Preset {
    ShapeKind kind;
    std::vector<std::string> needed, optional;
    bool has_one_ratio;  // height over diameter: it may follow from the sphericity
};

const Preset& preset_of(ShapeKind kind) {
    static const std::vector<Preset> presets = {{ShapeKind::cylinder, {"diameter_m", "height_m"}, {}, true},
                                                {ShapeKind::prism, {"sides", "diameter_m", "height_m"}, {}, true},
                                                {ShapeKind::ring, {"diameter_m", "inner_diameter_m", "height_m"}, {}, false},
                                                {ShapeKind::lobed, {"diameter_m", "lobe_diameter_m", "height_m"}, {"lobes"}, false},
                                                {ShapeKind::box, {"size_m"}, {}, false},
                                                {ShapeKind::cube, {"side_m"}, {}, false}};
    return *std::find_if(presets.begin(), presets.end(), [&](const Preset& preset) { return preset.kind == kind; });
}

Body with_rounding(const ShapeConfig& c, double rounding_m) {
    switch (c.kind) {
        case ShapeKind::cylinder:
            return make_ring({.diameter_m = c.diameter_m, .height_m = c.height_m, .rounding_m = rounding_m});
        case ShapeKind::ring:
            return make_ring({c.diameter_m, c.inner_diameter_m, c.height_m, rounding_m});
        case ShapeKind::prism:
            return make_polyhedron(prism_size(c.sides, c.diameter_m, c.height_m, rounding_m));
        case ShapeKind::lobed:
            return make_lobed({c.lobes > 0 ? c.lobes : 3, c.diameter_m, c.lobe_diameter_m, c.height_m, rounding_m});
        case ShapeKind::box:
            return make_polyhedron(box_size({c.size_m[0], c.size_m[1], c.size_m[2]}, rounding_m));
        default:
            return make_polyhedron(box_size(Vec3::Constant(c.side_m), rounding_m));
    }
}

struct Sizes {
    double volume_m3 = 0.0, area_m2 = 0.0;
    [[nodiscard]] double sphericity() const { return std::cbrt(36.0 * std::numbers::pi * volume_m3 * volume_m3) / area_m2; }
};

Sizes sizes_of(const RoundedBody& body) {
    Sizes sizes;
    body.for_surface([&](const Vec3& x, const Vec3& n, double area) {
        sizes.area_m2 += area;
        sizes.volume_m3 += area * x.dot(n) / 3.0;
    });
    return sizes;
}

FacedGrain of_sizes(const ShapeConfig& c) {
    const Sizes sharp = sizes_of(*with_rounding(c, 0.0));
    const double rounding = c.rounding_m > 0.0 ? c.rounding_m : default_rounding * std::cbrt(6.0 * sharp.volume_m3 / std::numbers::pi);
    const Body body = with_rounding(c, rounding);
    const double scale = std::cbrt(sharp.volume_m3 / sizes_of(*body).volume_m3);
    return {.body = body->scaled(scale), .scale = scale, .sharp_area_m2 = sharp.area_m2, .sharp_sphericity = sharp.sphericity()};
}

// With the diameter 1, scaled to the volume.
FacedGrain of_aspect(const ShapeConfig& c, double height_over_diameter) {
    ShapeConfig unit = c;
    unit.diameter_m = 1.0;
    unit.height_m = height_over_diameter;
    unit.rounding_m = 0.0;
    const double size = std::cbrt(c.volume_m3 / sizes_of(*with_rounding(unit, 0.0)).volume_m3);
    unit.rounding_m = c.rounding_m / size;
    FacedGrain grain = of_sizes(unit);
    grain.body = grain.body->scaled(size);
    grain.sharp_area_m2 *= size * size;
    return grain;
}

// The sphericity rises to its maximum near a height of one diameter and falls on both sides: the grain higher than that is taken.
FacedGrain of_sphericity(const ShapeConfig& c) {
    const auto sphericity_at = [&](double log_aspect) { return sizes_of(*of_aspect(c, std::exp(log_aspect)).body).sphericity(); };
    constexpr double golden = 0.6180339887498949;
    double low = std::log(0.3), high = std::log(3.0);
    for (int step = 0; step < 40; ++step) {
        const double a = high - golden * (high - low), b = low + golden * (high - low);
        (sphericity_at(a) > sphericity_at(b) ? high : low) = sphericity_at(a) > sphericity_at(b) ? b : a;
    }
    const double highest = sphericity_at(low), longest = std::log(50.0);
    if (c.sphericity > highest || c.sphericity < sphericity_at(longest))
        throw UserError(fmt::format("no {} has sphericity {:g}", name_of(c.kind), c.sphericity),
                        {.allowed = fmt::format("{:.4f} (50 diameters high) to {:.4f}", sphericity_at(longest), highest),
                         .fix = "flat ones: give diameter_m and height_m"});
    double from = low, to = longest;
    for (int step = 0; step < 60; ++step) {
        const double middle = 0.5 * (from + to);
        (sphericity_at(middle) > c.sphericity ? from : to) = middle;
    }
    return of_aspect(c, std::exp(from));
}

}  // namespace

bool has_faces(ShapeKind kind) {
    switch (kind) {
        case ShapeKind::cylinder:
        case ShapeKind::ring:
        case ShapeKind::box:
        case ShapeKind::cube:
        case ShapeKind::lobed:
        case ShapeKind::prism:
            return true;
        default:
            return false;
    }
}

void refuse_keys_of_faces(const ShapeConfig& c) {
    for (const Key& key : size_keys(c))
        if (key.given && std::string(key.name) != "diameter_m")
            throw UserError(fmt::format("`{}` has no effect on a {}", key.name, name_of(c.kind)),
                            {.fix = "remove it, or choose a kind with faces: cylinder, ring, box, cube, lobed, prism"});
    if (c.rounding_m > 0.0)
        throw UserError(fmt::format("`rounding_m` has no effect on a {}", name_of(c.kind)), {.fix = "remove it: capsules are round"});
}

FacedGrain make_faced(const ShapeConfig& c) {
    const Preset& preset = preset_of(c.kind);
    const auto contains = [](const std::vector<std::string>& list, const char* name) {
        return std::find(list.begin(), list.end(), name) != list.end();
    };
    const bool by_sphericity = c.sphericity > 0.0;
    if (!c.capsule.empty() || c.length_m > 0.0)
        throw UserError(
            fmt::format("a {} has no capsules", name_of(c.kind)),
            {.allowed = fmt::format("{}, rounding_m", fmt::join(preset.needed, ", ")), .fix = "remove length_m and [[shape.capsule]]"});
    if (by_sphericity && !preset.has_one_ratio)
        throw UserError(fmt::format("the sphericity does not determine a {}", name_of(c.kind)),
                        {.fix = fmt::format("give {}", fmt::join(preset.needed, ", "))});
    if (by_sphericity != (c.volume_m3 > 0.0))
        throw UserError(
            by_sphericity ? "sphericity also needs volume_m3" : "volume_m3 also needs sphericity",
            {.fix = fmt::format("give {}{}", fmt::join(preset.needed, ", "), preset.has_one_ratio ? "; or sphericity and volume_m3" : "")});
    for (const Key& key : size_keys(c)) {
        const bool from_sphericity = by_sphericity && std::string(key.name) != "sides";
        if (key.given && from_sphericity)
            throw UserError(fmt::format("both sphericity and {} are given: they may contradict each other", key.name),
                            {.fix = fmt::format("give sphericity and volume_m3, or {}", fmt::join(preset.needed, ", "))});
        if (key.given && !contains(preset.needed, key.name) && !contains(preset.optional, key.name))
            throw UserError(fmt::format("`{}` has no effect on a {}", key.name, name_of(c.kind)),
                            {.allowed = fmt::format("{}, rounding_m", fmt::join(preset.needed, ", "))});
        if (!key.given && contains(preset.needed, key.name) && !from_sphericity)
            throw UserError(fmt::format("a {} needs {}", name_of(c.kind), key.name),
                            {.fix = fmt::format("give {}{}", fmt::join(preset.needed, ", "),
                                                preset.has_one_ratio ? "; or sphericity and volume_m3" : "")});
    }
    return by_sphericity ? of_sphericity(c) : of_sizes(c);
}

}  // namespace porepack::shapes
