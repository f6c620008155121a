// Devices of OpenCL, through libOpenCL.so.1.
#pragma once

#include <memory>
#include <vector>

#include "devices/device.hpp"

namespace porepack::devices::opencl {

/// Empty where there is no library, or no driver.
[[nodiscard]] std::vector<DeviceInfo> find_devices();
[[nodiscard]] std::shared_ptr<Device> open_device(std::size_t number);

}  // namespace porepack::devices::opencl
