// Table [falling_head] of case.toml.
#pragma once

#include "core/config.hpp"

namespace porepack {

struct FallingHeadConfig {
    double sample_length_m = 0.12;
    double start_level_m = 1.6;
    std::vector<double> levels_m = {1.3, 0.7, 0.1};
    double kinematic_viscosity_m2_per_s = 1e-6;
    double gravity_m_per_s2 = 9.81;
};

inline void describe(ConfigVisitor& v, FallingHeadConfig& c) {
    v.number("sample_length_m", c.sample_length_m, length(), "length of the sample, L of Eq. 18");
    v.number("start_level_m", c.start_level_m, length(), "water level above the sample at time 0");
    v.numbers("levels_m", c.levels_m, {1, 1000}, not_negative(), "levels whose times are asked for");
    v.number("kinematic_viscosity_m2_per_s", c.kinematic_viscosity_m2_per_s, positive(), "of the liquid");
    v.number("gravity_m_per_s2", c.gravity_m_per_s2, positive(), "gravity");
}

}  // namespace porepack
