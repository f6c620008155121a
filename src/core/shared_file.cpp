#include "core/shared_file.hpp"

#include <filesystem>
#include <utility>

#include "core/error.hpp"

namespace porepack::inline core {

SharedFile::SharedFile(const Path& path, std::string what)
    : path_(path), what_(std::move(what)), file_(path, std::ios::binary | std::ios::in | std::ios::out) {
    if (!file_)
        throw MachineError(what_ + " cannot be opened by all ranks",
                           {.where = path_.string(), .fix = "choose a folder with --output that all machines see"});
}

void SharedFile::write(std::uint64_t byte, std::span<const std::byte> bytes) {
    file_.seekp(static_cast<std::streamoff>(byte));
    file_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    if (!file_) fail();
}

void SharedFile::close() {
    file_.close();
    if (!file_) fail();
}

void SharedFile::fail() const {
    throw MachineError(what_ + " cannot be written", {.where = path_.string(), .fix = "is the disk full?"});
}

void write_together(const Path& path, const std::string& what, const Communicator& parts, const std::function<void(SharedFile&)>& write) {
    // All have come when the name of the file is known, and when it is complete.
    const auto write_part = [&](const std::string& name_here) {
        const Bytes name = parts.gather(std::as_bytes(std::span(name_here))).front();
        SharedFile file(std::string(reinterpret_cast<const char*>(name.data()), name.size()), what);
        write(file);
        file.close();
        (void)parts.gather({});
    };
    if (parts.part() > 0) return write_part("");
    write_whole(path, [&](const Path& part) {
        if (!std::ofstream(part, std::ios::binary))
            throw MachineError(what + " cannot be written", {.where = path.string(), .fix = "is the disk full, or the folder not yours?"});
        write_part(std::filesystem::absolute(part).string());
    });
}

}  // namespace porepack::inline core
