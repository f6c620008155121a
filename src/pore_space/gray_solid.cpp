#include "pore_space/gray_solid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/median.hpp"
#include "core/parallel.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {

GraySolid::GraySolid(std::shared_ptr<const GrayImage> image, const Container& container)
    : image_(std::move(image)), layers_(image_->grid), periodic_(container.periodic()), level_(image_->level) {}

GraySolid::Place GraySolid::place(int axis, double coordinate) const {
    const auto a = static_cast<std::size_t>(axis);
    const Grid& grid = image_->grid;
    const int n = grid.cells[a];
    const double at = (coordinate - grid.origin_m[a]) / grid.spacing_m[a] - 0.5, floor = std::floor(at);
    Place place{.low = static_cast<int>(floor), .high = static_cast<int>(floor) + 1, .part = at - floor};
    const auto bring_in = [&](int i) { return periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1); };
    place.low = bring_in(place.low);
    place.high = bring_in(place.high);
    if (axis == 2) place = {layers_.place(place.low), layers_.place(place.high), place.part};
    return place;
}

double GraySolid::value(const Vec3& point) const {
    const Place x = place(0, point.x()), y = place(1, point.y()), z = place(2, point.z());
    const Grid& grid = image_->grid;
    const auto line = [&](int j, int k) {
        return (1.0 - x.part) * image_->at(grid.index(x.low, j, k)) + x.part * image_->at(grid.index(x.high, j, k));
    };
    const auto plane = [&](int k) { return (1.0 - y.part) * line(y.low, k) + y.part * line(y.high, k); };
    return (1.0 - z.part) * plane(z.low) + z.part * plane(z.high);
}

GraySolid GraySolid::with_level(double level) const {
    GraySolid copy = *this;
    copy.level_ = level;
    return copy;
}

std::shared_ptr<const Solid> GraySolid::between(const std::vector<Interval>& heights_m, bool periodic) const {
    const KnownLayers layers(image_->grid, heights_m, periodic);
    const auto kept = std::make_shared<GrayImage>(GrayImage{.grid = image_->grid,
                                                            .packed = layers.values(image_->grid, layers_, image_->packed),
                                                            .level = image_->level,
                                                            .notes = image_->notes});
    const auto part = std::make_shared<GraySolid>(*this);
    part->image_ = kept;
    part->layers_ = layers;
    return part;
}

Bounds GraySolid::bounds() const {
    const Grid& grid = image_->grid;
    const Vec3 low(grid.origin_m[0], grid.origin_m[1], grid.origin_m[2]);
    const Vec3 size(grid.cells[0] * grid.spacing_m[0], grid.cells[1] * grid.spacing_m[1], grid.cells[2] * grid.spacing_m[2]);
    return {low, low + size};
}

// Along a vertical line the values are linear between the centres of the layers.
void GraySolid::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    const Grid& grid = image_->grid;
    const Place px = place(0, x), py = place(1, y);
    const int n = grid.cells[2];
    const double h = grid.spacing_m[2], level = level_;
    const auto in_layer = [&](int layer) {
        const int k = layers_.place(layer);
        return (1.0 - py.part) *
                   ((1.0 - px.part) * image_->at(grid.index(px.low, py.low, k)) + px.part * image_->at(grid.index(px.high, py.low, k))) +
               py.part *
                   ((1.0 - px.part) * image_->at(grid.index(px.low, py.high, k)) + px.part * image_->at(grid.index(px.high, py.high, k)));
    };
    const double bottom = grid.origin_m[2], top = bottom + n * h;
    double before = periodic_[2] ? in_layer(n - 1) : in_layer(0), z = bottom - 0.5 * h;
    if (before > level) parts.push_back({bottom, top});
    for (int k = 0; k <= n; ++k, z += h) {
        if (k < n && !layers_.has(k)) continue;
        const double value = k < n ? in_layer(k) : periodic_[2] ? in_layer(0) : before;
        if ((before > level) != (value > level)) {
            const double at = std::clamp(z + h * (level - before) / (value - before), bottom, top);
            if (value > level)
                parts.push_back({at, top});
            else
                parts.back().high = at;
        }
        before = value;
    }
    std::erase_if(parts, [](const Interval& part) { return part.high <= part.low; });
}

