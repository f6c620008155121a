// The same bits on any number of threads.
#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "core/json.hpp"
#include "record/digest.hpp"
#include "support/helpers.hpp"

namespace porepack {
namespace {

namespace fs = std::filesystem;
using test::porepack;
using test::quoted;

constexpr const char* twelve_grains = R"([shape]
kind = "tetrapod"
sphericity = 0.53
volume_m3 = 7.33e-7
[container]
diameter_m = 0.045
height_m = 0.12
[packing]
grains = 12
[geometry]
voxel_size_m = 1.25e-3
surface_deviation_m = 2e-4
section_m = [0.004, 0.012]
[openfoam]
enabled = false
[forchheimer]
enabled = true
openfoam = false
grids = 1
voxel_size_m = 1.5e-3
reynolds = [2, 4, 8]
)";

// Without what a run costs, how it was started, and the digests of files that hold this.
Json without_costs(const Json& json) {
    static const std::set<std::string> costs = {"seconds", "updates_per_second", "set_up_seconds", "threads", "manifests", "title"};
    const auto is_cost = [](const std::string& key) {
        return costs.contains(key) || key.starts_with("cost") || key.ends_with("wall_time_s") || key.ends_with("memory_bytes");
    };
    if (json.is_array()) {
        Json list = Json::array();
        for (const Json& entry : json) list.push_back(without_costs(entry));
        return list;
    }
    if (!json.is_object()) return json;
    Json rest = Json::object();
    for (const auto& [key, value] : json.items())
        if (!is_cost(key)) rest[key] = without_costs(value);
    return rest;
}

// By the name of the file: bytes, or what a result says besides its costs.
std::map<std::string, std::string> results_in(const Path& folder) {
    std::map<std::string, std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        const std::string name = fs::relative(entry.path(), folder).string(), file = entry.path().filename().string();
        if (file == "manifest.json" || file.starts_with("report") || file.starts_with("log") || file == "merged.json" || file == "view.py")
            continue;  // view.py names its folder
        found[name] = file == "result.json" ? without_costs(read_json(entry.path())).dump() : sha256_of_file(entry.path());
    }
    return found;
}

TEST(Threads, EveryStageGivesTheSameBits) {
    const test::Folder folder;
    write_text(folder.path() / "case.toml", twelve_grains);
    std::map<std::string, std::string> alone;
    for (const int threads : {1, 2, 3, 5}) {
        const Path results = folder.path() / std::to_string(threads);
        const auto run =
            porepack("run " + quoted(folder.path()) + " --threads " + std::to_string(threads) + " --output " + quoted(results));
        ASSERT_EQ(run.exit_code, 0) << run.err;
        const auto found = results_in(results);
        if (threads == 1) alone = found;
        EXPECT_GT(found.size(), 30U);
        ASSERT_EQ(found.size(), alone.size());
        for (const auto& [name, content] : found) EXPECT_EQ(content, alone[name]) << name << " on " << threads << " threads";
    }
}

}  // namespace
}  // namespace porepack
