#include "analysis/device_use.hpp"

#include <fmt/format.h>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "devices/device.hpp"

namespace porepack::analysis {

std::string use_of_device(const std::string& device, const RunSize& size, double seconds_of_processor) {
    if (device == "cpu") return "";
    const devices::DeviceInfo info = devices::open_device(device)->info();
    const double bytes = lbm_device_bytes(size);
    if (bytes > info.memory_bytes)
        throw MachineError(fmt::format("the flow needs {} of the memory of {} ({}), which has {}", human_bytes(bytes), info.id, info.name,
                                       human_bytes(info.memory_bytes)),
                           {.fix = fmt::format("a larger voxel size{}, or --device cpu: {}, some {:.2g} h",
                                               size.bytes_per_number < 8.0 ? "" : ", precision = \"single\"",
                                               human_bytes(lbm_memory_bytes(size)), seconds_of_processor / 3600.0)});
    return fmt::format("; of the {} of {} ({}), {}; the time is that of the processor", human_bytes(info.memory_bytes), info.id, info.name,
                       human_bytes(bytes));
}

std::string by_device(const std::string& device) {
    if (device == "cpu") return "";
    const devices::DeviceInfo info = devices::open_device(device)->info();
    return fmt::format(", by {} ({})", info.id, info.name);
}

}  // namespace porepack::analysis
