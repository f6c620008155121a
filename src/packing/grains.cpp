#include "packing/grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "core/error.hpp"

namespace porepack::packing {
using namespace shapes;
using namespace vessels;

Grains::Grains(Packing packing) : packing_(std::move(packing)) {
    add_images();
    sort_into_bins();
    std::vector<Bounds> boxes, body_boxes;
    for (std::size_t i = 0; i < images_.size(); ++i) {
        for (const auto& capsule : images_[i].capsules) {
            capsules_.push_back(capsule);
            boxes.push_back(bounds_of({capsule}));
        }
        if (shape_of(images_[i]).body == nullptr) continue;
        with_body_.push_back(i);
        body_boxes.push_back(images_[i].bounds);
    }
    capsule_bins_ = SpatialBins(boxes);
    body_bins_ = SpatialBins(body_boxes);
}

// visit(index in the bins, shift of the periodic image).
template <typename Visit>
void Grains::for_near(const SpatialBins& bins, const Vec3& point, double reach, const Visit& visit) const {
    // Images across periodic faces: grains near one face also appear beyond the opposite face.
    std::array<int, 3> low{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        if (!packing_.container.periodic()[a]) continue;
        low[a] = point[axis] > packing_.container.size()[axis] - reach ? -1 : 0;
        high[a] = point[axis] < reach ? 1 : 0;
    }
    thread_local std::vector<int> indices;
    for (int i = low[0]; i <= high[0]; ++i)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int k = low[2]; k <= high[2]; ++k) {
                const Vec3 shift = Vec3(i, j, k).cwiseProduct(packing_.container.size());
                indices.clear();
                bins.near(point + shift, reach, indices);
                for (const int c : indices) visit(static_cast<std::size_t>(c), shift);
            }
}

void Grains::capsules_near(const Vec3& point, double reach, std::vector<Capsule>& found) const {
    for_near(capsule_bins_, point, reach, [&](std::size_t c, const Vec3& shift) {
        Capsule capsule = capsules_[c];
        capsule.a -= shift;
        capsule.b -= shift;
        // Segments along a diagonal are longer than `reach`.
        if (signed_distance(capsule, point) <= 1.7321 * reach) found.push_back(capsule);
    });
}

void Grains::bodies_near(const Vec3& point, double reach, std::vector<PlacedShape>& found) const {
    if (with_body_.empty()) return;
    for_near(body_bins_, point, reach, [&](std::size_t c, const Vec3& shift) {
        PlacedShape grain = placed(images_[with_body_[c]]);
        grain.position_m -= shift;
        if (signed_distance(grain, point) <= 1.7321 * reach) found.push_back(grain);
    });
}

namespace {

class GrainProbe : public SolidProbe {
public:
    explicit GrainProbe(const Grains& grains) : grains_(grains) {}
    void move_to(const Vec3& point, double reach) override {
        near_.clear();
        near_bodies_.clear();
        grains_.capsules_near(point, reach, near_);
        grains_.bodies_near(point, reach, near_bodies_);
    }
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        const double length = step.norm();
        const Vec3 direction = step / length;
        double first = 2.0 * length;
        for (const Capsule& capsule : near_) {
            const auto inside = line_interval(capsule, from, direction);
            if (inside && inside->high >= 0.0) first = std::min(first, std::max(0.0, inside->low));
        }
        thread_local std::vector<Interval> parts;
        for (const PlacedShape& grain : near_bodies_) {
            grain.shape.body->line(grain.to_shape(from), grain.orientation.conjugate() * direction, 0.0, parts);
            for (const Interval& part : parts) {
                if (part.high < 0.0) continue;
                first = std::min(first, std::max(0.0, part.low));
                break;
            }
        }
        return first <= length ? std::optional(first / length) : std::nullopt;
    }

private:
    const Grains& grains_;
    std::vector<Capsule> near_;
    std::vector<PlacedShape> near_bodies_;
};

}  // namespace

std::unique_ptr<SolidProbe> Grains::probe() const {
    return std::make_unique<GrainProbe>(*this);
}

