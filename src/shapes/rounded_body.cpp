// Grains with faces as they stand in packing.json.
#include "shapes/rounded_body.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::shapes {
namespace {

// An object whose keys are all read, and no others.
class Reader {
public:
    Reader(const Json& json, std::string where, const std::vector<std::string>& keys) : json_(json), where_(std::move(where)) {
        for (const auto& [key, value] : json.items())
            if (key != "kind" && std::find(keys.begin(), keys.end(), key) == keys.end())
                throw UserError(fmt::format("unknown key `{}`", key),
                                {.where = where_, .allowed = fmt::format("{}", fmt::join(keys, ", "))});
        for (const std::string& key : keys)
            if (!json.contains(key)) throw UserError(fmt::format("`{}` is missing", key), {.where = where_});
    }
    [[nodiscard]] double number(const char* key) const { return finite(json_.at(key), key); }
    [[nodiscard]] long integer(const char* key) const {
        if (!json_.at(key).is_number_integer()) throw UserError(fmt::format("`{}` is not a whole number", key), {.where = where_});
        return json_.at(key).get<long>();
    }
    [[nodiscard]] std::vector<Vec3> points(const char* key) const {
        std::vector<Vec3> list;
        for (const Json& entry : list_of(json_.at(key), key)) {
            if (list_of(entry, key).size() != 3)
                throw UserError(fmt::format("`{}` must hold points of three numbers", key), {.where = where_});
            list.emplace_back(finite(entry[0], key), finite(entry[1], key), finite(entry[2], key));
        }
        return list;
    }
    [[nodiscard]] std::vector<std::vector<int>> index_lists(const char* key) const {
        std::vector<std::vector<int>> lists;
        for (const Json& entry : list_of(json_.at(key), key)) {
            for (const Json& index : list_of(entry, key))
                if (!index.is_number_integer())
                    throw UserError(fmt::format("`{}` must hold lists of whole numbers", key), {.where = where_});
            lists.push_back(entry.get<std::vector<int>>());
        }
        return lists;
    }

private:
    [[nodiscard]] double finite(const Json& value, const char* key) const {
        if (!value.is_number() || !std::isfinite(value.get<double>()))
            throw UserError(fmt::format("`{}` is not a finite number", key), {.where = where_});
        return value.get<double>();
    }
    [[nodiscard]] const Json& list_of(const Json& value, const char* key) const {
        if (!value.is_array()) throw UserError(fmt::format("`{}` is not a list", key), {.where = where_});
        return value;
    }

    const Json& json_;
    std::string where_;
};

}  // namespace

void RoundedBody::distances(const PointRow& points, DistanceRow& found) const {
    Vec3 outward;
    for (int i = 0; i < points.count; ++i) {
        const double away = distance(points.at(i), &outward);
        found.set(i, away, outward);
    }
    found.clear_from(points.count);
}

SurfaceSizes surface_measures(const RoundedBody& body) {
    SurfaceSizes sizes;
    Vec3 about;
    body.for_surface([&](const Vec3& x, const Vec3& n, double area) {
        if (sizes.surface_area_m2 == 0.0) about = x;  // far from the origin, digits would be lost
        sizes.surface_area_m2 += area;
        sizes.volume_m3 += area * (x - about).dot(n) / 3.0;
    });
    return sizes;
}

std::shared_ptr<const RoundedBody> body_from_json(const Json& json, const std::string& where) {
    if (!json.is_object() || !json.contains("kind") || !json.at("kind").is_string())
        throw UserError("`kind` is missing", {.where = where, .allowed = "cylinder, ring, lobed, polyhedron"});
    const auto kind = json.at("kind").get<std::string>();
    // What is wrong with the sizes themselves is said by the functions that make the bodies.
    const auto made = [&](const auto& make, const auto& size) {
        try {
            return make(size);
        } catch (const UserError& fault) {
            throw UserError(fault.what(), {.where = where});
        }
    };
    if (kind == "cylinder") {
        const Reader keys(json, where, {"diameter_m", "height_m", "rounding_m"});
        return made(make_ring, RingSize{.diameter_m = keys.number("diameter_m"),
                                        .height_m = keys.number("height_m"),
                                        .rounding_m = keys.number("rounding_m")});
    }
    if (kind == "ring") {
        const Reader keys(json, where, {"diameter_m", "inner_diameter_m", "height_m", "rounding_m"});
        const RingSize size{keys.number("diameter_m"), keys.number("inner_diameter_m"), keys.number("height_m"), keys.number("rounding_m")};
        if (!(size.inner_diameter_m > 0.0))
            throw UserError("a ring needs a hole", {.where = where, .fix = "kind = \"cylinder\", or an inner_diameter_m above 0"});
        return made(make_ring, size);
    }
    if (kind == "lobed") {
        const Reader keys(json, where, {"lobes", "diameter_m", "lobe_diameter_m", "height_m", "rounding_m"});
        return made(make_lobed, LobedSize{keys.integer("lobes"), keys.number("diameter_m"), keys.number("lobe_diameter_m"),
                                          keys.number("height_m"), keys.number("rounding_m")});
    }
    if (kind == "polyhedron") {
        const Reader keys(json, where, {"corners_m", "faces", "rounding_m"});
        return made(make_polyhedron, PolyhedronSize{keys.points("corners_m"), keys.index_lists("faces"), keys.number("rounding_m")});
    }
    throw UserError("unknown kind of body: " + kind, {.where = where, .allowed = "cylinder, ring, lobed, polyhedron"});
}

}  // namespace porepack::shapes
