#include "parallel/mpi_ranks.hpp"

#include <fmt/format.h>
#ifdef POREPACK_WITH_MPI
#define OMPI_SKIP_MPICXX  // the old C++ interface, which needs another library
#include <mpi.h>
#endif
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "core/communicator.hpp"
#include "core/error.hpp"
#include "core/machine.hpp"

namespace porepack::parallel {
namespace {

using core::Bytes;

// Set by mpirun of OpenMPI, and by srun and other launchers for each process that they start.
bool is_started_by_launcher() {
    const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
    return size != nullptr ? std::atoi(size) > 1 : std::getenv("PMIX_RANK") != nullptr || std::getenv("PMI_RANK") != nullptr;
}

#ifdef POREPACK_WITH_MPI

constexpr std::size_t block_bytes = std::size_t{1} << 30;  // MPI counts with int

template <typename Byte, typename Visit>
void for_blocks(std::span<Byte> bytes, const Visit& visit) {
    for (std::size_t first = 0; first < bytes.size(); first += block_bytes)
        visit(bytes.data() + first, static_cast<int>(std::min(block_bytes, bytes.size() - first)));
}

class MpiTransfer : public core::Transfer {
public:
    void move_on() override {
        int all = 0;
        MPI_Testall(static_cast<int>(requests.size()), requests.data(), &all, MPI_STATUSES_IGNORE);
    }
    void finish() override { MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE); }

    std::vector<MPI_Request> requests;
};

class MpiCommunicator : public core::Communicator {
public:
    MpiCommunicator() {
        MPI_Comm_size(MPI_COMM_WORLD, &parts_);
        MPI_Comm_rank(MPI_COMM_WORLD, &part_);
    }
    [[nodiscard]] int parts() const override { return parts_; }
    [[nodiscard]] int part() const override { return part_; }

    [[nodiscard]] std::unique_ptr<core::Transfer> begin_exchange(const std::array<std::span<const std::byte>, 2>& to,
                                                                 const std::array<std::span<std::byte>, 2>& from) const override {
        const std::array<int, 2> beside{(part_ + parts_ - 1) % parts_, (part_ + 1) % parts_};
        auto transfer = std::make_unique<MpiTransfer>();
        std::vector<MPI_Request>& requests = transfer->requests;
        constexpr int downwards = 0, upwards = 1;
        for (std::size_t side = 0; side < 2; ++side)
            for_blocks(from[side], [&](std::byte* block, int size) {
                requests.emplace_back();
                MPI_Irecv(block, size, MPI_BYTE, beside[side], side == 0 ? upwards : downwards, MPI_COMM_WORLD, &requests.back());
            });
        for (std::size_t side = 0; side < 2; ++side)
            for_blocks(to[side], [&](const std::byte* block, int size) {
                requests.emplace_back();
                MPI_Isend(block, size, MPI_BYTE, beside[side], side == 0 ? downwards : upwards, MPI_COMM_WORLD, &requests.back());
            });
        return transfer;
    }

    [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> mine) const override {
        const auto count = static_cast<std::size_t>(parts_);
        const auto size = static_cast<unsigned long>(mine.size());
        std::vector<unsigned long> sizes(count);
        MPI_Allgather(&size, 1, MPI_UNSIGNED_LONG, sizes.data(), 1, MPI_UNSIGNED_LONG, MPI_COMM_WORLD);
        std::vector<Bytes> all(count);
        for (std::size_t part = 0; part < count; ++part) all[part].resize(sizes[part]);
        if (std::accumulate(sizes.begin(), sizes.end(), 0UL) < block_bytes) {
            gather_small(mine, all);
            return all;
        }
        std::copy(mine.begin(), mine.end(), all[static_cast<std::size_t>(part_)].begin());
        for (std::size_t part = 0; part < count; ++part)
            for_blocks(std::span(all[part]),
                       [&](std::byte* block, int length) { MPI_Bcast(block, length, MPI_BYTE, static_cast<int>(part), MPI_COMM_WORLD); });
        return all;
    }