// A grain that reaches through a periodic side appears again a period away, so that no query has to look around the box. Only images that
// reach into the box are kept; a grain in a corner has up to eight.
void Grains::add_images() {
    const Packing& packing = packing_;
    const Container& container = packing.container;
    for (std::size_t b = 0; b < packing.bodies.size(); ++b) {
        const auto capsules = world_capsules(packing, packing.bodies[b]);
        const Bounds own = bounds_of(packing::placed(packing, packing.bodies[b]));
        int count = 0;
        std::array<std::vector<int>, 3> steps;
        for (int axis = 0; axis < 3; ++axis) {
            auto& list = steps[static_cast<std::size_t>(axis)];
            list = {0};
            if (!container.periodic()[static_cast<std::size_t>(axis)]) continue;
            const double size = container.size()[axis];
            for (int k = 1; own.high[axis] - k * size > 0.0; ++k) list.push_back(-k);
            for (int k = 1; own.low[axis] + k * size < size; ++k) list.push_back(k);
        }
        for (const int i : steps[0])
            for (const int j : steps[1])
                for (const int k : steps[2]) {
                    const Vec3 shift(i * container.size().x(), j * container.size().y(), k * container.size().z());
                    Image image{.capsules = capsules, .bounds = {}, .body = b, .shift = shift, .image = count++};
                    for (auto& capsule : image.capsules) {
                        capsule.a += shift;
                        capsule.b += shift;
                    }
                    image.bounds = image.capsules.empty() ? Bounds{own.low + shift, own.high + shift} : bounds_of(image.capsules);
                    images_.push_back(image);
                }
    }
    for (const auto& image : images_) {
        bounds_.low = bounds_.low.cwiseMin(image.bounds.low);
        bounds_.high = bounds_.high.cwiseMax(image.bounds.high);
    }
}

// Seen from above, in squares of a quarter of a mean grain: a vertical line meets the grains of one bin only. At most 512 x 512 bins.
void Grains::sort_into_bins() {
    if (images_.empty()) {
        bounds_ = {Vec3::Zero(), Vec3::Zero()};
        bins_.resize(1);
        return;
    }
    double extent = 0.0;
    for (const auto& image : images_)
        extent += (image.bounds.high - image.bounds.low).head<2>().maxCoeff() / static_cast<double>(images_.size());
    const Vec3 size = bounds_.high - bounds_.low;
    bin_size_ = std::max(extent / 4.0, size.head<2>().maxCoeff() / 512.0);
    columns_ = 1 + static_cast<int>(size.x() / bin_size_);
    rows_ = 1 + static_cast<int>(size.y() / bin_size_);
    bins_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (std::size_t g = 0; g < images_.size(); ++g) {
        const auto& box = images_[g].bounds;
        const auto cell = [&](double value, double low, int count) {
            return std::clamp(static_cast<int>((value - low) / bin_size_), 0, count - 1);
        };
        for (int j = cell(box.low.y(), bounds_.low.y(), rows_); j <= cell(box.high.y(), bounds_.low.y(), rows_); ++j)
            for (int i = cell(box.low.x(), bounds_.low.x(), columns_); i <= cell(box.high.x(), bounds_.low.x(), columns_); ++i)
                bins_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i)].push_back(
                    static_cast<int>(g));
    }
}

const std::vector<int>& Grains::near(double x, double y) const {
    const double fi = (x - bounds_.low.x()) / bin_size_;
    const double fj = (y - bounds_.low.y()) / bin_size_;
    if (!(fi >= 0.0) || !(fj >= 0.0) || fi >= columns_ || fj >= rows_) return none_;
    return bins_[static_cast<std::size_t>(fj) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(fi)];
}

void Grains::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    thread_local std::vector<Interval> own;
    const Vec3 origin(x, y, 0.0);
    for (const int g : near(x, y)) {
        const Image& image = images_[static_cast<std::size_t>(g)];
        if (x < image.bounds.low.x() || x > image.bounds.high.x() || y < image.bounds.low.y() || y > image.bounds.high.y()) continue;
        line_parts(image, origin, Vec3::UnitZ(), own);
        parts.insert(parts.end(), own.begin(), own.end());
    }
    unite(parts);
}

