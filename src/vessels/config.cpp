#include "vessels/config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"
#include "vessels/annulus.hpp"
#include "vessels/box.hpp"
#include "vessels/cone.hpp"
#include "vessels/cylinder.hpp"
#include "vessels/mesh.hpp"

namespace porepack::vessels {
namespace {

// All that the program knows about a kind of vessel besides its class. A new kind is one more function, and its keys in ContainerConfig.
struct VesselKind {
    std::string name;
    std::vector<std::string> needed, optional;  // keys of ContainerConfig
    std::string missing;                        // what to say where a needed key is not given
    std::string form;                           // on the command line: name:numbers; empty: not there
    std::string frame;                          // where it lies, for help and messages; empty: said with another kind
    std::string text;                           // for the report, with the keys in braces
    std::size_t numbers;                        // that the command line gives
    bool may_be_periodic;
    void (*fill)(ContainerConfig& config, const std::vector<double>& numbers);
    std::shared_ptr<const Vessel> (*make)(const ContainerConfig& config);
};

VesselKind cylinder_kind() {
    return {.name = "cylinder",
            .needed = {"diameter_m", "height_m"},
            .optional = {},
            .missing = "a cylinder needs diameter_m and height_m",
            .form = "cylinder:D,H",
            .frame = "a cylinder, an annulus or a cone has its axis at x = y = 0",
            .text = "a cylinder {diameter_m} wide and {height_m} high",
            .numbers = 2,
            .may_be_periodic = false,
            .fill =
                [](ContainerConfig& config, const std::vector<double>& numbers) {
                    config.diameter_m = numbers[0];
                    config.height_m = numbers[1];
                },
            .make = [](const ContainerConfig& c) -> std::shared_ptr<const Vessel> {
                return std::make_shared<const Cylinder>(c.diameter_m, c.height_m);
            }};
}

VesselKind annulus_kind() {
    return {.name = "annulus",
            .needed = {"inner_diameter_m", "diameter_m", "height_m"},
            .optional = {},
            .missing = "an annulus needs inner_diameter_m, diameter_m and height_m",
            .form = "annulus:DI,D,H",
            .frame = {},
            .text = "an annulus from {inner_diameter_m} to {diameter_m}, {height_m} high",
            .numbers = 3,
            .may_be_periodic = false,
            .fill =
                [](ContainerConfig& config, const std::vector<double>& numbers) {
                    config.inner_diameter_m = numbers[0];
                    config.diameter_m = numbers[1];
                    config.height_m = numbers[2];
                },
            .make = [](const ContainerConfig& c) -> std::shared_ptr<const Vessel> {
                return std::make_shared<const Annulus>(c.inner_diameter_m, c.diameter_m, c.height_m);
            }};
}

VesselKind cone_kind() {
    return {.name = "cone",
            .needed = {"diameter_m", "top_diameter_m", "height_m"},
            .optional = {},
            .missing = "a cone needs diameter_m (at the floor), top_diameter_m and height_m",
            .form = "cone:D,DT,H",
            .frame = {},
            .text = "a cone, {diameter_m} wide at the floor and {top_diameter_m} at the top, {height_m} high",
            .numbers = 3,
            .may_be_periodic = false,
            .fill =
                [](ContainerConfig& config, const std::vector<double>& numbers) {
                    config.diameter_m = numbers[0];
                    config.top_diameter_m = numbers[1];
                    config.height_m = numbers[2];
                },
            .make = [](const ContainerConfig& c) -> std::shared_ptr<const Vessel> {
                return std::make_shared<const Cone>(c.diameter_m, c.top_diameter_m, c.height_m);
            }};
}

VesselKind box_kind() {
    return {.name = "box",
            .needed = {"size_m"},
            .optional = {"periodic"},
            .missing = "a box needs size_m",
            .form = "box:X,Y,Z",
            .frame = "a box has its corner at the origin",
            .text = "a box of {size_m}",
            .numbers = 3,
            .may_be_periodic = true,
            .fill = [](ContainerConfig& config, const std::vector<double>& numbers) { config.size_m = numbers; },
            .make = [](const ContainerConfig& c) -> std::shared_ptr<const Vessel> {
                return std::make_shared<const Box>(Vec3(c.size_m[0], c.size_m[1], c.size_m[2]),
                                                   std::array<bool, 3>{c.periodic[0], c.periodic[1], c.periodic[2]});
            }};
}

VesselKind mesh_kind() {
    return {.name = "mesh",
            .needed = {"file", "unit_m"},
            .optional = {},
            .missing = "a vessel of kind \"mesh\" needs file and unit_m",
            .form = {},
            .frame = "a mesh lies as in its file, moved along z",
            .text = "the vessel of {file}",
            .numbers = 0,
            .may_be_periodic = false,
            .fill = nullptr,
            .make = [](const ContainerConfig& c) -> std::shared_ptr<const Vessel> {
                if (c.mesh == nullptr)
                    throw UserError("a vessel from a file cannot be used here", {.where = "[container]", .allowed = "the other kinds"});
                return std::make_shared<const MeshVessel>(*c.mesh);
            }};
}

const std::vector<VesselKind>& all_kinds() {
    static const std::vector<VesselKind> kinds = {cylinder_kind(), annulus_kind(), cone_kind(), box_kind(), mesh_kind()};
    return kinds;
}

const VesselKind* kind_named(const std::string& name) {
    const auto found = std::find_if(all_kinds().begin(), all_kinds().end(), [&](const VesselKind& kind) { return kind.name == name; });
    return found == all_kinds().end() ? nullptr : &*found;
}

const VesselKind& known_kind(const std::string& name, const std::string& where) {
    if (const VesselKind* const kind = kind_named(name)) return *kind;
    throw UserError("unknown kind of container: " + name,
                    {.where = where, .allowed = fmt::format("{}", fmt::join(kinds_of_vessels(), ", "))});
}

bool contains(const std::vector<std::string>& list, const std::string& word) {
    return std::find(list.begin(), list.end(), word) != list.end();
}

// The keys that are given.
class GivenKeys : public record::ConfigVisitor {
public:
    std::vector<std::string> keys;
    void number(const char* key, double& value, const record::Range&, const char*) override { add(key, value != 0.0); }
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t>, const record::Range&,
                 const char*) override {
        add(key, !values.empty());
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t, const char*) override {
        add(key, std::find(values.begin(), values.end(), true) != values.end());
    }
    void integer(const char*, long&, const record::Range&, const char*) override {}
    void boolean(const char*, bool&, const char*) override {}
    void text(const char* key, std::string& value, const char*) override { add(key, !value.empty()); }
    void word(const char*, std::string&, const std::vector<std::string>&, const char*) override {}
    void renamed(const char*, const char*) override {}
    void any(const char*, Json&, const char*, const char*) override {}
    void tables(const char*, const std::function<std::size_t(std::size_t)>&, const std::function<void(std::size_t, ConfigVisitor&)>&,
                const char*) override {}

private:
    void add(const char* key, bool given) {
        if (given) keys.emplace_back(key);
    }
};

// The values of an object, each checked as a case's are.
class JsonReader : public GivenKeys {
public:
    JsonReader(const Json& json, const std::string& where) : json_(json), where_(where) {}
    void number(const char* key, double& value, const record::Range&, const char*) override {
        if (json_.contains(key)) value = positive_number(json_.at(key), key);
    }
    void numbers(const char* key, std::vector<double>& values, std::pair<std::size_t, std::size_t> sizes, const record::Range&,
                 const char*) override {
        if (!json_.contains(key)) return;
        const Json& list = json_.at(key);
        if (!list.is_array() || list.size() != sizes.first) refuse(fmt::format("`{}` must be a list of {} numbers", key, sizes.first));
        for (const Json& entry : list) values.push_back(positive_number(entry, key));
    }
    void booleans(const char* key, std::vector<bool>& values, std::size_t size, const char*) override {
        if (!json_.contains(key)) return;
        const Json& list = json_.at(key);
        const bool good = list.is_array() && list.size() == size &&
                          std::all_of(list.begin(), list.end(), [](const Json& one) { return one.is_boolean(); });
        if (!good) refuse(fmt::format("`{}` must be a list of {} values true or false", key, size));
        values = list.get<std::vector<bool>>();
    }
    // Keys of these types: no kind of vessel has one yet, and none may be ignored.
    void integer(const char* key, long&, const record::Range&, const char*) override { refuse_unread(key); }
    void boolean(const char* key, bool&, const char*) override { refuse_unread(key); }
    void text(const char* key, std::string&, const char*) override { refuse_unread(key); }
    void word(const char* key, std::string&, const std::vector<std::string>&, const char*) override {
        if (std::string_view(key) != "kind") refuse_unread(key);
    }

private:
    [[noreturn]] void refuse(const std::string& what) const { throw UserError(what, {.where = where_}); }
    void refuse_unread(const char* key) const {
        if (json_.contains(key)) refuse(fmt::format("`{}` of a container is not read from files yet", key));
    }
    [[nodiscard]] double positive_number(const Json& value, const char* key) const {
        if (!value.is_number() || !record::length_range().holds(value.get<double>()))
            refuse(fmt::format("`{}` must be a number from 1e-12 to 1e6 (metres)", key));
        return value.get<double>();
    }

