#include "design/candidates.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "design/uses.hpp"

namespace porepack::design {
namespace {

constexpr int preset_steps = 150;
constexpr double shortest = 0.02, longest = 12.0;  // length / diameter: sphericities from below 0.43 to above 0.99 for each preset
constexpr double grains_of_own_shape = 100.0;
constexpr double measured_to = 1e-5;

Candidate measured(std::string family, ShapeConfig config, std::vector<double> parameters) {
    const Shape shape = make_shape(config);
    const ShapeMeasures measures = measure(shape, measured_to, Effort::once);
    const double size = std::cbrt(6.0 * measures.volume_m3 / std::numbers::pi);
    return {.family = std::move(family),
            .shape = scaled(config, 1.0 / size),
            .form = {.sphericity = measures.sphericity,
                     .convexity = std::min(1.0, measures.volume_m3 / hull(shape).volume_m3),
                     .thickness = smallest_diameter(shape) / size,
                     .feret = maximum_feret_diameter(shape) / size},
            .parameters = std::move(parameters)};
}

// Grains that are no valid shape are left out.
std::vector<Candidate> all_measured(std::size_t count, const std::function<Candidate(std::size_t)>& one) {
    std::vector<std::optional<Candidate>> found(count);
    parallel_for(count, [&](std::size_t i) {
        try {
            found[i] = one(i);
        } catch (const UserError&) {
            found[i].reset();
        }
    });
    std::vector<Candidate> candidates;
    for (const auto& candidate : found)
        if (candidate) candidates.push_back(*candidate);
    return candidates;
}

struct Place {
    std::size_t capsule;  // the number of capsules: all of them
    bool radius;
};

Place place_of(const FreeParameter& parameter, const ShapeConfig& shape) {
    const std::size_t count = shape.capsule.size();
    if (parameter.name == "radius_m") return {count, true};
    std::size_t number = 0;
    int used = 0;
    if (std::sscanf(parameter.name.c_str(), "capsule.%zu.%n", &number, &used) == 1 && number >= 1 && number <= count) {
        const std::string rest = parameter.name.substr(static_cast<std::size_t>(used));
        if (rest == "radius_m" || rest == "length_m") return {number - 1, rest == "radius_m"};
    }
    throw UserError(
        fmt::format("the shape has no parameter \"{}\"", parameter.name),
        {.where = "--free", .allowed = fmt::format("radius_m, capsule.N.radius_m, capsule.N.length_m, with N from 1 to {}", count)});
}

void set(ShapeConfig& shape, const Place& place, double value) {
    for (std::size_t i = 0; i < shape.capsule.size(); ++i) {
        if (place.capsule != shape.capsule.size() && place.capsule != i) continue;
        Capsule& capsule = shape.capsule[i];
        if (place.radius) {
            capsule.radius = value;
        } else {
            const Vec3 axis = capsule.b - capsule.a;
            if (axis.norm() == 0.0)
                throw UserError(fmt::format("capsule {} is a sphere: it has no axis along which it could grow", i + 1),
                                {.where = "--free"});
            capsule.b = capsule.a + value * axis.normalized();
        }
    }
}

}  // namespace

FreeParameter parse_free_parameter(const std::string& text) {
    const std::size_t equals = text.find('=');
    FreeParameter parameter{.name = text.substr(0, equals)};
    int used = 0;
    if (equals == std::string::npos || std::sscanf(text.c_str() + equals + 1, "%lf,%lf%n", &parameter.low, &parameter.high, &used) != 2 ||
        equals + 1 + static_cast<std::size_t>(used) != text.size() || !(0.0 < parameter.low && parameter.low < parameter.high) ||
        !std::isfinite(parameter.high))
        throw UserError(
            fmt::format("\"{}\" is no free parameter", text),
            {.where = "--free", .allowed = "NAME=LOW,HIGH with 0 < LOW < HIGH", .fix = "--free capsule.2.radius_m=0.001,0.002"});
    return parameter;
}

ShapeConfig scaled(const ShapeConfig& shape, double size_m) {
    ShapeConfig other = shape;
    other.diameter_m *= size_m;
    other.length_m *= size_m;
    for (Capsule& capsule : other.capsule) {
        capsule.a *= size_m;
        capsule.b *= size_m;
        capsule.radius *= size_m;
    }
    return other;
}

std::vector<Candidate> preset_candidates(ShapeKind kind, const Interval& sphericity, long arms) {
    const std::string family(name_of(kind));
    if (kind == ShapeKind::sphere) return {measured(family, {.kind = kind, .diameter_m = 1.0}, {0.0})};
    std::vector<Candidate> candidates = all_measured(preset_steps, [&](std::size_t i) {
        const double ratio = shortest * std::pow(longest / shortest, static_cast<double>(i) / (preset_steps - 1));
        return measured(family, {.kind = kind, .diameter_m = 1.0, .length_m = ratio, .arms = arms}, {ratio});
    });
    std::erase_if(candidates,
                  [&](const Candidate& one) { return one.form.sphericity < sphericity.low || one.form.sphericity > sphericity.high; });
    return candidates;
}

std::vector<Candidate> own_candidates(const std::string& family, const ShapeConfig& shape, const std::vector<FreeParameter>& free) {
    if (shape.kind != ShapeKind::capsules || shape.capsule.empty())
        throw UserError("the shape is not a list of capsules",
                        {.where = family, .allowed = "[[capsule]] tables with a_m, b_m and radius_m"});
    std::vector<Place> places;
    for (const FreeParameter& parameter : free) places.push_back(place_of(parameter, shape));
    const auto steps = free.empty()
                           ? std::size_t{1}
                           : static_cast<std::size_t>(std::lround(std::pow(grains_of_own_shape, 1.0 / static_cast<double>(free.size()))));
    if (steps < 2 && !free.empty())
        throw UserError(fmt::format("{} parameters are free", free.size()), {.where = "--free", .allowed = "at most 6"});
    std::size_t count = 1;
    for (std::size_t i = 0; i < free.size(); ++i) count *= steps;
    const auto grain = [&](std::size_t number) {
        ShapeConfig one = shape;
        std::vector<double> values;
        for (std::size_t p = 0; p < free.size(); ++p, number /= steps) {
            const double t = static_cast<double>(number % steps) / static_cast<double>(steps - 1);
            values.push_back(free[p].low + t * (free[p].high - free[p].low));
            set(one, places[p], values.back());
        }
        return measured(family, one, values);
    };
    if (count == 1) return {grain(0)};
    std::vector<Candidate> candidates = all_measured(count, grain);
    if (candidates.empty())
        throw UserError("no combination of the free parameters is a valid shape", {.where = family, .fix = "change the ranges of --free"});
    return candidates;
}

}  // namespace porepack::design
