#include "devices/device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <optional>
#include <utility>

#include "devices/cuda.hpp"
#include "devices/opencl.hpp"

namespace porepack::devices {

extern const std::string_view copy_text;
#ifdef POREPACK_WITH_CUDA
extern "C" const char porepack_ptx_copy[];
#endif

namespace {

#ifdef POREPACK_WITH_CUDA
constexpr const char* ptx_of_copy = porepack_ptx_copy;
#else
constexpr const char* ptx_of_copy = nullptr;
#endif

// The number of "opencl:3".
std::optional<std::size_t> number_of(std::string_view id, std::string_view kind) {
    if (!id.starts_with(kind)) return std::nullopt;
    id.remove_prefix(kind.size());
    std::size_t number = 0;
    const auto [end, fault] = std::from_chars(id.data(), id.data() + id.size(), number);
    if (fault != std::errc() || end != id.data() + id.size()) return std::nullopt;
    return number;
}

std::string list_of(const std::vector<DeviceInfo>& devices) {
    std::string list = "cpu";
    for (const DeviceInfo& device : devices) list += fmt::format(", {} ({})", device.id, device.name);
    return list;
}

}  // namespace

std::vector<DeviceInfo> find_devices() {
    std::vector<DeviceInfo> all = cuda::find_devices();
    for (DeviceInfo& one : opencl::find_devices()) all.push_back(std::move(one));
    return all;
}

bool is_device_name(const std::string& id) {
    return id == "cpu" || id == "gpu" || number_of(id, "opencl:") || number_of(id, "cuda:");
}

std::shared_ptr<Device> open_device(const std::string& id) {
    if (!is_device_name(id))
        throw UserError(fmt::format("\"{}\" is not the name of a device", id),
                        {.allowed = "cpu, gpu, cuda:0, opencl:0, opencl:1, ...", .fix = "porepack devices lists what there is"});
    const std::vector<DeviceInfo> all = find_devices();
    std::string wanted = id;
    if (id == "gpu") {
        const auto card = std::find_if(all.begin(), all.end(), [](const DeviceInfo& device) { return device.graphics; });
        if (card == all.end())
            throw UserError("this machine has no graphics card that the program can use",
                            {.allowed = list_of(all), .fix = "install the driver of the card with its OpenCL library (docs/gpu.md)"});
        wanted = card->id;
    }
    if (const auto number = number_of(wanted, "cuda:"))
        if (auto device = cuda::open_device(*number)) return device;
    if (const auto number = number_of(wanted, "opencl:"))
        if (auto device = opencl::open_device(*number)) return device;
    throw UserError(fmt::format("there is no device \"{}\"", id), {.allowed = list_of(all), .fix = "porepack devices lists what there is"});
}

double copy_bandwidth(Device& device) {
    const double room = std::min(0.2 * device.info().memory_bytes, device.info().largest_buffer_bytes);
    const auto bytes = static_cast<std::size_t>(std::min(room, device.info().graphics ? 2e9 : 1e8)) / 4096 * 4096;
    const auto from = device.allocate(bytes), to = device.allocate(bytes);
    device.fill_with_zeros(*from);
    const std::string text = std::string(kernel_language) + std::string(copy_text);
    const auto program = device.compile({.text = text, .definitions = {}, .ptx = ptx_of_copy});
    const std::array<Argument, 3> arguments = {Argument(*from), Argument(*to),
                                               Argument(static_cast<std::uint64_t>(bytes / sizeof(double)))};
    double best = 0.0;
    for (int trial = 0; trial < 6; ++trial) {  // the first one compiles, and touches the memory
        const auto begin = std::chrono::steady_clock::now();
        device.run(*program, "copy", 4096, 256, arguments);
        device.finish();
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        best = std::max(best, 2.0 * static_cast<double>(bytes) / seconds);
    }
    return best;
}

}  // namespace porepack::devices
