#include "core/own_process.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <new>

#include "core/error.hpp"
#include "core/interrupt.hpp"

namespace porepack::inline core {
namespace {

void write_all(int file, std::string_view text) {
    while (!text.empty()) {
        const ssize_t count = write(file, text.data(), text.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return;
        text.remove_prefix(static_cast<std::size_t>(count));
    }
}

// The first character says what follows: 'r' a result, '2' to '5' the message of an error of that code.
std::string answer_of(const std::function<std::string()>& work) {
    try {
        return "r" + work();
    } catch (const Error& error) {
        return std::to_string(static_cast<int>(error.code())) + error.what();
    } catch (const std::bad_alloc&) {
        return std::to_string(static_cast<int>(ExitCode::machine)) + "out of memory";
    }
}

[[noreturn]] void be_the_copy(int answer, const std::function<std::string()>& work, double max_processor_seconds) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const int number : {SIGINT, SIGTERM, SIGABRT, SIGSEGV, SIGXCPU}) signal(number, SIG_DFL);
    const rlimit none{0, 0}, time{static_cast<rlim_t>(max_processor_seconds), static_cast<rlim_t>(max_processor_seconds) + 1};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &time);
    const int nothing = open("/dev/null", O_RDWR);
    dup2(nothing, 1);
    dup2(nothing, 2);
    std::string text;
    try {
        text = answer_of(work);
    } catch (...) {  // of the library: as if it had crashed
    }
    write_all(answer, text);
    _exit(0);
}

}  // namespace

SharedBytes::SharedBytes(std::size_t size) : size_(size) {
    void* const data = mmap(nullptr, std::max<std::size_t>(size, 1), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED) throw std::bad_alloc();
    data_ = static_cast<char*>(data);
}

SharedBytes::~SharedBytes() {
    munmap(data_, std::max<std::size_t>(size_, 1));
}

std::string in_own_process(const std::function<std::string()>& work, const std::function<std::string()>& what,
                           double max_processor_seconds) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw MachineError(std::string("cannot start another process: ") + std::strerror(errno));
    const pid_t copy = fork();
    if (copy < 0) {
        close(ends[0]);
        close(ends[1]);
        throw MachineError(std::string("cannot start another process: ") + std::strerror(errno));
    }
    if (copy == 0) be_the_copy(ends[1], work, max_processor_seconds);
    close(ends[1]);
    std::string answer;
    char part[4096];
    for (ssize_t count = 0; (count = read(ends[0], part, sizeof part)) != 0;) {
        if (count > 0)
            answer.append(part, static_cast<std::size_t>(count));
        else if (errno != EINTR || interrupted())
            break;
    }
    close(ends[0]);
    if (interrupted()) kill(copy, SIGKILL);
    int status = 0;
    while (waitpid(copy, &status, 0) < 0 && errno == EINTR) {
    }
    check_interrupt();
    if (answer.empty() || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw UserError(what(), {.fix = "the file may be incomplete or damaged: write it again"});
    const std::string text = answer.substr(1);
    switch (answer.front()) {
        case 'r':
            return text;
        case '2':
            throw UserError(text);
        case '3':
            throw NumericalError(text);
        case '4':
            throw EngineError(text);
        default:
            throw MachineError(text);
    }
}

}  // namespace porepack::inline core
