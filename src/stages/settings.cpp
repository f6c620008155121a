#include "stages/settings.hpp"

#include <set>
#include <stdexcept>

#include "core/json.hpp"
#include "record/resolved_config.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

const std::vector<std::string>& Settings::tables() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        Settings settings;
        visit_members(settings, [&](const char* name, const auto&) { list.emplace_back(name); });
        return list;
    }();
    return names;
}

Describe Settings::describe_table(const std::string& table) {
    Describe found;
    visit_members(*this, [&](const char* name, auto& config) {
        if (table == name) found = [&config](ConfigVisitor& v) { describe(v, config); };
    });
    if (!found) throw std::logic_error("no such table: " + table);
    return found;
}

Json Settings::resolved_tables(const std::vector<std::string>& names) const {
    Settings copy = *this;
    Json json = Json::object();
    for (const std::string& name : names) json[name] = resolved(copy.describe_table(name));
    return json;
}

Json deciding_keys(const Case& c, const std::vector<std::string>& tables, std::set<std::string> geometry_keys, bool with_section) {
    Json json = c.settings.resolved_tables(tables);
    if (with_section) geometry_keys.insert({"section_m", "trim_m"});
    geometry_keys.insert({"film_thickness_m", "film_volume_fraction", "closing_radius_m"});
    json["geometry"] = Json::object();
    const Json geometry = resolved_config(c.settings.geometry);
    for (const auto& [key, value] : geometry.items())
        if (geometry_keys.contains(key)) json["geometry"][key] = value;
    return json;
}

}  // namespace porepack::stages
