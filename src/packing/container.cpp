#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/json.hpp"
#include "packing/packing.hpp"
#include "record/config.hpp"

namespace porepack::packing {
using namespace core;
using namespace shapes;

double Container::inner_area_m2() const {
    if (kind == Kind::cylinder) return std::numbers::pi * diameter_m * diameter_m / 4.0;
    return size_m.x() * size_m.y();
}

Vec3 Container::low() const {
    if (kind == Kind::cylinder) return {-diameter_m / 2.0, -diameter_m / 2.0, 0.0};
    return Vec3::Zero();
}

Vec3 Container::high() const {
    if (kind == Kind::cylinder) return {diameter_m / 2.0, diameter_m / 2.0, height_m};
    return size_m;
}

bool Container::contains_column(double x, double y) const {
    if (kind == Kind::cylinder) return x * x + y * y <= diameter_m * diameter_m / 4.0;
    return x >= 0.0 && x <= size_m.x() && y >= 0.0 && y <= size_m.y();
}

double Container::wall_distance(const Vec3& point) const {
    if (kind == Kind::cylinder) return diameter_m / 2.0 - std::hypot(point.x(), point.y());
    double minimum = 1e300;
    for (int axis = 0; axis < 2; ++axis)
        if (!periodic[static_cast<std::size_t>(axis)]) minimum = std::min({minimum, point[axis], size_m[axis] - point[axis]});
    return minimum;
}

std::optional<double> Container::wall_hit(const Vec3& from, const Vec3& step) const {
    double first = 2.0;
    if (kind == Kind::cylinder) {
        const Eigen::Vector2d p = from.head<2>(), s = step.head<2>();
        const double a = s.squaredNorm(), half_b = p.dot(s), c = p.squaredNorm() - diameter_m * diameter_m / 4.0;
        const double root = half_b * half_b - a * c;  // |p + t s| = D/2 is a t^2 + 2 half_b t + c = 0; its larger t leaves the cylinder
        if (a > 0.0 && root >= 0.0) first = std::max(0.0, (std::sqrt(root) - half_b) / a);
    } else {
        for (int axis = 0; axis < 2; ++axis) {
            if (periodic[static_cast<std::size_t>(axis)] || step[axis] == 0.0) continue;
            const double wall = step[axis] > 0.0 ? size_m[axis] : 0.0;
            first = std::min(first, std::max(0.0, (wall - from[axis]) / step[axis]));
        }
    }
    return first <= 1.0 ? std::optional(first) : std::nullopt;
}

namespace {

constexpr const char* forms = "cylinder:D,H or box:X,Y,Z or box:X,Y,Z:periodic (metres, for instance cylinder:0.1,0.7)";

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const std::string& whole) {
    std::vector<double> values;
    std::size_t at = 0;
    while (at <= text.size()) {
        const std::size_t comma = std::min(text.find(',', at), text.size());
        try {
            std::size_t used = 0;
            const std::string part = text.substr(at, comma - at);
            values.push_back(std::stod(part, &used));
            if (used != part.size()) throw std::invalid_argument(part);
        } catch (const std::exception&) {
            throw UserError("not a container: " + whole, {.allowed = forms});
        }
        at = comma + 1;
    }
    if (values.size() != count) throw UserError("not a container: " + whole, {.allowed = forms});
    for (const double value : values)
        if (!record::length_range().holds(value))
            throw UserError("a container's sizes must be from 1e-12 to 1e6 m: " + whole, {.allowed = forms});
    return values;
}

}  // namespace

Container parse_container(const std::string& text) {
    Container container;
    if (text.starts_with("cylinder:")) {
        const auto sizes = parse_numbers(text.substr(9), 2, text);
        container.diameter_m = sizes[0];
        container.height_m = sizes[1];
        return container;
    }
    if (!text.starts_with("box:")) throw UserError("not a container: " + text, {.allowed = forms});
    std::string sizes_text = text.substr(4);
    container.kind = Container::Kind::box;
    if (const auto colon = sizes_text.find(':'); colon != std::string::npos) {
        if (sizes_text.substr(colon) != ":periodic") throw UserError("not a container: " + text, {.allowed = forms});
        sizes_text.resize(colon);
        container.periodic = {true, true, true};
    }
    const auto sizes = parse_numbers(sizes_text, 3, text);
    container.size_m = Vec3(sizes[0], sizes[1], sizes[2]);
    return container;
}

Json to_json(const Container& container) {
    Json json = container.kind == Container::Kind::cylinder
                    ? Json{{"kind", "cylinder"}, {"diameter_m", container.diameter_m}, {"height_m", container.height_m}}
                    : Json{{"kind", "box"},
                           {"size_m", {container.size_m.x(), container.size_m.y(), container.size_m.z()}},
                           {"periodic", container.periodic}};
    if (container.cut_ends) json["ends"] = "cut";
    return json;
}

Container container_from_json(const Json& json, const std::string& where) {
    const auto positive_number = [&](const Json& value, const char* key) {
        if (!value.is_number() || !record::length_range().holds(value.get<double>()))
            throw UserError(fmt::format("`{}` must be a number from 1e-12 to 1e6 (metres)", key), {.where = where});
        return value.get<double>();
    };
    const auto member = [&](const char* key) -> const Json& {
        if (!json.is_object() || !json.contains(key)) throw UserError(fmt::format("`{}` is missing", key), {.where = where});
        return json.at(key);
    };
    const auto only = [&](std::initializer_list<std::string_view> known) {
        for (const auto& [key, value] : json.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                throw UserError(fmt::format("unknown key `{}`", key),
                                {.where = where, .allowed = fmt::format("{}", fmt::join(known, ", "))});
    };
    Container container;
    const std::string kind = member("kind").is_string() ? member("kind").get<std::string>() : "";
    if (kind == "cylinder") {
        only({"kind", "diameter_m", "height_m", "ends"});
        container.diameter_m = positive_number(member("diameter_m"), "diameter_m");
        container.height_m = positive_number(member("height_m"), "height_m");
    } else if (kind == "box") {
        only({"kind", "size_m", "periodic", "ends"});
        container.kind = Container::Kind::box;
        const Json& size = member("size_m");
        if (!size.is_array() || size.size() != 3) throw UserError("`size_m` must be a list of 3 numbers", {.where = where});
        for (int i = 0; i < 3; ++i) container.size_m[i] = positive_number(size[static_cast<std::size_t>(i)], "size_m");
        if (json.contains("periodic")) {
            const Json& periodic = json["periodic"];
            if (!periodic.is_array() || periodic.size() != 3)
                throw UserError("`periodic` must be a list of 3 values true or false", {.where = where});
            for (std::size_t i = 0; i < 3; ++i) {
                if (!periodic[i].is_boolean()) throw UserError("`periodic` must be a list of 3 values true or false", {.where = where});
                container.periodic[i] = periodic[i].get<bool>();
            }
        }
    } else {
        throw UserError("unknown kind of container: " + kind, {.where = where, .allowed = "cylinder, box"});
    }
    if (json.contains("ends")) {
        if (json["ends"] != "cut") throw UserError("`ends` must be \"cut\", or be left out", {.where = where});
        if (container.periodic[2]) throw UserError("a container that is periodic along z has no cut ends", {.where = where});
        container.cut_ends = true;
    }
    return container;
}

}  // namespace porepack::packing