    const Json& json_;
    const std::string& where_;
};

std::string allowed_forms() {
    return container_forms() + " (metres, for instance cylinder:0.1,0.7)";
}

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
            throw UserError("not a container: " + whole, {.allowed = allowed_forms()});
        }
        at = comma + 1;
    }
    if (values.size() != count) throw UserError("not a container: " + whole, {.allowed = allowed_forms()});
    for (const double value : values)
        if (!record::length_range().holds(value))
            throw UserError("a container's sizes must be from 1e-12 to 1e6 m: " + whole, {.allowed = allowed_forms()});
    return values;
}

}  // namespace

const std::vector<std::string>& kinds_of_vessels() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const VesselKind& kind : all_kinds()) list.push_back(kind.name);
        return list;
    }();
    return names;
}

std::string container_forms() {
    std::vector<std::string> list;
    for (const VesselKind& kind : all_kinds())
        if (!kind.form.empty()) list.push_back(kind.form + (kind.may_be_periodic ? "[:periodic]" : ""));
    return fmt::format("{}", fmt::join(list, ", "));
}

std::string container_frames() {
    std::vector<std::string> list;
    for (const VesselKind& kind : all_kinds())
        if (!kind.frame.empty()) list.push_back(kind.frame);
    return fmt::format("{}; the floor is at z = 0", fmt::join(list, ", "));
}

