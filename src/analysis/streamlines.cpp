#include "analysis/streamlines.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "analysis/uses.hpp"
#include "geometry/vector.hpp"

namespace porepack::analysis {
namespace {

// Trilinear between centres; the outermost cells reach to the faces of the image. None outside of it.
std::optional<Vec3> velocity_at(const FlowImage& flow, const Vec3& point) {
    const Grid& grid = flow.grid;
    std::array<std::array<int, 2>, 3> cells{};
    std::array<double, 3> part{};
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const double at = (point[a] - grid.origin_m[i]) / grid.spacing_m[i];
        if (!(at >= 0.0 && at <= grid.cells[i])) return std::nullopt;
        const int low = static_cast<int>(std::floor(at - 0.5));
        part[i] = at - 0.5 - low;
        cells[i] = {std::max(0, low), std::min(grid.cells[i] - 1, low + 1)};
    }
    Vec3 velocity = Vec3::Zero();
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        std::array<int, 3> at{};
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t far = corner >> i & 1U;
            at[i] = cells[i][far];
            weight *= far != 0 ? part[i] : 1.0 - part[i];
        }
        const float* const u = &flow.velocity_m_per_s[3 * grid.index(at[0], at[1], at[2])];
        velocity += weight * Vec3(u[0], u[1], u[2]);
    }
    return velocity;
}

// The centres of cells of the first layer that divide its flow rate into equal parts.
std::vector<Vec3> starts_of(const FlowImage& flow, int axis, std::size_t number) {
    const Grid& grid = flow.grid;
    const auto along = static_cast<std::size_t>(axis), right = (along + 1) % 3, up = (along + 2) % 3;
    std::vector<std::array<int, 3>> cells;
    std::vector<double> rate;  // up to and with this cell
    double sum = 0.0;
    for (int v = 0; v < grid.cells[up]; ++v)
        for (int u = 0; u < grid.cells[right]; ++u) {
            std::array<int, 3> at{};
            at[right] = u;
            at[up] = v;
            const double speed = flow.velocity_m_per_s[3 * grid.index(at[0], at[1], at[2]) + along];
            if (!(speed > 0.0)) continue;
            cells.push_back(at);
            rate.push_back(sum += speed);
        }
    std::vector<Vec3> starts;
    std::size_t cell = 0;
    for (std::size_t n = 0; n < number && !cells.empty(); ++n) {
        while (cell + 1 < cells.size() && rate[cell] < sum * (static_cast<double>(n) + 0.5) / static_cast<double>(number)) ++cell;
        const auto& [i, j, k] = cells[cell];
        starts.emplace_back(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
    }
    return starts;
}

}  // namespace

std::vector<Streamline> streamlines(const FlowImage& flow, int axis, std::size_t number) {
    constexpr int kept = 4;
    constexpr double step_cells = 0.4, resting = 1e-6;  // of the speed at the start
    const Grid& grid = flow.grid;
    const double step = step_cells * grid.spacing_m[2];
    const long most = 20L * std::lround((grid.cells[0] + grid.cells[1] + grid.cells[2]) / step_cells);
    std::vector<Streamline> lines;
    for (const Vec3& start : starts_of(flow, axis, number)) {
        Streamline line;
        Vec3 point = start;
        double first = 0.0;
        for (long n = 0; n < most; ++n) {
            const std::optional<Vec3> here = velocity_at(flow, point);
            if (!here || here->norm() <= resting * first) break;
            if (n == 0) first = here->norm();
            if (n % kept == 0) {
                line.points_m.push_back({point.x(), point.y(), point.z()});
                line.speeds_m_per_s.push_back(here->norm());
            }
            const std::optional<Vec3> half = velocity_at(flow, point + 0.5 * step * here->normalized());
            if (!half || half->norm() <= resting * first) break;
            point += step * half->normalized();
        }
        if (line.points_m.size() > 1) lines.push_back(std::move(line));
    }
    return lines;
}

}  // namespace porepack::analysis
