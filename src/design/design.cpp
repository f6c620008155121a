#include "design/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/file_lock.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/owned_names.hpp"
#include "design/bed.hpp"
#include "design/page.hpp"
#include "design/uses.hpp"
#include "pouring/pour.hpp"
#include "record/toml_file.hpp"
#include "report/page.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::design {
namespace fs = std::filesystem;
namespace {

// A grain whose maximum Feret diameter is above this fraction of the container's width jams in it.
constexpr double largest_feret = 0.8;
// Below this chance of every candidate, the search ends; the goal counts as out of reach if it is so many standard deviations away.
constexpr double smallest_chance = 0.02, far_off = 2.0;
constexpr long most_packings = 4;
constexpr const char* last_stage = "seeds";
constexpr double scatter_without_data = 0.12, porosity_scatter_without_data = 0.01;

double normal_distribution(double x) {
    return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

double middle(const Interval& interval) {
    return 0.5 * (interval.low + interval.high);
}

class Design {
public:
    Design(const DesignGoal& goal, const Study& study, Path folder)
        : goal_(goal), folder_(std::move(folder)), bed_(goal, study), known_(known_beds(study)) {
        for (const ShapeKind kind : goal.kinds) {
            const std::vector<Candidate> some = preset_candidates(kind, goal.sphericity);
            candidates_.insert(candidates_.end(), some.begin(), some.end());
        }
        if (!goal.own_shape.empty()) {
            const std::vector<Candidate> some =
                own_candidates(goal.own_shape.filename().string(), read_capsules(goal.own_shape), goal.free);
            candidates_.insert(candidates_.end(), some.begin(), some.end());
        }
        if (candidates_.empty())
            throw UserError("there is no shape to choose from", {.where = "--shape, --sphericity", .fix = "allow more"});
        if (forecasts({}).empty())
            throw UserError("no grain meets the limits", {.where = "--convexity, --thinnest, --mass, or grains larger than the container",
                                                          .fix = "allow more, or another volume or container"});
    }

    DesignResult run() {
        DesignResult result;
        for (long n = 1; n <= goal_.max_proposals; ++n) {
            result.reachable = forecasts(result.proposals);
            if (out_of_time()) break;
            std::optional<SizedCandidate> next = best(result.reachable, result.proposals);
            if (!next) break;
            if (next->chance < smallest_chance && !result.proposals.empty() && result.proposals.back().error.empty()) {
                // A narrow goal within what is expected is in reach: the intervals are too wide to tell.
                if (next->distance > far_off) result.verdict = Verdict::out_of_reach;
                break;
            }
            log_info("design: proposal {} of at most {}: {}", n, goal_.max_proposals, text_of(*next));
            result.proposals.push_back(compute(*next, n, result.proposals));
            const Proposal& made = result.proposals.back();
            if (made.error.empty() && made.magnified_from == 0) known_.push_back(made.bed);
            log_info("design: proposal {}: {}", n,
                     made.error.empty() ? fmt::format("k = {:.3g} m2 {}, porosity {:.3f}{}", made.permeability_m2,
                                                      percent_text(made.permeability_m2, made.permeability_interval_m2), made.bed.porosity,
                                                      made.hit ? ": a hit" : "")
                                        : "failed: " + made.error);
            if (made.hit) {
                result.verdict = Verdict::hit;
                break;
            }
            write(result);
        }
        result.reachable = forecasts(result.proposals);
        if (result.verdict == Verdict::hit && goal_.full) result.full = compute_full(result.proposals.back().grain);
        result.text = answer(result);
        write(result);
        return result;
    }

    [[nodiscard]] Json plan() const {
        const std::vector<SizedCandidate> all = forecasts({});
        const SizedCandidate first = *best(all, {});
        const Prediction& expected = first.prediction;
        const Expectation cost = expected_of(case_pipeline(bed_.planned(first, goal_.packings)), last_stage);
        Json json = {{"first_proposal", text_of(first)},
                     {"chance", first.chance},
                     {"expected_of_first_proposal",
                      {{"permeability_m2", expected_permeability_m2(first)},
                       {"permeability_relative_deviation", expected.log_permeability.standard_deviation},
                       {"porosity", expected.porosity.value},
                       {"porosity_deviation", expected.porosity.standard_deviation},
                       {"extrapolated", expected.extrapolated},
                       {"cost", core::text_of(cost, slowness())}}},
                     {"beds_known", known_.size()},
                     {"expected_half_width", expected_half_widths().permeability}};
        // How well the beds predict each other.
        const Surrogate surrogate(known_);
        double k_squares = 0.0, eps_squares = 0.0;
        for (std::size_t i = 0; i < known_.size(); ++i) {
            const Prediction p = surrogate.leave_one_out(i);
            k_squares += std::pow(p.log_permeability.value - std::log(known_[i].permeability), 2) / static_cast<double>(known_.size());
            eps_squares += std::pow(p.porosity.value - known_[i].porosity, 2) / static_cast<double>(known_.size());
        }
        json["leave_one_out_error"] = {{"log_permeability", std::sqrt(k_squares)}, {"porosity", std::sqrt(eps_squares)}};
        Interval k = {std::numeric_limits<double>::infinity(), 0.0}, eps = {1.0, 0.0};
        for (const SizedCandidate& one : all) {
            const double value = expected_permeability_m2(one);
            k = {std::min(k.low, value), std::max(k.high, value)};
            eps = {std::min(eps.low, one.prediction.porosity.value), std::max(eps.high, one.prediction.porosity.value)};
        }
        const auto rounded = [](double value) { return std::stod(fmt::format("{:.4g}", value)); };
        json["reachable_permeability_m2"] = {rounded(k.low), rounded(k.high)};
        json["reachable_porosity"] = {rounded(eps.low), rounded(eps.high)};
        return json;
    }

private:
    static ShapeConfig read_capsules(const Path& file) {
        const TomlFile toml(file);
        ShapeConfig config;
        toml.read(toml.has("shape") ? "shape" : "", [&](ConfigVisitor& v) { describe(v, config); }, {{"kind", "\"capsules\""}});
        return config;
    }

    // Of the mean of the packings of a proposal that is not poured yet, 95 %, without the numerical part.
    struct HalfWidths {
        double permeability, porosity;
    };
    [[nodiscard]] HalfWidths expected_half_widths() const {
        const ScatterOfBeds k = permeability_scatter(known_), porosity = porosity_scatter(known_);
        return {k.half_width({k.typical().value_or(scatter_without_data), goal_.packings}),
                porosity.half_width({porosity.typical().value_or(porosity_scatter_without_data), goal_.packings})};
    }

    // The mean of the bed lies in the goal's range, or as near to its only value as its own interval is wide.
    static double chance_of(const Estimate& expected, const Interval& wanted, double half_width) {
        const double margin = wanted.low == wanted.high ? half_width : 0.0;
        return normal_distribution((wanted.high + margin - expected.value) / expected.standard_deviation) -
               normal_distribution((wanted.low - margin - expected.value) / expected.standard_deviation);
    }
    static double distance_of(const Estimate& expected, const Interval& wanted) {
        return std::max({0.0, wanted.low - expected.value, expected.value - wanted.high}) / expected.standard_deviation;
    }

    static bool same_grain(const Candidate& one, const Candidate& other) {
        return one.family == other.family && one.parameters == other.parameters;
    }

    // Two poured beds that are as wide, in grains.
    static bool same_bed(double wall, double other) {
        constexpr double rounding = 1e-9;
        return std::abs(wall / other - 1.0) < rounding;
    }

    // What the bed of a grain tells about the same grain in another size: k / d_v^2 and the porosity stay, but for the wall's part. That is
    // known better than what beds of other grains tell. None if the grain has not been computed.
    [[nodiscard]] std::optional<Prediction> own_prediction(const Candidate& grain, double wall,
                                                           const std::vector<Proposal>& computed) const {
        const Proposal* nearest = nullptr;
        for (const Proposal& p : computed)
            if (p.error.empty() && same_grain(p.grain.candidate, grain) &&
                (nearest == nullptr || std::abs(p.bed.wall - wall) < std::abs(nearest->bed.wall - wall)))
                nearest = &p;
        if (nearest == nullptr) return std::nullopt;
        if (same_bed(nearest->bed.wall, wall) && nearest->permeability_half_width() <= goal_.within) {
            constexpr double certain = 1e-9;  // this bed will be magnified, not poured
            return Prediction{.porosity = {nearest->bed.porosity, certain},
                              .log_permeability = {std::log(nearest->bed.permeability), certain}};
        }
        const double eps = nearest->bed.porosity, of_wall = Surrogate::porosity_per_wall * std::abs(nearest->bed.wall - wall),
                     half_width = core::half_widths(eps, nearest->porosity_interval).wider();
        return Prediction{
            .porosity = {eps, std::hypot(0.5 * half_width, of_wall)},
            .log_permeability = {std::log(nearest->bed.permeability), std::hypot(0.5 * nearest->permeability_half_width(),
                                                                                 Surrogate::log_permeability_per_porosity(eps) * of_wall)}};
    }

    [[nodiscard]] SizedCandidate forecast(const Candidate& candidate, double size_m, const Prediction& prediction,
                                          const HalfWidths& expected) const {
        SizedCandidate one{.candidate = candidate, .size_m = size_m, .bed_wall = bed_.wall(size_m), .prediction = prediction};
        Estimate log_k = prediction.log_permeability;
        log_k.value += 2.0 * std::log(size_m);
        const Interval wanted = {std::log(goal_.permeability_m2.low), std::log(goal_.permeability_m2.high)};
        // An interval that is wider than `within` is no hit.
        one.chance = chance_of(log_k, wanted, std::min(expected.permeability, goal_.within));
        one.distance = distance_of(log_k, wanted);
        if (goal_.porosity) {
            one.chance *= chance_of(prediction.porosity, *goal_.porosity, expected.porosity);
            one.distance = std::hypot(one.distance, distance_of(prediction.porosity, *goal_.porosity));
        }
        return one;
    }

    [[nodiscard]] bool allowed(const SizedCandidate& one) const {
        const GrainForm& form = one.candidate.form;
        const double mass = bed_.density_kg_per_m3() * std::numbers::pi / 6.0 * std::pow(one.size_m, 3);
        const double width = goal_.container.kind == Container::Kind::cylinder
                                 ? goal_.container.diameter_m
                                 : std::min(goal_.container.size_m[0], goal_.container.size_m[1]);
        return form.convexity >= goal_.convexity.low && form.convexity <= goal_.convexity.high &&
               form.thickness * one.size_m >= goal_.thinnest_m && mass >= goal_.mass_kg.low && mass <= goal_.mass_kg.high &&
               form.feret * one.size_m <= largest_feret * width;
    }

    [[nodiscard]] std::vector<SizedCandidate> forecasts(const std::vector<Proposal>& computed) const {
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
                const double wanted = std::sqrt(goal_.permeability_m2.low * goal_.permeability_m2.high);
                for (int pass = 0; pass < 20; ++pass) size_m = std::sqrt(wanted / std::exp(prediction(size_m).log_permeability.value));
            }
            const SizedCandidate one = forecast(candidate, size_m, prediction(size_m), expected);
            if (allowed(one)) all.push_back(one);
        }
        return all;
    }

