#include "design/candidates.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

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

using Setter = std::function<void(ShapeConfig& shape, double value)>;

Setter setter_of_faced(const FreeParameter& parameter, const ShapeConfig& shape) {
    std::vector<std::string> names;
    for (const SizeKey& key : size_keys) {
        if (!(shape.*key.size > 0.0) && key.size != &ShapeConfig::rounding_m) continue;
        if (parameter.name == key.name) return [size = key.size](ShapeConfig& one, double value) { one.*size = value; };
        names.emplace_back(key.name);
    }
    throw UserError(fmt::format("the shape has no parameter \"{}\"", parameter.name),
                    {.where = "--free", .allowed = fmt::format("{}", fmt::join(names, ", "))});
}

void set_length(Capsule& capsule, double length) {
    capsule.b = capsule.a + length * (capsule.b - capsule.a).normalized();
}

Setter setter_of(const FreeParameter& parameter, const ShapeConfig& shape) {
    if (has_faces(shape.kind)) return setter_of_faced(parameter, shape);
    if (parameter.name == "radius_m")
        return [](ShapeConfig& one, double value) {
            for (Capsule& capsule : one.capsule) capsule.radius = value;
        };
    const std::size_t count = shape.capsule.size();
    std::size_t number = 0;
    int used = 0;
    if (std::sscanf(parameter.name.c_str(), "capsule.%zu.%n", &number, &used) == 1 && number >= 1 && number <= count) {
        const std::string rest = parameter.name.substr(static_cast<std::size_t>(used));
        const std::size_t i = number - 1;
        if (rest == "radius_m") return [i](ShapeConfig& one, double value) { one.capsule[i].radius = value; };
        if (rest == "length_m") {
            if (shape.capsule[i].a == shape.capsule[i].b)
                throw UserError(fmt::format("capsule {} is a sphere: it has no axis along which it could grow", number),
                                {.where = "--free"});
            return [i](ShapeConfig& one, double value) { set_length(one.capsule[i], value); };
        }
    }
    throw UserError(
        fmt::format("the shape has no parameter \"{}\"", parameter.name),
        {.where = "--free", .allowed = fmt::format("radius_m, capsule.N.radius_m, capsule.N.length_m, with N from 1 to {}", count)});
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
    for (const SizeKey& key : size_keys) other.*key.size *= size_m;
    for (double& edge : other.size_m) edge *= size_m;
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
    if (kind == ShapeKind::cube) return {measured(family, {.kind = kind, .side_m = 1.0}, {0.0})};
    std::vector<Candidate> candidates = all_measured(preset_steps, [&](std::size_t i) {
        const double ratio = shortest * std::pow(longest / shortest, static_cast<double>(i) / (preset_steps - 1));
        ShapeConfig one{.kind = kind, .diameter_m = 1.0, .arms = arms};
        (has_faces(kind) ? one.height_m : one.length_m) = ratio;
        return measured(family, one, {ratio});
    });
    std::erase_if(candidates,
                  [&](const Candidate& one) { return one.form.sphericity < sphericity.low || one.form.sphericity > sphericity.high; });
    return candidates;
}

std::vector<Candidate> own_candidates(const std::string& family, const ShapeConfig& shape, const std::vector<FreeParameter>& free) {
    if (shape.kind == ShapeKind::mesh || shape.kind == ShapeKind::library)
        throw UserError(fmt::format("a search does not take grains from meshes (kind = \"{}\")", name_of(shape.kind)),
                        {.where = family,
                         .allowed = "[[capsule]] tables, or a kind with faces and its sizes",
                         .fix = "`porepack study` varies a case with such grains"});
    if (!has_faces(shape.kind) && (shape.kind != ShapeKind::capsules || shape.capsule.empty()))
        throw UserError("the shape is neither a list of capsules nor a grain with faces",
                        {.where = family, .allowed = "[[capsule]] tables with a_m, b_m and radius_m; or a kind with faces and its sizes"});
    if (shape.volume_m3 > 0.0)
        throw UserError("the shape is given by its volume", {.where = family, .fix = "give its sizes: the search chooses the volume"});
    std::vector<Setter> setters;
    for (const FreeParameter& parameter : free) setters.push_back(setter_of(parameter, shape));
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
            setters[p](one, values.back());
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
