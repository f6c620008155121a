#include "packing/packing.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#ifdef POREPACK_WITH_ZLIB
#include <zlib.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "packing/grains.hpp"
#include "vessels/config.hpp"

namespace porepack::packing {
using namespace shapes;
using namespace vessels;
namespace {

constexpr std::size_t largest_text = 2'000'000'000;  // bytes

std::string read_maybe_compressed(const Path& path) {
    if (path.extension() != ".gz") return read_text(path, largest_text);
    require_file(path);
#ifdef POREPACK_WITH_ZLIB
    gzFile file = gzopen(path.c_str(), "rb");
    std::string text;
    std::vector<char> buffer(1 << 16);
    int count = 0;
    while (text.size() < largest_text && (count = gzread(file, buffer.data(), static_cast<unsigned>(buffer.size()))) > 0)
        text.append(buffer.data(), static_cast<std::size_t>(count));
    const bool good = count == 0 && gzeof(file) == 1;
    gzclose(file);
    if (text.size() >= largest_text) throw UserError(path.string() + " unpacks to more than 2 GB", {.fix = "check that this is a packing"});
    if (!good) throw UserError("cannot unpack " + path.string(), {.fix = "the file is damaged or incomplete: copy it again"});
    return text;
#else
    throw UserError("this build cannot unpack " + path.string(), {.fix = "unpack it with gunzip"});
#endif
}

// Reads members; error messages name the file and the position in it.
struct Place {
    const Json& json;
    std::string path;

