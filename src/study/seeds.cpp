#include "study/seeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "stages/case_space.hpp"
#include "study/case_jobs.hpp"
#include "study/case_pipeline.hpp"
#include "study/known_packings.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace {

constexpr const char *last_stage = "tortuosity", *pour_stage = "pack";

// The part of the interval of the mean that the numerical error of one packing may take: a packing with a coarser grid costs much less,
// and 0.4 of the half width leaves 0.92 of it to the scatter.
constexpr double numerical_share = 0.4;

// Expected before two packings are known: 10 to 15 % for sections of a few grain diameters.
constexpr std::array<double, 2> usual_scatter = {0.10, 0.15};
// The part of it that the porosity does not tell, expected before it is known; 0.37 on the quickstart.
constexpr double usual_share_about_line = 0.5;

void log_flow(const Case& one) {
    const auto lbm = one.result<results::Lbm>();
    log_info("packings: seed {}: k = {:.4g} m2, porosity {:.4f}", one.settings.packing.seed, lbm.permeability.m2, lbm.porosity);
}

class SeedsStudy {
public:
    explicit SeedsStudy(const Case& c) : case_(c), config_(c.settings.packings), known_(c) {}

    results::Seeds run(const Path& folder) {
        const double memory = memory_of_one();
        const int at_once = jobs_at_once(memory);
        log_info("seeds: up to {} packings at once, about {} each", at_once, human_bytes(memory));
        log_flow(case_);
        const auto next = [&]() -> std::optional<Job> {
            while (!out_of_time()) {
                const auto job = next_job();
                if (!job) break;
                const Case one = member(job->seed);
                const char* last = job->flow ? last_stage : pour_stage;
                if (is_done(case_pipeline(one), last)) {
                    take(*job, {});
                    continue;
                }
                const std::string name = fmt::format("{} {}", job->flow ? "flow" : "pour", job->seed);
                running_.emplace(name, *job);
                return job_of(one, last, name);
            }
            show_progress();
            return std::nullopt;
        };
        run_jobs(at_once, next, [&](const JobEnd& end) {
            take(running_.at(end.name), end.error);
            show_progress();
        });
        known_.write_tables(folder);
        return known_.result(out_of_time());
    }

private:
    struct Next {
        bool flow;  // or the pour alone
        long seed;
    };
    // Flows first. A packing is begun once: its flow waits while its pour runs, and a flow that begins before its pour makes it itself.
    [[nodiscard]] std::optional<Next> next_job() {
        const long first = case_.settings.packing.seed;
        if (flows_begun_ < wanted()) {
            const long seed = first + flows_begun_;
            const bool pouring = flows_begun_ >= known_.pours() && flows_begun_ < pours_begun_ && !pours_done_.contains(seed);
            if (!pouring) {
                ++flows_begun_;
                return Next{.flow = true, .seed = seed};
            }
        }
        pours_begun_ = std::max(pours_begun_, flows_begun_);
        if (pours_begun_ < known_.pours_wanted(wanted())) return Next{.flow = false, .seed = first + pours_begun_++};
        return std::nullopt;
    }

    // The same case with another seed, on grids that are only as fine as the interval of the mean asks.
    [[nodiscard]] Case member(long seed) const {
        Case one = case_of_seed(case_, seed);
        one.settings.packing.friction = friction_of(seed - case_.settings.packing.seed);
        LbmConfig& lbm = one.settings.lbm;
        if (config_.until_sure > 0.0 && lbm.walls == Walls::interpolated) lbm.tolerance = numerical_share * config_.until_sure;
        return one;
    }

    // Of the first that is not done: a finished one needs none.
    [[nodiscard]] double memory_of_one() const {
        const long first = case_.settings.packing.seed, last = first + (config_.until_sure > 0.0 ? config_.max_packings : config_.seeds);
        for (long seed = first + 1; seed < last; ++seed)
            if (const double bytes = expected_memory_bytes(member(seed), last_stage); bytes > 0.0) return bytes;
        return 0.0;
    }

