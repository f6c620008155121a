// How the parts of one computation, each on its own processor or in its own thread, exchange data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace porepack::inline core {

using Bytes = std::vector<std::byte>;

/// Messages that are under way.
class Transfer {
public:
    virtual ~Transfer() = default;
    /// Lets them move on, while this part computes something else.
    virtual void move_on() {}
    /// Returns when all have been sent and received.
    virtual void finish() = 0;
};

/// The parts of a grid, from the lowest to the highest. Every part calls the same functions in the same order, and each call returns when
/// the parts that it needs have called it too. A part that fails ends the others with MachineError.
class Communicator {
public:
    virtual ~Communicator() = default;
    [[nodiscard]] virtual int parts() const = 0;
    /// 0 .. parts() - 1.
    [[nodiscard]] virtual int part() const = 0;

    /// Sends to the parts below (0) and above (1), and receives from them as many bytes as they send. Below the lowest part lies the
    /// highest; what is empty on both sides is not sent. The memory of both stays until the transfer is finished, before which nothing else
    /// is asked of the communicator.
    [[nodiscard]] virtual std::unique_ptr<Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>& to,
                                                                   const std::array<std::span<std::byte>, 2>& from) const = 0;
    void exchange(const std::array<std::span<const std::byte>, 2>& to, const std::array<std::span<std::byte>, 2>& from) const {
        begin_exchange(to, from)->finish();
    }
    /// What each part gives, in their order, for all parts.
    [[nodiscard]] virtual std::vector<Bytes> gather(std::span<const std::byte> mine) const = 0;
    /// Each part in turn, from the lowest, gets the numbers that the part below left and calls add(), which may change them; then all parts
    /// have what the highest left. The order of additions is thus that of the parts.
    virtual void in_turn(std::span<double> numbers, const std::function<void()>& add) const = 0;
};

/// One part.
[[nodiscard]] const Communicator& no_communicator();

/// All ranks of this program where it was started as several (src/parallel), else one part.
[[nodiscard]] const Communicator& ranks();
/// Of these, on this machine.
[[nodiscard]] int ranks_here();
/// Called once, before the work begins; `all` outlives it.
void set_ranks(const Communicator& all, int here);

/// The number that part 0 gives, for all parts: clocks and free memory differ, and decisions must not.
[[nodiscard]] double agreed(const Communicator& parts, double number);
/// True if it is for one of the parts.
[[nodiscard]] bool any_of(const Communicator& parts, bool here);
[[nodiscard]] double largest_of(const Communicator& parts, double number);
/// Sum over the parts, in their order.
[[nodiscard]] double sum_of(const Communicator& parts, double number);
/// Sum over the parts below this one.
[[nodiscard]] std::uint64_t sum_below(const Communicator& parts, std::uint64_t number);

/// Calls work(communicator) once for each part, in threads of this process, and rethrows the first error.
void run_parts(int parts, const std::function<void(const Communicator&)>& work);

/// Objects of plain memory as bytes and back.
template <typename T>
[[nodiscard]] std::span<const std::byte> bytes_of(const std::vector<T>& list) {
    static_assert(std::is_trivially_copyable_v<T>);
    return std::as_bytes(std::span(list));
}
template <typename T>
[[nodiscard]] std::vector<T> list_of(std::span<const std::byte> bytes) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> list(bytes.size() / sizeof(T));
    if (!list.empty()) std::memcpy(list.data(), bytes.data(), bytes.size());
    return list;
}
/// What the parts below (0) and above (1) send; of any length.
template <typename T>
[[nodiscard]] std::array<std::vector<T>, 2> exchange_lists(const Communicator& parts, const std::array<std::vector<T>, 2>& to) {
    std::array<std::uint64_t, 2> sizes{to[0].size(), to[1].size()}, counts{};
    const auto one = [](auto& number) { return std::span(&number, 1); };
    parts.exchange({std::as_bytes(one(sizes[0])), std::as_bytes(one(sizes[1]))},
                   {std::as_writable_bytes(one(counts[0])), std::as_writable_bytes(one(counts[1]))});
    std::array<std::vector<T>, 2> from{std::vector<T>(counts[0]), std::vector<T>(counts[1])};
    parts.exchange({bytes_of(to[0]), bytes_of(to[1])},
                   {std::as_writable_bytes(std::span(from[0])), std::as_writable_bytes(std::span(from[1]))});
    return from;
}

}  // namespace porepack::inline core