    // Computed before in this size; or so near to a grain that could not be computed that it would fail as well.
    static bool is_tried(const SizedCandidate& one, const Proposal& before) {
        constexpr double near = 0.03, same_size = 0.005;
        const GrainForm &a = one.candidate.form, &b = before.grain.candidate.form;
        if (!before.error.empty())
            return one.candidate.family == before.grain.candidate.family && std::abs(a.sphericity - b.sphericity) < near;
        return same_grain(one.candidate, before.grain.candidate) && std::abs(one.size_m / before.grain.size_m - 1.0) < same_size;
    }

    // The most promising grain that has not been tried; where no chance is left, the nearest.
    static std::optional<SizedCandidate> best(const std::vector<SizedCandidate>& all, const std::vector<Proposal>& computed) {
        std::optional<SizedCandidate> found;
        for (const SizedCandidate& one : all) {
            if (std::any_of(computed.begin(), computed.end(), [&](const Proposal& before) { return is_tried(one, before); })) continue;
            const auto worse = [](const SizedCandidate& a, const SizedCandidate& b) {
                constexpr double tiny = 1e-6;
                return a.chance < tiny && b.chance < tiny ? a.distance > b.distance : a.chance < b.chance;
            };
            if (!found || worse(*found, one)) found = one;
        }
        return found;
    }

