// Work that a library may not survive, in a process of its own: what it reads may come from anyone.
#pragma once

#include <functional>
#include <span>
#include <string>

namespace porepack::inline core {

/// Memory that a process and those that it starts with in_own_process() both see; zero at first.
class SharedBytes {
public:
    explicit SharedBytes(std::size_t size);
    ~SharedBytes();
    SharedBytes(const SharedBytes&) = delete;
    SharedBytes& operator=(const SharedBytes&) = delete;
    [[nodiscard]] std::span<char> bytes() const { return {data_, size_}; }

private:
    char* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Runs `work` in a copy of this process, without its standard output and error, and returns the text that it returns. An Error of `work`
/// is thrown here. Throws UserError with what() when the copy ends in another way: by an abort, a fault of memory, or after
/// `max_processor_seconds` seconds of processor time. `work` must not use threads.
[[nodiscard]] std::string in_own_process(const std::function<std::string()>& work, const std::function<std::string()>& what,
                                         double max_processor_seconds = 600.0);

}  // namespace porepack::inline core
