#include "core/machine.hpp"

#include <malloc.h>
#include <omp.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::inline core {
namespace {

double read_number(const char* path) {
    std::ifstream in(path);
    double value = -1.0;
    in >> value;
    return in ? value : -1.0;
}

}  // namespace

void require_stack() {
    constexpr rlim_t minimum = rlim_t{1} << 20U;
    rlimit stack{};
    if (getrlimit(RLIMIT_STACK, &stack) == 0 && stack.rlim_cur != RLIM_INFINITY && stack.rlim_cur < minimum)
        throw MachineError(fmt::format("the stack is limited to {}", human_bytes(static_cast<double>(stack.rlim_cur))),
                           {.allowed = "1 MB or more", .fix = "ulimit -s 8192"});
}

std::string host_name() {
    std::array<char, 256> name{};
    gethostname(name.data(), name.size() - 1);
    return name.data();
}

std::string processor_name() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    return "unknown";
}

double available_memory_bytes() {
    double available = 1e18;
    std::ifstream in("/proc/meminfo");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("MemAvailable:")) available = 1024.0 * std::stod(line.substr(13));
    const double limit = read_number("/sys/fs/cgroup/memory.max");
    const double used = read_number("/sys/fs/cgroup/memory.current");
    if (limit > 0.0 && used >= 0.0) available = std::min(available, limit - used);
    return available;
}

void return_large_blocks() {
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

double peak_memory_bytes() {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("VmHWM:")) return 1024.0 * std::stod(line.substr(6));
    return 0.0;
}

void reset_peak_memory() {
    malloc_trim(0);
    std::ofstream("/proc/self/clear_refs") << "5";
}

int thread_count() {
    return omp_get_max_threads();
}

int usable_cores() {
    cpu_set_t allowed;
    const int cores = sched_getaffinity(0, sizeof allowed, &allowed) == 0 ? CPU_COUNT(&allowed) : omp_get_num_procs();
    // The quota of the control group and of those above it: "quota period" in microseconds, or "max period".
    double quota = cores;
    std::ifstream in("/proc/self/cgroup");
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("0::/")) continue;
        const std::filesystem::path root = "/sys/fs/cgroup";
        for (std::filesystem::path group = line.substr(4);; group = group.parent_path()) {
            std::ifstream limit(root / group / "cpu.max");
            double used = 0.0, period = 0.0;
            if (limit >> used >> period && used > 0.0 && period > 0.0) quota = std::min(quota, used / period);
            if (group.empty()) break;
        }
    }
    return std::max(1, static_cast<int>(std::ceil(quota - 1e-9)));
}

void set_thread_count(int threads) {
    constexpr int max_threads = 1024;
    if (threads == 0 && std::getenv("OMP_NUM_THREADS") != nullptr) {
        threads = omp_get_max_threads();
        if (threads > max_threads)
            throw UserError(fmt::format("{} threads are too many", threads),
                            {.where = "OMP_NUM_THREADS", .allowed = fmt::format("1 to {}", max_threads), .fix = "unset it"});
    }
    omp_set_num_threads(threads > 0 ? threads : usable_cores());
}

double slowness() {
    static const double measured = [] {
        std::vector<double> values(20'000'000, 1.0);
        double best = std::numeric_limits<double>::infinity();
        for (int round = 0; round < 4; ++round) {
            const Stopwatch watch;
#pragma omp parallel for schedule(static)
            for (std::size_t i = 0; i < values.size(); ++i) values[i] *= 1.0000001;
            best = std::min(best, watch.seconds());
        }
        constexpr double reference_bytes_per_second = 6.5e10;
        return reference_bytes_per_second * best / (2.0 * sizeof(double) * static_cast<double>(values.size()));
    }();
    return measured;
}

void require_memory(double bytes, const std::string& what, const std::string& fix) {
    const double available = available_memory_bytes();
    if (bytes < 0.95 * available) return;
    throw UserError(fmt::format("{} needs {}, and this machine has {} free", what, human_bytes(bytes), human_bytes(available)),
                    {.fix = fix});
}

}  // namespace porepack::inline core