    [[nodiscard]] Case prepared(const SizedCandidate& grain, const std::string& name, bool full, long packings) const {
        const Path folder = folder_ / name, file = folder / "case.toml";
        const std::string text = bed_.case_text(grain, full, packings);
        make_folder(folder);
        write_own_text(file, text);
        return read_case(file);
    }

    [[nodiscard]] bool out_of_time() const { return goal_.max_time_s > 0.0 && watch_.seconds() > goal_.max_time_s; }

    // The same grain in a bed of the same width in grains has been computed: the whole bed is magnified, and k grows as the square of
    // lengths. None if that would not be a hit: then more packings of it are poured.
    [[nodiscard]] std::optional<Proposal> magnified(const SizedCandidate& grain, long n, const std::vector<Proposal>& computed) const {
        for (std::size_t i = 0; i < computed.size(); ++i) {
            const Proposal& before = computed[i];
            if (!before.error.empty() || before.magnified_from != 0 || !same_grain(before.grain.candidate, grain.candidate) ||
                !same_bed(before.bed.wall, grain.bed_wall))
                continue;
            const double scale2 = std::pow(grain.size_m / before.grain.size_m, 2);
            Proposal proposal = before;
            proposal.grain = grain;
            proposal.magnified_from = static_cast<long>(i) + 1;
            proposal.bed.name = fmt::format("proposal_{}", n);
            proposal.permeability_m2 *= scale2;
            proposal.permeability_interval_m2 = {scale2 * before.permeability_interval_m2.low,
                                                 scale2 * before.permeability_interval_m2.high};
            proposal.hit = is_hit(proposal);
            if (!proposal.hit) continue;
            (void)prepared(grain, proposal.bed.name, false, before.bed.packings);
            return proposal;
        }
        return std::nullopt;
    }

