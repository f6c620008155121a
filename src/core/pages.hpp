// Large arrays whose memory the system provides as it is first touched, and takes back in parts.
#pragma once

#include <cstddef>
#include <type_traits>

namespace porepack::inline core {

/// Anonymous memory in pages of the system, zero until written. MachineError if there is none left.
class PageMemory {
public:
    PageMemory() = default;
    explicit PageMemory(std::size_t bytes);
    PageMemory(PageMemory&& other) noexcept;
    PageMemory& operator=(PageMemory&& other) noexcept;
    PageMemory(const PageMemory&) = delete;
    PageMemory& operator=(const PageMemory&) = delete;
    ~PageMemory();
    [[nodiscard]] std::byte* data() const { return data_; }
    /// Gives the pages that lie completely within [first, end) back; they are zero again.
    void release(std::size_t first, std::size_t end);

private:
    void free();

    std::byte *mapped_ = nullptr, *data_ = nullptr;
    std::size_t mapped_bytes_ = 0;
};

/// An array in such memory; its values are zero at first.
template <typename T>
class Pages {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    Pages() = default;
    explicit Pages(std::size_t size) : memory_(size * sizeof(T)), size_(size) {}
    [[nodiscard]] T* data() const { return reinterpret_cast<T*>(memory_.data()); }
    [[nodiscard]] std::size_t size() const { return size_; }
    T& operator[](std::size_t i) { return data()[i]; }
    const T& operator[](std::size_t i) const { return data()[i]; }
    /// The values [first, end) are needed no more.
    void release(std::size_t first, std::size_t end) { memory_.release(first * sizeof(T), end * sizeof(T)); }

private:
    PageMemory memory_;
    std::size_t size_ = 0;
};

}  // namespace porepack::inline core
