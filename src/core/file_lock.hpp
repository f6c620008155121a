// A lock on a file, held by one process at a time and released when it ends, also by kill -9.
#pragma once

#include <optional>
#include <utility>

#include "core/files.hpp"

namespace porepack::inline core {

class FileLock {
public:
    /// Nothing if another process holds it. The file is made where necessary, and stays. Throws MachineError if that is not possible.
    [[nodiscard]] static std::optional<FileLock> try_take(const Path& file);
    /// Waits until no other process holds it.
    [[nodiscard]] static FileLock wait_for(const Path& file);

    FileLock(FileLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
    FileLock& operator=(FileLock&&) = delete;
    ~FileLock();

private:
    explicit FileLock(int file) : file_(file) {}
    int file_;
};

}  // namespace porepack::inline core