    // As many packings as the goal says; more, up to most_packings times as many, where the goal lies in an interval that is too wide, or
    // where it takes a narrow one only: the bed can be magnified to any k.
    [[nodiscard]] Proposal compute(const SizedCandidate& grain, long n, const std::vector<Proposal>& computed) const {
        if (const std::optional<Proposal> known = magnified(grain, n, computed)) return *known;
        Proposal proposal = compute(grain, n, goal_.packings);
        const bool any_k = goal_.volume_m3 == 0.0 && bed_.shrink(grain.size_m) < 1.0;
        while (proposal.error.empty() && !out_of_time() && (any_k || meets_goal(proposal)) &&
               proposal.permeability_half_width() > goal_.within && proposal.bed.packings < most_packings * goal_.packings) {
            const double more = std::pow(1.05 * proposal.permeability_half_width() / goal_.within, 2);
            const long wanted = std::lround(std::ceil(more * static_cast<double>(proposal.bed.packings)));
            proposal = compute(grain, n, std::min(wanted, most_packings * goal_.packings));
        }
        proposal.hit = is_hit(proposal);
        return proposal;
    }

    [[nodiscard]] Proposal compute(const SizedCandidate& grain, long n, long packings) const {
        Proposal proposal{.grain = grain};
        const std::string name = fmt::format("proposal_{}", n);
        const Case made = prepared(grain, name, false, packings);
        try {
            (void)run_pipeline(case_pipeline(made), last_stage);
        } catch (const MachineError&) {
            throw;
        } catch (const EngineError&) {
            throw;
        } catch (const Error& error) {
            const std::string message = error.what();
            proposal.error = message.substr(0, message.find('\n'));
            return proposal;
        }
        const auto seeds = made.result<results::Seeds>();
        const auto &k = *find(seeds.quantities, "permeability_m2"), &eps = *find(seeds.quantities, "porosity");
        proposal.permeability_m2 = k.mean;
        proposal.bed = {.name = name,
                        .form = grain.candidate.form,
                        .wall = grain.bed_wall,
                        .packings = packings,
                        .porosity = eps.mean,
                        .permeability = proposal.permeability_m2 / (grain.size_m * grain.size_m),
                        .porosity_deviation = eps.standard_deviation.value_or(0.0),
                        .permeability_deviation = k.standard_deviation.value_or(0.0) / proposal.permeability_m2};
        // The scatter of all beds helps that of this one.
        std::vector<KnownBed> all = known_;
        all.push_back(proposal.bed);
        const ScatterOfBeds k_scatter = permeability_scatter(all), eps_scatter = porosity_scatter(all);
        const auto with_scatter = [&](const results::SeedsQuantity& quantity, double half_width) {
            const double mean = quantity.mean;
            return widened(quantity.numerical_interval.value_or(Interval{mean, mean}), mean, {half_width, half_width});
        };
        proposal.permeability_interval_m2 =
            with_scatter(k, proposal.permeability_m2 * k_scatter.half_width({proposal.bed.permeability_deviation, packings}));
        proposal.porosity_interval = with_scatter(eps, eps_scatter.half_width({proposal.bed.porosity_deviation, packings}));
        return proposal;
    }

