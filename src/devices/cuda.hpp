// Devices of CUDA, through the library of NVIDIA's driver, libcuda.so.1. Their kernels are compiled with the program, where nvcc was there.
#pragma once

#include <memory>
#include <vector>

#include "devices/device.hpp"

namespace porepack::devices::cuda {

/// Empty where there is no driver, or the program has no kernels for CUDA.
[[nodiscard]] std::vector<DeviceInfo> find_devices();
[[nodiscard]] std::shared_ptr<Device> open_device(std::size_t number);

}  // namespace porepack::devices::cuda
