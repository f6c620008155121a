#include "falling_head/simulated_noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace porepack::falling_head {
namespace {

std::vector<double> white(std::size_t count, NoiseSource& random) {
    std::normal_distribution<double> normal;
    std::vector<double> values(count);
    for (double& value : values) value = normal(random);
    return values;
}

// Of unit variance.
std::vector<double> autoregressive(double a, double b, std::size_t count, NoiseSource& random) {
    constexpr std::size_t settling = 3000;  // 15 correlation times of the slowest that is used
    std::vector<double> x = white(count + settling, random);
    for (std::size_t i = 2; i < x.size(); ++i) x[i] += a * x[i - 1] + b * x[i - 2];
    x.erase(x.begin(), x.begin() + settling);
    const double variance = (1.0 - b) / ((1.0 + b) * ((1.0 - b) * (1.0 - b) - a * a));
    for (double& value : x) value /= std::sqrt(variance);
    return x;
}

}  // namespace

Noise correlated_noise(double deviation_m, std::vector<AutoregressivePart> parts) {
    return [=](std::size_t frames, NoiseSource& random) {
        double left = 1.0;
        for (const AutoregressivePart& part : parts) left -= part.share;
        std::vector<double> noise = white(frames, random);
        for (double& value : noise) value *= deviation_m * std::sqrt(std::max(0.0, left));
        for (const AutoregressivePart& part : parts) {
            const std::vector<double> slow = autoregressive(part.a, part.b, frames, random);
            for (std::size_t i = 0; i < frames; ++i) noise[i] += deviation_m * std::sqrt(part.share) * slow[i];
        }
        return noise;
    };
}

std::vector<LevelCurve> noisy_runs(const LevelCurve& exact, const Noise& noise, std::size_t runs, NoiseSource& random,
                                   const FallingHeadConfig& config, double pixel_m) {
    std::vector<LevelCurve> curves;
    for (std::size_t run = 0; run < runs; ++run) {
        LevelCurve curve = exact;
        const std::vector<double> errors = noise(curve.level_m.size(), random);
        for (std::size_t i = 0; i < errors.size(); ++i) {
            curve.level_m[i] += errors[i];
            if (pixel_m > 0.0) curve.level_m[i] = pixel_m * std::round(curve.level_m[i] / pixel_m);
        }
        curves.push_back(take_window(curve, config));
    }
    return curves;
}

}  // namespace porepack::falling_head
