// A case or study of one's own, copied from one that porepack brings.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "converters/surface_file.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"

namespace porepack::apps {
namespace fs = std::filesystem;
namespace {

bool is_case_folder(const Path& folder) {
    return fs::exists(folder / "case.toml") || fs::exists(folder / "study.toml");
}

// Names below cases/, also "ct/truth".
std::vector<std::string> names_of_cases(const Path& cases) {
    std::vector<std::string> names;
    for (auto entry = fs::recursive_directory_iterator(cases); entry != fs::recursive_directory_iterator(); ++entry) {
        if (!entry->is_directory()) continue;
        if (entry->path().filename() == "results") entry.disable_recursion_pending();
        if (is_case_folder(entry->path())) names.push_back(fs::relative(entry->path(), cases).string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

// What a case is made of, not what was made of it.
bool belongs_to_case(const Path& file) {
    const std::string name = file.filename().string();
    return name == "case.toml" || name == "study.toml" || name == "packing.json" || name.ends_with(".json.gz") ||
           converters::is_surface_file(name);
}

void make_new(const Common& common, const std::string& folder, const std::string& from) {
    const Path cases = data_file("cases");
    const auto names = names_of_cases(cases);
    if (std::find(names.begin(), names.end(), from) == names.end())
        throw UserError("there is no case \"" + from + "\"", {.where = "--from", .allowed = fmt::format("{}", fmt::join(names, ", "))});
    if (fs::exists(folder) && !(fs::is_directory(folder) && fs::is_empty(folder)))
        throw UserError(folder + " exists and is not empty", {.fix = "choose another name"});
    std::vector<std::string> written;
    for (auto entry = fs::recursive_directory_iterator(cases / from); entry != fs::recursive_directory_iterator(); ++entry) {
        const std::string name = entry->path().filename().string();
        if (entry->is_directory() && (name == "results" || is_case_folder(entry->path()))) entry.disable_recursion_pending();
        if (!entry->is_regular_file() || !belongs_to_case(entry->path())) continue;
        const Path relative = fs::relative(entry->path(), cases / from);
        written.push_back(relative.string());
        if (common.dry_run) continue;
        make_folder((Path(folder) / relative).parent_path());
        fs::copy_file(entry->path(), Path(folder) / relative);
    }
    std::sort(written.begin(), written.end());
    print_result(common, {{"folder", folder}, {"from", from}, {common.dry_run ? "would_write" : "written_files", written}});
    if (!common.dry_run && fs::exists(Path(folder) / "case.toml")) say_files_outside(stages::read_case(folder));
    if (!common.json && !common.dry_run)
        fmt::print("next: edit {0}/{1}, then porepack {2} {0}\n", for_terminal(folder), written.front(),
                   written.back() == "study.toml" ? "study run" : "run");
}

}  // namespace

void add_new_command(CommandLine& line) {
    const Common& common = line.common;
    const auto folder = std::make_shared<std::string>(), from = std::make_shared<std::string>("quickstart");
    auto command = line.add("new", "a case or study of your own, copied from one that porepack brings",
                            "porepack new my_bed --from quickstart", [&, folder, from] { make_new(common, *folder, *from); });
    command.add_option("folder", *folder, "made; must be empty if it exists").type_name("path").required();
    command.add_option("--from", *from, "name of a folder of cases/; default quickstart").type_name("name");
}

}  // namespace porepack::apps
