// The slice through the speed of the flow, as a picture with axes and a colour bar.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "io/image.hpp"
#include "report/plot.hpp"
#include "report/report.hpp"
#include "report/uses.hpp"

namespace porepack::report {

bool draw_speed_slice(const Path& flow_vti, const Path& folder) {
    const FlowImage flow = read_flow_image(flow_vti);
    const int width = flow.grid.cells[0], height = flow.grid.cells[2], row = flow.grid.cells[1] / 2;
    std::vector<float> speeds;
    std::vector<std::uint8_t> solid;  // colours of the cells without flow; transparent elsewhere
    for (int k = 0; k < height; ++k)
        for (int i = 0; i < width; ++i) {
            const std::size_t cell = flow.grid.index(i, row, k);
            const float* u = &flow.velocity_m_per_s[3 * cell];
            speeds.push_back(std::hypot(u[0], u[1], u[2]));
            const std::uint8_t phase = flow.phase.empty() ? Phase::pore : flow.phase[cell];
            std::array<std::uint8_t, 4> rgba = {0, 0, 0, 0};
            if (phase == Phase::grain) rgba = {205, 190, 170, 255};
            if (phase == Phase::outside) rgba = {255, 255, 255, 255};
            solid.insert(solid.end(), rgba.begin(), rgba.end());
        }
    // The scale ends at the 99.5th percentile: single fast cells must not darken the image.
    std::vector<float> sorted = speeds;
    std::sort(sorted.begin(), sorted.end());
    const double top =
        std::max(1e-30, static_cast<double>(sorted[static_cast<std::size_t>(0.995 * static_cast<double>(sorted.size() - 1))]));
    write_text(folder / "speed.bin", std::string(reinterpret_cast<const char*>(speeds.data()), sizeof(float) * speeds.size()));
    write_text(folder / "speed_solid.bin", std::string(solid.begin(), solid.end()));
    const double dx = flow.grid.spacing_m[0], dz = flow.grid.spacing_m[2], shown = 480.0 / std::max(width * dx, height * dz);
    return draw_plot(folder / "speed.png", "speed",
                     {{"columns", static_cast<double>(width)},
                      {"rows", static_cast<double>(height)},
                      {"dx", 1e3 * dx},
                      {"dz", 1e3 * dz},
                      {"x0", 1e3 * flow.grid.origin_m[0]},
                      {"z0", 1e3 * flow.grid.origin_m[2]},
                      {"top", top}},
                     {.width = 230 + static_cast<int>(shown * width * dx), .height = 70 + static_cast<int>(shown * height * dz)});
}

}  // namespace porepack::report
