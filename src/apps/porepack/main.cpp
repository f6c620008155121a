// The program `porepack`.
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <thread>

#include "apps/porepack/command_line.hpp"
#include "core/communicator.hpp"
#include "core/error.hpp"
#include "core/escape.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "core/passive_waiting.hpp"
#include "parallel/mpi_ranks.hpp"
#include "pipeline/run_ranks.hpp"

namespace {

int report(const std::string& message, porepack::core::ExitCode code) {
    const int rank = porepack::core::ranks().part();
    // What all ranks meet is told by the first, which ends the others.
    if (rank > 0) std::this_thread::sleep_for(std::chrono::seconds(2));
    const std::string where = rank > 0 ? fmt::format("rank {}: ", rank) : "";
    if (!porepack::pipeline::tell_starter(where + message, static_cast<int>(code))) {
        const std::string line = fmt::format("error: {}{}\n", where, porepack::core::for_terminal(message));
        (void)std::fwrite(line.data(), 1, line.size(), stderr);  // a log that cannot be written is not an error
    }
    porepack::parallel::end_all(static_cast<int>(code));
    return static_cast<int>(code);
}

}  // namespace

int main(int argc, char** argv) {
    using porepack::core::ExitCode;
    using porepack::core::with_advice;
    // MPI, in the engines and in mpirun, looks for devices of OpenCL by hwloc. A driver made with LLVM then takes the signals that mpirun
    // would pass on, and writes into its cache.
    (void)setenv("HWLOC_COMPONENTS", "-opencl", 0);
    porepack::core::wait_passively(argv);
    porepack::core::return_large_blocks();
    porepack::core::install_signal_handlers();
    std::optional<porepack::parallel::MpiRanks> ranks;  // outlives what is caught below: ending MPI waits for all ranks
    try {
        ranks.emplace();
        porepack::core::require_stack();
        return porepack::apps::CommandLine().run(argc, argv);
    } catch (const porepack::core::Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report(with_advice("out of memory", {.fix = "use a larger voxel size or a shorter section"}), ExitCode::machine);
    } catch (const std::filesystem::filesystem_error& fault) {
        return report(with_advice(fmt::format("cannot use {}: {}", fault.path1().string(), fault.code().message()),
                                  {.fix = "check the path, its permissions and the free space"}),
                      ExitCode::machine);
    } catch (const nlohmann::json::exception& fault) {
        return report(with_advice(fmt::format("a result that was read has not the expected content: {}", fault.what()),
                                  {.fix = "if a file of the results was edited, remove it and run the command again"}),
                      ExitCode::user);
    } catch (const std::exception& fault) {
        return report(with_advice(fmt::format("unexpected: {}", fault.what()), {.fix = "report it, with the command and its input"}),
                      ExitCode::machine);
    }
}
