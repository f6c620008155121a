#include "packing/grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace porepack::packing {
using namespace core;
using namespace geometry;
using namespace shapes;

Grains::Grains(const Packing& packing) : container_(packing.container), shapes_(packing.shapes) {
    for (const auto& body : packing.bodies) {
        shape_of_body_.push_back(body.shape);
        orientation_.push_back(body.orientation);
        position_.push_back(body.position_m);
    }
    add_images(packing);
    sort_into_bins();
    std::vector<Bounds> boxes;
    for (const auto& image : images_)
        for (const auto& capsule : image.capsules) {
            capsules_.push_back(capsule);
            boxes.push_back(bounds_of({capsule}));
        }
    capsule_bins_ = SpatialBins(boxes);
}

void Grains::capsules_near(const Vec3& point, double reach, std::vector<Capsule>& found) const {
    // Images across periodic faces: grains near one face also appear beyond the opposite face.
    std::array<int, 3> low{}, high{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        if (!container_.periodic[a]) continue;
        low[a] = point[axis] > container_.size_m[axis] - reach ? -1 : 0;
        high[a] = point[axis] < reach ? 1 : 0;
    }
    thread_local std::vector<int> indices;
    for (int i = low[0]; i <= high[0]; ++i)
        for (int j = low[1]; j <= high[1]; ++j)
            for (int k = low[2]; k <= high[2]; ++k) {
                const Vec3 shift = Vec3(i, j, k).cwiseProduct(container_.size_m);
                indices.clear();
                capsule_bins_.near(point + shift, reach, indices);
                for (const int c : indices) {
                    Capsule capsule = capsules_[static_cast<std::size_t>(c)];
                    capsule.a -= shift;
                    capsule.b -= shift;
                    // Segments along a diagonal are longer than `reach`.
                    if (signed_distance(capsule, point) <= 1.7321 * reach) found.push_back(capsule);
                }
            }
}

namespace {

class CapsuleProbe : public SolidProbe {
public:
    explicit CapsuleProbe(const Grains& grains) : grains_(grains) {}
    void move_to(const Vec3& point, double reach) override {
        near_.clear();
        grains_.capsules_near(point, reach, near_);
    }
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        const double length = step.norm();
        const Vec3 direction = step / length;
        double first = 2.0 * length;
        for (const Capsule& capsule : near_) {
            const auto inside = line_interval(capsule, from, direction);
            if (inside && inside->high >= 0.0) first = std::min(first, std::max(0.0, inside->low));
        }
        return first <= length ? std::optional(first / length) : std::nullopt;
    }

private:
    const Grains& grains_;
    std::vector<Capsule> near_;
};

}  // namespace

std::unique_ptr<SolidProbe> Grains::probe() const {
    return std::make_unique<CapsuleProbe>(*this);
}

void Grains::add_images(const Packing& packing) {
    const Container& container = packing.container;
    for (std::size_t b = 0; b < packing.bodies.size(); ++b) {
        const auto capsules = world_capsules(packing, packing.bodies[b]);
        const Bounds own = bounds_of(capsules);
        int count = 0;
        std::array<std::vector<int>, 3> steps;
        for (int axis = 0; axis < 3; ++axis) {
            auto& list = steps[static_cast<std::size_t>(axis)];
            list = {0};
            if (!container.periodic[static_cast<std::size_t>(axis)]) continue;
            const double size = container.size_m[axis];
            for (int k = 1; own.high[axis] - k * size > 0.0; ++k) list.push_back(-k);
            for (int k = 1; own.low[axis] + k * size < size; ++k) list.push_back(k);
        }
        for (const int i : steps[0])
            for (const int j : steps[1])
                for (const int k : steps[2]) {
                    const Vec3 shift(i * container.size_m.x(), j * container.size_m.y(), k * container.size_m.z());
                    Image image{.capsules = capsules, .bounds = {}, .body = b, .shift = shift, .image = count++};
                    for (auto& capsule : image.capsules) {
                        capsule.a += shift;
                        capsule.b += shift;
                    }
                    image.bounds = bounds_of(image.capsules);
                    images_.push_back(image);
                }
    }
    for (const auto& image : images_) {
        bounds_.low = bounds_.low.cwiseMin(image.bounds.low);
        bounds_.high = bounds_.high.cwiseMax(image.bounds.high);
    }
}

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
                for (Capsule capsule : image.capsules) {
                    capsule.radius = std::hypot(capsule.radius, reach) * (1.0 + 1e-9);
                    if (const auto part = line_interval(capsule, origin, Vec3::UnitZ())) parts.push_back(*part);
                }
            }
    unite(parts);
}

