#include "pore_space/closing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/parallel.hpp"
#include "pore_space/gray_solid.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

constexpr double kept_cells = 3.0;  // distances beyond so many cells are cut
constexpr double largest_image = 1e9, bytes_per_voxel = 10.0;

// The exact grains and, between them, a level set. It is no scan: it has neither blur nor gray levels that are uncertain.
class ClosedSolid : public Solid {
public:
    ClosedSolid(std::shared_ptr<const Solid> grains, std::shared_ptr<const GrayImage> image, const Container& container)
        : grains_(std::move(grains)), levels_(std::make_shared<GraySolid>(std::move(image), container)) {}
    void column(double x, double y, std::vector<Interval>& parts) const override {
        std::vector<Interval> others;
        grains_->column(x, y, parts);
        levels_->column(x, y, others);
        add(others, parts);
    }
    void near_column(double x, double y, double length, std::vector<Interval>& parts) const override {
        std::vector<Interval> others;
        grains_->near_column(x, y, length, parts);
        levels_->near_column(x, y, length, others);
        add(others, parts);
    }
    [[nodiscard]] Bounds bounds() const override { return grains_->bounds(); }
    [[nodiscard]] std::unique_ptr<SolidProbe> probe() const override { return std::make_unique<Probe>(grains_->probe(), levels_->probe()); }
    [[nodiscard]] std::shared_ptr<const Solid> between(const std::vector<Interval>& heights_m, bool periodic) const override {
        const auto part = std::make_shared<ClosedSolid>(*this);
        part->levels_ = levels_->between(heights_m, periodic);
        return part;
    }

private:
    class Probe : public SolidProbe {
    public:
        Probe(std::unique_ptr<SolidProbe> grains, std::unique_ptr<SolidProbe> levels)
            : grains_(std::move(grains)), levels_(std::move(levels)) {}
        void move_to(const Vec3& point, double reach) override {
            grains_->move_to(point, reach);
            levels_->move_to(point, reach);
        }
        [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
            const auto one = grains_->first_hit(from, step), other = levels_->first_hit(from, step);
            return one && other ? std::min(one, other) : one ? one : other;
        }

    private:
        std::unique_ptr<SolidProbe> grains_, levels_;
    };
    static void add(const std::vector<Interval>& others, std::vector<Interval>& parts) {
        parts.insert(parts.end(), others.begin(), others.end());
        unite(parts);
    }

    std::shared_ptr<const Solid> grains_;
    std::shared_ptr<const Solid> levels_;
};

struct Offset {
    int i, j, k;
    double length;
};

std::vector<Offset> offsets_within(const Grid& grid, double reach) {
    std::array<int, 3> most{};
    for (std::size_t a = 0; a < 3; ++a) most[a] = static_cast<int>(reach / grid.spacing_m[a]) + 1;
    std::vector<Offset> offsets;
    for (int k = -most[2]; k <= most[2]; ++k)
        for (int j = -most[1]; j <= most[1]; ++j)
            for (int i = -most[0]; i <= most[0]; ++i)
                if (const double length = Vec3(i * grid.spacing_m[0], j * grid.spacing_m[1], k * grid.spacing_m[2]).norm(); length <= reach)
                    offsets.push_back({i, j, k, length});
    std::sort(offsets.begin(), offsets.end(), [](const Offset& p, const Offset& q) { return p.length < q.length; });
    return offsets;
}

Grid image_grid(const PoreSpace& space, double radius_m) {
    const double voxel = closing_voxel_m(space, radius_m), margin = radius_m + 4.0 * voxel;
    const std::array<bool, 3> periodic = space.container.periodic();
    Vec3 low = space.container.low(), high = space.container.high();
    if (!periodic[2]) {
        low.z() = std::min(space.bed_bottom_m, space.computed().z0_m) - margin;
        high.z() = std::max(space.bed_top_m, space.computed().z1_m) + margin;
    }
    Grid grid;
    double cells = 1.0;
    for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<int>(a);
        const double count = std::max(1.0, std::ceil((high[axis] - low[axis]) / voxel));
        cells *= count;
        grid.cells[a] = static_cast<int>(std::min(count, largest_image));
        grid.spacing_m[a] = (high[axis] - low[axis]) / count;
        grid.origin_m[a] = low[axis];
    }
    if (cells > largest_image)
        throw UserError(fmt::format("menisci of {:g} m need an image of {:.2g} voxels of {:.3g} m", radius_m, cells, voxel),
                        {.where = "[geometry] closing_radius_m",
                         .allowed = fmt::format("{:g} voxels", largest_image),
                         .fix = "choose a larger radius, or a shorter section"});
    require_memory(closing_memory_bytes(space, radius_m), fmt::format("the menisci, an image of {:.2g} voxels of {:.3g} m,", cells, voxel),
                   "choose a larger closing_radius_m, or a smaller bed");
    return grid;
}