// Interpolated values do not exceed those of the voxels around: the layers in which one of these is above the level, and those beside them.
void GraySolid::near_column(double x, double y, double length, std::vector<Interval>& parts) const {
    parts.clear();
    const Grid& grid = image_->grid;
    const double reach = 0.5 * length, h = grid.spacing_m[2];
    const auto cells = [&](int axis, double from) {
        const auto a = static_cast<std::size_t>(axis);
        const int n = grid.cells[a];
        const auto at = [&](double value) { return static_cast<int>(std::floor((value - grid.origin_m[a]) / grid.spacing_m[a] - 0.5)); };
        std::vector<int> found;
        for (int i = at(from - reach); i <= at(from + reach) + 1; ++i)
            found.push_back(periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1));
        return found;
    };
    const std::vector<int> xs = cells(0, x), ys = cells(1, y);
    const int n = grid.cells[2];
    for (int k = 0; k < n; ++k) {
        if (!layers_.has(k)) continue;
        const int kept = layers_.place(k);
        const bool above = std::any_of(ys.begin(), ys.end(), [&](int j) {
            return std::any_of(xs.begin(), xs.end(), [&](int i) { return image_->at(grid.index(i, j, kept)) > level_; });
        });
        if (!above) continue;
        const double z = grid.centre(2, k), margin = h + reach;
        parts.push_back({k == 0 ? -1e300 : z - margin, k + 1 == n ? 1e300 : z + margin});
        if (periodic_[2] && k == 0) parts.push_back({z + n * h - margin, 1e300});
        if (periodic_[2] && k + 1 == n) parts.push_back({-1e300, z - n * h + margin});
    }
    unite(parts);
}

class GraySolid::Probe : public SolidProbe {
public:
    explicit Probe(const GraySolid& solid) : solid_(solid) {}
    // Interpolated values do not exceed those of the voxels around: where none is above the level, nothing is hit.
    void move_to(const Vec3& point, double reach) override {
        const GrayImage& image = *solid_.image_;
        const Grid& grid = image.grid;
        std::array<std::array<int, 16>, 3> cells;
        std::array<std::size_t, 3> count;
        for (std::size_t a = 0; a < 3; ++a) {
            const int n = grid.cells[a];
            const auto cell = [&](double coordinate) {
                return static_cast<int>(std::floor((coordinate - grid.origin_m[a]) / grid.spacing_m[a] - 0.5));
            };
            const double at = point[static_cast<int>(a)];
            const int low = cell(at - reach), high = cell(at + reach) + 1;
            if (high - low >= static_cast<int>(cells[a].size())) {
                near_ = true;
                return;
            }
            count[a] = static_cast<std::size_t>(high - low + 1);
            for (int i = low; i <= high; ++i)
                cells[a][static_cast<std::size_t>(i - low)] = solid_.periodic_[a] ? ((i % n) + n) % n : std::clamp(i, 0, n - 1);
        }
        for (std::size_t k = 0; k < count[2]; ++k) cells[2][k] = solid_.layers_.place(cells[2][k]);
        std::uint16_t largest = 0;
        for (std::size_t k = 0; k < count[2]; ++k)
            for (std::size_t j = 0; j < count[1]; ++j)
                for (std::size_t i = 0; i < count[0]; ++i)
                    largest = std::max(largest, image.packed[grid.index(cells[0][i], cells[1][j], cells[2][k])]);
        near_ = largest >= GrayImage::pack(solid_.level_);
    }
    // Along a segment through one voxel the values are a cubic polynomial: steps of a quarter of a voxel find its roots.
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        if (!near_) return std::nullopt;
        const double level = solid_.level_;
        const int steps = std::max(1, static_cast<int>(std::ceil(4.0 * step.norm() / solid_.image_->grid.spacing_m[0])));
        double before = solid_.value(from), at = 0.0;
        if (before > level) return 0.0;
        for (int i = 1; i <= steps; ++i) {
            const double next = static_cast<double>(i) / steps, value = solid_.value(from + next * step);
            if (value > level) return root(from, step, {at, before}, {next, value});
            at = next;
            before = value;
        }
        return std::nullopt;
    }

private:
    struct End {
        double at, value;
    };
    [[nodiscard]] double root(const Vec3& from, const Vec3& step, End outside, End inside) const {
        const double level = solid_.level_;
        double at = inside.at;
        for (int i = 0; i < 3; ++i) {
            at = outside.at + (inside.at - outside.at) * (level - outside.value) / (inside.value - outside.value);
            const double value = solid_.value(from + at * step);
            (value > level ? inside : outside) = {at, value};
        }
        return at;
    }
    const GraySolid& solid_;
    bool near_ = false;
};

std::unique_ptr<SolidProbe> GraySolid::probe() const {
    return std::make_unique<Probe>(*this);
}

}  // namespace porepack::pore_space
