#include "packing/batches.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include "core/error.hpp"

namespace porepack {
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

// Draws a shape by the number fractions; one shape needs no draw.
std::size_t draw(const std::vector<ShapeShare>& shapes, Random& random) {
    if (shapes.size() == 1) return 0;
    double at = random.uniform(0.0, 1.0);
    for (std::size_t s = 0; s + 1 < shapes.size(); ++s) {
        if (at < shapes[s].number_fraction) return s;
        at -= shapes[s].number_fraction;
    }
    return shapes.size() - 1;
}

// Poses of one batch: random in a slab at the drop height, clear of the walls and of each other. As many as fit.
Batch make_batch(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config, double drop_height,
                 long count, Random& random) {
    constexpr int tries = 300;
    const double slab = largest_span(shapes);
    const double clearance = 0.02 * finest_diameter(shapes);
    Batch batch;
    std::vector<std::vector<Capsule>> placed;
    const auto fits = [&](const std::vector<Capsule>& grain) {
        for (const auto& capsule : grain)
            for (const Vec3& end : {capsule.a, capsule.b})
                if (container.wall_distance(end) < capsule.radius + clearance) return false;
        for (const auto& other : placed)
            for (const auto& p : other)
                for (const auto& q : grain)
                    if (gap(p, q) < clearance) return false;
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
            if (!fits(capsules)) continue;
            grain.velocity_m_per_s.x() = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            grain.velocity_m_per_s.y() = random.uniform(-config.horizontal_speed_m_per_s, config.horizontal_speed_m_per_s);
            batch.push_back(grain);
            placed.push_back(capsules);
            break;
        }
    }
    return batch;
}

}  // namespace

double finest_diameter(const std::vector<ShapeShare>& shapes) {
    double least = 1e300;
    for (const auto& share : shapes) least = std::min(least, smallest_diameter(share.shape));
    return least;
}

double largest_span(const std::vector<ShapeShare>& shapes) {
    double largest = 0.0;
    for (const auto& share : shapes) largest = std::max(largest, span(share.shape));
    return largest;
}

std::vector<Batch> make_batches(const std::vector<ShapeShare>& shapes, const Container& container, const PackingConfig& config,
                                double drop_height_m, long grains) {
    Random random(config.seed);
    std::vector<Batch> batches;
    for (long left = grains; left > 0;) {
        batches.push_back(make_batch(shapes, container, config, drop_height_m, std::min(left, config.batch_grains), random));
        if (batches.back().empty())
            throw UserError("no grain fits into the container at the drop height", {.mend = "take a wider container or smaller grains"});
        left -= static_cast<long>(batches.back().size());
    }
    return batches;
}

}  // namespace porepack
