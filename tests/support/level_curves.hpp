// Falling-head curves of the paper's sample, simulated.
#pragma once

#include <random>
#include <vector>

#include "falling_head/column.hpp"
#include "falling_head/level_curve.hpp"

namespace porepack::test {

using namespace falling_head;

inline constexpr double k_053 = 8.931320185e-7, k_in_053 = 3.873579470e-3;  // the paper's permeability, Ergun's inertial permeability
inline const Resistance paper_053{1.0 / k_053, 1.0 / k_in_053};

inline std::vector<double> frames(double end, double rate = 50.0) {
    std::vector<double> times;
    for (int i = 0; i / rate <= end; ++i) times.push_back(i / rate);
    return times;
}

// From rest at 1.6 m, with the time resolution of the camera.
inline LevelCurve simulated(const Resistance& resistance, const FallingHeadConfig& config, double noise_m, unsigned seed,
                            double end = 6.0) {
    const std::vector<double> times = frames(end, config.frames_per_s);
    LevelCurve curve{.name = "simulated",
                     .packing = {},
                     .time_s = times,
                     .level_m = Column(config).levels(resistance, 0.0, config.start_level_m, 0.0, times)};
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, noise_m > 0.0 ? noise_m : 1.0);
    if (noise_m > 0.0)
        for (double& level : curve.level_m) level += noise(random);
    return curve;
}

}  // namespace porepack::test