    [[nodiscard]] bool is_hit(const Proposal& p) const {
        return p.error.empty() && meets_goal(p) && p.permeability_half_width() <= goal_.within;
    }

    // Whatever the width of its interval.
    [[nodiscard]] bool meets_goal(const Proposal& p) const {
        const auto within = [](double value, const Interval& known, const Interval& wanted) {
            if (wanted.low == wanted.high) return known.low <= wanted.low && wanted.high <= known.high;
            return wanted.low <= value && value <= wanted.high;
        };
        return within(p.permeability_m2, p.permeability_interval_m2, goal_.permeability_m2) &&
               (!goal_.porosity || within(p.bed.porosity, p.porosity_interval, *goal_.porosity));
    }

    [[nodiscard]] FullBed compute_full(const SizedCandidate& grain) const {
        const Case made = prepared(grain, "full", true, 1);
        log_info("design: the answer in its whole container");
        (void)run_pipeline(case_pipeline(made), "lbm");
        const auto lbm = made.result<results::Lbm>();
        return {.permeability_m2 = lbm.permeability.m2,
                .permeability_interval_m2 = lbm.permeability.interval_m2,
                .porosity = lbm.porosity,
                .over_goal = lbm.permeability.m2 / middle(goal_.permeability_m2)};
    }

    [[nodiscard]] std::string answer(const DesignResult& result) const {
        std::vector<const Proposal*> computed;
        for (const Proposal& p : result.proposals)
            if (p.error.empty()) computed.push_back(&p);
        if (computed.empty()) return "No proposal could be computed: see proposals.csv.";
        const double k_scatter = permeability_scatter(known_).typical().value_or(scatter_without_data);
        const double eps_scatter = porosity_scatter(known_).typical().value_or(porosity_scatter_without_data);
        const auto far = [&](const Proposal* p) {
            const double k =
                std::log(std::clamp(p->permeability_m2, goal_.permeability_m2.low, goal_.permeability_m2.high) / p->permeability_m2);
            const double eps =
                goal_.porosity ? std::clamp(p->bed.porosity, goal_.porosity->low, goal_.porosity->high) - p->bed.porosity : 0.0;
            return std::hypot(k / k_scatter, eps / eps_scatter);
        };
        const Proposal& nearest = **std::min_element(computed.begin(), computed.end(), [&](auto* a, auto* b) { return far(a) < far(b); });
        const std::string grain =
            fmt::format("{}: k = {:.3g} m² {} and porosity {:.3f} ({:.3f} to {:.3f}) (mean of {} packings, 95 %)", text_of(nearest.grain),
                        nearest.permeability_m2, percent_text(nearest.permeability_m2, nearest.permeability_interval_m2),
                        nearest.bed.porosity, nearest.porosity_interval.low, nearest.porosity_interval.high, nearest.bed.packings);
        std::string text = result.verdict == Verdict::hit ? "Found. " + grain
                           : result.verdict == Verdict::out_of_reach
                               ? "Out of reach. Nearest: " + grain + ". " + obstacle(result.reachable)
                               : fmt::format("Not hit in {} proposals. Nearest: ", result.proposals.size()) + grain;
        text += ".";
        if (nearest.permeability_half_width() > goal_.within)
            text +=
                fmt::format(" Its interval is wider than {:g} %: it takes more packings per proposal (--packings).", 100.0 * goal_.within);
        if (goal_.volume_m3 == 0.0)
            text +=
                " The volume was free: k grows as volume^(2/3) as long as the container is wide, so other shapes of other volumes have "
                "this k, too; the porosity chooses among them.";
        if (nearest.magnified_from != 0)
            text += fmt::format(" Its bed is that of proposal {}, magnified: k grows as the square of lengths. It was not poured again.",
                                nearest.magnified_from);
        if (result.verdict == Verdict::not_hit && out_of_time())
            text += fmt::format(" The search ended after {} (--max-time); the same command resumes it.", human_time(goal_.max_time_s));
        if (bed_.shrink(nearest.grain.size_m) < 1.0)
            text +=
                fmt::format(" The bed was poured in a container {:g} grains wide; the wall of the wider one changes k less.", widest_bed);
        if (nearest.grain.prediction.extrapolated)
            text +=
                " The grain or its container lies outside the beds that the search began with; the computed values do not depend on them.";
        return text;
    }

