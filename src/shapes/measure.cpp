// Volume, area and moments of a union of capsules, by integration over its exposed surface (divergence theorem, Eq. (T2)).
// A capsule's surface is swept by meridians. The exposed parts of each are exact to rounding and integrated by Gauss' rule, so
// that one integral over the angle phi remains. Its integrand is smooth except where a meridian touches another capsule or the
// pattern of exposed parts changes; these angles are found by bisection, and the smooth pieces between them are integrated
// by the Gauss-Kronrod pair (7, 15) in a variable that removes square-root singularities at both ends.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <queue>
#include <vector>

#include "core/parallel.hpp"
#include "shapes/meridian.hpp"
#include "shapes/shape.hpp"

namespace porepack::shapes {
namespace {

// Area, volume, first moments, second moments (xx, yy, zz, xy, yz, zx); of the outer surface, then of the cavities'.
constexpr int quantities = 11;
using Sums = Eigen::Array<double, 2 * quantities, 1>;

// Each volume integral as a flux: the fields x / 3, x_i^2 / 2 e_i, x_i^3 / 3 e_i and x_i^2 x_j / 2 e_i have the divergences 1, x_i, x_i^2
// and x_i x_j.
void add_point(Sums& sums, int offset, const Vec3& x, const Vec3& normal, double dA) {
    const Vec3 n = dA * normal;
    sums[offset] += dA;
    sums[offset + 1] += x.dot(n) / 3.0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        sums[offset + 2 + i] += x[i] * x[i] * n[i] / 2.0;
        sums[offset + 5 + i] += x[i] * x[i] * x[i] * n[i] / 3.0;
        sums[offset + 8 + i] += x[i] * x[i] * x[j] * n[i] / 2.0;
    }
}

constexpr std::array<double, 8> gauss_node = {-0.9602898564975363, -0.7966664774136267, -0.5255324099163290, -0.1834346424956498,
                                              0.1834346424956498,  0.5255324099163290,  0.7966664774136267,  0.9602898564975363};
constexpr std::array<double, 8> gauss_weight = {0.1012285362903763, 0.2223810344533745, 0.3137066458778873, 0.3626837833783620,
                                                0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};

// Errors that no estimate detects: surfaces that coincide within rounding (shared end spheres), and in dense unions features smaller
// than the distance of two meridians. Values from rotating, shifting and reordering about a hundred shapes.
constexpr double unseen_in_few = 5e-8, unseen_in_many = 1e-5;
constexpr std::size_t few = 6;
constexpr int nodes = 15;
constexpr std::array<double, nodes> kronrod_node = {-0.991455371120812639206854697526329, -0.949107912342758524526189684047851,
                                                    -0.864864423359769072789712788640926, -0.741531185599394439863864773280788,
                                                    -0.586087235467691130294144691693013, -0.405845151377397166906606412076961,
                                                    -0.207784955007898467600689403773245, 0.0,
                                                    0.207784955007898467600689403773245,  0.405845151377397166906606412076961,
                                                    0.586087235467691130294144691693013,  0.741531185599394439863864773280788,
                                                    0.864864423359769072789712788640926,  0.949107912342758524526189684047851,
                                                    0.991455371120812639206854697526329};
constexpr std::array<double, 8> kronrod_weight = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                                  0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                                  0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                                  0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
// At every other node of the Kronrod rule.
constexpr std::array<double, 4> embedded_weight = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                                                   0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

struct Stretch {  // of the angle phi on one capsule
    std::size_t own;
    double low, high;
    Sums value = Sums::Zero();
    Eigen::Array3d uncertain = Eigen::Array3d::Zero();  // of area, volume and second moments
    double error = 0.0;                                 // the largest of them, relative to the whole shape
    double change_low = 0.0, change_high = 0.0;         // the pattern of exposed parts changes between these angles, if they differ
    bool operator<(const Stretch& other) const { return error < other.error; }
};

class Integral {
public:
    Integral(const Shape& shape, double tolerance) : shape_(shape), surface_(shape.capsules), tolerance_(tolerance) {}

