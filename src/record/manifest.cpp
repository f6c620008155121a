#include "record/manifest.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <filesystem>

#include "core/build.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "record/digest.hpp"

namespace porepack::record {

Json given_values(const Json& value) {
    if (value.is_array()) {  // as long as it was
        Json list = Json::array();
        for (const Json& entry : value) list.push_back(given_values(entry));
        return list;
    }
    if (!value.is_object()) return value;
    Json given = Json::object();
    for (const auto& [key, entry] : value.items()) {
        const Json inner = given_values(entry);
        const bool zero = inner.is_null() || inner == Json(0) || inner == Json(false) || inner == Json("");
        if (!zero && !((inner.is_array() || inner.is_object()) && inner.empty())) given[key] = inner;
    }
    return given;
}

std::string key_of(const Manifest& manifest) {
    const Json decisive = {{"stage", manifest.stage},
                           {"result_version", manifest.result_version},
                           {"configuration", given_values(manifest.configuration)},
                           {"inputs", manifest.inputs}};
    return sha256(decisive.dump());
}

Json to_json(const Manifest& manifest) {
    return {{"format", "porepack-manifest"},
            {"version", 1},
            {"stage", manifest.stage},
            {"key", key_of(manifest)},
            {"result_version", manifest.result_version},
            {"program_version", program_version()},
            {"git_hash", git_hash()},
            {"versions", manifest.versions},
            {"configuration", manifest.configuration},
            {"seed", manifest.seed},
            {"inputs_sha256", manifest.inputs},
            {"outputs_sha256", manifest.outputs},
            {"host", host_name()},
            {"processor", processor_name()},
            {"processes", manifest.processes},
            {"threads", thread_count()},
            {"wall_time_s", manifest.wall_time_s},
            {"peak_memory_bytes", manifest.peak_memory_bytes},
            {"finished", fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)))}};
}

namespace {

std::string difference(const Json& found, const Manifest& expected) {
    if (const long version = found.value("result_version", 0L); version != expected.result_version)
        return fmt::format("result version {}, this porepack computes version {}", version, expected.result_version);
    for (const auto& [name, digest] : expected.inputs)
        if (found["inputs_sha256"].value(name, "") != digest) return "input changed: " + name;
    const Json before = given_values(found["configuration"]), now = given_values(expected.configuration);
    for (const Json* side : {&now, &before})
        for (const auto& [key, value] : side->items())
            if (before.value(key, Json()) != now.value(key, Json())) return "configuration changed: " + key;
    return "configuration changed";
}

}  // namespace

StageState state_of(const Path& folder, const Manifest& expected, std::string* why) {
    const auto say = [&](const std::string& text) {
        if (why != nullptr) *why = text;
    };
    const Path file = folder / "manifest.json";
    if (!std::filesystem::exists(file)) return StageState::missing;
    try {
        const Json found = read_json(file);
        if (found.value("key", "") != key_of(expected)) {
            say(difference(found, expected));
            return StageState::stale;
        }
        if (!found.at("outputs_sha256").contains("result.json") || !found.at("peak_memory_bytes").is_number() ||
            !found.at("wall_time_s").is_number()) {
            say("manifest damaged");
            return StageState::stale;
        }
        for (const auto& [name, digest] : found.at("outputs_sha256").items())
            if (!std::filesystem::exists(folder / name) || sha256_of_file(folder / name) != digest.get<std::string>()) {
                say("output changed or missing: " + name);
                return StageState::stale;
            }
        return StageState::done;
    } catch (const std::exception& fault) {
        say(std::string("manifest unreadable: ") + fault.what());
        return StageState::stale;
    }
}

}  // namespace porepack::record
