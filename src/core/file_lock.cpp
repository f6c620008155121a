#include "core/file_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "core/error.hpp"
#include "core/interrupt.hpp"

namespace porepack::inline core {
namespace {

int opened(const Path& path) {
    const int file = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file < 0) throw MachineError("cannot write " + path.string(), {.fix = "check the permissions of the folder and the free space"});
    return file;
}

}  // namespace

std::optional<FileLock> FileLock::try_take(const Path& path) {
    const int file = opened(path);
    if (flock(file, LOCK_EX | LOCK_NB) == 0) return FileLock(file);
    close(file);
    return std::nullopt;
}

FileLock FileLock::wait_for(const Path& path) {
    FileLock lock(opened(path));
    while (flock(lock.file_, LOCK_EX) != 0) check_interrupt();
    return lock;
}

FileLock::~FileLock() {
    if (file_ >= 0) close(file_);
}

}  // namespace porepack::inline core
