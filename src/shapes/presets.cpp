#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "shapes/shape.hpp"

namespace porepack::shapes {
namespace {

// The arms point to four corners of a cube, no two of which share an edge: (1, 1, 1) has the length sqrt(3).
std::vector<Capsule> tetrapod(double r, double L) {
    const double s = L / std::sqrt(3.0);
    const Vec3 o = Vec3::Zero();
    return {{o, Vec3(s, s, s), r}, {o, Vec3(s, -s, -s), r}, {o, Vec3(-s, s, -s), r}, {o, Vec3(-s, -s, s), r}};
}

std::vector<Capsule> dolos(double r, double L) {
    const double h = L / 2.0;
    return {{Vec3(-h, 0, 0), Vec3(h, 0, 0), r}, {Vec3(-h, -h, 0), Vec3(-h, h, 0), r}, {Vec3(h, 0, -h), Vec3(h, 0, h), r}};
}

std::vector<Capsule> tetrahedron(double r, double L) {
    // The same corners; two of them are sqrt(8) apart.
    const double s = L / std::sqrt(8.0);
    const Vec3 corners[4] = {{s, s, s}, {s, -s, -s}, {-s, s, -s}, {-s, -s, s}};
    std::vector<Capsule> edges;
    for (int i = 0; i < 4; ++i)
        for (int j = i + 1; j < 4; ++j) edges.push_back({corners[i], corners[j], r});
    return edges;
}

// Directions that repel each other (Thomson's problem), by steepest descent from a spiral; 4 arms make a tetrapod, 6 a jack.
std::vector<Vec3> spread_directions(long count) {
    std::vector<Vec3> arms;
    const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
    for (long i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count), phi = golden * static_cast<double>(i);
        arms.emplace_back(std::sqrt(1.0 - z * z) * std::cos(phi), std::sqrt(1.0 - z * z) * std::sin(phi), z);
    }
    double step = 0.5 / static_cast<double>(count * count);
    for (int round = 0; round < 20000; ++round) {
        double largest = 0.0;
        std::vector<Vec3> next = arms;
        for (std::size_t i = 0; i < arms.size(); ++i) {
            Vec3 push = Vec3::Zero();
            for (std::size_t j = 0; j < arms.size(); ++j)
                if (j != i) push += (arms[i] - arms[j]) / std::pow((arms[i] - arms[j]).norm(), 3);
            push -= push.dot(arms[i]) * arms[i];
            largest = std::max(largest, push.norm());
            next[i] = (arms[i] + step * push).normalized();
        }
        arms = next;
        if (largest < 1e-13) break;
    }
    return arms;
}

std::vector<Capsule> star(double r, double L, long arms) {
    if (arms < 2 || arms > 64) throw UserError(fmt::format("a star of {} arms is not possible", arms), {.allowed = "2 to 64 arms"});
    std::vector<Capsule> capsules;
    for (const Vec3& direction : spread_directions(arms)) capsules.push_back({Vec3::Zero(), L * direction, r});
    return capsules;
}

double rounded(double value, int digits) {
    if (value == 0.0) return value;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) + 1.0 - digits);
    return std::round(value / unit) * unit;
}

// A preset with diameter 1, whose measures depend only on L/d.
// Sphericity has no dimension, so it fixes L/d alone; the volume then fixes the scale. The measures come from a numerical integration whose
// cost grows with its accuracy: the bracket is found with coarse values, the root with fine ones.
struct UnitPreset {
    ShapeKind kind;
    long arms;
    Cavity cavity;
    [[nodiscard]] ShapeMeasures at(double log_aspect, double tolerance) const {
        Shape shape = make_preset(kind, 1.0, std::exp(log_aspect), arms);
        shape.cavity = cavity;
        if (cavity == Cavity::filled) find_cavities(shape);
        return measure(shape, tolerance, Effort::once);
    }
};