    /// Begins with `pieces` intervals of phi around each capsule, the first at angle `turn`.
    void run(int pieces, double turn) {
        total_.setZero();
        scale_.setOnes();
        error_ = 0.0;
        evaluations_ = 0;
        std::priority_queue<Stretch> open;
        std::vector<Stretch> first;
        for (std::size_t own = 0; own < surface_.capsules().size(); ++own)
            for (int k = 0; k < pieces; ++k) {
                const double width = 2.0 * std::numbers::pi / pieces;
                first.push_back(integrated(own, turn + k * width, turn + (k + 1) * width));
                total_ += first.back().value;
            }
        // Reference values of the relative errors.
        // The first estimate of the whole shape; before it the scale is 1, because no stretch knows the sum.
        scale_.setZero();
        for (const int offset : {0, quantities}) {
            scale_[0] += std::abs(total_[offset]);
            scale_[1] += std::abs(total_[offset + 1]);
            scale_[2] += total_.segment<3>(offset + 5).abs().sum();
        }
        for (auto& stretch : first) {
            stretch.error = (stretch.uncertain / scale_).maxCoeff();
            error_ += stretch.error;
            open.push(stretch);
        }
        // Global adaptivity: the stretch with the largest error is divided until the sum of the errors is small enough.
        while (error_ > tolerance_ && evaluations_ < (tolerance_ < exacting ? max_evaluations : max_evaluations / 8)) {
            const Stretch worst = open.top();
            open.pop();
            total_ -= worst.value;
            error_ -= worst.error;
            for (const auto& part : split(worst)) {
                total_ += part.value;
                error_ += part.error;
                open.push(part);
            }
        }
        // Summed again: updating by differences would accumulate rounding errors.
        total_.setZero();
        error_ = 0.0;
        for (; !open.empty(); open.pop()) {
            total_ += open.top().value;
            error_ += open.top().error;
        }
    }

    [[nodiscard]] const Sums& total() const { return total_; }
    [[nodiscard]] double error() const { return error_; }
    [[nodiscard]] long evaluations() const { return evaluations_; }

private:
    static constexpr long max_evaluations = 1'000'000;
    static constexpr double exacting = 1e-7;  // a tolerance below this uses all of them, otherwise an eighth

    // The exposed parts at `phi` as a hash of the surfaces at their ends.
    std::uint64_t pattern(std::size_t own, double phi) {
        ++evaluations_;
        surface_.meridian(own, phi, parts_);
        std::uint64_t hash = 1469598103934665603U;
        const auto mix = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211U; };
        in_cavity_.clear();
        for (const auto& part : parts_) {
            // An exposed part is one connected piece of the surface, so it lies either entirely inside or entirely outside a cavity.
            bool inner = false;
            if (!shape_.cavity_points.empty()) {
                const SurfacePoint middle = surface_.point(own, phi, part.piece, 0.5 * (part.low + part.high));
                inner = in_cavity(shape_, middle.x + 1e-7 * surface_.capsules()[own].radius * middle.normal);
            }
            in_cavity_.push_back(inner);
            mix(static_cast<std::uint64_t>(part.piece));
            mix(part.low_tag);
            mix(part.high_tag);
            mix(inner);
        }
        return hash;
    }

    void add_meridian(Sums& sums, std::size_t own, double phi, double weight) const {
        for (std::size_t p = 0; p < parts_.size(); ++p) {
            const ExposedPart& part = parts_[p];
            const double half = 0.5 * (part.high - part.low);
            for (std::size_t g = 0; g < gauss_node.size(); ++g) {
                const SurfacePoint at = surface_.point(own, phi, part.piece, part.low + half * (1.0 + gauss_node[g]));
                add_point(sums, in_cavity_[p] ? quantities : 0, at.x, at.normal, at.area_per_parameter * half * gauss_weight[g] * weight);
            }
        }
    }

    [[nodiscard]] Stretch integrated(std::size_t own, double low, double high) {
        Stretch stretch{.own = own, .low = low, .high = high};
        const double width = high - low;
        Sums embedded = Sums::Zero(), size = Sums::Zero();
        std::uint64_t before = 0;
        double phi_before = low;
        bool changed = false;
        for (int k = 0; k < nodes; ++k) {
            // phi = low + width s^2 (3 - 2 s): a square root at an end becomes linear in s.
            const double s = 0.5 * (1.0 + kronrod_node[static_cast<std::size_t>(k)]);
            const double phi = low + width * s * s * (3.0 - 2.0 * s);
            const std::uint64_t hash = pattern(own, phi);
            if (k > 0 && hash != before && !changed) {
                changed = true;
                stretch.change_low = phi_before;
                stretch.change_high = phi;
            }
            before = hash;
            phi_before = phi;
            Sums value = Sums::Zero();
            add_meridian(value, own, phi, 0.5 * width * 6.0 * s * (1.0 - s));
            const auto mirrored = static_cast<std::size_t>(std::min(k, nodes - 1 - k));
            stretch.value += kronrod_weight[mirrored] * value;
            size += kronrod_weight[mirrored] * value.abs();
            if (k % 2 == 1) embedded += embedded_weight[mirrored / 2] * value;
        }
        for (int q = 0; q < 3; ++q)
            for (const int offset : {0, quantities}) {
                const int at = offset + (q < 2 ? q : 5);
                const int count = q < 2 ? 1 : 3;
                stretch.uncertain[q] +=
                    kronrod_error((stretch.value - embedded).segment(at, count).abs().sum(), size.segment(at, count).sum());
            }
        stretch.error = (stretch.uncertain / scale_).maxCoeff();
        return stretch;
    }

