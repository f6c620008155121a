#include "core/owned_names.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::inline core {
namespace fs = std::filesystem;
namespace {

constexpr const char* mark_name = ".porepack";
constexpr std::string_view whole_folder = "This folder was written by porepack and is replaced as a whole.\n";
constexpr std::string_view list_of_names = "Written by porepack, which may replace these files and folders:\n";

[[noreturn]] void throw_in_the_way(const Path& path) {
    throw UserError(fmt::format("{} {} is in the way and was not written by porepack", fs::is_directory(path) ? "the folder" : "the file",
                                path.string()),
                    {.fix = "move it, or choose another folder with --output"});
}

Json manifest_in(const Path& file) {
    constexpr double largest = 1e8;
    try {
        Json manifest = Json::parse(read_text(file, largest));
        if (manifest.is_object() && manifest.value("format", Json()) == "porepack-manifest") return manifest;
    } catch (const std::exception&) {  // of another program
    }
    return nullptr;
}

// Also true of a link to nothing.
bool is_there(const Path& path) {
    std::error_code none;
    return fs::symlink_status(path, none).type() != fs::file_type::not_found;
}

}  // namespace

void mark_as_own(const Path& folder) {
    write_text(folder / mark_name, whole_folder);
}

bool is_own(const Path& folder) {
    if (fs::is_regular_file(folder / mark_name) && read_text(folder / mark_name).starts_with(whole_folder)) return true;
    return fs::is_regular_file(folder / "manifest.json") && !manifest_in(folder / "manifest.json").is_null();
}

void require_own(const Path& folder) {
    if (is_there(folder) && !(fs::is_directory(folder) && (fs::is_empty(folder) || is_own(folder)))) throw_in_the_way(folder);
}

OwnedNames::OwnedNames(Path folder) : folder_(std::move(folder)) {
    if (!fs::is_directory(folder_)) return;
    if (fs::is_regular_file(folder_ / mark_name)) {
        const std::string text = read_text(folder_ / mark_name);
        std::istringstream lines(text.starts_with(list_of_names) ? text.substr(list_of_names.size()) : std::string());
        for (std::string line; std::getline(lines, line);) names_.insert(line);
    }
    for (const auto& entry : fs::directory_iterator(folder_)) {
        const std::string name = entry.path().filename().string();
        if (entry.is_directory() && is_own(entry.path())) names_.insert(name);
        if (!name.ends_with(".manifest.json")) continue;
        const Json manifest = manifest_in(entry.path());
        if (manifest.is_null() || !manifest.contains("outputs_sha256")) continue;
        names_.insert(name);
        for (const auto& [output, digest] : manifest["outputs_sha256"].items())
            if (output.find('/') == std::string::npos) names_.insert(output);
    }
}

void OwnedNames::require(const std::string& name) const {
    if (is_there(folder_ / name) && !contains(name)) throw_in_the_way(folder_ / name);
}

void OwnedNames::claim(const std::vector<std::string>& names) {
    for (const std::string& name : names) require(name);
    add(names);
}

void OwnedNames::add(const std::vector<std::string>& names) {
    const std::size_t before = names_.size();
    names_.insert(names.begin(), names.end());
    if (names_.size() == before) return;
    std::string text(list_of_names);
    for (const std::string& name : names_) text += name + "\n";
    write_text(folder_ / mark_name, text);
}

void write_own_text(const Path& file, const std::string& text) {
    if (is_there(file)) {
        const std::string before = read_text(file);
        if (before == text) return;
        // Up to the first full stop or colon: what follows may differ.
        const std::string first = text.substr(0, text.find_first_of(".:\n"));
        if (!before.starts_with(first)) throw_in_the_way(file);
    }
    write_text(file, text);
}

}  // namespace porepack::inline core