    // Evenly within sqrt(3) standard uncertainties, by the radical inverse of the packing's number: any number of packings is balanced.
    [[nodiscard]] double friction_of(long index) const {
        const pouring::PackingConfig& packing = case_.settings.packing;
        double inverse = 0.0, digit = 0.5;
        for (long rest = index; rest > 0; rest /= 2, digit *= 0.5) inverse += static_cast<double>(rest % 2) * digit;
        const double place = index == 0 ? 0.0 : 2.0 * inverse - 1.0;
        return packing.friction + std::sqrt(3.0) * packing.friction_uncertainty * place;
    }

    // Packings count in the order of their seeds, each flow with its pours, and once the mean is sure, no more of them do: neither a result
    // nor a failure.
    void take(const Next& ended, const std::string& error) {
        (ended.flow ? flows_done_ : pours_done_)[ended.seed] = error;
        const long first = case_.settings.packing.seed;
        while (!known_.sure()) {
            const long flows = known_.flows(), pours = known_.pours();
            if (pours < known_.pours_wanted(flows + 1)) {
                const long seed = first + pours;
                for (const auto* done : {&pours_done_, &flows_done_})
                    if (const auto found = done->find(seed); found != done->end()) require_success(seed, found->second);
                if (pours >= flows && !pours_done_.contains(seed) && !flows_done_.contains(seed)) return;
                known_.add_pour(pours < flows ? known_.porosity_of_flow(pours) : case_pore_space(member(seed)).porosity().value);
                continue;
            }
            const auto found = flows_done_.find(first + flows);
            if (found == flows_done_.end()) return;
            require_success(found->first, found->second);
            const Case one = member(found->first);
            known_.add_flow(one);
            log_flow(one);
        }
    }

    void require_success(long seed, const std::string& error) const {
        if (!error.empty())
            throw NumericalError(fmt::format("the packing with seed {} failed: {}", seed, error),
                                 {.where = (member(seed).results() / "log.porepack").string(),
                                  .fix = "the other packings are kept; correct the cause and run again"});
    }

    [[nodiscard]] bool out_of_time() const {
        return config_.until_sure > 0.0 && config_.max_time_s > 0.0 && watch_.seconds() > config_.max_time_s;
    }
    // Number of flows to begin, as far as is known now.
    [[nodiscard]] long wanted() const {
        if (config_.until_sure == 0.0) return config_.seeds;
        const long known = known_.flows();
        if (known_.sure() || known_.too_coarse()) return known;
        const long expected = known_.enough_for_a_look() ? known_.flows_expected() : known_.flows_of_first_look();
        return std::clamp(expected, std::min(known + 1, config_.max_packings), config_.max_packings);
    }

    void show_progress() {
        const long flows = known_.flows(), all = wanted();
        const std::string mean = known_.enough_for_a_look() ? fmt::format(", mean k within {:.2g} %", 100.0 * known_.reached()) : "",
                          pours = known_.many_pours() ? fmt::format(", {} of {} pours", known_.pours(), known_.pours_wanted(all)) : "";
        progress_.update(std::min(1.0, (static_cast<double>(flows) - 1.0) / std::max(1.0, static_cast<double>(all) - 1.0)),
                         fmt::format("{} packings known, {} more begun, {}{} wanted{}{}", flows, flows_begun_ - flows,
                                     config_.until_sure > 0.0 ? "about " : "", all, pours, mean));
    }

    const Case& case_;
    const pouring::PackingsConfig& config_;
    KnownPackings known_;                                  // without gaps between the seeds
    std::map<std::string, Next> running_;                  // by the name of the job
    std::map<long, std::string> flows_done_, pours_done_;  // seeds, with their error, in any order
    long flows_begun_ = 1, pours_begun_ = 1;
    Stopwatch watch_;
    Progress progress_{"packings"};
};