    // As in QUADPACK: where both rules have converged their difference is far larger than the error of the better one.
    [[nodiscard]] static double kronrod_error(double difference, double size) {
        if (size == 0.0) return 0.0;
        return std::min(difference, size * std::pow(200.0 * difference / size, 1.5));
    }

    [[nodiscard]] std::vector<Stretch> split(const Stretch& stretch) {
        // The integrand is not smooth where the pattern changes. The change is located by bisection and becomes an end of both halves; a
        // change too near to an end is ignored, and the stretch is halved.
        if (stretch.change_high > stretch.change_low) {
            double low = stretch.change_low, high = stretch.change_high;
            const std::uint64_t at_low = pattern(stretch.own, low);
            while (high - low > 1e-9) {
                const double middle = 0.5 * (low + high);
                (pattern(stretch.own, middle) == at_low ? low : high) = middle;
            }
            const double change = 0.5 * (low + high);
            if (change - stretch.low > 1e-8 && stretch.high - change > 1e-8)
                return {integrated(stretch.own, stretch.low, change), integrated(stretch.own, change, stretch.high)};
        }
        const double middle = 0.5 * (stretch.low + stretch.high);
        return {integrated(stretch.own, stretch.low, middle), integrated(stretch.own, middle, stretch.high)};
    }

    const Shape& shape_;
    ExposedSurface surface_;
    double tolerance_;
    std::vector<ExposedPart> parts_;
    std::vector<bool> in_cavity_;
    Sums total_ = Sums::Zero();
    Eigen::Array3d scale_ = Eigen::Array3d::Ones();
    double error_ = 0.0;
    long evaluations_ = 0;
};

}  // namespace

namespace {

// A feature that begins and ends between two meridians is missed, and no local estimate detects it. So everything is done twice
// with different meridians; where the two disagree, again with three times as many initial meridians.
struct Integrated {
    Sums total;
    double error = 0.0;
    long evaluations = 0;
};

Integrated integrate(const Shape& scaled, double tolerance, bool twice) {
    std::array<Integral, 2> passes = {Integral(scaled, tolerance), Integral(scaled, tolerance)};
    const Sums &total = passes[0].total(), &other = passes[1].total();
    Integrated result;
    constexpr int min_pieces = 6, rounds = 4;
    int pieces = min_pieces;
    for (int round = 0; round < rounds; ++round, pieces *= 3) {
        // The second pass begins at an irrational fraction of an interval: its meridians are nowhere those of the first.
        const std::array<double, 2> turn = {0.0, 0.7548776662466927 * 2.0 * std::numbers::pi / pieces};
        parallel_for(twice ? 2 : 1, [&](std::size_t pass) { passes[pass].run(pieces, turn[pass]); });
        result.total = total;
        result.error = passes[0].error();
        result.evaluations += passes[0].evaluations();
        if (!twice) break;
        result.evaluations += passes[1].evaluations();
        double difference = 0.0;
        for (int q = 0; q < 2; ++q) {
            const double whole = std::abs(other[q]) + std::abs(other[quantities + q]);
            difference = std::max(difference, std::abs(other[q] - total[q]) / whole);
            difference = std::max(difference, std::abs(other[quantities + q] - total[quantities + q]) / whole);
        }
        result.error = std::max(result.error, difference);
        // Each repetition costs three times the last one, so small differences are accepted.
        constexpr double bearable = 5.0;
        constexpr long dear = 200'000;
        if (result.error <= bearable * tolerance || result.evaluations > dear) break;
    }
    return result;
}

// Of sums in the unit `unit` about the point `about`.
ShapeMeasures measures_of(const Eigen::Array<double, quantities, 1>& sums, const Vec3& about, double unit) {
    ShapeMeasures measures;
    const double area = sums[0], volume = sums[1];
    const double unit3 = unit * unit * unit;
    measures.surface_area_m2 = area * unit * unit;
    measures.volume_m3 = volume * unit3;
    const Vec3 centre = sums.segment<3>(2).matrix() / volume;
    measures.centre_of_mass_m = about + unit * centre;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        second(i, i) = sums[5 + i];
        second(i, j) = second(j, i) = sums[8 + i];
    }
    second -= volume * centre * centre.transpose();
    measures.inertia_per_density_m5 = (second.trace() * Eigen::Matrix3d::Identity() - second) * unit3 * unit * unit;
    measures.sphericity = std::cbrt(36.0 * std::numbers::pi * volume * volume) / area;
    return measures;
}

