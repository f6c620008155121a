#include <algorithm>
#include <cmath>

#include "io/image.hpp"
#include "report/report.hpp"

namespace porepack::report {
using namespace core;
using namespace io;

namespace {

// Dark blue through green to yellow; nearly equal steps of lightness, so it prints well.
std::array<std::uint8_t, 3> colour(double t) {
    constexpr std::array<std::array<double, 3>, 5> stops = {
        {{0.27, 0.00, 0.33}, {0.23, 0.32, 0.55}, {0.13, 0.57, 0.55}, {0.37, 0.79, 0.38}, {0.99, 0.91, 0.14}}};
    const double place = std::clamp(t, 0.0, 1.0) * 4.0;
    const auto i = std::min<std::size_t>(3, static_cast<std::size_t>(place));
    std::array<std::uint8_t, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c)
        rgb[c] = static_cast<std::uint8_t>(
            std::lround(255.0 * (stops[i][c] + (place - static_cast<double>(i)) * (stops[i + 1][c] - stops[i][c]))));
    return rgb;
}

}  // namespace

double draw_speed_slice(const Path& flow_vti, const Path& png) {
    const FlowImage flow = read_flow_image(flow_vti);
    const int width = flow.grid.cells[0], height = flow.grid.cells[2], row = flow.grid.cells[1] / 2;
    std::vector<double> speed;
    for (int k = 0; k < height; ++k)
        for (int i = 0; i < width; ++i) {
            const float* u = &flow.velocity_m_per_s[3 * flow.grid.index(i, row, k)];
            speed.push_back(
                std::sqrt(static_cast<double>(u[0]) * u[0] + static_cast<double>(u[1]) * u[1] + static_cast<double>(u[2]) * u[2]));
        }
    // The scale ends at the 99.5th percentile: single fast cells must not darken the image.
    std::vector<double> sorted = speed;
    std::sort(sorted.begin(), sorted.end());
    const double top = std::max(1e-300, sorted[static_cast<std::size_t>(0.995 * static_cast<double>(sorted.size() - 1))]);
    const int zoom = std::max(1, 600 / std::max(width, height));
    std::vector<std::uint8_t> pixels;
    for (int k = 0; k < height * zoom; ++k)
        for (int i = 0; i < width * zoom; ++i) {
            const std::size_t cell = flow.grid.index(i / zoom, row, k / zoom);
            std::array<std::uint8_t, 3> rgb = colour(
                speed[static_cast<std::size_t>(k / zoom) * static_cast<std::size_t>(width) + static_cast<std::size_t>(i / zoom)] / top);
            if (!flow.phase.empty() && flow.phase[cell] == Phase::grain) rgb = {205, 190, 170};
            if (!flow.phase.empty() && flow.phase[cell] == Phase::outside) rgb = {255, 255, 255};
            pixels.insert(pixels.end(), rgb.begin(), rgb.end());
        }
    write_colour_png(png, width * zoom, height * zoom, pixels);
    return top;
}

}  // namespace porepack::report