double side_distance(const Grains& grains, const Vec3& point) {
    return grains.packing().container.vessel().distance(point);
}

// From grains and the container's sides, at most `cap`. The grains know their images only where these reach into the box: beyond a periodic
// side within `cap`, the point's own images look for them.
double wall_distance(const Grains& grains, Vec3 point, double cap) {
    const Container& container = grains.packing().container;
    const std::array<bool, 3> periodic = container.periodic();
    const Vec3 size = container.size();
    std::vector<Vec3> images = {point};
    for (int axis = 0; axis < 3; ++axis) {
        if (!periodic[static_cast<std::size_t>(axis)]) continue;
        for (Vec3& image : images) image[axis] -= size[axis] * std::floor(image[axis] / size[axis]);
        for (std::size_t n = 0, count = images.size(); n < count; ++n)
            for (const double shift : {-size[axis], size[axis]}) {
                Vec3 other = images[n];
                other[axis] += shift;
                if (other[axis] > -cap && other[axis] < size[axis] + cap) images.push_back(other);
            }
    }
    double nearest = std::min(cap, side_distance(grains, images.front()));
    for (const Vec3& image : images) nearest = std::min(nearest, *grains.distance(image, cap));
    return nearest;
}

// The point nearest to `point` from which no wall is nearer than `radius`: the walls near the last one found are taken as planes, and the
// point is projected onto what they leave (Hildreth's method).
Vec3 nearest_centre(const Grains& grains, const Vec3& point, Vec3 centre, double radius, double h) {
    struct Wall {
        Vec3 normal;
        double offset, multiplier;  ///< normal . x >= offset
    };
    std::vector<Capsule> capsules;
    std::vector<PlacedShape> bodies;
    std::vector<Wall> walls;
    for (int round = 0; round < 8; ++round) {
        capsules.clear();
        bodies.clear();
        walls.clear();
        const auto add = [&](double distance, const Vec3& outward) {
            if (distance < radius + 3.0 * h) walls.push_back({outward, radius - distance + outward.dot(centre), 0.0});
        };
        grains.capsules_near(centre, radius + 3.0 * h, capsules);
        grains.bodies_near(centre, radius + 3.0 * h, bodies);
        Vec3 outward;
        for (const Capsule& capsule : capsules) {
            const double distance = signed_distance(std::vector<Capsule>{capsule}, centre, outward);
            add(distance, outward);
        }
        for (const PlacedShape& body : bodies) {
            const double distance = signed_distance(body, centre, outward);
            add(distance, outward);
        }
        if (const double distance = side_distance(grains, centre); distance < radius + 3.0 * h) {
            for (int axis = 0; axis < 3; ++axis) {
                const Vec3 step = 0.01 * h * Vec3::Unit(axis);
                outward[axis] = side_distance(grains, centre + step) - side_distance(grains, centre - step);
            }
            add(distance, outward.normalized());
        }
        Vec3 x = point;
        for (int sweep = 0; sweep < 40; ++sweep)
            for (Wall& wall : walls) {
                const double multiplier = std::max(0.0, wall.multiplier + wall.offset - wall.normal.dot(x));
                x += (multiplier - wall.multiplier) * wall.normal;
                wall.multiplier = multiplier;
            }
        const double moved = (x - centre).norm();
        centre = x;
        if (moved < 1e-3 * h) break;
    }
    return centre;
}

}  // namespace

double closing_memory_bytes(const PoreSpace& space, double radius_m) {
    const double voxel = closing_voxel_m(space, radius_m);
    const Vec3 size = space.container.size();
    const double height = space.container.periodic()[2] ? size.z() : space.bed_top_m - space.bed_bottom_m + 2.0 * radius_m;
    return bytes_per_voxel * size.x() * size.y() * height / (voxel * voxel * voxel);
}

double closing_voxel_m(const PoreSpace& space, double radius_m) {
    return std::min(0.25 * radius_m, 0.1 * space.grain_size_m);
}