Dimensions solve(const UnitPreset& preset, double sphericity, double volume_m3) {
    constexpr double largest_aspect = 50.0;
    // Tolerances of the search for a bracket, of the slope, and of the answer.
    double coarse = preset.cavity == Cavity::filled ? 1e-5 : 1e-3;
    constexpr double middling = 1e-6, fine = 3e-9;
    const double minimum = preset.at(std::log(largest_aspect), middling).sphericity;
    if (sphericity < minimum)
        throw UserError(fmt::format("no {} has sphericity {:g}", name_of(preset.kind), sphericity),
                        {.allowed = fmt::format("{:.4f} (at L/d = {:g}) to 1", minimum, largest_aspect)});

    // The sphericity decreases with L/d: first a bracket, then the secant method on values of increasing accuracy.
    const auto excess = [&](double log_aspect) { return preset.at(log_aspect, coarse).sphericity - sphericity; };
    // The slope of a smooth shape is of order one; a jump is a closing cavity, and the bracket is narrowed to detect it.
    constexpr double steepest = -3.0;
    double bracket = preset.cavity == Cavity::filled ? 1e-3 : 1e-2, low = std::log(1e-6), high = std::log(largest_aspect), slope = 0.0;
    ShapeMeasures above, below;
    for (; bracket > 1e-9; bracket *= 1e-3, coarse = 1e-5) {
        const auto close_enough = [&](double from, double to) { return to - from < bracket; };
        std::uintmax_t steps = 60;
        std::tie(low, high) = boost::math::tools::toms748_solve(excess, low, high, excess(low), excess(high), close_enough, steps);
        low -= bracket;
        high += bracket;
        above = preset.at(low, middling);
        below = preset.at(high, middling);
        slope = (below.sphericity - above.sphericity) / (high - low);
        if (slope > steepest) break;
    }
    if (slope <= steepest)
        throw UserError(
            fmt::format("no {} with filled cavity has sphericity {:g}: it jumps where the cavity closes", name_of(preset.kind), sphericity),
            {.allowed = fmt::format("above {:.4f} or below {:.4f}", above.sphericity, below.sphericity),
             .fix = "choose another sphericity, or count the cavity as void (cavity = \"open\")"});
    double before = high, excess_before = below.sphericity - sphericity;
    double at = before - excess_before / slope;
    ShapeMeasures here = preset.at(at, middling);
    for (int round = 0; round < 8; ++round) {
        const double excess_here = here.sphericity - sphericity;
        if (round > 0 && std::abs(excess_here) < 1e-10) break;
        // Where rounding dominates the difference, the old slope is better.
        if (std::abs(at - before) > 1e-5) slope = (excess_here - excess_before) / (at - before);
        before = at;
        excess_before = excess_here;
        at -= excess_here / slope;
        here = preset.at(at, fine);
    }
    const double scale = std::cbrt(volume_m3 / here.volume_m3);
    return {scale, std::exp(at) * scale};
}

}  // namespace

Shape make_preset(ShapeKind kind, double diameter, double length, long arms) {
    const std::string name(name_of(kind));
    if (!(diameter > 0.0) || !std::isfinite(diameter))
        throw UserError(fmt::format("the diameter of a {} must be positive, got {:g} m", name, diameter),
                        {.fix = "diameter_m in metres: 0.005"});
    if (!(length >= 0.0) || !std::isfinite(length))
        throw UserError(fmt::format("the length of a {} must not be negative, got {:g} m", name, length),
                        {.allowed = "0 or more, in metres"});
    const double r = diameter / 2;
    switch (kind) {
        case ShapeKind::tetrapod:
            return {.id = name, .capsules = tetrapod(r, length)};
        case ShapeKind::dolos:
            return {.id = name, .capsules = dolos(r, length)};
        case ShapeKind::tetrahedron:
            return {.id = name, .capsules = tetrahedron(r, length)};
        case ShapeKind::sphere:
            return {.id = name, .capsules = {{Vec3::Zero(), Vec3::Zero(), r}}};
        case ShapeKind::rod:
            return {.id = name, .capsules = {{Vec3(0, 0, -length / 2), Vec3(0, 0, length / 2), r}}};
        case ShapeKind::star:
            return {.id = name, .capsules = star(r, length, arms)};
        default:
            throw UserError("unknown preset: " + name, {.allowed = "tetrapod, dolos, tetrahedron, star, sphere, rod"});
    }
}

