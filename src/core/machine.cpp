#include "core/machine.hpp"

#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>

#include "core/error.hpp"
#include "core/log.hpp"

namespace porepack::core {
namespace {

double read_number(const char* path) {
    std::ifstream in(path);
    double value = -1.0;
    in >> value;
    return in ? value : -1.0;
}

}  // namespace

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

double peak_memory_bytes() {
    std::ifstream in("/proc/self/status");
    for (std::string line; std::getline(in, line);)
        if (line.starts_with("VmHWM:")) return 1024.0 * std::stod(line.substr(6));
    return 0.0;
}

void reset_peak_memory() {
    std::ofstream("/proc/self/clear_refs") << "5";
}

int thread_count() {
    return omp_get_max_threads();
}

void set_thread_count(int threads) {
    if (threads > 0) omp_set_num_threads(threads);
}

void require_memory(double bytes, const std::string& what, const std::string& fix) {
    const double available = available_memory_bytes();
    if (bytes < 0.95 * available) return;
    throw UserError(fmt::format("{} needs {}, and this machine has {} free", what, human_bytes(bytes), human_bytes(available)),
                    {.fix = fix});
}

}  // namespace porepack::core
