#include "core/files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>

#include "core/error.hpp"

namespace porepack::core {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void throw_write_error(const Path& path) {
    const std::string reason = std::strerror(errno == 0 ? EIO : errno);
    throw MachineError("cannot write " + path.string() + ": " + reason,
                       {.fix = "free some disk space or choose another folder with --output"});
}

}  // namespace

std::string read_text(const Path& path) {
    if (!fs::exists(path)) throw UserError("no such file: " + path.string(), {.fix = "check the path"});
    if (fs::is_directory(path)) throw UserError(path.string() + " is a folder, a file is needed");
    std::ifstream in(path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), {});
    if (!in) throw UserError("cannot read " + path.string() + ": " + std::strerror(errno));
    return text;
}

Json read_json(const Path& path) {
    const std::string text = read_text(path);
    if (text.empty()) throw UserError("the file is empty: " + path.string());
    try {
        return Json::parse(text);
    } catch (const nlohmann::json::parse_error& fault) {
        const auto end = static_cast<std::ptrdiff_t>(std::min(fault.byte, text.size()));
        const auto line = 1 + std::count(text.begin(), text.begin() + end, '\n');
        throw UserError("not valid JSON: " + path.string(), {.where = fmt::format("line {} (byte {})", line, fault.byte)});
    }
}

void write_whole(const Path& path, const std::function<void(const Path&)>& write) {
    const Path temporary = path.parent_path() / fmt::format(".{}.{}.partial{}", path.stem().string(), getpid(), path.extension().string());
    try {
        write(temporary);
        errno = 0;
        fs::rename(temporary, path);
    } catch (...) {
        std::error_code ignored;
        fs::remove(temporary, ignored);
        throw;
    }
}

void write_text(const Path& path, std::string_view text) {
    write_whole(path, [&](const Path& name) {
        errno = 0;
        std::ofstream out(name, std::ios::binary);
        out << text;
        out.close();
        if (!out) throw_write_error(path);
    });
}

void write_json(const Path& path, const Json& json) {
    write_text(path, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void make_folder(const Path& path) {
    std::error_code fault;
    fs::create_directories(path, fault);
    if (fault)
        throw UserError("cannot make the folder " + path.string() + ": " + fault.message(),
                        {.fix = "choose a folder that you may write to with --output"});
}

void require_writable(const Path& folder) {
    make_folder(folder);
    if (access(folder.c_str(), W_OK) != 0)
        throw UserError("cannot write in the folder " + folder.string() + ": " + std::strerror(errno),
                        {.fix = "choose a folder that you may write to with --output"});
}

std::string tail(const Path& path, int lines) {
    std::ifstream in(path);
    std::deque<std::string> last;
    for (std::string line; std::getline(in, line);) {
        last.push_back(line);
        if (static_cast<int>(last.size()) > lines) last.pop_front();
    }
    std::string text;
    for (const auto& line : last) text += "  | " + line + "\n";
    return text;
}

}  // namespace porepack::core
