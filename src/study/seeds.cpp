#include "study/seeds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/table.hpp"
#include "permeability/quantities.hpp"
#include "permeability/sample.hpp"
#include "stages/results.hpp"
#include "study/case_pipeline.hpp"
#include "study/members.hpp"

namespace porepack::study {
using namespace core;
using namespace lbm;
using namespace permeability;
using namespace pipeline;
using namespace stages;
namespace {

constexpr const char* last_stage = "tortuosity";
constexpr std::size_t permeability = 0, porosity = 1;  // of the quantities

// The part of the interval of the mean that the numerical error of one packing may take: a packing with a coarser grid costs much less,
// and 0.4 of the half width leaves 0.92 of it to the scatter.
constexpr double numerical_share = 0.4;

// Expected before two packings are known: 10 to 15 % for sections of a few grain diameters.
constexpr std::array<double, 2> usual_scatter = {0.10, 0.15};

struct Member {
    long seed;
    std::array<std::optional<double>, reported_quantities.size()> values;
    std::array<std::optional<Interval>, reported_quantities.size()> intervals;  // numerical
    double section_scatter;  // predicted from the slices of this packing, relative; NaN where there is no gradient along z
};

Member member_of(const Case& one) {
    const Json results = {{"lbm", one.result_of("lbm")}, {"tortuosity", one.result_of("tortuosity")}};
    Member member{
        .seed = one.settings.packing.seed, .values = {}, .intervals = {}, .section_scatter = std::numeric_limits<double>::quiet_NaN()};
    if (const auto scatter = section_scatter_of(one)) member.section_scatter = scatter->relative;
    for (std::size_t i = 0; i < reported_quantities.size(); ++i) {
        member.values[i] = number_at(results, reported_quantities[i].value);
        if (member.values[i]) member.intervals[i] = interval_at(results, reported_quantities[i].interval);
    }
    return member;
}

class SeedsStudy {
public:
    explicit SeedsStudy(const Case& c) : case_(c), config_(c.settings.packings), members_{member_of(c)} {}

