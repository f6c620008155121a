#include "design/forecast.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "design/uses.hpp"
#include "record/toml_file.hpp"

namespace porepack::design {
namespace {

// A grain whose maximum Feret diameter is above this fraction of the container's width jams in it.
constexpr double largest_feret = 0.8;

double normal_distribution(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

ShapeConfig read_shape(const Path& file) {
    const TomlFile toml(file);
    ShapeConfig config;
    toml.read(toml.has("shape") ? "shape" : "", [&](ConfigVisitor& v) { describe(v, config); }, {{"kind", "\"capsules\""}});
    return config;
}

// The mean of the bed lies in the goal's range, or as near to its only value as its own interval is wide.
double chance_of(const Estimate& expected, const Interval& wanted, double half_width) {
    const double margin = wanted.low == wanted.high ? half_width : 0.0;
    return normal_distribution((wanted.high + margin - expected.value) / expected.standard_deviation) -
           normal_distribution((wanted.low - margin - expected.value) / expected.standard_deviation);
}
double distance_of(const Estimate& expected, const Interval& wanted) {
    return std::max({0.0, wanted.low - expected.value, expected.value - wanted.high}) / expected.standard_deviation;
}

// Computed before in this size; or so near to a grain that could not be computed that it would fail as well.
bool is_tried(const SizedCandidate& one, const Proposal& before) {
    constexpr double near = 0.03, same_size = 0.005;
    const GrainForm &a = one.candidate.form, &b = before.grain.candidate.form;
    if (!before.error.empty()) return one.candidate.family == before.grain.candidate.family && std::abs(a.sphericity - b.sphericity) < near;
    return same_grain(one.candidate, before.grain.candidate) && std::abs(one.size_m / before.grain.size_m - 1.0) < same_size;
}

}  // namespace

bool same_grain(const Candidate& one, const Candidate& other) {
    return one.family == other.family && one.parameters == other.parameters;
}

bool same_bed(double wall, double other) {
    constexpr double rounding = 1e-9;
    return std::abs(wall / other - 1.0) < rounding;
}

Forecaster::Forecaster(const DesignGoal& goal, const DesignBed& bed, std::vector<KnownBed> known)
    : goal_(goal), bed_(bed), known_(std::move(known)) {
    for (const ShapeKind kind : goal.kinds) {
        const std::vector<Candidate> some = preset_candidates(kind, goal.sphericity);
        candidates_.insert(candidates_.end(), some.begin(), some.end());
    }
    if (!goal.own_shape.empty()) {
        const std::vector<Candidate> some = own_candidates(goal.own_shape.filename().string(), read_shape(goal.own_shape), goal.free);
        candidates_.insert(candidates_.end(), some.begin(), some.end());
    }
    if (candidates_.empty()) throw UserError("there is no shape to choose from", {.where = "--shape, --sphericity", .fix = "allow more"});
    if (forecasts({}).empty())
        throw UserError("no grain meets the limits", {.where = "--convexity, --thinnest, --mass, or grains larger than the container",
                                                      .fix = "allow more, or another volume or container"});
}

Forecaster::HalfWidths Forecaster::expected_half_widths() const {
    const ScatterOfBeds k = permeability_scatter(known_), porosity = porosity_scatter(known_);
    return {k.half_width({k.typical().value_or(scatter_without_data), goal_.packings}),
            porosity.half_width({porosity.typical().value_or(porosity_scatter_without_data), goal_.packings})};
}

// What the bed of a grain tells about the same grain in another size: k / d_v^2 and the porosity stay, but for the wall's part. That is
// known better than what beds of other grains tell. None if the grain has not been computed.
std::optional<Prediction> Forecaster::own_prediction(const Candidate& grain, double wall, const std::vector<Proposal>& computed) const {
    const Proposal* nearest = nullptr;
    for (const Proposal& p : computed)
        if (p.error.empty() && same_grain(p.grain.candidate, grain) &&
            (nearest == nullptr || std::abs(p.bed.wall - wall) < std::abs(nearest->bed.wall - wall)))
            nearest = &p;
    if (nearest == nullptr) return std::nullopt;
    if (same_bed(nearest->bed.wall, wall) && nearest->permeability_half_width() <= goal_.within) {
        constexpr double certain = 1e-9;  // this bed will be magnified, not poured
        return Prediction{.porosity = {nearest->bed.porosity, certain}, .log_permeability = {std::log(nearest->bed.permeability), certain}};
    }
    const double eps = nearest->bed.porosity, of_wall = Surrogate::porosity_per_wall * std::abs(nearest->bed.wall - wall),
                 half_width = core::half_widths(eps, nearest->porosity_interval).wider();
    return Prediction{
        .porosity = {eps, std::hypot(0.5 * half_width, of_wall)},
        .log_permeability = {std::log(nearest->bed.permeability), std::hypot(0.5 * nearest->permeability_half_width(),
                                                                             Surrogate::log_permeability_per_porosity(eps) * of_wall)}};
}

SizedCandidate Forecaster::forecast(const Candidate& candidate, double size_m, const Prediction& prediction,
                                    const HalfWidths& expected) const {
    SizedCandidate one{.candidate = candidate, .size_m = size_m, .bed_wall = bed_.wall(size_m), .prediction = prediction};
    Estimate log_k = prediction.log_permeability;
    log_k.value += 2.0 * std::log(size_m);
    const Interval wanted = {std::log(goal_.permeability_m2.low), std::log(goal_.permeability_m2.high)};
    // An interval that is wider than `within` is no hit.
    one.chance = chance_of(log_k, wanted, std::min(expected.permeability, goal_.within));
    one.distance = distance_of(log_k, wanted);
    if (goal_.porosity) {
        // k and porosity count as independent.
        one.chance *= chance_of(prediction.porosity, *goal_.porosity, expected.porosity);
        one.distance = std::hypot(one.distance, distance_of(prediction.porosity, *goal_.porosity));
    }
    return one;
}

bool Forecaster::allowed(const SizedCandidate& one) const {
    const GrainForm& form = one.candidate.form;
    const double mass = bed_.density_kg_per_m3() * std::numbers::pi / 6.0 * std::pow(one.size_m, 3);
    const double width = std::min(goal_.container.size().x(), goal_.container.size().y());
    return form.convexity >= goal_.convexity.low && form.convexity <= goal_.convexity.high &&
           form.thickness * one.size_m >= goal_.thinnest_m && mass >= goal_.mass_kg.low && mass <= goal_.mass_kg.high &&
           form.feret * one.size_m <= largest_feret * width;
}

std::vector<SizedCandidate> Forecaster::forecasts(const std::vector<Proposal>& computed) const {
    const Surrogate surrogate(known_);
    const HalfWidths expected = expected_half_widths();
    std::vector<SizedCandidate> all;
    for (const Candidate& candidate : candidates_) {
        const auto prediction = [&](double size_m) {
            const double wall = bed_.wall(size_m);
            const std::optional<Prediction> own = own_prediction(candidate, wall, computed);
            return own ? *own : surrogate.at(candidate.form, wall);
        };
        double size_m = std::cbrt(6.0 * goal_.volume_m3 / std::numbers::pi);
        // With the volume free, the size gives the permeability; the wall ratio, which depends on it, changes it little.
        if (goal_.volume_m3 == 0.0) {
            size_m = 1e-2;
            // Fixed-point iteration for the size from k = d_v^2 exp(log_permeability(d_v)), at the geometric mean of the wanted range.
            const double wanted = std::sqrt(goal_.permeability_m2.low * goal_.permeability_m2.high);
            for (int pass = 0; pass < 20; ++pass) size_m = std::sqrt(wanted / std::exp(prediction(size_m).log_permeability.value));
        }
        const SizedCandidate one = forecast(candidate, size_m, prediction(size_m), expected);
        if (allowed(one)) all.push_back(one);
    }
    return all;
}

std::optional<SizedCandidate> best(const std::vector<SizedCandidate>& all, const std::vector<Proposal>& computed) {
    std::optional<SizedCandidate> found;
    for (const SizedCandidate& one : all) {
        if (std::any_of(computed.begin(), computed.end(), [&](const Proposal& before) { return is_tried(one, before); })) continue;
        // Chances too small to be told apart are ranked by distance.
        const auto worse = [](const SizedCandidate& a, const SizedCandidate& b) {
            constexpr double tiny = 1e-6;
            return a.chance < tiny && b.chance < tiny ? a.distance > b.distance : a.chance < b.chance;
        };
        if (!found || worse(*found, one)) found = one;
    }
    return found;
}

}  // namespace porepack::design