// Its pieces are known, and each is integrated by one Gauss rule.
ShapeMeasures measure_body(const Shape& shape) {
    Vec3 about;  // the middle
    for (int axis = 0; axis < 3; ++axis)
        about[axis] = 0.5 * (shape.body->support(Vec3::Unit(axis)) - shape.body->support(-Vec3::Unit(axis)));
    const double unit = shape.body->reach_from(about);
    Sums sums = Sums::Zero();
    shape.body->for_surface(
        [&](const Vec3& x, const Vec3& n, double area) { add_point(sums, 0, (x - about) / unit, n, area / (unit * unit)); });
    // Moments that vanish by symmetry, but for rounding.
    for (int q = 2; q < quantities; ++q)
        if (std::abs(sums[q]) < 1e-14) sums[q] = 0.0;
    ShapeMeasures measures = measures_of(sums.head<quantities>(), about, unit);
    measures.bounding_radius_m = shape.body->reach_from(measures.centre_of_mass_m);
    measures.maximum_feret_diameter_m = shape.body->maximum_feret_diameter();
    measures.relative_error = shape.body->surface_error();
    return measures;
}

}  // namespace

ShapeMeasures measure(const Shape& shape, double tolerance, Effort effort) {
    if (shape.body != nullptr) return measure_body(shape);
    // In units of the shape's own size, about its middle: sizes of 1e-9 m and 1e3 m have the same relative error.
    const Bounds bounds = bounds_of(shape.capsules);
    const Vec3 about = 0.5 * (bounds.low + bounds.high);
    const double unit = 0.5 * (bounds.high - bounds.low).maxCoeff();
    Shape scaled{.id = shape.id, .capsules = {}, .cavity = shape.cavity};
    for (const auto& capsule : shape.capsules)
        scaled.capsules.push_back({(capsule.a - about) / unit, (capsule.b - about) / unit, capsule.radius / unit});
    for (const auto& point : shape.cavity_points) scaled.cavity_points.emplace_back((point - about) / unit);
    scaled.void_cells = {
        .origin = (shape.void_cells.origin - about) / unit, .size = shape.void_cells.size / unit, .label = shape.void_cells.label};
    scaled.cavity_bounds = {(shape.cavity_bounds.low - about) / unit, (shape.cavity_bounds.high - about) / unit};

    // An estimate far below the undetected errors has no use.
    const double floor = shape.capsules.size() <= few ? unseen_in_few : unseen_in_many;
    const Integrated integral =
        integrate(scaled, std::max(tolerance, effort == Effort::twice && shape.capsules.size() > few ? 0.1 * unseen_in_many : 0.0),
                  effort == Effort::twice);
    const auto& total = integral.total;
    Eigen::Array<double, quantities, 1> sums = total.head<quantities>();
    // The walls of a filled cavity do not belong to the surface; the flux through the outer surface alone includes the cavity's volume.
    if (shape.cavity == Cavity::open) sums += total.tail<quantities>();

    ShapeMeasures measures = measures_of(sums, about, unit);
    measures.cavity_volume_m3 = std::max(0.0, -total[quantities + 1]) * unit * unit * unit;  // its outward normal points into the void
    measures.cavity_area_m2 = total[quantities] * unit * unit;
    for (const auto& capsule : shape.capsules)
        for (const Vec3& end : {capsule.a, capsule.b})
            measures.bounding_radius_m = std::max(measures.bounding_radius_m, (end - measures.centre_of_mass_m).norm() + capsule.radius);
    measures.maximum_feret_diameter_m = maximum_feret_diameter(shape);
    measures.relative_error = std::max(integral.error, floor);
    measures.meridians = integral.evaluations;
    return measures;
}

}  // namespace porepack::shapes