    Json run(const Path& folder) {
        const long first = case_.settings.packing.seed;
        long begun = 1;
        const double memory = memory_of_one();
        const int at_once = jobs_at_once(memory);
        log_info("seeds: up to {} packings at once, about {} each", at_once, human_bytes(memory));
        const auto next = [&]() -> std::optional<Job> {
            while (begun < wanted() && !out_of_time()) {
                const long seed = first + begun++;
                const Case one = member(seed);
                if (!is_done(case_pipeline(one), last_stage)) return job_of(one, last_stage, std::to_string(seed));
                take(seed, {});
            }
            show_progress(begun - static_cast<long>(members_.size()));
            return std::nullopt;
        };
        run_jobs(at_once, next, [&](const JobEnd& end) {
            take(std::stol(end.name), end.error);
            show_progress(begun - static_cast<long>(members_.size()));
        });
        write_table(folder / "seeds.csv");
        return result();
    }

private:
    // The same case with another seed, on grids that are only as fine as the interval of the mean asks.
    [[nodiscard]] Case member(long seed) const {
        Case one = case_of_seed(case_, seed);
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

    // Packings count in the order of their seeds, and once the mean is sure, no more of them do: neither a result nor a failure.
    void take(long seed, const std::string& error) {
        waiting_[seed] = error;
        while (!sure() && waiting_.contains(members_.back().seed + 1)) {
            const auto found = waiting_.find(members_.back().seed + 1);
            const Case one = member(found->first);
            if (!found->second.empty())
                throw NumericalError(fmt::format("the packing with seed {} failed: {}", found->first, found->second),
                                     {.where = (one.results() / "log.porepack").string(),
                                      .fix = "the other packings are kept; correct the cause and run again"});
            members_.push_back(member_of(one));
            waiting_.erase(found);
        }
    }

    [[nodiscard]] std::vector<double> values_of(std::size_t quantity) const {
        std::vector<double> values;
        for (const Member& one : members_)
            if (one.values[quantity]) values.push_back(*one.values[quantity]);
        return values;
    }
    [[nodiscard]] Sample sample(std::size_t quantity) const { return sample_of(values_of(quantity)); }
    // Of one packing, numerical: the mean of those that are known, on each side.
    [[nodiscard]] std::optional<Sides> mean_half_widths(std::size_t quantity) const {
        Sides sum;
        double count = 0.0;
        for (const Member& one : members_)
            if (const auto& known = one.intervals[quantity]) {
                const Sides half = half_widths(*one.values[quantity], *known);
                sum = {sum.below + half.below, sum.above + half.above};
                count += 1.0;
            }
        return count > 0.0 ? std::optional((1.0 / count) * sum) : std::nullopt;
    }
    // The wider side decides when the mean is sure.
    [[nodiscard]] double numerical_half_width_m2() const { return mean_half_widths(permeability).value_or(Sides{}).wider(); }
    // Packings cannot help: the numerical part alone is too wide.
    [[nodiscard]] bool too_coarse() const {
        return members_.size() >= least_packings && numerical_half_width_m2() >= config_.until_sure * sample(permeability).mean;
    }
    [[nodiscard]] double reached() const { return relative_half_width(sample(permeability), numerical_half_width_m2()); }
    [[nodiscard]] bool sure() const {
        return config_.until_sure > 0.0 && members_.size() >= least_packings && reached() <= config_.until_sure;
    }
    [[nodiscard]] bool out_of_time() const {
        return config_.until_sure > 0.0 && config_.max_time_s > 0.0 && watch_.seconds() > config_.max_time_s;
    }
    // Number of packings to begin, as far as is known now.
    [[nodiscard]] long wanted() const {
        const auto known = static_cast<long>(members_.size());
        if (config_.until_sure == 0.0) return config_.seeds;
        if (sure() || too_coarse()) return known;
        long expected = static_cast<long>(least_packings);
        if (members_.size() >= least_packings) {
            const Sample k = sample(permeability);
            expected = static_cast<long>(packings_for(k.relative_deviation(), config_.until_sure, numerical_half_width_m2() / k.mean)
                                             .value_or(config_.max_packings));
        }
        return std::clamp(expected, std::min(known + 1, config_.max_packings), config_.max_packings);
    }

    void show_progress(long running) {
        const auto known = static_cast<double>(members_.size());
        const std::string mean = members_.size() < 2 ? std::string() : fmt::format(", mean k within {:.2g} %", 100.0 * reached());
        progress_.update(std::min(1.0, (known - 1.0) / std::max(1.0, static_cast<double>(wanted()) - 1.0)),
                         fmt::format("{} packings known, {} more begun, {}{} wanted{}", members_.size(), running,
                                     config_.until_sure > 0.0 ? "about " : "", wanted(), mean));
    }

    void write_table(const Path& file) const {
        std::vector<std::string> columns = {"seed"};
        for (const Quantity& quantity : reported_quantities) columns.emplace_back(quantity.name);
        columns.insert(columns.end(), {"permeability_low_m2", "permeability_high_m2", "section_scatter"});
        Table table(columns);
        for (const Member& one : members_) {
            const auto& v = one.values;
            const auto& k = one.intervals[permeability];
            table.add(one.seed, v[0], v[1], v[2], v[3], v[4], v[5], k ? std::optional(k->low) : std::nullopt,
                      k ? std::optional(k->high) : std::nullopt, one.section_scatter);
        }
        table.write(file);
    }

    [[nodiscard]] Json quantity_json(std::size_t quantity) const {
        const Sample s = sample(quantity);
        const StudyEnd end = config_.until_sure > 0.0 ? StudyEnd::when_sure : StudyEnd::at_number;
        const std::optional<Sides> numerical = mean_half_widths(quantity);
        return {{"packings", s.packings},
                {"mean", s.mean},
                {"standard_deviation", s.packings > 1 ? Json(s.deviation) : Json(nullptr)},
                {"standard_deviation_interval",
                 s.packings > 1 ? json_of(interval_of_deviation(s.deviation, static_cast<double>(s.packings) - 1.0)) : Json(nullptr)},
                {"numerical_half_width", numerical ? Json(numerical->wider()) : Json(nullptr)},
                {"numerical_interval", numerical ? json_of(about(s.mean, *numerical)) : Json(nullptr)},
                {"interval_of_mean", json_of(interval_of_mean(s, numerical.value_or(Sides{}), end))},
                {"interval_of_next", json_of(interval_of_next(s, numerical.value_or(Sides{}), end))}};
    }

    [[nodiscard]] Json result() const {
        const Sample k = sample(permeability), eps = sample(porosity);
        const auto n = static_cast<double>(k.packings);
        Json json = {
            {"packings", members_.size()},
            {"quantities", Json::object()},
            {"porosity_mean", eps.mean},
            {"porosity_standard_deviation", eps.deviation},
            {"permeability_mean_m2", k.mean},
            {"standard_deviation_between_packings_m2", k.deviation},
            {"standard_error_of_mean_m2", k.deviation / std::sqrt(n)},
            {"numerical_half_width_m2", mean_half_widths(permeability) ? Json(numerical_half_width_m2()) : Json(nullptr)},
            {"unseen_share", unseen_share(members_.size())},
            {"meaning",
             "intervals of 95 %: Student's t for the scatter between packings, and the numerical half widths of one packing, added in "
             "quadrature on each side where they are known. They presume that these packings show the scatter: packings of another "
             "kind, up to unseen_share of all, may all be absent with a probability of 5 %"}};
        for (std::size_t i = 0; i < reported_quantities.size(); ++i)
            if (!values_of(i).empty()) json["quantities"][reported_quantities[i].name] = quantity_json(i);
        if (config_.until_sure > 0.0) {
            json["until_sure"] = config_.until_sure;
            json["relative_half_width"] = number_or_null(reached());
            json["sure"] = sure();
            const char* stopped_by = too_coarse() ? "numerical" : out_of_time() ? "max_time_s" : "max_packings";
            json["stopped_by"] = sure() ? Json(nullptr) : Json(stopped_by);
            if (!sure())
                log_warning(fmt::format("the mean of k is known to {:.2g} %, not to {:g} %: {} was reached", 100.0 * reached(),
                                        100.0 * config_.until_sure, json["stopped_by"].get<std::string>()));
        }
        return json;
    }

    const Case& case_;
    const packing::PackingsConfig& config_;
    std::vector<Member> members_;          // in the order of their seeds, without gaps
    std::map<long, std::string> waiting_;  // seeds that have ended before their predecessors, with their error
    Stopwatch watch_;
    Progress progress_{"packings"};
};

Expectation expect(const Case& c) {
    const packing::PackingsConfig& config = c.settings.packings;
    const Case one = case_of_seed(c, c.settings.packing.seed + 1);
    const Expectation each = expected_of(case_pipeline(one), last_stage);
    if (config.until_sure == 0.0)
        return {.text = fmt::format("{} more packings", config.seeds - 1),
                .memory_bytes = each.memory_bytes,
                .wall_time_s = static_cast<double>(config.seeds - 1) * each.wall_time_s,
                .disk_bytes = static_cast<double>(config.seeds - 1) * each.disk_bytes};
    const auto number = [&](double scatter) {
        const auto found = packings_for(scatter, config.until_sure, numerical_share * config.until_sure);
        return std::min(config.max_packings, static_cast<long>(found.value_or(least_packings)));
    };
    const double most = static_cast<double>(number(usual_scatter[1]) - 1);
    return {.text = fmt::format("{} to {} packings if k scatters by {:g} to {:g} %", number(usual_scatter[0]), number(usual_scatter[1]),
                                100.0 * usual_scatter[0], 100.0 * usual_scatter[1]),
            .memory_bytes = each.memory_bytes,
            .wall_time_s = most * each.wall_time_s,
            .disk_bytes = most * each.disk_bytes};
}

}  // namespace

Stage make_seeds_stage(const Case& c) {
    if (const LbmConfig& lbm = c.settings.lbm; c.settings.packings.until_sure > 0.0 && lbm.walls == Walls::bounce_back && lbm.grids < 2)
        throw UserError("until_sure needs the numerical error of each packing, and one grid with bounce_back gives none",
                        {.where = "[lbm] grids", .allowed = "2 or more", .fix = "grids = 2, or walls = \"interpolated\""});
    return {.name = "seeds",
            .needs = {"lbm", last_stage},
            .configuration = c.settings.resolved_tables({"packings"}),
            .outputs = {"seeds.csv"},
            .run = [c](const Path& folder) { return SeedsStudy(c).run(folder); },
            .expect = [c] { return expect(c); },
            .result_version = 5};
}

}  // namespace porepack::study