    // What stops the search: at the wanted permeability, the porosity; or the range of k among the allowed porosities.
    [[nodiscard]] std::string obstacle(const std::vector<SizedCandidate>& all) const {
        Interval k = {std::numeric_limits<double>::infinity(), 0.0}, eps = {1.0, 0.0};
        for (const SizedCandidate& one : all) {
            const double porosity = one.prediction.porosity.value;
            const double value = expected_permeability_m2(one);
            if (!goal_.porosity || (porosity >= goal_.porosity->low - 0.005 && porosity <= goal_.porosity->high + 0.005))
                k = {std::min(k.low, value), std::max(k.high, value)};
            if (value >= 0.9 * goal_.permeability_m2.low && value <= 1.1 * goal_.permeability_m2.high)
                eps = {std::min(eps.low, porosity), std::max(eps.high, porosity)};
        }
        const auto range = [](const Interval& x, const char* format) {
            return fmt::format(fmt::runtime(fmt::format("{} to {}", format, format)), x.low, x.high);
        };
        std::string text;
        if (k.high > 0.0)
            text += fmt::format("{}allowed grains are expected to have k from {} m²",
                                goal_.porosity ? "With a porosity as wanted, the " : "The ", range(k, "{:.2g}"));
        else
            text += "No allowed grain is expected to have such a porosity";
        if (goal_.porosity && eps.high > 0.0) text += fmt::format("; with k as wanted, porosities from {}", range(eps, "{:.2f}"));
        return text;
    }

    [[nodiscard]] static std::string text_of(const SizedCandidate& one) { return description(one); }

    void write(const DesignResult& result) const {
        make_folder(folder_);
        write_design(goal_, result, known_, folder_);
    }

    const DesignGoal& goal_;
    Path folder_;
    DesignBed bed_;
    std::vector<KnownBed> known_;
    std::vector<Candidate> candidates_;
    Stopwatch watch_;
};

void check(const DesignGoal& goal) {
    const auto fail = [](const char* what, const char* where, const char* allowed) {
        throw UserError(what, {.where = where, .allowed = allowed});
    };
    if (!(goal.permeability_m2.low > 0.0 && goal.permeability_m2.low <= goal.permeability_m2.high))
        fail("the permeability is not a positive value or range", "--permeability", "K, or LOW,HIGH, in m2");
    if (goal.porosity && !(goal.porosity->low > 0.0 && goal.porosity->low <= goal.porosity->high && goal.porosity->high < 1.0))
        fail("the porosity is not a value or range between 0 and 1", "--porosity", "EPS, or LOW,HIGH");
    if (goal.packings < 2) fail("one packing tells no scatter", "--packings", "2 or more");
    if (!goal.free.empty() && goal.own_shape.empty())
        fail("free parameters belong to a shape of your own", "--free", "with --shape FILE.toml");
}

}  // namespace

DesignResult run_design(const DesignGoal& goal, const Path& folder) {
    check(goal);
    make_folder(folder);
    const std::optional<FileLock> lock = FileLock::try_take(folder / ".lock");
    if (!lock) throw UserError("another design runs here", {.where = folder.string(), .fix = "wait for it, or choose another --output"});
    const OwnedNames owned(folder);
    for (const std::string& name : design_files()) owned.require(name);
    // A finished proposal is used again only for the same goal.
    const Path file = folder / "design.json";
    if (fs::exists(file))
        if (const Json before = read_json(file); before.value("goal", Json()) != to_json(goal))
            throw UserError("another design lies in this folder", {.where = file.string(), .fix = "choose another --output, or remove it"});
    return Design(goal, read_study(goal.study), folder).run();
}

Json plan_design(const DesignGoal& goal) {
    check(goal);
    return Design(goal, read_study(goal.study), {}).plan();
}

}  // namespace porepack::design
