#include "design/bed.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <vector>

#include "design/uses.hpp"
#include "pouring/pour.hpp"
#include "record/toml_file.hpp"

namespace porepack::design {
namespace fs = std::filesystem;
namespace {

Flags shape_flags(const SizedCandidate& grain) {
    const ShapeConfig shape = scaled(grain.candidate.shape, grain.size_m);
    Flags flags = {{"kind", fmt::format("\"{}\"", name_of(shape.kind))},
                   {"sphericity", ""},
                   {"volume_m3", ""},
                   {"sides", shape.sides > 0 ? std::to_string(shape.sides) : ""},
                   {"lobes", shape.lobes > 0 ? std::to_string(shape.lobes) : ""},
                   {"size_m", shape.size_m.empty() ? "" : fmt::format("[{:.12g}]", fmt::join(shape.size_m, ", "))},
                   {"capsule", ""}};
    for (const SizeKey& key : size_keys) flags[key.name] = shape.*key.size > 0.0 ? fmt::format("{:.12g}", shape.*key.size) : "";
    if (shape.kind == ShapeKind::star) flags["arms"] = std::to_string(shape.arms);
    if (shape.kind != ShapeKind::capsules) return flags;
    std::string list;
    const auto point = [](const Vec3& p) { return fmt::format("[{:.12g}, {:.12g}, {:.12g}]", p[0], p[1], p[2]); };
    for (const Capsule& capsule : shape.capsule)
        list += fmt::format("{}{{ a_m = {}, b_m = {}, radius_m = {:.12g} }}", list.empty() ? "" : ", ", point(capsule.a), point(capsule.b),
                            capsule.radius);
    flags["capsule"] = "[" + list + "]";
    return flags;
}

}  // namespace

DesignBed::DesignBed(const DesignGoal& goal, const study::Study& study)
    : goal_(goal), base_(study.folder / study.config.base), settings_(read_case(base_).settings) {
    size_m_ = std::cbrt(6.0 * mean_volume_m3(make_shapes(settings_.shape)) / std::numbers::pi);
}

double DesignBed::shrink(double size_m) const {
    const double wall = wall_ratio(size_m, goal_.container);
    return wall > 0.0 && wall < 1.0 / widest_bed ? widest_bed * wall : 1.0;
}

// The whole container keeps the drop height of the low beds, as far as it is high enough: grains that fall less pack looser.
bool DesignBed::too_high(double drop_height_m, const SizedCandidate& grain, bool full) const {
    return full && drop_height_m > goal_.container.height() - grain.candidate.form.feret * grain.size_m;
}

double DesignBed::fill_height() const {
    return settings_.packing.fill_height_m > 0.0 ? settings_.packing.fill_height_m : 0.5 * make_container(settings_.container).height();
}

Flags DesignBed::container_flags(double shrunk, double height_m) const {
    const Vec3 size = goal_.container.size();
    Json json = to_json(goal_.container.resized({size.x() * shrunk, size.y() * shrunk, height_m}));
    if (json.contains("periodic")) json["periodic"][2] = false;  // grains are poured along z
    Flags flags;
    for (const record::KeyRow& row : record::key_rows([](record::ConfigVisitor& v) {
             vessels::ContainerConfig none;
             describe(v, none);
         })) {
        std::string text;  // empty: the key is removed
        if (json.contains(row.key))
            for (const Json& value : json[row.key].is_array() ? json[row.key] : Json::array({json[row.key]}))
                text += (text.empty() ? "" : ", ") + (value.is_number() ? fmt::format("{:.12g}", value.get<double>()) : value.dump());
        flags[row.key] = json.contains(row.key) && json[row.key].is_array() ? "[" + text + "]" : text;
    }
    return flags;
}

std::map<std::string, Flags> DesignBed::keys(const SizedCandidate& grain, bool full, long packings) const {
    const double scale = grain.size_m / size_m_, shrunk = full ? 1.0 : shrink(grain.size_m);
    const PackingConfig& p = settings_.packing;
    const auto text = [](double value) { return fmt::format("{:.12g}", value); };
    std::map<std::string, Flags> set = {{"shape", shape_flags(grain)}, {"packing", {}}, {"packings", {}}, {"geometry", {}}};
    // Of the cross-section, in units of the grain's, over that of the base case.
    const double area =
        goal_.container.inner_area_m2() * shrunk * shrunk / (make_container(settings_.container).inner_area_m2() * scale * scale);
    set["container"] = container_flags(shrunk, full ? goal_.container.height() : make_container(settings_.container).height() * scale);
    set["packing"] = {
        {"seed", std::to_string(goal_.seed)},
        {"grains", full || p.grains == 0 ? "" : std::to_string(std::lround(static_cast<double>(p.grains) * area))},
        {"fill_height_m", full || p.grains > 0 ? "" : text(fill_height() * scale)},
        {"drop_height_m", p.drop_height_m == 0.0 || too_high(p.drop_height_m * scale, grain, full) ? "" : text(p.drop_height_m * scale)},
        {"batch_grains", std::to_string(std::max(1L, std::lround(static_cast<double>(p.batch_grains) * area)))},
        {"batch_interval_s", text(p.batch_interval_s * std::sqrt(scale))},
        {"horizontal_speed_m_per_s", text(p.horizontal_speed_m_per_s * std::sqrt(scale))},
        {"normal_stiffness_N_per_m", text(p.normal_stiffness_N_per_m * scale * scale)},
        {"tangential_stiffness_N_per_m", text(p.tangential_stiffness_N_per_m * scale * scale)},
        {"settle_time_s", text(p.settle_time_s * std::max(1.0, std::sqrt(scale)))}};
    set["packings"]["seeds"] = std::to_string(packings);
    const std::vector<double>& section = settings_.geometry.section_m;
    set["geometry"]["section_m"] =
        full || section.empty() ? "" : fmt::format("[{}, {}]", text(section[0] * scale), text(section[1] * scale));
    if (settings_.geometry.voxel_size_m > 0.0) set["geometry"]["voxel_size_m"] = text(settings_.geometry.voxel_size_m * scale);
    return set;
}

std::string DesignBed::case_text(const SizedCandidate& grain, bool full, long packings) const {
    return fmt::format("# Written by `porepack design`: {}.\n\n", full ? "the answer in its whole container" : "a proposal") +
           TomlFile(fs::is_directory(base_) ? base_ / "case.toml" : base_).with(keys(grain, full, packings)).text();
}

Case DesignBed::planned(const SizedCandidate& grain, long packings) const {
    return read_changed_case(base_, keys(grain, false, packings));
}

}  // namespace porepack::design
