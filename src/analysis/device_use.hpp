// What a flow needs of the device that is to compute it.
#pragma once

#include <string>

#include "lbm/domain.hpp"

namespace porepack::analysis {

/// Empty for "cpu"; else in words, for the text of an expectation. UserError where there is no such device, MachineError, with the numbers
/// and the seconds of the processor, where its memory is too small.
[[nodiscard]] std::string use_of_device(const std::string& device, const lbm::RunSize& size, double seconds_of_processor);
/// ", by opencl:0 (its name)", or empty for "cpu".
[[nodiscard]] std::string by_device(const std::string& device);

}  // namespace porepack::analysis