// A segment that passes through a grain with faces has its nearer end at most half its length away from it.
// A segment that passes through a capsule passes through one of the spheres that it consists of. The nearer end of a chord of `length` is
// at most half the length away from the foot of the centre's perpendicular, so that its distance to the sphere is at most this margin.
void Grains::near_column(double x, double y, double length, std::vector<Interval>& parts) const {
    parts.clear();
    const double reach = 0.5 * length;
    const auto bin = [&](double value, double low, int count) {
        return std::clamp(static_cast<int>(std::floor((value - low) / bin_size_)), 0, count - 1);
    };
    const Vec3 origin(x, y, 0.0);
    for (int j = bin(y - reach, bounds_.low.y(), rows_); j <= bin(y + reach, bounds_.low.y(), rows_); ++j)
        for (int i = bin(x - reach, bounds_.low.x(), columns_); i <= bin(x + reach, bounds_.low.x(), columns_); ++i)
            for (const int g : bins_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i)]) {
                const Image& image = images_[static_cast<std::size_t>(g)];
                if (x < image.bounds.low.x() - reach || x > image.bounds.high.x() + reach || y < image.bounds.low.y() - reach ||
                    y > image.bounds.high.y() + reach)
                    continue;
                if (shape_of(image).body != nullptr) {
                    thread_local std::vector<Interval> own;
                    body_parts(image, origin, Vec3::UnitZ(), reach * (1.0 + 1e-9), own);
                    parts.insert(parts.end(), own.begin(), own.end());
                }
                for (Capsule capsule : image.capsules) {
                    capsule.radius = std::hypot(capsule.radius, reach) * (1.0 + 1e-9);
                    if (const auto part = line_interval(capsule, origin, Vec3::UnitZ())) parts.push_back(*part);
                }
            }
    unite(parts);
}

void Grains::body_parts(const Image& image, const Vec3& origin, const Vec3& direction, double grown, std::vector<Interval>& parts) const {
    const PlacedShape grain = placed(image);
    grain.shape.body->line(grain.to_shape(origin), grain.orientation.conjugate() * direction, grown, parts);
}

void Grains::line_parts(const Image& image, const Vec3& origin, const Vec3& direction, std::vector<Interval>& parts) const {
    parts.clear();
    if (shape_of(image).body != nullptr) return body_parts(image, origin, direction, 0.0, parts);
    for (const auto& capsule : image.capsules)
        if (const auto part = line_interval(capsule, origin, direction)) parts.push_back(*part);
    const Shape& shape = shape_of(image);
    if (!has_filled_cavity(shape)) return;
    unite(parts);
    const Quaternion to_shape = packing_.bodies[image.body].orientation.conjugate();
    join_over_cavities(shape, to_shape * (origin - image.shift - packing_.bodies[image.body].position_m), to_shape * direction, parts);
}

std::optional<double> Grains::distance(const Vec3& point, double cap) const {
    double minimum = cap;
    const int reach = 1 + static_cast<int>(cap / bin_size_);
    for (int dj = -reach; dj <= reach; ++dj)
        for (int di = -reach; di <= reach; ++di)
            for (const int g : near(point.x() + di * bin_size_, point.y() + dj * bin_size_)) {
                const Image& image = images_[static_cast<std::size_t>(g)];
                if (((image.bounds.low - point).array() > minimum).any() || ((point - image.bounds.high).array() > minimum).any()) continue;
                if (shape_of(image).body != nullptr) {
                    minimum = std::min(minimum, signed_distance(placed(image), point));
                    continue;
                }
                double own = signed_distance(image.capsules, point);
                if (own > 0.0 && has_filled_cavity(shape_of(image)) &&
                    in_cavity(shape_of(image), packing_.bodies[image.body].orientation.conjugate() *
                                                   (point - image.shift - packing_.bodies[image.body].position_m)))
                    own = -own;  // the way out leads through the wall of the cavity
                minimum = std::min(minimum, own);
            }
    return minimum;
}

std::shared_ptr<const Solid> Grains::thinned(double depth) const {
    Packing thinner = packing_;
    for (Shape& shape : thinner.shapes) {
        if (shape.body != nullptr) {
            shape.body = shape.body->thinned(depth);
            if (shape.body == nullptr) return nullptr;
            continue;
        }
        std::erase_if(shape.capsules, [&](const Capsule& capsule) { return capsule.radius <= depth; });
        for (Capsule& capsule : shape.capsules) capsule.radius -= depth;
        if (shape.capsules.empty()) return nullptr;
    }
    return std::make_shared<const Grains>(std::move(thinner));
}

}  // namespace porepack::packing