Dimensions dimensions_for(ShapeKind kind, double sphericity, double volume_m3, Cavity cavity, long arms) {
    if (!(sphericity > 0.0) || sphericity > 1.0)
        throw UserError(fmt::format("sphericity {:g} is not possible", sphericity), {.allowed = "0 < sphericity <= 1 (1 is a sphere)"});
    if (!(volume_m3 > 0.0) || !std::isfinite(volume_m3))
        throw UserError(fmt::format("the volume must be positive, got {:g} m3", volume_m3), {.fix = "volume_m3 in cubic metres: 7.33e-7"});
    const double equal_diameter = std::cbrt(6.0 * volume_m3 / std::numbers::pi);
    if (kind == ShapeKind::sphere && sphericity < 1.0) throw UserError("a sphere has sphericity 1", {.fix = "choose another shape"});
    if (sphericity == 1.0) return {equal_diameter, 0.0};

    // If the open shape encloses no void, the filled one is identical: one search for cavities is enough.
    Dimensions size = solve({kind, arms, Cavity::open}, sphericity, volume_m3);
    if (cavity == Cavity::filled) {
        Shape shape = make_preset(kind, size.diameter_m, size.length_m, arms);
        find_cavities(shape);
        if (!shape.cavity_points.empty()) size = solve({kind, arms, cavity}, sphericity, volume_m3);
    }
    // Nine digits: a packing must not change with the last bits of a root.
    return {rounded(size.diameter_m, 9), rounded(size.length_m, 9)};
}

double smallest_diameter(const Shape& shape) {
    if (shape.body != nullptr) return shape.body->thickness();
    double minimum = 1e300;
    for (const auto& capsule : shape.capsules) minimum = std::min(minimum, 2.0 * capsule.radius);
    return minimum;
}

double maximum_feret_diameter(const Shape& shape) {
    if (shape.body != nullptr) return shape.body->maximum_feret_diameter();
    double largest = 0.0;
    for (const auto& first : shape.capsules)
        for (const auto& second : shape.capsules)
            for (const Vec3& p : {first.a, first.b})
                for (const Vec3& q : {second.a, second.b}) largest = std::max(largest, (p - q).norm() + first.radius + second.radius);
    return largest;
}

void require_capsules(const Shape& shape, const std::string& what) {
    if (shape.body != nullptr)
        throw UserError(fmt::format("{} takes grains of capsules; `{}` has faces", what, shape.id),
                        {.allowed = "tetrapod, dolos, tetrahedron, star, sphere, rod, capsules"});
}

void validate(const Shape& shape) {
    constexpr double smallest_radius_m = 1e-9, largest_length_m = 1e6;
    const auto& capsules = shape.capsules;
    if (shape.body != nullptr) {
        const double reach = shape.body->reach_from(Vec3::Zero());
        if (!(shape.body->thickness() >= 2.0 * smallest_radius_m) || !(reach <= largest_length_m))
            throw UserError(
                fmt::format("shape `{}` is not possible: {:g} m thick, reaching {:g} m", shape.id, shape.body->thickness(), reach),
                {.allowed = "from 2e-9 m thick, within 1e6 m"});
        return;
    }
    if (capsules.empty()) throw UserError("shape `" + shape.id + "` has no capsule", {.fix = "give at least one [[shape.capsule]]"});
    if (capsules.size() > 64) throw UserError(fmt::format("shape `{}` has {} capsules", shape.id, capsules.size()), {.allowed = "1 to 64"});
    for (std::size_t i = 0; i < capsules.size(); ++i)
        if (!(capsules[i].a.norm() <= largest_length_m) || !(capsules[i].b.norm() <= largest_length_m) ||
            !(capsules[i].radius >= smallest_radius_m && capsules[i].radius <= largest_length_m))
            throw UserError(fmt::format("capsule {} of shape `{}` is not possible: radius {:g} m", i, shape.id, capsules[i].radius),
                            {.allowed = "coordinates within 1e6 m, radius_m from 1e-9 to 1e6"});
    // Breadth-first search over the capsules that overlap or touch.
    std::vector<std::size_t> reached = {0};
    std::vector<bool> seen(capsules.size(), false);
    seen[0] = true;
    for (std::size_t next = 0; next < reached.size(); ++next)
        for (std::size_t j = 0; j < capsules.size(); ++j)
            if (!seen[j] && gap(capsules[reached[next]], capsules[j]) <= 0.0) {
                seen[j] = true;
                reached.push_back(j);
            }
    if (reached.size() < capsules.size() && !shape.may_be_disconnected)
        throw UserError(
            fmt::format("shape `{}` is not connected: {} of {} capsules are connected", shape.id, reached.size(), capsules.size()),
            {.fix = "let the capsules overlap, describe two shapes, or allow it: disconnected = true"});
}

}  // namespace porepack::shapes
