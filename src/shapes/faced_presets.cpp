// Presets of grains with faces. The given sizes are those of the grain with sharp edges; the rounding takes a little of its volume away,
// which one scale gives back.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "shapes/config.hpp"

namespace porepack::shapes {
namespace {

using Body = std::shared_ptr<const RoundedBody>;

struct Key {
    const char* name;
    bool given;
};

// All that give sizes, but for the rounding and the length of capsules.
std::vector<Key> keys_of_sizes(const ShapeConfig& c) {
    std::vector<Key> keys = {{"lobes", c.lobes > 0}, {"sides", c.sides > 0}, {"size_m", !c.size_m.empty()}};
    for (const SizeKey& key : size_keys)
        if (key.size != &ShapeConfig::length_m && key.size != &ShapeConfig::rounding_m) keys.push_back({key.name, c.*key.size > 0.0});
    return keys;
}

struct Preset {
    ShapeKind kind;
    std::vector<std::string> needed, optional;
    bool has_one_ratio;  // height over diameter: it may follow from the sphericity
    Body (*make)(const ShapeConfig& sizes, double rounding_m);
};

const std::vector<Preset>& presets() {
    static const std::vector<Preset> all = {
        {ShapeKind::cylinder,
         {"diameter_m", "height_m"},
         {},
         true,
         [](const ShapeConfig& c, double r) { return make_ring({.diameter_m = c.diameter_m, .height_m = c.height_m, .rounding_m = r}); }},
        {ShapeKind::prism,
         {"sides", "diameter_m", "height_m"},
         {},
         true,
         [](const ShapeConfig& c, double r) { return make_polyhedron(prism_size(c.sides, c.diameter_m, c.height_m, r)); }},
        {ShapeKind::ring,
         {"diameter_m", "inner_diameter_m", "height_m"},
         {},
         false,
         [](const ShapeConfig& c, double r) {
             return make_ring({c.diameter_m, c.inner_diameter_m, c.height_m, r});
         }},
        {ShapeKind::lobed,
         {"diameter_m", "lobe_diameter_m", "height_m"},
         {"lobes"},
         false,
         [](const ShapeConfig& c, double r) {
             return make_lobed({c.lobes > 0 ? c.lobes : 3, c.diameter_m, c.lobe_diameter_m, c.height_m, r});
         }},
        {ShapeKind::box,
         {"size_m"},
         {},
         false,
         [](const ShapeConfig& c, double r) {
             return make_polyhedron(box_size({c.size_m[0], c.size_m[1], c.size_m[2]}, r));
         }},
        {ShapeKind::cube, {"side_m"}, {}, false, [](const ShapeConfig& c, double r) {
             return make_polyhedron(box_size(Vec3::Constant(c.side_m), r));
         }}};
    return all;
}

// Null where the kind has no faces.
const Preset* preset_of(ShapeKind kind) {
    const auto found = std::find_if(presets().begin(), presets().end(), [&](const Preset& preset) { return preset.kind == kind; });
    return found == presets().end() ? nullptr : &*found;
}

Body with_rounding(const ShapeConfig& c, double rounding_m) {
    return preset_of(c.kind)->make(c, rounding_m);
}

double sphericity_of(const SurfaceSizes& sizes) {
    return std::cbrt(36.0 * std::numbers::pi * sizes.volume_m3 * sizes.volume_m3) / sizes.surface_area_m2;
}

FacedGrain of_sizes(const ShapeConfig& c) {
    const SurfaceSizes sharp = surface_measures(*with_rounding(c, 0.0));
    const double rounding = c.rounding_m > 0.0 ? c.rounding_m : default_rounding * std::cbrt(6.0 * sharp.volume_m3 / std::numbers::pi);
    const Body body = with_rounding(c, rounding);
    const double scale = std::cbrt(sharp.volume_m3 / surface_measures(*body).volume_m3);
    return {.body = body->scaled(scale), .scale = scale, .sharp_area_m2 = sharp.surface_area_m2, .sharp_sphericity = sphericity_of(sharp)};
}

// With the diameter 1, scaled to the volume.
FacedGrain of_aspect(const ShapeConfig& c, double height_over_diameter) {
    ShapeConfig unit = c;
    unit.diameter_m = 1.0;
    unit.height_m = height_over_diameter;
    unit.rounding_m = 0.0;
    const double size = std::cbrt(c.volume_m3 / surface_measures(*with_rounding(unit, 0.0)).volume_m3);
    unit.rounding_m = c.rounding_m / size;
    FacedGrain grain = of_sizes(unit);
    grain.body = grain.body->scaled(size);
    grain.sharp_area_m2 *= size * size;
    return grain;
}

// The sphericity rises to its maximum near a height of one diameter and falls on both sides: the grain higher than that is taken. A given
// rounding does not fit into every grain.
FacedGrain of_sphericity(const ShapeConfig& c) {
    const auto sphericity_at = [&](double log_aspect) {  // 0 where it does not fit
        try {
            return sphericity_of(surface_measures(*of_aspect(c, std::exp(log_aspect)).body));
        } catch (const UserError&) {
            return 0.0;
        }
    };
    constexpr int bits = 40;
    const auto roundest =
        boost::math::tools::brent_find_minima([&](double x) { return -sphericity_at(x); }, std::log(0.3), std::log(3.0), bits);
    if (-roundest.second == 0.0)
        throw UserError(fmt::format("a rounding of {:g} m does not fit into a {} of {:g} m3", c.rounding_m, name_of(c.kind), c.volume_m3),
                        {.fix = "use a smaller rounding_m"});
    double longest = std::log(50.0);
    if (sphericity_at(longest) == 0.0) {
        double low = roundest.first;
        while (longest - low > 1e-6) {
            const double middle = 0.5 * (low + longest);
            (sphericity_at(middle) > 0.0 ? low : longest) = middle;
        }
        longest = low;
    }
    const double highest = -roundest.second, lowest = sphericity_at(longest);
    if (c.sphericity > highest || c.sphericity < lowest)
        throw UserError(fmt::format("no {} has sphericity {:g}", name_of(c.kind), c.sphericity),
                        {.allowed = fmt::format("{:.4f} ({:.3g} diameters high) to {:.4f}", lowest, std::exp(longest), highest),
                         .fix = "flat ones: give diameter_m and height_m"});
    const auto excess = [&](double x) { return sphericity_at(x) - c.sphericity; };
    std::uintmax_t steps = 100;
    const auto root = boost::math::tools::toms748_solve(excess, roundest.first, longest, highest - c.sphericity, lowest - c.sphericity,
                                                        boost::math::tools::eps_tolerance<double>(bits), steps);
    // Nine digits: a packing must not change with the last bits of a root.
    return of_aspect(c, std::stod(fmt::format("{:.9g}", std::exp(root.first))));
}

void refuse_keys_of_libraries(const ShapeConfig& c) {
    for (const Key& key : {Key{"folder", !c.folder.empty()}, Key{"library_by", c.library_by != LibraryBy::number}})
        if (key.given)
            throw UserError(fmt::format("`{}` has no effect with kind = \"{}\"", key.name, name_of(c.kind)),
                            {.fix = "remove it, or choose kind = \"library\""});
}

void refuse_keys_of_meshes(const ShapeConfig& c) {
    refuse_keys_of_libraries(c);
    for (const Key& key :
         {Key{"file", !c.file.empty()}, Key{"unit_m", c.unit_m > 0.0}, Key{"faces", c.faces > 0}, Key{"deviation_m", c.deviation_m > 0.0}})
        if (key.given)
            throw UserError(fmt::format("`{}` has no effect on a {}", key.name, name_of(c.kind)),
                            {.fix = "remove it, or choose kind = \"mesh\""});
}

}  // namespace

bool has_faces(ShapeKind kind) {
    return preset_of(kind) != nullptr;
}

void refuse_keys_of_faces(const ShapeConfig& c) {
    std::vector<std::string_view> names;
    for (const Preset& preset : presets()) names.push_back(name_of(preset.kind));
    for (const Key& key : keys_of_sizes(c))
        if (key.given && std::string(key.name) != "diameter_m")
            throw UserError(fmt::format("`{}` has no effect on a {}", key.name, name_of(c.kind)),
                            {.fix = fmt::format("remove it, or choose a kind with faces: {}", fmt::join(names, ", "))});
    if (c.rounding_m > 0.0)
        throw UserError(fmt::format("`rounding_m` has no effect on a {}", name_of(c.kind)), {.fix = "remove it: capsules are round"});
    refuse_keys_of_meshes(c);
}

void refuse_sizes(const ShapeConfig& c, const std::string& allowed) {
    std::vector<Key> keys = keys_of_sizes(c);
    keys.insert(keys.end(), {{"length_m", c.length_m > 0.0},
                             {"sphericity", c.sphericity > 0.0},
                             {"volume_m3", c.volume_m3 > 0.0},
                             {"cavity", c.cavity == Cavity::open},
                             {"disconnected", c.disconnected},
                             {"capsule", !c.capsule.empty()}});
    for (const Key& key : keys)
        if (key.given)
            throw UserError(fmt::format("`{}` has no effect with kind = \"{}\"", key.name, name_of(c.kind)),
                            {.allowed = allowed, .fix = "remove it: the file has the sizes"});
}

void require_library_keys(const ShapeConfig& c) {
    refuse_sizes(c, "folder, library_by, unit_m, faces, deviation_m, rounding_m");
    if (!c.file.empty())
        throw UserError("`file` has no effect with kind = \"library\"", {.fix = "folder = \"library\", or kind = \"mesh\""});
    if (c.folder.empty()) throw UserError("kind is \"library\", but no folder is given", {.fix = "folder = \"segmented/library\""});
    if (c.unit_m == 0.0)
        throw UserError("the unit of the meshes in " + c.folder + " is not known",
                        {.allowed = "its length in metres", .fix = "unit_m = 1 for those of porepack image segment"});
}

void require_mesh_keys(const ShapeConfig& c) {
    refuse_sizes(c, "file, unit_m, faces, deviation_m, rounding_m");
    refuse_keys_of_libraries(c);
    if (c.file.empty()) throw UserError("kind is \"mesh\", but no file is given", {.fix = "file = \"stone.stl\""});
    if (c.unit_m == 0.0)
        throw UserError("the unit of " + c.file + " is not known",
                        {.allowed = "its length in metres", .fix = "unit_m = 0.001 for millimetres"});
    if (c.faces > 0 && c.deviation_m > 0.0)
        throw UserError("both faces and deviation_m are given: each decides the other", {.fix = "remove one of them"});
}

FacedGrain make_faced(const ShapeConfig& c) {
    const Preset& preset = *preset_of(c.kind);
    refuse_keys_of_meshes(c);
    const auto contains = [](const std::vector<std::string>& list, const char* name) {
        return std::find(list.begin(), list.end(), name) != list.end();
    };
    const bool by_sphericity = c.sphericity > 0.0;
    if (c.cavity == Cavity::open || c.disconnected)
        throw UserError(fmt::format("`{}` has no effect on a {}", c.disconnected ? "disconnected" : "cavity", name_of(c.kind)),
                        {.fix = "remove it"});
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
    for (const Key& key : keys_of_sizes(c)) {
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
