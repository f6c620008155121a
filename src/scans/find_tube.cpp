#include "scans/find_tube.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/median.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

// Solid fractions, averaged over all layers.
struct Projection {
    int width = 0, height = 0;
    std::vector<double> mean;
    [[nodiscard]] double at(double x, double y) const {  // bilinear between the centres of the pixels
        const double u = std::clamp(x - 0.5, 0.0, width - 1.0), v = std::clamp(y - 0.5, 0.0, height - 1.0);
        const int i = std::min(static_cast<int>(u), width - 2), j = std::min(static_cast<int>(v), height - 2);
        const auto value = [&](int a, int b) { return mean[static_cast<std::size_t>(b * width + a)]; };
        const double p = u - i, q = v - j;
        return (1 - q) * ((1 - p) * value(i, j) + p * value(i + 1, j)) + q * ((1 - p) * value(i, j + 1) + p * value(i + 1, j + 1));
    }
};

Projection project(const VolumeSource& source, const GrayLevels& levels, const std::vector<std::uint8_t>& explained) {
    const VolumeHeader& header = source.header;
    Projection projection{.width = static_cast<int>(header.voxels[0]), .height = static_cast<int>(header.voxels[1])};
    projection.mean.assign(static_cast<std::size_t>(header.layer()), 0.0);
    std::vector<float> layer(projection.mean.size());
    for (std::int64_t z = 0; z < header.voxels[2]; ++z) {
        source.read(z, layer);
        const std::size_t first = static_cast<std::size_t>(z) * layer.size();
        for (std::size_t i = 0; i < layer.size(); ++i) {
            const double grains = explained.empty() ? 0.0 : explained[first + i] / 255.0;
            projection.mean[i] += (levels.fraction(layer[i]) - grains) / static_cast<double>(header.voxels[2]);
        }
    }
    return projection;
}

struct Edge {
    double x, y;
};

// Along a ray from outside: the tube is where the mean is above 0.75; its inner edge is half-way to the smallest value
// behind it, or to 0 where the tube is empty.
std::optional<Edge> edge_on_ray(const Projection& projection, double cx, double cy, double angle, double reach, bool empty) {
    constexpr double step = 0.25;
    const double dx = std::cos(angle), dy = std::sin(angle);
    const auto value = [&](double r) { return projection.at(cx + r * dx, cy + r * dy); };
    double r = reach;
    while (r > 0.2 * reach && value(r) < 0.75) r -= step;
    const double outside = r;
    double densest = 0.0, outer = r;
    while (r > 0.2 * reach && value(r) >= 0.75) {
        if (value(r) >= densest) {
            densest = value(r);
            outer = r;
        }
        r -= step;
    }
    if (r <= 0.2 * reach) return std::nullopt;
    // The tube next to its inner edge: farther outside, hardened rays make it brighter. The densest place where it is thin.
    double in_tube = densest;
    if (const double from = r + 2.0, to = std::min(r + 5.0, outside - 2.0); to > from) {
        double sum = 0.0, count = 0.0;
        for (double s = from; s <= to; s += step) {
            sum += value(s);
            count += 1.0;
        }
        in_tube = sum / count;
        outer = from;
    }
    double behind = empty ? 0.0 : value(r);
    for (double s = r; s > r - 4.0 && !empty; s -= step) behind = std::min(behind, value(s));
    const double half = 0.5 * (in_tube + behind);
    while (outer > r - 4.0 && value(outer - step) > half) outer -= step;
    const double high = value(outer), low = value(outer - step);
    const double at = outer - step * (high > low ? (high - half) / (high - low) : 0.5);
    return Edge{cx + at * dx, cy + at * dy};
}

// x^2 + y^2 = 2 a x + 2 b y + c (Kasa 1976).
Tube circle_of(const std::vector<Edge>& edges) {
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(edges.size()), 3);
    Eigen::VectorXd squares(matrix.rows());
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        const Edge& edge = edges[static_cast<std::size_t>(i)];
        matrix.row(i) << 2.0 * edge.x, 2.0 * edge.y, 1.0;
        squares[i] = edge.x * edge.x + edge.y * edge.y;
    }
    const Eigen::Vector3d found = matrix.colPivHouseholderQr().solve(squares);
    Tube tube{.x_voxels = found[0], .y_voxels = found[1]};
    tube.radius_voxels = std::sqrt(found[2] + found[0] * found[0] + found[1] * found[1]);
    double sum = 0.0;
    for (const Edge& edge : edges) sum += std::pow(std::hypot(edge.x - tube.x_voxels, edge.y - tube.y_voxels) - tube.radius_voxels, 2.0);
    tube.residual_voxels = std::sqrt(sum / static_cast<double>(edges.size()));
    return tube;
}

}  // namespace

Tube find_tube(const VolumeSource& source, PoreSide pores, const std::string& where, const std::vector<std::uint8_t>& explained) {
    const Projection projection = project(source, fit_gray_levels(source, pores, {}, where), explained);
    const double cx = 0.5 * projection.width, cy = 0.5 * projection.height;
    constexpr int rays = 360;
    std::vector<Edge> edges;
    for (int ray = 0; ray < rays; ++ray) {
        const double angle = 2.0 * std::numbers::pi * ray / rays;
        const double reach = std::min(cx / std::max(1e-9, std::abs(std::cos(angle))), cy / std::max(1e-9, std::abs(std::sin(angle))));
        if (const auto edge = edge_on_ray(projection, cx, cy, angle, reach, !explained.empty())) edges.push_back(*edge);
    }
    const auto none = [&] {
        return UserError("the image shows no tube: the mean of its layers has no bright ring",
                         {.where = where, .fix = "--container cylinder:D,H, or a scan that shows the wall of the container all around"});
    };
    if (edges.size() < rays / 2) throw none();
    Tube tube = circle_of(edges);
    for (int pass = 0; pass < 2; ++pass) {
        const double limit = std::max(0.5, 2.5 * tube.residual_voxels);
        std::vector<Edge> near;
        for (const Edge& edge : edges)
            if (std::abs(std::hypot(edge.x - tube.x_voxels, edge.y - tube.y_voxels) - tube.radius_voxels) < limit) near.push_back(edge);
        if (near.size() < rays / 2) throw none();
        tube = circle_of(near);
    }
    if (!(tube.residual_voxels < 1.5)) throw none();
    return tube;
}

}  // namespace porepack::scans
