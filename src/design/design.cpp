#include "design/design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.hpp"
#include "core/file_lock.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/owned_names.hpp"
#include "design/answer.hpp"
#include "design/bed.hpp"
#include "design/design_page.hpp"
#include "design/uses.hpp"
#include "pouring/pour.hpp"
#include "record/toml_file.hpp"
#include "report/page.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::design {
namespace fs = std::filesystem;
namespace {

// Below this chance of every candidate, the search ends; the goal counts as out of reach if it is so many standard deviations away.
constexpr double smallest_chance = 0.02, far_off = 2.0;
constexpr long max_packings = 4;

double middle(const Interval& interval) {
    return 0.5 * (interval.low + interval.high);
}

class Design {
public:
    Design(const DesignGoal& goal, const Study& study, Path folder)
        : goal_(goal), folder_(std::move(folder)), bed_(goal, study), forecaster_(goal, bed_, known_beds(study)) {}

    DesignResult run() {
        DesignResult result;
        for (long n = 1; n <= goal_.max_proposals; ++n) {
            result.reachable = forecaster_.forecasts(result.proposals);
            if (out_of_time()) break;
            std::optional<SizedCandidate> next = best(result.reachable, result.proposals);
            if (!next) break;
            if (next->chance < smallest_chance && !result.proposals.empty() && result.proposals.back().error.empty()) {
                // A narrow goal within what is expected is in reach: the intervals are too wide to tell.
                if (next->distance > far_off) result.verdict = Verdict::out_of_reach;
                break;
            }
            log_info("design: proposal {} of at most {}: {}", n, goal_.max_proposals, description(*next));
            result.proposals.push_back(compute(*next, n, result.proposals));
            const Proposal& made = result.proposals.back();
            // A magnified bed is no new observation.
            if (made.error.empty() && made.magnified_from == 0) forecaster_.learn(made.bed);
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
        result.reachable = forecaster_.forecasts(result.proposals);
        if (result.verdict == Verdict::hit && goal_.full) result.full = compute_full(result.proposals.back().grain);
        result.text = answer_of(goal_, bed_, forecaster_.known(), result, out_of_time());
        write(result);
        return result;
    }

private:
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

    // As many packings as the goal says; more, up to max_packings times as many, where the goal lies in an interval that is too wide, or
    // where it takes a narrow one only: the bed can be magnified to any k.
    [[nodiscard]] Proposal compute(const SizedCandidate& grain, long n, const std::vector<Proposal>& computed) const {
        if (const std::optional<Proposal> known = magnified(grain, n, computed)) return *known;
        Proposal proposal = compute(grain, n, goal_.packings);
        const bool any_k = goal_.volume_m3 == 0.0 && bed_.shrink(grain.size_m) < 1.0;
        while (proposal.error.empty() && !out_of_time() && (any_k || meets_goal(proposal)) &&
               proposal.permeability_half_width() > goal_.within && proposal.bed.packings < max_packings * goal_.packings) {
            // The half width falls with the square root of the number of packings; 5 % in reserve.
            const double more = std::pow(1.05 * proposal.permeability_half_width() / goal_.within, 2);
            const long wanted = std::lround(std::ceil(more * static_cast<double>(proposal.bed.packings)));
            proposal = compute(grain, n, std::min(wanted, max_packings * goal_.packings));
        }
        proposal.hit = is_hit(proposal);
        return proposal;
    }

    [[nodiscard]] Proposal compute(const SizedCandidate& grain, long n, long packings) const {
        Proposal proposal{.grain = grain};
        const std::string name = fmt::format("proposal_{}", n);
        const Case made = prepared(grain, name, false, packings);
        try {
            // A fault of the machine or of an engine says nothing about the grain, and ends the search. Other errors belong to this grain.
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
        std::vector<KnownBed> all = forecaster_.known();
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
        // A single wanted value must lie in the interval that is known; a wanted range must contain the value.
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

    void write(const DesignResult& result) const {
        make_folder(folder_);
        write_design(goal_, result, forecaster_.known(), folder_);
    }

    Stopwatch watch_;  // before the forecasts, which count
    const DesignGoal& goal_;
    Path folder_;
    DesignBed bed_;
    Forecaster forecaster_;
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
    const Study study = read_study(goal.study);
    const DesignBed bed(goal, study);
    return plan_of(goal, bed, Forecaster(goal, bed, known_beds(study)));
}

}  // namespace porepack::design
