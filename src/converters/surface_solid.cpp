#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "geometry/triangle.hpp"
#include "vessels/config.hpp"

namespace porepack::converters {

// Two searches over the triangles: a grid of columns seen from above for vertical lines, and boxes in space for segments in any direction.
struct SurfaceSolid::Bins {
    struct Triangle {
        Vec3 a, b, c;
    };
    Container container;
    std::vector<Triangle> triangles;
    Bounds bounds{};
    double size = 1.0;
    int columns = 1, rows = 1;
    std::vector<std::vector<int>> cells;
    SpatialBins boxes{{}};

    [[nodiscard]] int clamp_cell(double value, double low, int count) const {
        return std::clamp(static_cast<int>((value - low) / size), 0, count - 1);
    }
    // All crossings of the line at (x, y), moved by `lift`.
    void collect(double x, double y, double lift, std::vector<LineCrossing>& crossings) const;
};

SurfaceSolid::SurfaceSolid(TriangleSurface surface, const Container& container)
    : surface_(std::move(surface)), bins_(std::make_unique<Bins>()) {
    Bins& bins = *bins_;
    bins.container = container;
    const auto point = [&](int i) {
        const auto& p = surface_.points[static_cast<std::size_t>(i)];
        return Vec3(p[0], p[1], p[2]);
    };
    double extent = 0.0;
    std::vector<Bounds> boxes;
    for (const auto& t : surface_.triangles) {
        bins.triangles.push_back({point(t[0]), point(t[1]), point(t[2])});
        const auto& last = bins.triangles.back();
        const Vec3 low = last.a.cwiseMin(last.b).cwiseMin(last.c), high = last.a.cwiseMax(last.b).cwiseMax(last.c);
        bins.bounds.low = bins.bounds.low.cwiseMin(low);
        bins.bounds.high = bins.bounds.high.cwiseMax(high);
        boxes.push_back({low, high});
        extent += (high - low).head<2>().maxCoeff() / static_cast<double>(surface_.triangles.size());
    }
    bins.boxes = SpatialBins(boxes);
    const Vec3 size = bins.bounds.high - bins.bounds.low;
    // About as large as a mean triangle, so that a cell holds few of them; at most 1025 x 1025 cells.
    bins.size = std::max(extent, size.head<2>().maxCoeff() / 1024.0);
    bins.columns = 1 + static_cast<int>(size.x() / bins.size);
    bins.rows = 1 + static_cast<int>(size.y() / bins.size);
    bins.cells.resize(static_cast<std::size_t>(bins.columns) * static_cast<std::size_t>(bins.rows));
    for (std::size_t t = 0; t < bins.triangles.size(); ++t) {
        const auto& triangle = bins.triangles[t];
        const Vec3 low = triangle.a.cwiseMin(triangle.b).cwiseMin(triangle.c), high = triangle.a.cwiseMax(triangle.b).cwiseMax(triangle.c);
        for (int j = bins.clamp_cell(low.y(), bins.bounds.low.y(), bins.rows);
             j <= bins.clamp_cell(high.y(), bins.bounds.low.y(), bins.rows); ++j)
            for (int i = bins.clamp_cell(low.x(), bins.bounds.low.x(), bins.columns);
                 i <= bins.clamp_cell(high.x(), bins.bounds.low.x(), bins.columns); ++i)
                bins.cells[static_cast<std::size_t>(j) * static_cast<std::size_t>(bins.columns) + static_cast<std::size_t>(i)].push_back(
                    static_cast<int>(t));
    }
}

SurfaceSolid::~SurfaceSolid() = default;

class SurfaceSolid::Probe : public SolidProbe {
public:
    explicit Probe(const Bins& bins) : bins_(bins) {}
    void move_to(const Vec3& point, double reach) override {
        near_.clear();
        const Container& container = bins_.container;
        const auto around = [&](int axis) { return container.periodic()[static_cast<std::size_t>(axis)] ? 1 : 0; };
        for (int i = -around(0); i <= around(0); ++i)
            for (int j = -around(1); j <= around(1); ++j)
                for (int k = -around(2); k <= around(2); ++k) {
                    const Vec3 shift(i * container.size().x(), j * container.size().y(), k * container.size().z());
                    found_.clear();
                    bins_.boxes.near(point - shift, reach, found_);
                    for (const int t : found_) near_.push_back({t, shift});
                }
    }
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        double first = 2.0;
        for (const auto& [t, shift] : near_) {
            const Bins::Triangle& triangle = bins_.triangles[static_cast<std::size_t>(t)];
            if (const auto hit = crossing_from_outside(triangle.a, triangle.b, triangle.c, from - shift, step))
                first = std::min(first, *hit);
        }
        return first <= 1.0 ? std::optional(first) : std::nullopt;
    }

private:
    struct Shifted {
        int triangle;
        Vec3 shift;
    };
    const Bins& bins_;
    std::vector<int> found_;
    std::vector<Shifted> near_;
};