void Grains::line_parts(const Image& image, const Vec3& origin, const Vec3& direction, std::vector<Interval>& parts) const {
    parts.clear();
    for (const auto& capsule : image.capsules)
        if (const auto part = line_interval(capsule, origin, direction)) parts.push_back(*part);
    const Shape& shape = shape_of(image);
    if (!has_filled_cavity(shape)) return;
    unite(parts);
    const Quaternion to_shape = orientation_[image.body].conjugate();
    join_over_cavities(shape, to_shape * (origin - image.shift - position_[image.body]), to_shape * direction, parts);
}

double Grains::distance(const Vec3& point, double cap) const {
    double minimum = cap;
    const int reach = 1 + static_cast<int>(cap / bin_size_);
    for (int dj = -reach; dj <= reach; ++dj)
        for (int di = -reach; di <= reach; ++di)
            for (const int g : near(point.x() + di * bin_size_, point.y() + dj * bin_size_)) {
                const Image& image = images_[static_cast<std::size_t>(g)];
                if (((image.bounds.low - point).array() > minimum).any() || ((point - image.bounds.high).array() > minimum).any()) continue;
                double own = signed_distance(image.capsules, point);
                if (own > 0.0 && has_filled_cavity(shape_of(image)) &&
                    in_cavity(shape_of(image), orientation_[image.body].conjugate() * (point - image.shift - position_[image.body])))
                    own = -own;  // the way out leads through the wall of the cavity
                minimum = std::min(minimum, own);
            }
    return minimum;
}

Section choose_section(const Container& container, const SectionChoice& choice, const Section& bed, double maximum_feret_diameter_m) {
    if (choice.section_m.size() == 2) {
        const Section section{choice.section_m[0], choice.section_m[1]};
        if (container.periodic[2] && (section.z0 > 1e-9 * container.height() || section.z1 < container.height() * (1.0 - 1e-9)))
            throw UserError("a cell that is periodic along z is taken as a whole: it has no section",
                            {.allowed = fmt::format("0,{:g} or nothing", container.height()), .fix = "leave the section out"});
        if (section.length() <= 0.0 || section.z0 < 0.0 || section.z1 > container.height() * (1.0 + 1e-9))
            throw UserError(fmt::format("the section from {:g} to {:g} m is not possible", section.z0, section.z1),
                            {.allowed = fmt::format("0 <= z0 < z1 <= {:g} m (the container's height); the bed is {:g} m high",
                                                    container.height(), bed.z1)});
        const double rounding = 1e-6 * container.height();
        if (choice.bed_known && !container.periodic[2] && (section.z0 < bed.z0 - rounding || section.z1 > bed.z1 + rounding))
            throw UserError(
                fmt::format("the section from {:g} to {:g} m is not in the bed: free space would count as pores", section.z0, section.z1),
                {.allowed = fmt::format("{:.6g} <= z0 < z1 <= {:.6g} m (lowest and highest point of the grains)", bed.z0, bed.z1)});
        return section;
    }
    if (container.periodic[2]) return {0.0, container.size_m.z()};
    const double trim = choice.trim_m > 0.0 ? choice.trim_m : std::min(0.03, maximum_feret_diameter_m);
    const double top = std::min(bed.z1, container.height());
    if (top - bed.z0 - 2.0 * trim <= 0.0)
        throw UserError(fmt::format("nothing is left of the bed: it {} {:.4g} m high, and {:.4g} m are trimmed at both ends",
                                    choice.bed_known ? "is" : "will be about", bed.length(), trim),
                        {.allowed = "in [geometry]: section_m (--section z0,z1), trim_m (--trim)",
                         .fix = "use a smaller trim_m, a section_m, or more grains"});
    return {bed.z0 + trim, top - trim};
}