// The balls that reach into the pores are those around points whose distance d from the solid is at least the radius. Around a cell's
// centre even the ball of radius d lies in the pores, so the signed distance is about the largest d - (distance from that centre). Near the
// surface, the best centre between those of the cells is found. Where there is no meniscus, the solid's own distance is exact: there the
// ball that touches the nearest wall from the side of the point lies in the pores.
std::vector<float> closed_distances(const Grains& grains, const Grid& grid, double radius_m, const std::array<bool, 3>& periodic) {
    const double h = grid.spacing_m[0], farthest = kept_cells * h, cap = radius_m + 2.0 * h;
    const auto [nx, ny, nz] = grid.cells;
    std::vector<float> own(grid.size()), closed(grid.size());
    parallel_for(static_cast<std::size_t>(nz), [&](std::size_t layer) {
        const int k = static_cast<int>(layer);
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i)
                own[grid.index(i, j, k)] =
                    static_cast<float>(wall_distance(grains, Vec3(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k)), cap));
    });
    const std::vector<Offset> offsets = offsets_within(grid, cap + farthest);
    const auto bring_in = [](int i, int n, bool period) { return period ? ((i % n) + n) % n : i; };
    const auto nearest_ball = [&](int i, int j, int k) {
        double best = -farthest;
        Vec3 centre = Vec3::Zero();
        for (const Offset& o : offsets) {
            if (cap - o.length <= best) break;
            const int x = bring_in(i + o.i, nx, periodic[0]), y = bring_in(j + o.j, ny, periodic[1]),
                      z = bring_in(k + o.k, nz, periodic[2]);
            if (x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz) continue;
            const double d = own[grid.index(x, y, z)];
            if (d < radius_m || d - o.length <= best) continue;
            best = d - o.length;
            centre = Vec3(o.i * grid.spacing_m[0], o.j * grid.spacing_m[1], o.k * grid.spacing_m[2]);
        }
        if (std::abs(best) > 2.5 * h) return best;
        const Vec3 point(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
        const Vec3 better = nearest_centre(grains, point, point + centre, radius_m, h);
        return wall_distance(grains, better, cap) >= radius_m - 0.02 * h ? std::max(best, radius_m - (point - better).norm()) : best;
    };
    const auto under_no_meniscus = [&](int i, int j, int k) {
        const auto slope = [&](int axis, int n, const auto& at) {
            const auto a = static_cast<std::size_t>(axis);
            const int low = periodic[a] ? n - 1 : std::max(0, n - 1), high = periodic[a] ? n + 1 : std::min(grid.cells[a] - 1, n + 1);
            return (at(high) - at(low)) / ((high - low) * grid.spacing_m[a]);
        };
        const auto value = [&](int x, int y, int z) {
            return static_cast<double>(
                own[grid.index(bring_in(x, nx, periodic[0]), bring_in(y, ny, periodic[1]), bring_in(z, nz, periodic[2]))]);
        };
        const Vec3 away(slope(0, i, [&](int n) { return value(n, j, k); }), slope(1, j, [&](int n) { return value(i, n, k); }),
                        slope(2, k, [&](int n) { return value(i, j, n); }));
        const Vec3 point(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
        const Vec3 centre = point + (radius_m - value(i, j, k)) * away.normalized();
        return wall_distance(grains, centre, cap) >= radius_m - 0.02 * h;
    };
    parallel_for(static_cast<std::size_t>(nz), [&](std::size_t layer) {
        const int k = static_cast<int>(layer);
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const std::size_t cell = grid.index(i, j, k);
                const double d = own[cell];
                const bool own_wall = d >= radius_m || d <= -farthest || under_no_meniscus(i, j, k);
                closed[cell] = static_cast<float>(std::clamp(own_wall ? d : std::min(d, nearest_ball(i, j, k)), -farthest, farthest));
            }
    });
    return closed;
}

PoreSpace closed(const PoreSpace& space, double radius_m) {
    if (space.grains() == nullptr)
        throw UserError("menisci are made between the grains of a packing; this is none",
                        {.where = space.source, .fix = "remove closing_radius_m"});
    const Grid grid = image_grid(space, radius_m);
    log_info("menisci: an image of {} x {} x {} voxels of {:.4g} m", grid.cells[0], grid.cells[1], grid.cells[2], grid.spacing_m[0]);
    const std::vector<float> distances = closed_distances(*space.grains(), grid, radius_m, space.container.periodic());
    auto image = std::make_shared<GrayImage>(GrayImage{.grid = grid, .packed = {}, .notes = {}});
    image->packed.resize(grid.size());
    // The values of a gray image reach from -0.5 to 1.5, with the wall at 0.5.
    const double scale = 1.0 / (kept_cells * grid.spacing_m[0]);
    for (std::size_t cell = 0; cell < grid.size(); ++cell) image->packed[cell] = GrayImage::pack(0.5 - scale * distances[cell]);
    PoreSpace result = space;
    result.closing_radius_m = radius_m;
    result.solid = std::make_shared<const ClosedSolid>(space.solid, std::move(image), space.container);
    return result;
}

}  // namespace porepack::pore_space