std::string container_text(const Json& container, const std::function<std::string(double)>& length_text) {
    const VesselKind* const kind = kind_named(container.value("kind", ""));
    if (kind == nullptr) return "its container";
    std::string text = kind->text;
    for (const std::string& key : kind->needed) {
        const Json value = container.value(key, Json());
        if (value.is_string() && !value.get<std::string>().empty()) {
            text.replace(text.find("{" + key + "}"), key.size() + 2, value.get<std::string>());
            continue;
        }
        std::vector<std::string> sizes;
        for (const Json& one : value.is_array() ? value : Json::array({value}))
            if (one.is_number() && one.get<double>() > 0.0) sizes.push_back(length_text(one.get<double>()));
        if (sizes.empty()) return "its container";
        if (const auto at = text.find("{" + key + "}"); at != std::string::npos)
            text.replace(at, key.size() + 2, fmt::format("{}", fmt::join(sizes, " x ")));
    }
    return text;
}

Container make_container(const ContainerConfig& config) {
    ContainerConfig copy = config;
    GivenKeys given;
    describe(given, copy);
    const VesselKind& kind = known_kind(config.kind, "[container]");
    for (const std::string& key : given.keys) {
        if (contains(kind.needed, key) || contains(kind.optional, key)) continue;
        std::vector<std::string> owners;
        for (const VesselKind& other : all_kinds())
            if (contains(other.needed, key) || contains(other.optional, key)) owners.push_back(fmt::format("kind = \"{}\"", other.name));
        throw UserError(fmt::format("`{}` has no effect here: it belongs to {}", key, fmt::join(owners, " and ")),
                        {.where = "[container]", .fix = "remove it, or change kind"});
    }
    for (const std::string& key : kind.needed)
        if (!contains(given.keys, key))
            throw UserError(kind.missing, {.where = "[container]", .fix = fmt::format("give {}", fmt::join(kind.needed, ", "))});
    return Container(kind.make(config));
}

Container parse_container(const std::string& text) {
    const std::size_t colon = text.find(':');
    const VesselKind* const kind = colon == std::string::npos ? nullptr : kind_named(text.substr(0, colon));
    if (kind == nullptr || kind->form.empty()) throw UserError("not a container: " + text, {.allowed = allowed_forms()});
    ContainerConfig config{.kind = kind->name};
    std::string numbers = text.substr(colon + 1);
    if (const auto end = numbers.find(':'); end != std::string::npos) {
        if (!kind->may_be_periodic || numbers.substr(end) != ":periodic")
            throw UserError("not a container: " + text, {.allowed = allowed_forms()});
        numbers.resize(end);
        config.periodic = {true, true, true};
    }
    kind->fill(config, parse_numbers(numbers, kind->numbers, text));
    return Container(kind->make(config));
}

Container container_from_json(const Json& json, const std::string& where) {
    const auto refuse = [&](const std::string& what, const std::string& allowed = {}) {
        throw UserError(what, {.where = where, .allowed = allowed});
    };
    if (!json.is_object() || !json.contains("kind")) refuse("`kind` is missing");
    ContainerConfig config{.kind = json.at("kind").is_string() ? json.at("kind").get<std::string>() : ""};
    const VesselKind* const kind = &known_kind(config.kind, where);
    const bool mesh = kind->name == "mesh";  // its triangles are in the packing, not in a file of their own
    std::vector<std::string> known = {"kind"};
    if (mesh) known.insert(known.end(), {"points_m", "triangles"});
    if (!mesh) known.insert(known.end(), kind->needed.begin(), kind->needed.end());
    if (!mesh) known.insert(known.end(), kind->optional.begin(), kind->optional.end());
    known.emplace_back("ends");
    for (const auto& [key, value] : json.items())
        if (!contains(known, key)) refuse(fmt::format("unknown key `{}`", key), fmt::format("{}", fmt::join(known, ", ")));
    for (const std::string& key : kind->needed)
        if (!mesh && !json.contains(key)) refuse(fmt::format("`{}` is missing", key));
    JsonReader reader(json, where);
    if (mesh)
        config.mesh = std::make_shared<const TriangleMesh>(mesh_from_json(json, where));
    else
        describe(reader, config);
    if (!json.contains("ends")) return Container(kind->make(config));
    if (json["ends"] != "cut") refuse("`ends` must be \"cut\", or be left out");
    if (config.periodic[2]) refuse("a container that is periodic along z has no cut ends");
    return Container(kind->make(config), true);
}

}  // namespace porepack::vessels