Expectation expect(const Case& c) {
    const pouring::PackingsConfig& config = c.settings.packings;
    const Case one = case_of_seed(c, c.settings.packing.seed + 1);
    const Expectation each = expected_of(case_pipeline(one), last_stage);
    if (config.until_sure == 0.0)
        return {.text = fmt::format("{} more packings", config.seeds - 1),
                .memory_bytes = each.memory_bytes,
                .wall_time_s = static_cast<double>(config.seeds - 1) * each.wall_time_s,
                .disk_bytes = static_cast<double>(config.seeds - 1) * each.disk_bytes};
    const bool pours = config.pours_per_flow > 1;
    const auto number = [&](double scatter) {
        const double wanted = config.until_sure * std::sqrt(1.0 - numerical_share * numerical_share);
        const auto found =
            pours ? flows_for(usual_share_about_line * scatter, std::sqrt(1.0 - std::pow(usual_share_about_line, 2.0)) * scatter, wanted,
                              static_cast<std::size_t>(config.pours_per_flow))
                  : packings_for(scatter, config.until_sure, numerical_share * config.until_sure).value_or(min_packings);
        return std::min(config.max_packings, static_cast<long>(found));
    };
    const double flows = static_cast<double>(number(usual_scatter[1]) - 1),
                 more_pours = pours ? flows * static_cast<double>(config.pours_per_flow - 1) : 0.0;
    const Expectation pour = expected_of(case_pipeline(one), pour_stage);
    std::string text = fmt::format("{} to {} packings if k scatters by {:g} to {:g} %", number(usual_scatter[0]), number(usual_scatter[1]),
                                   100.0 * usual_scatter[0], 100.0 * usual_scatter[1]);
    if (pours) {
        text += fmt::format(", and {} pours for each", config.pours_per_flow);
        if (pour.wall_time_s > 0.2 * each.wall_time_s)
            text += fmt::format(" ({} each, a flow {}: pours_per_flow = 1 may be faster)", human_time(pour.wall_time_s),
                                human_time(each.wall_time_s - pour.wall_time_s));
    }
    double wall_time_s = flows * each.wall_time_s + more_pours * pour.wall_time_s;
    // A packing that has begun is finished.
    if (config.max_time_s > 0.0 && wall_time_s > config.max_time_s + each.wall_time_s) {
        wall_time_s = config.max_time_s + each.wall_time_s;
        text += fmt::format("; no packing begins after {} (max_time_s), so that the mean is not expected to be sure",
                            human_time(config.max_time_s));
    }
    return {.text = text,
            .memory_bytes = each.memory_bytes,
            .wall_time_s = wall_time_s,
            .disk_bytes = flows * each.disk_bytes + more_pours * pour.disk_bytes};
}

}  // namespace

Stage make_seeds_stage(const Case& c) {
    if (const LbmConfig& lbm = c.settings.lbm; c.settings.packings.until_sure > 0.0 && lbm.walls == Walls::bounce_back && lbm.grids < 2)
        throw UserError("until_sure needs the numerical error of each packing, and one grid with bounce_back gives none",
                        {.where = "[lbm] grids", .allowed = "2 or more", .fix = "grids = 2, or walls = \"interpolated\""});
    const pouring::PackingsConfig& packings = c.settings.packings;
    std::vector<std::string> outputs = {"seeds.csv"};
    if (packings.until_sure > 0.0 && packings.pours_per_flow > 1) outputs.emplace_back("pours.csv");
    return {.name = "seeds",
            .needs = {"lbm", last_stage},
            .configuration = c.settings.resolved_tables({"packings"}),
            .outputs = outputs,
            .run = [c](const Path& folder) { return SeedsStudy(c).run(folder); },
            .expect = [c] { return expect(c); },
            .result_version = results::Seeds::version};
}

}  // namespace porepack::study
