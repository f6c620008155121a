// A simulated falling-head test, recorded frame by frame.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <random>

#include "core/error.hpp"
#include "falling_head/causes.hpp"

namespace porepack::falling_head {

LevelCurve simulate_curve(const Resistance& resistance, const FallingHeadConfig& config) {
    const Column column(config);
    const double bottom = 0.9 * std::min(config.window_m[0], config.window_m[1]);
    const double slowest = column.steady_speed(resistance, bottom);
    if (!(slowest > 0.0))
        throw UserError("the water level does not fall to the end of the window",
                        {.fix = "check window_m, level_offset_m and sample_length_m (metres)"});
    // Long enough: the time at the slowest speed throughout, doubled for the start from rest.
    const double longest = 2.0 * (config.start_level_m - bottom) / slowest + 2.0;
    if (longest * config.frames_per_s > 5e7)
        throw UserError(fmt::format("the test takes up to {:.3g} s: too many frames", longest),
                        {.fix = "lower frames_per_s, or check k and k_in: SI units"});
    LevelCurve curve{.name = "simulated", .packing = {}, .time_s = {}, .level_m = {}};
    const auto frames = static_cast<std::size_t>(longest * config.frames_per_s) + 2;
    curve.time_s.reserve(frames);
    for (std::size_t i = 0; i < frames; ++i) curve.time_s.push_back(static_cast<double>(i) / config.frames_per_s);
    curve.level_m = column.levels(resistance, 0.0, config.start_level_m, 0.0, curve.time_s);
    const auto past = std::find_if(curve.level_m.begin(), curve.level_m.end(), [&](double level) { return level < bottom; });
    curve.level_m.erase(past, curve.level_m.end());
    curve.time_s.resize(curve.level_m.size());
    if (config.noise_m > 0.0) {
        std::mt19937_64 random(static_cast<std::uint64_t>(config.seed));
        std::normal_distribution<double> noise(0.0, config.noise_m);
        for (double& level : curve.level_m) level += noise(random);
    }
    return curve;
}

}  // namespace porepack::falling_head
