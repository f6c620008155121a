// A file that the parts of a computation write together, each at its own places.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <span>
#include <string>

#include "core/communicator.hpp"
#include "core/files.hpp"

namespace porepack::inline core {

class SharedFile {
public:
    /// Opens what is there.
    SharedFile(const Path& path, std::string what);
    /// Beyond the end too.
    void write(std::uint64_t byte, std::span<const std::byte> bytes);
    void close();

private:
    [[noreturn]] void fail() const;

    Path path_;
    std::string what_;
    std::fstream file_;
};

/// Calls write(file) once in each part. The file has its name when all have written and the first part returns; if one of them fails,
/// nothing is left. `what`, for messages: "the checkpoint". Throws MachineError.
void write_together(const Path& path, const std::string& what, const Communicator& parts, const std::function<void(SharedFile&)>& write);

}  // namespace porepack::inline core
