#include "pipeline/run_ranks.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "core/process.hpp"
#include "core/throw_as.hpp"

namespace porepack::pipeline {
namespace fs = std::filesystem;
namespace {

constexpr const char* file_of_error = "POREPACK_FILE_OF_ERROR";

// The error of a rank, in another process, with its exit code and its text.
[[noreturn]] void throw_error_of(const Path& file) {
    const Json told = read_json(file);
    throw_as(static_cast<ExitCode>(told.at("exit_code").get<int>()), told.at("error").get<std::string>());
}

// Removed at the end.
struct ErrorFile {
    explicit ErrorFile(Path file) : path(std::move(file)) {}
    ~ErrorFile() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
    ErrorFile(const ErrorFile&) = delete;
    ErrorFile& operator=(const ErrorFile&) = delete;
    const Path path;
};

std::map<std::string, std::string> environment_of(long ranks, const Path& error) {
    std::map<std::string, std::string> environment = {{file_of_error, error.string()}};
    // mpirun looks for devices of OpenCL, and a driver made with LLVM then takes the signals that mpirun would pass on.
    if (std::getenv("HWLOC_COMPONENTS") == nullptr) environment["HWLOC_COMPONENTS"] = "-opencl";
    if (geteuid() == 0)  // as in containers
        environment.insert({{"OMPI_ALLOW_RUN_AS_ROOT", "1"}, {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"}});
    if (std::getenv("OMP_NUM_THREADS") == nullptr && thread_count() < usable_cores())
        environment["OMP_NUM_THREADS"] = std::to_string(std::max(1L, thread_count() / ranks));
    return environment;
}

}  // namespace

void run_ranks(long ranks, const std::vector<std::string>& arguments, const Path& folder) {
    require_program("mpirun", "openmpi-bin");
    const std::optional<Path> program = porepack_program();
    if (!program) throw EngineError("the program porepack is not found", {.fix = "put it on PATH"});
    const ErrorFile error(fs::absolute(folder) / fmt::format(".ranks.{}.error.json", getpid()));
    std::vector<std::string> command = {"mpirun",      "--quiet", "--oversubscribe",     "--bind-to",      "none", "-x",
                                        file_of_error, "-np",     std::to_string(ranks), program->string()};
    command.insert(command.end(), arguments.begin(), arguments.end());
    constexpr double seconds_to_write = 600.0;
    const ProgramEnd end = run_program(
        {.command = command, .environment = environment_of(ranks, error.path), .stop_signal = SIGUSR1, .stop_seconds = seconds_to_write});
    if (fs::exists(error.path)) throw_error_of(error.path);
    if (end.exit_code != 0)
        throw MachineError(fmt::format("one of the {} ranks has ended without a message (exit code {} of mpirun)", ranks, end.exit_code),
                           {.fix = "was its memory too small, or was it killed? --dry-run shows the memory of a rank"});
}

bool tell_starter(const std::string& message, int exit_code) {
    const char* const file = std::getenv(file_of_error);
    if (file == nullptr) return false;
    try {
        if (!fs::exists(file)) write_json(file, {{"error", message}, {"exit_code", exit_code}});
    } catch (const std::exception&) {
        return false;  // a full disk, for one
    }
    return true;
}

}  // namespace porepack::pipeline
