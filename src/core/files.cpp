#include "core/files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <fstream>
#include <new>
#include <set>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"

namespace porepack::inline core {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void throw_write_error(const Path& path) {
    const std::string reason = std::strerror(errno == 0 ? EIO : errno);
    throw MachineError("cannot write " + path.string() + ": " + reason,
                       {.fix = "free some disk space or choose another folder with --output"});
}

}  // namespace

void require_file(const Path& path, double max_bytes) {
    std::error_code fault;
    const fs::file_status status = fs::status(path, fault);
    if (status.type() == fs::file_type::not_found) throw UserError("no such file: " + path.string(), {.fix = "check the path"});
    if (fs::is_directory(status)) throw UserError(path.string() + " is a folder, a file is needed", {.fix = "name the file in it"});
    if (!fs::exists(status))
        throw UserError("cannot read " + path.string() + ": " + fault.message(),
                        {.fix = "check its permissions, and those of its folders"});
    if (!fs::is_regular_file(status))
        throw UserError(path.string() + " is a pipe or a device, a regular file is needed", {.fix = "write the content into a file first"});
    const auto bytes = static_cast<double>(fs::file_size(path));
    if (bytes > max_bytes)
        throw UserError(fmt::format("{} has {:.3g} MB", path.string(), 1e-6 * bytes),
                        {.allowed = fmt::format("at most {:.3g} MB", 1e-6 * max_bytes), .fix = "check that this is the right file"});
}

std::string read_text(const Path& path, double max_bytes) {
    require_file(path, max_bytes);
    std::ifstream in(path, std::ios::binary);
    std::string text;
    try {
        text.resize(fs::file_size(path));
    } catch (const std::bad_alloc&) {
        throw MachineError(
            fmt::format("not enough memory to read {} ({:.3g} MB)", path.string(), 1e-6 * static_cast<double>(fs::file_size(path))),
            {.fix = "use a machine with more memory, or a smaller file"});
    }
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (in.bad() || !in.is_open())
        throw UserError("cannot read " + path.string() + ": " + std::strerror(errno), {.fix = "check its permissions"});
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

Json parse_json(std::string_view text, const std::string& source) {
    std::vector<std::set<std::string>> keys;  // of the objects around the place that is read
    const auto no_key_twice = [&](int, Json::parse_event_t event, Json& parsed) {
        if (event == Json::parse_event_t::object_start) keys.emplace_back();
        if (event == Json::parse_event_t::object_end) keys.pop_back();
        if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second)
            throw UserError(fmt::format("the key \"{}\" is there twice in one object", parsed.get<std::string>()),
                            {.where = source, .fix = "remove one of them"});
        return true;
    };
    try {
        return Json::parse(text, no_key_twice);
    } catch (const nlohmann::json::parse_error& fault) {
        const auto end = static_cast<std::ptrdiff_t>(std::min(fault.byte, text.size()));
        const auto line = 1 + std::count(text.begin(), text.begin() + end, '\n');
        throw UserError("not valid JSON: " + source,
                        {.where = fmt::format("line {} (byte {})", line, fault.byte), .fix = "the file may be incomplete: write it again"});
    } catch (const nlohmann::json::exception& fault) {
        throw UserError(fmt::format("not valid JSON: {}: {}", source, fault.what()));
    }
}

Json read_json(const Path& path) {
    const std::string text = read_text(path);
    if (text.empty()) throw UserError("the file is empty: " + path.string());
    return parse_json(text, path.string());
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

}  // namespace porepack::inline core
