// Noise of measured levels whose frames are correlated, for tests and benchmarks of the fit's intervals.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "falling_head/level_curve.hpp"

namespace porepack::falling_head {

using NoiseSource = std::mt19937_64;
/// Metres, of this number of frames.
using Noise = std::function<std::vector<double>(std::size_t frames, NoiseSource& random)>;

/// x_i = a x_{i-1} + b x_{i-2} + white noise; its variance is `share` of that of the whole noise.
struct AutoregressivePart {
    double share, a, b = 0.0;
};
/// Of this standard deviation; what the parts leave of the variance is white.
[[nodiscard]] Noise correlated_noise(double deviation_m, std::vector<AutoregressivePart> parts);

/// The windows of `runs` records of the exact curve. Levels are rounded to multiples of `pixel_m`, if it is positive.
[[nodiscard]] std::vector<LevelCurve> noisy_runs(const LevelCurve& exact, const Noise& noise, std::size_t runs, NoiseSource& random,
                                                 const FallingHeadConfig& config, double pixel_m = 0.0);

}  // namespace porepack::falling_head