    void in_turn(std::span<double> numbers, const std::function<void()>& add) const override {
        constexpr int tag = 2;
        const auto size = static_cast<int>(numbers.size());
        if (part_ > 0) MPI_Recv(numbers.data(), size, MPI_DOUBLE, part_ - 1, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        add();
        if (part_ + 1 < parts_) MPI_Send(numbers.data(), size, MPI_DOUBLE, part_ + 1, tag, MPI_COMM_WORLD);
        MPI_Bcast(numbers.data(), size, MPI_DOUBLE, parts_ - 1, MPI_COMM_WORLD);
    }

private:
    // In one call; `all` has the sizes.
    static void gather_small(std::span<const std::byte> mine, std::vector<Bytes>& all) {
        std::vector<int> sizes, places;
        int end = 0;
        for (const Bytes& of_part : all) {
            sizes.push_back(static_cast<int>(of_part.size()));
            places.push_back(end);
            end += sizes.back();
        }
        Bytes bytes(static_cast<std::size_t>(end));
        MPI_Allgatherv(mine.data(), static_cast<int>(mine.size()), MPI_BYTE, bytes.data(), sizes.data(), places.data(), MPI_BYTE,
                       MPI_COMM_WORLD);
        for (std::size_t part = 0; part < all.size(); ++part)
            std::copy_n(bytes.begin() + places[part], all[part].size(), all[part].begin());
    }
    int parts_ = 1, part_ = 0;
};

// Programs that a rank starts, as liggghts --version, would take themselves for this rank, and the launcher would take their end for its
// end.
void hide_launcher_from_children() {
    std::vector<std::string> names;
    for (char** variable = environ; *variable != nullptr; ++variable) {
        const std::string name = std::string(*variable).substr(0, std::string(*variable).find('='));
        const bool of_launcher = name.starts_with("OMPI_") || name.starts_with("PMIX_") || name.starts_with("PMI_");
        if (of_launcher && !name.starts_with("OMPI_ALLOW_RUN_AS_ROOT")) names.push_back(name);
    }
    for (const std::string& name : names) unsetenv(name.c_str());
}

std::unique_ptr<const MpiCommunicator>& world() {
    static std::unique_ptr<const MpiCommunicator> ranks;
    return ranks;
}

#endif

}  // namespace

#ifdef POREPACK_WITH_MPI

MpiRanks::MpiRanks() {
    if (!is_started_by_launcher()) return;
    int level = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &level);  // an error ends all ranks
    world() = std::make_unique<const MpiCommunicator>();
    hide_launcher_from_children();
    if (world()->parts() == 1) return;
    MPI_Comm here = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &here);
    int count = 1;
    MPI_Comm_size(here, &count);
    MPI_Comm_free(&here);
    core::set_ranks(*world(), count);
    const bool is_bound = core::usable_cores() < sysconf(_SC_NPROCESSORS_ONLN);  // by the launcher, to cores of its own
    if (std::getenv("OMP_NUM_THREADS") == nullptr && !is_bound)
        setenv("OMP_NUM_THREADS", std::to_string(std::max(1, core::usable_cores() / count)).c_str(), 1);
}

MpiRanks::~MpiRanks() {
    if (!world()) return;
    core::set_ranks(core::no_communicator(), 1);
    MPI_Finalize();
}

void end_all(int exit_code) {
    if (world() && world()->parts() > 1) MPI_Abort(MPI_COMM_WORLD, exit_code);
}

#else

MpiRanks::MpiRanks() {
    const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
    if (size != nullptr && std::atoi(size) > 1)
        throw core::EngineError("this porepack was built without MPI, and mpirun has started it several times",
                                {.fix = "start it once, or install libopenmpi-dev and build it again"});
}
MpiRanks::~MpiRanks() = default;
void end_all(int) {}

#endif

}  // namespace porepack::parallel
