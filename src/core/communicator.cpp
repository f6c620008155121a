#include "core/communicator.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "core/context.hpp"
#include "core/error.hpp"

namespace porepack::inline core {
namespace {

// Nothing is under way.
class NoTransfer : public Transfer {
public:
    void finish() override {}
};

class Alone : public Communicator {
public:
    [[nodiscard]] int parts() const override { return 1; }
    [[nodiscard]] int part() const override { return 0; }
    [[nodiscard]] std::unique_ptr<Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>&,
                                                           const std::array<std::span<std::byte>, 2>&) const override {
        return std::make_unique<NoTransfer>();
    }
    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> mine) const override { return {Bytes(mine.begin(), mine.end())}; }
    void in_turn(std::span<double>, const std::function<void()>& add) const override { add(); }
};

// What the threads of one run share.
class Room {
public:
    explicit Room(int parts) : sent(static_cast<std::size_t>(parts)), parts_(sent.size()) {}

    // Returns when all parts have come.
    void meet() {
        std::unique_lock lock(mutex_);
        const long round = round_;
        if (++waiting_ == parts_) {
            waiting_ = 0;
            ++round_;
            changed_.notify_all();
        }
        changed_.wait(lock, [&] { return round_ != round || fault_; });
        if (round_ == round) throw MachineError("another part of the computation failed");
    }
    void fail(const std::exception_ptr& fault) {
        const std::scoped_lock lock(mutex_);
        if (!fault_) fault_ = fault;
        changed_.notify_all();
    }
    [[nodiscard]] std::exception_ptr fault() const { return fault_; }
    [[nodiscard]] std::size_t parts() const { return parts_; }

    // Copies: a part that fails takes its own memory with it while others still read. Written before a meeting, read between it and the
    // next.
    std::vector<std::array<Bytes, 2>> sent;  // by part
    std::vector<double> numbers;

private:
    std::size_t parts_, waiting_ = 0;
    long round_ = 0;
    std::exception_ptr fault_;
    std::mutex mutex_;
    std::condition_variable changed_;
};

void receive(std::span<const std::byte> sent, std::span<std::byte> here) {
    if (sent.size() != here.size()) throw std::logic_error("two parts expect messages of different lengths");
    std::copy(sent.begin(), sent.end(), here.begin());
}

class CopyOfBothSides : public Transfer {
public:
    CopyOfBothSides(Room& room, std::size_t part, const std::array<std::span<std::byte>, 2>& from)
        : room_(room), part_(part), from_(from) {}
    void finish() override {
        room_.meet();
        const std::size_t n = room_.parts();
        receive(room_.sent[(part_ + n - 1) % n][1], from_[0]);
        receive(room_.sent[(part_ + 1) % n][0], from_[1]);
        room_.meet();
    }

private:
    Room& room_;
    std::size_t part_;
    std::array<std::span<std::byte>, 2> from_;
};

class Thread : public Communicator {
public:
    Thread(Room& room, int part) : room_(room), part_(static_cast<std::size_t>(part)) {}
    [[nodiscard]] int parts() const override { return static_cast<int>(room_.parts()); }
    [[nodiscard]] int part() const override { return static_cast<int>(part_); }

    [[nodiscard]] std::unique_ptr<Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>& to,
                                                           const std::array<std::span<std::byte>, 2>& from) const override {
        for (std::size_t side = 0; side < 2; ++side) room_.sent[part_][side].assign(to[side].begin(), to[side].end());
        return std::make_unique<CopyOfBothSides>(room_, part_, from);
    }
    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> mine) const override {
        room_.sent[part_][0].assign(mine.begin(), mine.end());
        room_.meet();
        std::vector<Bytes> all;
        for (const auto& sent : room_.sent) all.push_back(sent[0]);
        room_.meet();
        return all;
    }
    void in_turn(std::span<double> numbers, const std::function<void()>& add) const override {
        const auto copy = [](std::span<const double> from, std::span<double> to) { std::copy(from.begin(), from.end(), to.begin()); };
        for (std::size_t turn = 0; turn < room_.parts(); ++turn) {
            if (turn == part_) {
                if (turn > 0) copy(room_.numbers, numbers);
                add();
                room_.numbers.assign(numbers.begin(), numbers.end());
            }
            room_.meet();
        }
        copy(room_.numbers, numbers);
        room_.meet();
    }

private:
    Room& room_;
    std::size_t part_;
};

}  // namespace

const Communicator& no_communicator() {
    static const Alone alone;
    return alone;
}

namespace {
const Communicator*& all_ranks() {
    static const Communicator* all = &no_communicator();
    return all;
}
int number_here = 1;
}  // namespace

const Communicator& ranks() {
    return *all_ranks();
}

int ranks_here() {
    return number_here;
}

void set_ranks(const Communicator& all, int here) {
    all_ranks() = &all;
    number_here = here;
}

namespace {
template <typename T>
std::vector<T> of_all(const Communicator& parts, T mine) {
    if (parts.parts() == 1) return {mine};
    std::vector<T> all;
    for (const Bytes& of_part : parts.gather(std::as_bytes(std::span(&mine, 1)))) all.push_back(list_of<T>(of_part).front());
    return all;
}
}  // namespace

double agreed(const Communicator& parts, double number) {
    return of_all(parts, number).front();
}

bool any_of(const Communicator& parts, bool here) {
    const std::vector<std::uint8_t> all = of_all(parts, static_cast<std::uint8_t>(here));
    return std::find(all.begin(), all.end(), 1) != all.end();
}

double largest_of(const Communicator& parts, double number) {
    const std::vector<double> all = of_all(parts, number);
    return *std::max_element(all.begin(), all.end());
}

double sum_of(const Communicator& parts, double number) {
    const std::vector<double> all = of_all(parts, number);
    return std::accumulate(all.begin(), all.end(), 0.0);
}

std::uint64_t sum_below(const Communicator& parts, std::uint64_t number) {
    const std::vector<std::uint64_t> all = of_all(parts, number);
    return std::accumulate(all.begin(), all.begin() + parts.part(), std::uint64_t{0});
}

void run_parts(int parts, const std::function<void(const Communicator&)>& work) {
    Room room(parts);
    const Context& run = context();
    {
        std::vector<std::jthread> threads;
        for (int part = 0; part < parts; ++part)
            threads.emplace_back([&room, &run, &work, part] {
                const ContextScope here(run);
                try {
                    work(Thread(room, part));
                } catch (...) {
                    room.fail(std::current_exception());
                }
            });
    }
    if (room.fault()) std::rethrow_exception(room.fault());
}

}  // namespace porepack::inline core
