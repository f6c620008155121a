// A scan of a solid that is known exactly, for tests and measurements: partial volumes, blur and white noise, nothing else.
#pragma once

#include <optional>

#include "pore_space/gray_solid.hpp"

namespace porepack::test {

struct ScanSettings {
    double blur_voxels = 0.0;  ///< standard deviation of the point spread function
    double noise = 0.0;        ///< standard deviation, over the contrast
    unsigned seed = 1;
    bool tube = false;                          ///< a cylinder's wall attenuates like the grains, and the image shows 6 voxels of it
    std::optional<packing::Section> part = {};  ///< of the height; the image starts at its lower plane
};
/// `tube`: solid outside a cylinder. The container from low() to high() in cubic voxels of about this size, changed so that a periodic box
/// is a whole number of voxels. Solid fractions are exact along z, and on 4 x 4 lines per voxel.
[[nodiscard]] geometry::GrayImage simulated_scan(const geometry::Solid& solid, const vessels::Container& container, double voxel_size_m,
                                                 const ScanSettings& settings);

}  // namespace porepack::test
