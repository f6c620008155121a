// A scan by X-rays of grains that are known exactly: projections of the grains in their tube, and the image that is computed from them.
#pragma once

#include <vector>

#include "geometry/grid.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"
#include "record/config.hpp"

namespace porepack::scans {

struct ScannerConfig {
    double voxel_size_m = 0.0;
    long views = 0;
    double counts = 2e4;
    double blur_voxels = 0.5;
    double gain_error = 0.002;
    double tube_wall_m = 0.005;
    double tube_attenuation = 1.1;
    double thickness_attenuation = 3.0;
    bool one_energy = false;
    double tilt_deg = 0.0;
    long seed = 1;
};
inline void describe(record::ConfigVisitor& v, ScannerConfig& c) {
    v.number("voxel_size_m", c.voxel_size_m, record::length_range(), "edge length of the voxels and of the detector's pixels");
    v.integer(
        "views", c.views, {.low = 0, .high = 20000, .zero_is_auto = true},
        "number of projections over 180 degrees; auto: 1.6 for each pixel of a detector row, by which views do not limit the resolution");
    v.number("counts", c.counts, {.low = 0.0, .high = 1e9},
             "photons per pixel and view without an object, which set the noise; 0: no noise");
    v.number("blur_voxels", c.blur_voxels, record::between(0.0, 5.0), "standard deviation of the detector's point spread function");
    v.number("gain_error", c.gain_error, record::between(0.0, 0.1), "standard deviation of the pixels' gains, which make rings; relative");
    v.number("tube_wall_m", c.tube_wall_m, record::between(0.0, 1.0), "thickness of a cylinder's wall; 0: no tube");
    v.number("tube_attenuation", c.tube_attenuation, record::between(0.0, 100.0), "attenuation of the tube over that of the grains");
    v.number("thickness_attenuation", c.thickness_attenuation, record::between(0.01, 20.0),
             "attenuation coefficient of the grains times the width of the container");
    v.boolean("one_energy", c.one_energy, "photons of one energy: no beam hardening; else three, as of a tube with 100 to 160 kV");
    v.number("tilt_deg", c.tilt_deg, record::between(-20.0, 20.0), "angle between the packing's axis and that of the scanner");
    v.integer("seed", c.seed, record::between(0, 2147483647), "of the noise");
}

/// Attenuation coefficients in 1/m, computed from the projections.
struct SimulatedScan {
    geometry::Grid grid;        ///< in the container's frame, except for the tilt
    std::vector<float> values;  ///< x fastest
};

/// Parallel beams across the axis, over 180 degrees. Each projection: exact chords through the grains and the tube on 2 x 2 rays per pixel,
/// attenuation at three energies, blur, Poisson counts, gains of the pixels; then filtered back projection (Ramachandran &
/// Lakshminarayanan 1971) of each layer. `part` of the height; the image is as wide as the tube. Throws UserError for a periodic
/// container, and MachineError without memory.
[[nodiscard]] SimulatedScan scan_packing(const packing::Packing& packing, const packing::Section& part, const ScannerConfig& config);
/// Memory that it needs, of which 4 bytes per voxel are the image.
[[nodiscard]] double scan_memory_bytes(const vessels::Container& container, const packing::Section& part, const ScannerConfig& config);

}  // namespace porepack::scans
