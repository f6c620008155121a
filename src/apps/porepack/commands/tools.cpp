// Further commands: benchmark, picture, manual, keys.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "converters/surface.hpp"
#include "converters/surface_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/process.hpp"
#include "devices/device.hpp"
#include "io/render.hpp"

namespace porepack::apps {
namespace {

// Replaces this process; returns only when that failed.
void become(const std::vector<std::string>& command) {
    std::vector<const char*> words;
    for (const auto& word : command) words.push_back(word.c_str());
    words.push_back(nullptr);
    execvp(words[0], const_cast<char* const*>(words.data()));
}

Path own_folder() {
    return std::filesystem::read_symlink("/proc/self/exe").parent_path();
}

// The measurements are a separate program.
void forward_to_benchmark(const std::vector<std::string>& arguments) {
    std::vector<std::string> command = {(own_folder() / "porepack_benchmark").string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    become(command);
    throw EngineError("the program porepack_benchmark is missing",
                      {.where = command[0], .fix = "cmake --build build --target porepack_benchmark"});
}

// Without a display the command runs again under xvfb-run, which provides one.
void render_under_some_display(const std::vector<std::string>& arguments) {
    if (std::getenv("DISPLAY") != nullptr) return;
    require_program("xvfb-run", "xvfb xauth");
    std::vector<std::string> command = {"xvfb-run", "-a", std::filesystem::read_symlink("/proc/self/exe").string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    become(command);
    throw EngineError("cannot start xvfb-run");
}

void draw(const Common& common, const std::vector<std::string>& arguments, bool front, const std::string& walls) {
    const Path target = common.output.empty() ? Path(common.input).replace_extension(".png") : Path(common.output);
    if (common.dry_run) return print_result(common, {{"picture", target.string()}, {"expected", "seconds"}});
    if (!inputs::is_surface(common.input))
        throw UserError("not a surface (STL, PLY or OBJ): " + common.input, {.fix = "make one: porepack stl packing.json"});
    render_under_some_display(arguments);
    const TriangleSurface surface = converters::read_surface(common.input, common.unit_m);
    PictureStyle style = style_for(surface);
    style.front = front;
    if (const auto container = container_of(common)) style = {.walls = sides_of(*container, container->height())};
    if (!walls.empty()) style = {.walls = converters::read_surface(walls)};
    render_surface(target, surface, style);
    print_result(common, {{"picture", target.string()}});
}

void list_devices(const Common& common) {
    if (common.dry_run) return print_result(common, {{"expected", "seconds per device"}});
    Json list = Json::array();
    for (const devices::DeviceInfo& info : devices::find_devices()) {
        Json entry = {{"id", info.id},
                      {"name", info.name},
                      {"driver", info.driver},
                      {"graphics_card", info.graphics},
                      {"memory_bytes", info.memory_bytes},
                      {"largest_buffer_bytes", info.largest_buffer_bytes}};
        try {
            entry["copy_bytes_per_second"] = devices::copy_bandwidth(*devices::open_device(info.id));
        } catch (const Error& fault) {
            entry["fault"] = fault.what();
        }
        list.push_back(entry);
    }
    if (common.json) return print_result(common, {{"devices", list}});
    fmt::print("{:<10}  {:>8}  {:>14}  {:>11}  name\n", "device", "memory", "largest buffer", "copy");
    fmt::print("{:<10}  {:>8}  {:>14}  {:>11}  this processor\n", "cpu", "", "", "");
    for (const Json& one : list) {
        const auto gigabytes = [&](const char* key) { return fmt::format("{:.3g} GB", 1e-9 * one.value(key, 0.0)); };
        fmt::print("{:<10}  {:>8}  {:>14}  {:>11}  {}{}\n", one["id"].get<std::string>(), gigabytes("memory_bytes"),
                   gigabytes("largest_buffer_bytes"),
                   one.contains("fault") ? "-" : fmt::format("{:.3g} GB/s", 1e-9 * one["copy_bytes_per_second"].get<double>()),
                   one["name"].get<std::string>(), one.contains("fault") ? ": " + one["fault"].get<std::string>() : "");
    }
    if (list.empty()) fmt::print("No driver of OpenCL was found: see docs/gpu.md.\n");
}

std::string key_reference() {
    Settings settings;
    std::string text;
    const auto add = [&](const std::string& title, const record::Describe& keys) {
        text += fmt::format("{}## {}\n\n| key | type | default | allowed | meaning |\n|---|---|---|---|---|\n", text.empty() ? "" : "\n",
                            title);
        for (const auto& row : key_rows(keys))
            text += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.key, row.type, row.standard.empty() ? "–" : row.standard,
                                row.allowed.empty() ? "–" : row.allowed, row.meaning);
    };
    for (const auto& table : Settings::tables()) {
        add("[" + table + "]", settings.describe_table(table));
        pouring::ProtocolStep step;
        if (table == "protocol") add("[[protocol.step]]", [&](record::ConfigVisitor& v) { describe(v, step); });
    }
    return text;
}

}  // namespace

void add_tools(CommandLine& line) {
    const auto front = std::make_shared<bool>(false);
    const auto walls = std::make_shared<std::string>();
    line.add_forwarded("benchmark", "measurements (the program porepack_benchmark)", [&line] {
        forward_to_benchmark({line.arguments.begin() + 1, line.arguments.end()});
    });
    auto picture = line.add("picture", "render an STL file to a PNG", "porepack picture solid.stl --output solid.png",
                            [&line, front, walls] { draw(line.common, line.arguments, *front, *walls); });
    line.add_input(picture, "an STL file");
    picture.add_flag("--front", *front, "seen along y, without perspective");
    picture.add_option("--walls", *walls, "a surface that is drawn transparent, in metres: of the container");
    line.add("manual", "man pages of all commands and the completion for bash, below a folder share/",
             "porepack manual --output ~/.local/share", [&line] {
                 const Common& common = line.common;
                 if (common.output.empty())
                     throw UserError("--output is missing", {.fix = "--output ~/.local/share, where man and bash look"});
                 if (common.dry_run) return print_result(common, {{"folder", common.output}, {"expected", "seconds"}});
                 print_result(common, {{"folder", common.output}, {"written_files", line.write_manual(common.output).size()}});
             });
    line.add("devices", "what --device can name: memory, and how fast it is copied", "porepack devices",
             [&line] { list_devices(line.common); });
    line.add_plain("keys", "all keys of case.toml, as a Markdown table", [] { fmt::print("{}", key_reference()); });
}

}  // namespace porepack::apps