    [[nodiscard]] Place at(const char* key) const {
        if (!json.is_object() || !json.contains(key)) throw UserError(fmt::format("`{}` is missing", key), {.where = path});
        return {json[key], path + "/" + key};
    }
    [[nodiscard]] Place at(std::size_t i) const { return {json[i], fmt::format("{}[{}]", path, i)}; }
    [[nodiscard]] const Json& list(std::size_t size = 0) const {
        if (!json.is_array() || (size > 0 && json.size() != size))
            throw UserError("is not a list" + (size > 0 ? fmt::format(" of {} numbers", size) : std::string()), {.where = path});
        return json;
    }
    [[nodiscard]] double number() const {
        if (!json.is_number() || !std::isfinite(json.get<double>())) throw UserError("is not a finite number", {.where = path});
        return json.get<double>();
    }
    [[nodiscard]] std::string text() const {
        if (!json.is_string()) throw UserError("is not text", {.where = path});
        return json.get<std::string>();
    }
    void only(const std::vector<std::string>& known) const {
        for (const auto& [key, value] : json.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                throw UserError(fmt::format("unknown key `{}`", key),
                                {.where = path, .allowed = fmt::format("{}", fmt::join(known, ", "))});
    }
    [[nodiscard]] Vec3 vector() const {
        (void)list(3);
        return {at(std::size_t{0}).number(), at(std::size_t{1}).number(), at(std::size_t{2}).number()};
    }
};

bool boolean_or_false(const Place& place, const char* key) {
    if (!place.json.contains(key)) return false;
    if (!place.json[key].is_boolean()) throw UserError(fmt::format("`{}` must be true or false", key), {.where = place.path});
    return place.json[key].get<bool>();
}

Shape shape_from(const Place& place) {
    Shape shape;
    shape.id = place.at("id").text();
    if (place.json.contains("body")) {
        place.only({"id", "body", "note"});
        shape.body = body_from_json(place.at("body").json, place.at("body").path);
        validate(shape);
        return shape;
    }
    place.only({"id", "cavity", "capsules", "disconnected", "note"});
    shape.may_be_disconnected = boolean_or_false(place, "disconnected");
    const std::string cavity = place.json.contains("cavity") ? place.at("cavity").text() : "filled";
    if (cavity != "filled" && cavity != "open")
        throw UserError("unknown cavity convention: " + cavity, {.where = place.path, .allowed = "filled, open"});
    shape.cavity = cavity == "filled" ? Cavity::filled : Cavity::open;
    const Place capsules = place.at("capsules");
    for (std::size_t i = 0; i < capsules.list().size(); ++i) {
        const Place entry = capsules.at(i);
        entry.only({"a_m", "b_m", "radius_m"});
        shape.capsules.push_back({entry.at("a_m").vector(), entry.at("b_m").vector(), entry.at("radius_m").number()});
    }
    validate(shape);
    if (shape.cavity == Cavity::filled) find_cavities(shape);
    return shape;
}

Body body_from(const Place& place, const std::vector<Shape>& shapes) {
    Body body;
    const std::string id = place.at("shape").text();
    place.only({"shape", "position_m", "orientation", "note"});
    body.shape = shapes.size();
    for (std::size_t i = 0; i < shapes.size(); ++i)
        if (shapes[i].id == id) body.shape = i;
    if (body.shape == shapes.size()) throw UserError("no such shape in this file: " + id, {.where = place.path});
    body.position_m = place.at("position_m").vector();
    const Place q = place.at("orientation");
    (void)q.list(4);
    body.orientation = Quaternion(q.at(std::size_t{0}).number(), q.at(std::size_t{1}).number(), q.at(std::size_t{2}).number(),
                                  q.at(std::size_t{3}).number());
    if (std::abs(body.orientation.norm() - 1.0) > 1e-6)
        throw UserError(fmt::format("the orientation is not a unit quaternion: its norm is {:g}", body.orientation.norm()),
                        {.where = place.path, .allowed = "[w, x, y, z] of norm 1"});
    body.orientation.normalize();
    return body;
}

void require_plausible(const Packing& packing, const Path& path) {
    const Vec3 size = packing.container.high() - packing.container.low();
    for (const auto& shape : packing.shapes)
        if (maximum_feret_diameter(shape) > 1.001 * size.norm())
            throw UserError(fmt::format("a grain is larger than the container: `{}` measures {:g} m, the container's diagonal is {:g} m",
                                        shape.id, maximum_feret_diameter(shape), size.norm()),
                            {.where = path.string(), .fix = "check the units: all lengths are metres"});
    std::map<std::array<double, 3>, std::size_t> seen;
    for (std::size_t i = 0; i < packing.bodies.size(); ++i) {
        const Vec3& at = packing.bodies[i].position_m;
        const auto [twin, fresh] = seen.try_emplace({at.x(), at.y(), at.z()}, i);
        if (!fresh && packing.bodies[twin->second].orientation.coeffs() == packing.bodies[i].orientation.coeffs() &&
            packing.bodies[twin->second].shape == packing.bodies[i].shape)
            throw UserError(fmt::format("bodies {} and {} are the same grain at the same place", twin->second, i),
                            {.where = path.string()});
        // Every grain must reach into the container; it may protrude because of soft contacts and open tops.
        bool reaches_in = false;
        const auto add_ball = [&](const Vec3& x, double radius) {
            const bool in_height = packing.container.periodic()[2] || (x.z() > -radius && x.z() < packing.container.height() + radius);
            reaches_in = reaches_in || (in_height && packing.container.wall_distance(x) > -radius);
        };
        const PlacedShape grain = placed(packing, packing.bodies[i]);
        for (const Ball& ball : balls_of(grain)) add_ball(ball.centre, ball.radius);
        // All corners of a high grain may lie beyond two cut ends.
        if (!reaches_in && grain.shape.body != nullptr)
            grain.shape.body->for_surface([&](const Vec3& x, const Vec3&, double) { add_ball(grain.to_world(x), 0.0); });
        if (!reaches_in)
            throw UserError(fmt::format("body {} lies outside the container: at ({:g}, {:g}, {:g}) m", i, at.x(), at.y(), at.z()),
                            {.where = path.string(), .fix = "check the units (metres) and the frame: " + container_frames()});
    }
}

// A shape without a body has no say in voxel sizes and time steps.
void leave_out_unused_shapes(Packing& packing, const Path& path) {
    std::vector<std::size_t> place(packing.shapes.size(), 0);
    for (const Body& body : packing.bodies) place[body.shape] = 1;
    std::vector<Shape> used;
    for (std::size_t s = 0; s < packing.shapes.size(); ++s) {
        if (place[s] == 0)
            log_warning(fmt::format("{}: no body has the shape \"{}\"; it is left out", path.string(), packing.shapes[s].id));
        else
            used.push_back(packing.shapes[s]);
        place[s] = used.size() - 1;
    }
    if (used.empty()) return;  // an empty container keeps them
    for (Body& body : packing.bodies) body.shape = place[body.shape];
    packing.shapes = std::move(used);
}

// Bodies of a periodic box into the box.
void bring_in(Packing& packing, const Path& path) {
    constexpr double max_boxes = 1e6;  // beyond them, a double does not know the place in the box
    for (std::size_t i = 0; i < packing.bodies.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            if (!packing.container.periodic()[static_cast<std::size_t>(axis)]) continue;
            double& x = packing.bodies[i].position_m[axis];
            const double boxes = std::floor(x / packing.container.size()[axis]);
            if (std::abs(boxes) > max_boxes)
                throw UserError(fmt::format("body {} lies {:g} boxes away from the periodic box", i, boxes),
                                {.where = path.string(), .allowed = fmt::format("at most {:g}", max_boxes)});
            if (std::abs(boxes) > 1.0) x -= boxes * packing.container.size()[axis];
        }
}

Json vector_json(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

}  // namespace

Packing read_packing(const Path& path) {
    const std::string text = read_maybe_compressed(path);
    if (text.empty()) throw UserError("the file is empty: " + path.string(), {.fix = "write it again, for instance with porepack pack"});
    const Json json = parse_json(text, path.string());
    const Place root{json, path.string()};
    if (root.at("format").text() != "porepack-packing")
        throw UserError("not a packing file: " + path.string(), {.allowed = "\"format\": \"porepack-packing\""});
    if (root.at("version").number() != 1.0)
        throw UserError(fmt::format("packing file of version {:g}", root.at("version").number()),
                        {.where = path.string(), .allowed = "version 1"});
    Packing packing;
    packing.container = container_from_json(root.at("container").json, path.string() + "/container");
    root.only({"format", "version", "container", "shapes", "bodies", "overlap_allowed", "note"});
    packing.overlap_allowed = boolean_or_false(root, "overlap_allowed");
    const Place shapes = root.at("shapes");
    for (std::size_t i = 0; i < shapes.list().size(); ++i) {
        packing.shapes.push_back(shape_from(shapes.at(i)));
        for (std::size_t j = 0; j < i; ++j)
            if (packing.shapes[j].id == packing.shapes[i].id)
                throw UserError("two shapes have the same id: " + packing.shapes[i].id, {.where = shapes.at(i).path});
    }
    const Place bodies = root.at("bodies");
    for (std::size_t i = 0; i < bodies.list().size(); ++i) packing.bodies.push_back(body_from(bodies.at(i), packing.shapes));
    leave_out_unused_shapes(packing, path);
    bring_in(packing, path);
    require_plausible(packing, path);
    if (!packing.overlap_allowed) require_no_overlap(packing, path.string());
    return packing;
}

void write_packing(const Path& path, const Packing& packing) {
    Json json = {{"format", "porepack-packing"},
                 {"version", 1},
                 {"container", to_json(packing.container)},
                 {"shapes", Json::array()},
                 {"bodies", Json::array()}};
    if (packing.overlap_allowed) json["overlap_allowed"] = true;
    for (const auto& shape : packing.shapes) {
        if (shape.body != nullptr) {
            json["shapes"].push_back({{"id", shape.id}, {"body", shape.body->to_json()}});
            continue;
        }
        Json entry = {{"id", shape.id}, {"cavity", shape.cavity == Cavity::filled ? "filled" : "open"}, {"capsules", Json::array()}};
        if (shape.may_be_disconnected) entry["disconnected"] = true;
        for (const auto& capsule : shape.capsules)
            entry["capsules"].push_back({{"a_m", vector_json(capsule.a)}, {"b_m", vector_json(capsule.b)}, {"radius_m", capsule.radius}});
        json["shapes"].push_back(entry);
    }
    for (const auto& body : packing.bodies) {
        const auto& q = body.orientation;
        json["bodies"].push_back({{"shape", packing.shapes[body.shape].id},
                                  {"position_m", vector_json(body.position_m)},
                                  {"orientation", {q.w(), q.x(), q.y(), q.z()}}});
    }
    // One body per line: readable and compact.
    std::string text = json.dump();
    for (const char* start : {"{\"shape\":", "\"bodies\":", "\"shapes\":", "\"container\":"})
        for (std::size_t at = 0; (at = text.find(start, at)) != std::string::npos; at += 2) text.insert(at, "\n");
    write_text(path, text + "\n");
}

double finest_diameter(const Packing& packing) {
    double minimum = 1e300;
    for (const auto& shape : packing.shapes) minimum = std::min(minimum, smallest_diameter(shape));
    return minimum;
}

PlacedShape placed(const Packing& packing, const Body& body) {
    return {packing.shapes[body.shape], body.position_m, body.orientation};
}

std::vector<Capsule> world_capsules(const Packing& packing, const Body& body) {
    std::vector<Capsule> capsules;
    for (const auto& capsule : packing.shapes[body.shape].capsules) capsules.push_back(moved(capsule, body.position_m, body.orientation));
    return capsules;
}

Overlaps find_overlaps(const Packing& packing) {
    const Grains grains(packing);
    Overlaps overlaps;
    double sum = 0.0;
    const auto& all = grains.images();
    // By the lowest point: only images that begin below the top of this one can overlap it.
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return all[a].bounds.low.z() < all[b].bounds.low.z(); });
    for (std::size_t n = 0; n < order.size(); ++n) {
        const std::size_t i = order[n];
        if (const PlacedShape grain = grains.placed(all[i]); grain.shape.body != nullptr && all[i].image == 0) {
            double outside = reach_beyond(grain, [&](const Vec3& x) { return packing.container.wall_distance(x); });
            if (!packing.container.periodic()[2] && !packing.container.cut_ends()) outside = std::max(outside, -all[i].bounds.low.z());
            if (outside > overlaps.largest_with_wall_m) {
                overlaps.largest_with_wall_m = outside;
                overlaps.grain_at_wall = all[i].body;
            }
        }
        for (const auto& capsule : all[i].capsules) {
            if (all[i].image != 0) continue;
            double outside = capsule.radius - packing.container.vessel().least_distance(capsule.a, capsule.b);
            if (!packing.container.periodic()[2] && !packing.container.cut_ends())
                outside = std::max(outside, capsule.radius - std::min(capsule.a.z(), capsule.b.z()));
            if (outside <= overlaps.largest_with_wall_m) continue;
            overlaps.largest_with_wall_m = outside;
            overlaps.grain_at_wall = all[i].body;
        }
        for (std::size_t m = n + 1; m < order.size() && all[order[m]].bounds.low.z() <= all[i].bounds.high.z(); ++m) {
            const std::size_t j = order[m];
            if (all[i].image != 0 && all[j].image != 0) continue;  // the same pair occurs once with an original
            if (((all[i].bounds.high - all[j].bounds.low).array() < 0.0).any() ||
                ((all[j].bounds.high - all[i].bounds.low).array() < 0.0).any())
                continue;
            double minimum = 1e300;
            if (grains.shape_of(all[i]).body != nullptr || grains.shape_of(all[j]).body != nullptr)
                minimum = nearest(grains.placed(all[i]), grains.placed(all[j]), 0.0).gap_m;
            for (const auto& first : all[i].capsules)
                for (const auto& second : all[j].capsules) minimum = std::min(minimum, gap(first, second));
            if (minimum >= 0.0) continue;
            ++overlaps.contacts;
            sum -= minimum;
            if (-minimum <= overlaps.largest_between_grains_m) continue;
            overlaps.largest_between_grains_m = -minimum;
            overlaps.grains = {std::min(all[i].body, all[j].body), std::max(all[i].body, all[j].body)};
        }
    }
    if (overlaps.contacts > 0) overlaps.mean_between_grains_m = sum / static_cast<double>(overlaps.contacts);
    return overlaps;
}

void require_no_overlap(const Packing& packing, const std::string& where) {
    const Overlaps overlaps = find_overlaps(packing);
    const double d = finest_diameter(packing), largest = largest_overlap_of_diameter * d;
    const std::string allowed =
        fmt::format("up to {:g} m, {:g} of the thickness of the thinnest grain", largest, largest_overlap_of_diameter);
    const char* fix = "check units and poses; for grains that overlap on purpose, write \"overlap_allowed\": true into the file";
    if (overlaps.largest_between_grains_m > largest)
        throw UserError(
            fmt::format("bodies {} and {} overlap by {:g} m", overlaps.grains[0], overlaps.grains[1], overlaps.largest_between_grains_m),
            {.where = where, .allowed = allowed, .fix = fix});
    if (overlaps.largest_with_wall_m > largest)
        throw UserError(
            fmt::format("body {} reaches {:g} m into the wall or the floor", overlaps.grain_at_wall, overlaps.largest_with_wall_m),
            {.where = where, .allowed = allowed, .fix = fix});
}

GrainMeans grain_means(const Packing& packing) {
    std::vector<ShapeMeasures> measures;
    for (const Shape& shape : packing.shapes) measures.push_back(measure(shape, 1e-6));
    double volume = 0.0, area = 0.0;
    for (const Body& body : packing.bodies) {
        volume += measures[body.shape].volume_m3;
        area += measures[body.shape].surface_area_m2;
    }
    return {std::cbrt(6.0 * volume / static_cast<double>(packing.bodies.size()) / std::numbers::pi), 6.0 * volume / area};
}

}  // namespace porepack::packing