std::unique_ptr<SolidProbe> SurfaceSolid::probe() const {
    return std::make_unique<Probe>(*bins_);
}

Bounds SurfaceSolid::bounds() const {
    return bins_->bounds;
}

std::optional<double> SurfaceSolid::volume_between(double z0, double z1) const {
    const Container& container = bins_->container;
    if (container.any_periodic()) return std::nullopt;
    const double slack = 1e-6 * container.size().head<2>().maxCoeff();  // rounding of STL files
    double volume = 0.0;
    for (const auto& t : bins_->triangles) {
        for (const Vec3& p : {t.a, t.b, t.c}) {
            if (container.wall_distance(p) < -slack) return std::nullopt;
        }
        volume += geometry::volume_between(t.a, t.b, t.c, z0, z1);
    }
    return volume;
}

void SurfaceSolid::Bins::collect(double x, double y, double lift, std::vector<LineCrossing>& crossings) const {
    if (x < bounds.low.x() || x > bounds.high.x() || y < bounds.low.y() || y > bounds.high.y()) return;
    const auto& cell = cells[static_cast<std::size_t>(clamp_cell(y, bounds.low.y(), rows)) * static_cast<std::size_t>(columns) +
                             static_cast<std::size_t>(clamp_cell(x, bounds.low.x(), columns))];
    for (const int t : cell) {
        const Triangle& s = triangles[static_cast<std::size_t>(t)];
        if (const auto crossing = line_crossing(s.a, s.b, s.c, x, y)) crossings.push_back({crossing->z + lift, crossing->step});
    }
}

void SurfaceSolid::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    thread_local std::vector<LineCrossing> crossings;
    const Container& container = bins_->container;
    const double extent = (bins_->bounds.high - bins_->bounds.low).norm();
    // A line through an edge or a corner counts it twice or not at all: then the line is moved by a tiny amount and evaluated again.
    for (int attempt = 0; attempt < 8; ++attempt) {
        crossings.clear();
        const auto [px, py] = line_nearby(x, y, extent, attempt);
        const auto around = [&](int axis) { return container.periodic()[static_cast<std::size_t>(axis)] ? 1 : 0; };
        for (int i = -around(0); i <= around(0); ++i)
            for (int j = -around(1); j <= around(1); ++j)
                for (int k = -around(2); k <= around(2); ++k)
                    bins_->collect(px + i * container.size().x(), py + j * container.size().y(), k * container.size().z(), crossings);
        int sum = 0;
        for (const auto& crossing : crossings) sum += crossing.step;
        if (sum == 0) break;
    }
    parts_between(crossings, parts);
    unite(parts);
}