namespace {

struct LatticeSum {
    double solid = 0.0;
    long lines = 0;
    double area = 0.0;  // of the cells of the lines
};

LatticeSum sum_on_lattice(const Solid& solid, const Container& container, const Section& section, double spacing, double shift) {
    const Vec3 low = container.low();
    const Vec3 high = container.high();
    const int nx = static_cast<int>(std::ceil((high.x() - low.x()) / spacing));
    const int ny = static_cast<int>(std::ceil((high.y() - low.y()) / spacing));
    const double hx = (high.x() - low.x()) / nx;
    const double hy = (high.y() - low.y()) / ny;
    // A sum per row: the same on any number of threads.
    std::vector<LatticeSum> rows(static_cast<std::size_t>(ny));
#pragma omp parallel for schedule(dynamic, 8)
    for (int j = 0; j < ny; ++j) {
        LatticeSum& row = rows[static_cast<std::size_t>(j)];
        std::vector<Interval> parts;
        for (int i = 0; i < nx; ++i) {
            const double x = low.x() + (i + shift) * hx;
            const double y = low.y() + (j + shift) * hy;
            if (!container.contains_column(x, y)) continue;
            ++row.lines;
            solid.column(x, y, parts);
            for (const auto& part : parts) row.solid += std::max(0.0, std::min(part.high, section.z1) - std::max(part.low, section.z0));
        }
    }
    double sum = 0.0;
    long lines = 0;
    for (const LatticeSum& row : rows) {
        sum += row.solid;
        lines += row.lines;
    }
    return {sum, lines, static_cast<double>(lines) * hx * hy};
}

}  // namespace

Packing cut_out(const Packing& packing, const Section& part) {
    Packing cut{.container = packing.container, .shapes = packing.shapes, .bodies = {}, .overlap_allowed = packing.overlap_allowed};
    cut.container.cut_ends = true;
    (cut.container.kind == Container::Kind::cylinder ? cut.container.height_m : cut.container.size_m.z()) = part.length();
    for (Body body : packing.bodies) {
        body.position_m.z() -= part.z0;
        Bounds bounds;
        for (const Capsule& capsule : world_capsules(packing, body)) add(bounds, capsule);
        if (bounds.high.z() > 0.0 && bounds.low.z() < part.length()) cut.bodies.push_back(body);
    }
    return cut;
}

Section whole_bed(const Container& container, const Section& bed) {
    return container.periodic[2] ? Section{0.0, container.height()} : Section{bed.z0, std::min(bed.z1, container.height())};
}

std::array<bool, 3> periodic_sides(const Container& container, const Section& section) {
    return {container.periodic[0], container.periodic[1], container.periodic[2] && section.length() > 0.999 * container.height()};
}

Porosity porosity(const Solid& solid, const Container& container, const Section& section, long lines) {
    if (const std::optional<double> volume = solid.volume_between(section.z0, section.z1)) {
        const double fraction = *volume / (container.inner_area_m2() * section.length());
        constexpr double rounding = 3.0 * 0x1p-24;  // of the three coordinates of an STL file
        return {.value = 1.0 - fraction, .uncertainty = rounding * fraction};
    }
    const double spacing = std::sqrt(2.0 * container.inner_area_m2() / static_cast<double>(lines));
    double values[2], area = 0.0;
    long used = 0;
    for (int lattice = 0; lattice < 2; ++lattice) {
        const LatticeSum sum = sum_on_lattice(solid, container, section, spacing, 0.25 + 0.5 * lattice);
        values[lattice] = 1.0 - sum.solid / (static_cast<double>(sum.lines) * section.length());
        used += sum.lines;
        area += sum.area;
    }
    // The number of lines stands for the area: for grains away from the walls, its error is that of the solid volume.
    const double area_error = (1.0 - 0.5 * (values[0] + values[1])) * std::abs(area / (2.0 * container.inner_area_m2()) - 1.0);
    return {.value = 0.5 * (values[0] + values[1]),
            .uncertainty = 0.5 * std::abs(values[0] - values[1]) + area_error,
            .line_spacing_m = spacing,
            .lines = used};
}

}  // namespace porepack::packing
