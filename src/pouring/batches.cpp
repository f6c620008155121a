#include "pouring/batches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "pouring/uses.hpp"
#include "shapes/distance.hpp"

namespace porepack::pouring {
namespace {

// The standard library's distributions differ between implementations; these do not.
class Random {
public:
    explicit Random(long seed) : engine_(static_cast<std::uint64_t>(seed)) {}
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
    // Uniform over all rotations (Shoemake 1992).
    Quaternion rotation() {
        const double u = uniform(0, 1), v = 2.0 * std::numbers::pi * uniform(0, 1), w = 2.0 * std::numbers::pi * uniform(0, 1);
        return {std::sqrt(1 - u) * std::sin(v), std::sqrt(1 - u) * std::cos(v), std::sqrt(u) * std::sin(w), std::sqrt(u) * std::cos(w)};
    }

private:
    std::mt19937_64 engine_;
};

// Draws a shape by the number fractions; a single shape needs no random number.
std::size_t draw(const std::vector<ShapeShare>& shapes, Random& random) {
    if (shapes.size() == 1) return 0;
    double at = random.uniform(0.0, 1.0);
    for (std::size_t s = 0; s + 1 < shapes.size(); ++s) {
        if (at < shapes[s].number_fraction) return s;
        at -= shapes[s].number_fraction;
    }
    return shapes.size() - 1;
}

// By which the images of a grain in a container with periodic faces are moved; the first by nothing.
std::vector<Vec3> shifts_of_images(const Container& container) {
    std::vector<Vec3> shifts = {Vec3::Zero()};
    for (const int axis : {0, 1}) {
        if (!container.periodic()[static_cast<std::size_t>(axis)]) continue;
        const Vec3 step = (container.high()[axis] - container.low()[axis]) * Vec3::Unit(axis);
        for (std::size_t i = 0, before = shifts.size(); i < before; ++i) {
            shifts.push_back(shifts[i] + step);
            shifts.push_back(shifts[i] - step);
        }
    }
    return shifts;
}

// Poses of one batch: random in a slab at the drop height, without contact with the walls or each other. As many as fit.
Batch make_batch(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config, double drop_height,
                 long count, Random& random) {
    constexpr int tries = 300;
    const double slab = maximum_feret_diameter(shapes);
    const double clearance = 0.02 * finest_diameter(shapes);
    Batch batch;
    std::vector<std::vector<Capsule>> placed;
    std::vector<PlacedShape> placed_bodies;
    const std::vector<Vec3> shifts = shifts_of_images(container);
    const auto body_fits = [&](const PlacedShape& grain) {
        const auto wall = [&](const Vec3& x) { return container.wall_distance(x); };
        if (reach_beyond(grain, wall) > -clearance) return false;
        return std::all_of(shifts.begin(), shifts.end(), [&](const Vec3& shift) {
            const PlacedShape image{grain.shape, grain.position_m + shift, grain.orientation};
            return std::all_of(placed_bodies.begin(), placed_bodies.end(), [&](const PlacedShape& other) {
                return (image.position_m - other.position_m).norm() > 2.0 * slab + clearance ||
                       nearest(image, other, clearance).gap_m >= clearance;
            });
        });
    };
    const bool faced = std::any_of(shapes.begin(), shapes.end(), [](const ShapeShare& share) { return share.shape.body != nullptr; });
    const auto fits = [&](const std::vector<Capsule>& grain) {
        for (const auto& capsule : grain)
            if (container.vessel().least_distance(capsule.a, capsule.b) < capsule.radius + clearance) return false;
        for (const Vec3& shift : shifts)
            for (const auto& capsule : grain) {
                const Capsule image{capsule.a + shift, capsule.b + shift, capsule.radius};
                for (const auto& other : placed)
                    for (const auto& p : other)
                        if (gap(p, image) < clearance) return false;
            }
        return true;
    };
    for (long n = 0; n < count; ++n) {
        const std::size_t kind = draw(shapes, random);
        for (int t = 0; t < tries; ++t) {
            const Vec3 low = container.low(), high = container.high();
            Newcomer grain{.shape = kind, .position_m = {}, .orientation = {}, .velocity_m_per_s = Vec3::Zero()};
            grain.position_m = Vec3(random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                                    drop_height + random.uniform(0.0, slab) - slab / 2.0);
            grain.orientation = random.rotation();
            std::vector<Capsule> capsules;
            for (const auto& capsule : shapes[kind].shape.capsules) capsules.push_back(moved(capsule, grain.position_m, grain.orientation));
            const PlacedShape body{shapes[kind].shape, grain.position_m, grain.orientation};
            if (!(faced ? body_fits(body) : fits(capsules))) continue;
            grain.velocity_m_per_s.x() = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            grain.velocity_m_per_s.y() = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            batch.push_back(grain);
            placed.push_back(capsules);
            placed_bodies.push_back(body);
            break;
        }
    }
    return batch;
}

}  // namespace

double finest_diameter(const std::vector<ShapeShare>& shapes) {
    double minimum = 1e300;
    for (const auto& share : shapes) minimum = std::min(minimum, smallest_diameter(share.shape));
    return minimum;
}

double maximum_feret_diameter(const std::vector<ShapeShare>& shapes) {
    double largest = 0.0;
    for (const auto& share : shapes) largest = std::max(largest, maximum_feret_diameter(share.shape));
    return largest;
}

namespace {

// A lattice in layers with a pitch of 1.02 maximum Feret diameters and random orientations.
Pour make_lattice(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config, long grains,
                  Random& random) {
    const double pitch = 1.02 * maximum_feret_diameter(shapes);
    const Vec3 low = container.low(), high = container.high();
    const auto count = [&](int axis) {
        const bool periodic = container.periodic()[static_cast<std::size_t>(axis)];
        return std::max(1L, static_cast<long>((high[axis] - low[axis]) / pitch + (periodic ? 1e-9 : 0.0)));
    };
    const long nx = count(0), ny = count(1);
    const auto places_at = [&](double z) {
        std::vector<Vec3> places;
        for (long j = 0; j < ny; ++j)
            for (long i = 0; i < nx; ++i) {
                const Vec3 place(low.x() + (static_cast<double>(i) + 0.5) * (high.x() - low.x()) / static_cast<double>(nx),
                                 low.y() + (static_cast<double>(j) + 0.5) * (high.y() - low.y()) / static_cast<double>(ny), z);
                if (container.wall_distance(place) >= 0.5 * pitch) places.push_back(place);
            }
        if (!places.empty()) return places;
        // A grain as wide as the vessel goes into the middle. Where a cone is narrower than that, the lattice has no place.
        const Vec3 widest = container.widest_place(z).at;
        const double room = container.wall_distance(widest), above = container.wall_distance(widest + pitch * Vec3::UnitZ());
        if (room >= 0.5 * pitch || room == above) places.push_back(widest);
        if (places.empty() && above < room)
            throw UserError("the lattice of grains does not fit into the vessel, which becomes narrower upwards",
                            {.where = "[packing]", .fix = "fill = \"batches\", or fewer grains"});
        return places;
    };
    Pour pour;
    pour.batches.emplace_back();
    std::vector<Vec3> places;  // of one layer
    std::size_t slot = 0;
    long layer = -1;
    for (long n = 0; n < grains; ++n, ++slot) {
        for (; slot == places.size(); slot = 0) {
            ++layer;
            places = places_at((static_cast<double>(layer) + 0.5) * pitch);
        }
        Newcomer grain{
            .shape = draw(shapes, random), .position_m = places[slot], .orientation = random.rotation(), .velocity_m_per_s = Vec3::Zero()};
        // The middle of the grain, not the origin of its frame, is placed on the lattice point.
        const Bounds bounds = bounds_of(PlacedShape{shapes[grain.shape].shape});
        grain.position_m -= grain.orientation * (0.5 * (bounds.low + bounds.high));
        const double speed = config.horizontal_speed_m_per_s;
        grain.velocity_m_per_s = {random.uniform(-speed, speed), random.uniform(-speed, speed), 0.0};
        pour.batches.back().push_back(grain);
        pour.top_m = static_cast<double>(layer + 1) * pitch;
    }
    return pour;
}

// Random places in a periodic box at which the spheres around the grains do not touch, one after another.
Pour make_scattered(const std::vector<ShapeShare>& shapes, const Container& container, long grains, Random& random) {
    constexpr int tries = 2000;
    constexpr double most = 0.3;  // part of the box that such spheres fill, surely
    struct Sphere {
        Vec3 centre;
        double radius;
    };
    std::vector<double> radii;
    std::vector<Vec3> middles;
    double mean_volume = 0.0;
    for (const auto& [shape, share] : shapes) {
        const Bounds bounds = bounds_of(PlacedShape{shape});
        middles.emplace_back(0.5 * (bounds.low + bounds.high));
        double radius = 0.0;
        for (const Capsule& capsule : shape.capsules)
            radius = std::max(radius, std::max((capsule.a - middles.back()).norm(), (capsule.b - middles.back()).norm()) + capsule.radius);
        if (shape.body != nullptr) radius = std::max(radius, shape.body->reach_from(middles.back()));
        radii.push_back(1.01 * radius);
        mean_volume += share * 4.0 / 3.0 * std::numbers::pi * std::pow(radii.back(), 3);
    }
    const Vec3 size = container.size();
    const auto refuse = [&] {
        throw UserError(fmt::format("{} grains do not fit into the box without contact", grains),
                        {.where = "[container]",
                         .allowed = fmt::format("a box of {:.3g} m3 or more", static_cast<double>(grains) * mean_volume / most),
                         .fix = "a larger box: it shrinks until the grains touch"});
    };
    if (static_cast<double>(grains) * mean_volume > most * size.prod()) refuse();
    Pour pour;
    pour.batches.emplace_back();
    pour.top_m = size.z();
    std::vector<Sphere> placed;
    const auto is_free = [&](const Sphere& one) {
        return std::none_of(placed.begin(), placed.end(), [&](const Sphere& other) {
            Vec3 apart = one.centre - other.centre;
            for (int axis = 0; axis < 3; ++axis) apart[axis] -= size[axis] * std::round(apart[axis] / size[axis]);
            const double reach = one.radius + other.radius;
            return apart.squaredNorm() < reach * reach;
        });
    };
    for (long n = 0; n < grains; ++n) {
        const std::size_t kind = draw(shapes, random);
        int t = 0;
        for (; t < tries; ++t) {
            const Sphere sphere{{random.uniform(0.0, size.x()), random.uniform(0.0, size.y()), random.uniform(0.0, size.z())}, radii[kind]};
            if (!is_free(sphere)) continue;
            placed.push_back(sphere);
            const Quaternion orientation = random.rotation();
            pour.batches.back().push_back({.shape = kind,
                                           .position_m = sphere.centre - orientation * middles[kind],
                                           .orientation = orientation,
                                           .velocity_m_per_s = Vec3::Zero()});
            break;
        }
        if (t == tries) refuse();
    }
    return pour;
}

}  // namespace

Pour make_batches(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config, double drop_height_m,
                  long grains) {
    Random random(config.seed);
    if (config.fill == Fill::scatter) return make_scattered(shapes, container, grains, random);
    if (config.fill == Fill::lattice) return make_lattice(shapes, container, config, grains, random);
    Pour pour;
    pour.top_m = drop_height_m + maximum_feret_diameter(shapes);
    for (long left = grains; left > 0;) {
        const long wanted = std::min(left, config.batch_grains);
        pour.batches.push_back(make_batch(shapes, container, config, drop_height_m, wanted, random));
        const long fitted = static_cast<long>(pour.batches.back().size());
        if (fitted == 0)
            throw UserError("no grain fits into the container at the drop height", {.fix = "choose a wider container or smaller grains"});
        if (fitted < wanted) ++pour.thinned;
        left -= fitted;
    }
    return pour;
}

}  // namespace porepack::pouring