// The points above and below a triangle's box, as far as they are near its plane.
void SurfaceSolid::near_column(double x, double y, double length, std::vector<Interval>& parts) const {
    parts.clear();
    const Bins& bins = *bins_;
    const Container& container = bins.container;
    const double reach = 0.5 * length * (1.0 + 1e-9);
    const auto around = [&](int axis) { return container.periodic()[static_cast<std::size_t>(axis)] ? 1 : 0; };
    const auto add = [&](const Bins::Triangle& t, double px, double py, double lift) {
        const Vec3 low = t.a.cwiseMin(t.b).cwiseMin(t.c), high = t.a.cwiseMax(t.b).cwiseMax(t.c);
        if (px < low.x() - reach || px > high.x() + reach || py < low.y() - reach || py > high.y() + reach) return;
        Interval part{low.z() - reach, high.z() + reach};
        const Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();  // 0 for a triangle without area: then the box counts
        // The distance to the plane is at_zero + slope z; a vertical plane has the same distance at all heights.
        const double at_zero = normal.dot(Vec3(px, py, 0.0) - t.a), slope = normal.z();
        if (std::abs(slope) > 1e-9) {
            const double one = (-reach - at_zero) / slope, other = (reach - at_zero) / slope;
            part = {std::max(part.low, std::min(one, other)), std::min(part.high, std::max(one, other))};
        } else if (std::abs(at_zero) > reach * (1.0 + 1e-6) + 1e-9 * (high - low).norm()) {
            return;
        }
        if (part.low <= part.high) parts.push_back({part.low + lift, part.high + lift});
    };
    for (int i = -around(0); i <= around(0); ++i)
        for (int j = -around(1); j <= around(1); ++j) {
            const double px = x + i * container.size().x(), py = y + j * container.size().y();
            if (px < bins.bounds.low.x() - reach || px > bins.bounds.high.x() + reach || py < bins.bounds.low.y() - reach ||
                py > bins.bounds.high.y() + reach)
                continue;
            for (int row = bins.clamp_cell(py - reach, bins.bounds.low.y(), bins.rows);
                 row <= bins.clamp_cell(py + reach, bins.bounds.low.y(), bins.rows); ++row)
                for (int column = bins.clamp_cell(px - reach, bins.bounds.low.x(), bins.columns);
                     column <= bins.clamp_cell(px + reach, bins.bounds.low.x(), bins.columns); ++column)
                    for (const int t : bins.cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(bins.columns) +
                                                  static_cast<std::size_t>(column)])
                        for (int k = -around(2); k <= around(2); ++k)
                            add(bins.triangles[static_cast<std::size_t>(t)], px, py, k * container.size().z());
        }
    unite(parts);
}

namespace {

// The bounding box has been checked; most vessels are smaller. Poured grains press into the wall a little.
void require_between_sides(const TriangleSurface& surface, const Container& container, const std::string& where) {
    if (container.vessel().fills_bounds()) return;
    double deepest = 0.0;
    std::array<double, 3> there{};
    for (const auto& point : surface.points)
        if (const double depth = -container.wall_distance({point[0], point[1], point[2]}); depth > deepest) {
            deepest = depth;
            there = point;
        }
    const double allowed = 0.01 * std::min(container.size().x(), container.size().y());
    if (deepest > allowed)
        throw UserError(fmt::format("the surface reaches through the wall of the container: {:.6g} m deep at ({:.6g}, {:.6g}, {:.6g})",
                                    deepest, there[0], there[1], there[2]),
                        {.where = where,
                         .allowed = fmt::format("up to {:.6g} m, 1 % of the container's width", allowed),
                         .fix = fmt::format("move the surface ({}), or give the right container and unit", vessels::container_frames())});
}

// Free space beside the grains makes k far too large, and usually means that the container or the unit is wrong.
void warn_of_free_space(const SurfaceCheck& check, const Container& container) {
    const Vec3 size = container.high() - container.low();
    for (int axis = 0; axis < 2; ++axis)
        for (const auto& [side, gap] :
             {std::pair("low", check.low[axis] - container.low()[axis]), std::pair("high", container.high()[axis] - check.high[axis])})
            if (gap > 0.05 * size[axis] && !container.periodic()[static_cast<std::size_t>(axis)])
                log_warning(
                    fmt::format("there is {:.3g} m of free space between the grains and the wall on the {} side of {}: is the "
                                "container the right one?",
                                gap, side, "xyz"[axis]));
}

}  // namespace

PoreSpace pore_space_of(TriangleSurface surface, const Container& container, const std::string& where) {
    const SurfaceCheck check = check_surface(surface);
    require_plausible_size(check, container, where);
    require_sound(check, where);
    require_between_sides(surface, container, where);
    warn_of_free_space(check, container);
    PoreSpace space{.container = container, .section = {}};
    space.solid = std::make_shared<const SurfaceSolid>(std::move(surface), container);
    space.grain_size_m = 4.0 * check.volume_m3 / check.area_m2;
    space.bed_bottom_m = std::max(0.0, check.low.z());
    space.bed_top_m = check.high.z();
    // A connected part of an STL file may be one grain or the whole bed: at most a quarter of the bed is trimmed.
    space.maximum_feret_diameter_m = std::min(check.largest_shell_diagonal_m, 0.25 * space.bed_top_m);
    space.section = whole_bed(container, {space.bed_bottom_m, space.bed_top_m});
    space.source = where;
    return space;
}

}  // namespace porepack::converters
