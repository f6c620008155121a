#include "core/process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <thread>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"

namespace porepack::inline core {
namespace {

std::atomic<double> peak_program_memory{0.0};

Path& host_porepack() {
    static Path program;
    return program;
}

// Runs in the child between fork and exec: only async-signal-safe calls.
[[noreturn]] void become(const Program& program, char* const* arguments, char* const* environment) {
    setpgid(0, 0);  // its own process group, so that it and its children can be stopped together
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    signal(SIGXFSZ, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    if (!program.log.empty()) {
        const int log = open(program.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
        if (log < 0 || dup2(log, 1) < 0 || dup2(log, 2) < 0) _exit(126);
    }
    const int nothing = open("/dev/null", O_RDONLY);
    if (nothing < 0 || dup2(nothing, 0) < 0 || chdir(program.folder.c_str()) != 0) _exit(126);
    execvpe(arguments[0], arguments, environment);
    _exit(127);
}

std::vector<std::string> merged_environment(const std::map<std::string, std::string>& added) {
    std::vector<std::string> all;
    for (char** entry = environ; *entry != nullptr; ++entry) {
        const std::string text(*entry);
        if (!added.contains(text.substr(0, text.find('=')))) all.push_back(text);
    }
    for (const auto& [name, value] : added) all.push_back(fmt::format("{}={}", name, value));
    return all;
}

std::vector<char*> as_pointers(std::vector<std::string>& texts) {
    std::vector<char*> pointers;
    pointers.reserve(texts.size() + 1);
    for (auto& text : texts) pointers.push_back(text.data());
    pointers.push_back(nullptr);
    return pointers;
}

// Kills the process group of a program when this process dies, even by SIGKILL: a shell waits for one byte on a pipe
// whose other end only this process holds.
class Guardian {
public:
    explicit Guardian(pid_t group) {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0) return;
        const std::string script = fmt::format("read word || kill -9 -{}", group);
        const char* arguments[] = {"sh", "-c", script.c_str(), nullptr};
        guardian_ = fork();
        if (guardian_ == 0) {
            setpgid(0, 0);
            dup2(ends[0], 0);
            const int nothing = open("/dev/null", O_WRONLY);
            dup2(nothing, 1);
            dup2(nothing, 2);
            execv("/bin/sh", const_cast<char* const*>(arguments));
            _exit(127);
        }
        close(ends[0]);
        pipe_ = ends[1];
    }
    ~Guardian() {
        if (pipe_ < 0) return;
        (void)!write(pipe_, "\n", 1);
        close(pipe_);
        if (guardian_ > 0) waitpid(guardian_, nullptr, 0);
    }
    Guardian(const Guardian&) = delete;
    Guardian& operator=(const Guardian&) = delete;

private:
    pid_t guardian_ = -1;
    int pipe_ = -1;
};

void end_group(pid_t child, const Program& program) {
    kill(-child, program.stop_signal);
    const Stopwatch watch;
    bool ended = false;
    while (!ended && watch.seconds() < program.stop_seconds) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        ended = waitpid(child, nullptr, WNOHANG) != 0;
    }
    kill(-child, SIGKILL);
    if (!ended) waitpid(child, nullptr, 0);
}

}  // namespace

ProgramEnd run_program(const Program& program) {
    auto command = program.command;
    auto environment = merged_environment(program.environment);
    auto arguments = as_pointers(command);
    auto variables = as_pointers(environment);
    const Stopwatch watch;
    Program absolute = program;
    if (!program.log.empty()) absolute.log = std::filesystem::absolute(program.log);
    const pid_t child = fork();
    if (child < 0) throw MachineError(std::string("cannot start another process: ") + std::strerror(errno));
    if (child == 0) become(absolute, arguments.data(), variables.data());

    setpgid(child, child);  // also in the parent: either process may run first
    const Guardian guardian(child);

    int status = 0;
    rusage usage{};
    auto pause = std::chrono::milliseconds(2);
    while (wait4(child, &status, WNOHANG, &usage) == 0) {
        std::this_thread::sleep_for(pause);
        pause = std::min(pause * 2, std::chrono::milliseconds(200));
        try {
            check_interrupt();
            if (program.while_running) program.while_running();
        } catch (...) {
            end_group(child, program);
            throw;
        }
    }
    ProgramEnd end{.wall_time_s = watch.seconds(), .peak_memory_bytes = 1024.0 * static_cast<double>(usage.ru_maxrss)};
    end.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    double before = peak_program_memory;
    while (end.peak_memory_bytes > before && !peak_program_memory.compare_exchange_weak(before, end.peak_memory_bytes)) {
    }
    if (end.exit_code == 126 || end.exit_code == 127)
        throw EngineError("cannot start " + program.command.front(),
                          {.where = program.folder.string(), .fix = "see `porepack --version` for the engines found"});
    return end;
}

double take_peak_program_memory_bytes() {
    return peak_program_memory.exchange(0.0);
}

std::optional<Path> find_program(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path == nullptr ? "" : path);
    for (std::string folder; std::getline(folders, folder, ':');) {
        const Path candidate = Path(folder) / name;
        if (access(candidate.c_str(), X_OK) == 0 && !std::filesystem::is_directory(candidate)) return candidate;
    }
    return std::nullopt;
}

void set_porepack_program(const Path& program) {
    host_porepack() = program;
}

std::optional<Path> porepack_program() {
    if (!host_porepack().empty()) return host_porepack();
    std::error_code none;
    const Path beside = std::filesystem::read_symlink("/proc/self/exe", none).parent_path() / "porepack";
    return std::filesystem::exists(beside) ? std::optional(beside) : find_program("porepack");
}

void require_program(const std::string& name, const std::string& package) {
    if (find_program(name)) return;
    throw EngineError(name + " is not installed (not on PATH)", {.fix = "apt-get install --no-install-recommends " + package});
}

std::string first_line_of(const std::string& shell_command) {
    FILE* pipe = popen(("cd /tmp && timeout 10 " + shell_command + " 2>/dev/null").c_str(), "r");
    if (pipe == nullptr) return {};
    std::array<char, 512> line{};
    std::string text = std::fgets(line.data(), line.size(), pipe) == nullptr ? "" : line.data();
    pclose(pipe);
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    return text;
}

}  // namespace porepack::inline core
