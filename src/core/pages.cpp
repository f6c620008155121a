#include "core/pages.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

#include "core/error.hpp"

namespace porepack::inline core {
namespace {

constexpr std::size_t large_page = std::size_t{1} << 21;

std::size_t small_page() {
    static const auto bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return bytes;
}

std::size_t round_up(std::size_t bytes, std::size_t page) {
    return (bytes + page - 1) / page * page;
}

}  // namespace

// In large pages where that is worth it and the system has them.
PageMemory::PageMemory(std::size_t bytes) {
    const bool large = bytes >= large_page;
    mapped_bytes_ = round_up(bytes, small_page()) + (large ? large_page : 0);
    void* const mapped = mmap(nullptr, mapped_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (mapped == MAP_FAILED)
        throw MachineError(fmt::format("{} bytes of memory are not available", bytes),
                           {.fix = "use a larger voxel size or a larger machine"});
    mapped_ = static_cast<std::byte*>(mapped);
    data_ = mapped_;
    if (!large) return;
    const std::size_t beyond = reinterpret_cast<std::uintptr_t>(mapped_) % large_page;
    data_ += beyond == 0 ? 0 : large_page - beyond;
    madvise(data_, round_up(bytes, small_page()), MADV_HUGEPAGE);
}

PageMemory::PageMemory(PageMemory&& other) noexcept
    : mapped_(std::exchange(other.mapped_, nullptr)),
      data_(std::exchange(other.data_, nullptr)),
      mapped_bytes_(std::exchange(other.mapped_bytes_, 0)) {}

PageMemory& PageMemory::operator=(PageMemory&& other) noexcept {
    if (this == &other) return *this;
    free();
    mapped_ = std::exchange(other.mapped_, nullptr);
    data_ = std::exchange(other.data_, nullptr);
    mapped_bytes_ = std::exchange(other.mapped_bytes_, 0);
    return *this;
}

PageMemory::~PageMemory() {
    free();
}

void PageMemory::free() {
    if (mapped_ != nullptr) munmap(mapped_, mapped_bytes_);
}

void PageMemory::release(std::size_t first, std::size_t end) {
    const std::size_t begin = round_up(first, small_page()), last = end / small_page() * small_page();
    if (begin < last) madvise(data_ + begin, last - begin, MADV_DONTNEED);
}

}  // namespace porepack::inline core
