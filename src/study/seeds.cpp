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
#include "permeability/regression.hpp"
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

constexpr const char *last_stage = "tortuosity", *pour_stage = "pack";
constexpr std::size_t permeability = 0, porosity = 1;  // of the quantities

// The part of the interval of the mean that the numerical error of one packing may take: a packing with a coarser grid costs much less,
// and 0.4 of the half width leaves 0.92 of it to the scatter.
constexpr double numerical_share = 0.4;

// Expected before two packings are known: 10 to 15 % for sections of a few grain diameters.
constexpr std::array<double, 2> usual_scatter = {0.10, 0.15};
// The part of it that the porosity does not tell, expected before it is known; 0.37 on the quickstart.
constexpr double usual_share_about_line = 0.5;

// A packing whose flow is known.
struct Member {
    long seed;
    double friction;
    double measured_part_porosity;  // of the part whose porosity was measured; NaN where none was
    std::array<std::optional<double>, reported_quantities.size()> values;
    std::array<std::optional<Interval>, reported_quantities.size()> intervals;  // numerical
    double section_scatter;  // predicted from the slices of this packing, relative; NaN where there is no gradient along z
};

// NaN where no porosity was measured, or where the upper level lies above this bed.
double measured_part_porosity(const Case& one, const packing::PackingsConfig& config) {
    if (config.measured_porosity.empty()) return std::numeric_limits<double>::quiet_NaN();
    if (config.measured_part == packing::MeasuredPart::bed) return one.result_of("pack").at("porosity_bed").get<double>();
    const converters::PoreSpace space = case_pore_space(one);
    if (config.measured_part == packing::MeasuredPart::section) return space.porosity().value;
    const packing::Section part{config.measured_between_m[0], config.measured_between_m[1]};
    return part.z1 > space.bed_top_m ? std::numeric_limits<double>::quiet_NaN() : space.with_section(part).porosity().value;
}

Member member_of(const Case& one, const packing::PackingsConfig& config) {
    const Json results = {{"lbm", one.result_of("lbm")}, {"tortuosity", one.result_of("tortuosity")}};
    Member member{.seed = one.settings.packing.seed,
                  .friction = one.settings.packing.friction,
                  .measured_part_porosity = measured_part_porosity(one, config),
                  .values = {},
                  .intervals = {},
                  .section_scatter = std::numeric_limits<double>::quiet_NaN()};
    if (const auto scatter = section_scatter_of(one)) member.section_scatter = scatter->relative;
    for (std::size_t i = 0; i < reported_quantities.size(); ++i) {
        member.values[i] = number_at(results, reported_quantities[i].value);
        if (member.values[i]) member.intervals[i] = interval_at(results, reported_quantities[i].interval);
    }
    return member;
}

class SeedsStudy {
public:
    explicit SeedsStudy(const Case& c) : case_(c), config_(c.settings.packings), members_{member_of(c, c.settings.packings)} {
        if (many_pours()) pours_.push_back(*members_.front().values[porosity]);
    }

    Json run(const Path& folder) {
        const double memory = memory_of_one();
        const int at_once = jobs_at_once(memory);
        log_info("seeds: up to {} packings at once, about {} each", at_once, human_bytes(memory));
        const auto next = [&]() -> std::optional<Job> {
            while (!out_of_time()) {
                const auto job = next_job();
                if (!job) break;
                const Case one = member(job->seed);
                const char* last = job->flow ? last_stage : pour_stage;
                if (!is_done(case_pipeline(one), last)) return job_of(one, last, fmt::format("{}{}", job->flow ? "" : pour_mark, job->seed));
                take(*job, {});
            }
            show_progress();
            return std::nullopt;
        };
        run_jobs(at_once, next, [&](const JobEnd& end) {
            const bool flow = !end.name.starts_with(pour_mark);
            take({.flow = flow, .seed = std::stol(flow ? end.name : end.name.substr(std::string_view(pour_mark).size()))}, end.error);
            show_progress();
        });
        write_table(folder / "seeds.csv");
        if (many_pours()) write_pours(folder / "pours.csv");
        return result();
    }

private:
    static constexpr const char* pour_mark = "pour ";

    // Most pours tell their porosity alone.
    [[nodiscard]] bool many_pours() const { return config_.until_sure > 0.0 && config_.pours_per_flow > 1; }
    [[nodiscard]] long pours_wanted(long flows) const { return many_pours() ? flows * config_.pours_per_flow : 0; }
    [[nodiscard]] std::size_t least() const { return many_pours() ? least_flows : least_packings; }

    struct Next {
        bool flow;  // or the pour alone
        long seed;
    };
    // Flows first. A packing is begun once: its flow waits while its pour runs, and a flow that begins before its pour makes it itself.
    [[nodiscard]] std::optional<Next> next_job() {
        const long first = case_.settings.packing.seed;
        if (flows_begun_ < wanted()) {
            const long seed = first + flows_begun_;
            const bool pouring = flows_begun_ >= static_cast<long>(pours_.size()) && flows_begun_ < pours_begun_ && !pours_done_.contains(seed);
            if (!pouring) {
                ++flows_begun_;
                return Next{.flow = true, .seed = seed};
            }
        }
        pours_begun_ = std::max(pours_begun_, flows_begun_);
        if (pours_begun_ < pours_wanted(wanted())) return Next{.flow = false, .seed = first + pours_begun_++};
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
        const packing::PackingConfig& packing = case_.settings.packing;
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
        while (!sure()) {
            const auto flows = static_cast<long>(members_.size()), pours = static_cast<long>(pours_.size());
            if (pours < pours_wanted(flows + 1)) {
                const long seed = first + pours;
                for (const auto* done : {&pours_done_, &flows_done_})
                    if (const auto found = done->find(seed); found != done->end()) require_success(seed, found->second);
                if (pours >= flows && !pours_done_.contains(seed) && !flows_done_.contains(seed)) return;
                pours_.push_back(pours < flows ? *members_[static_cast<std::size_t>(pours)].values[porosity]
                                               : case_pore_space(member(seed)).porosity().value);
                continue;
            }
            const auto found = flows_done_.find(first + flows);
            if (found == flows_done_.end()) return;
            require_success(found->first, found->second);
            members_.push_back(member_of(member(found->first), config_));
        }
    }

    void require_success(long seed, const std::string& error) const {
        if (!error.empty())
            throw NumericalError(fmt::format("the packing with seed {} failed: {}", seed, error),
                                 {.where = (member(seed).results() / "log.porepack").string(),
                                  .fix = "the other packings are kept; correct the cause and run again"});
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
    // k of the flows on the Kozeny function of their porosity, at the mean of all pours.
    [[nodiscard]] std::optional<RegressedMean> regressed() const {
        if (!many_pours()) return std::nullopt;
        std::vector<double> x, all;
        for (const Member& one : members_) x.push_back(kozeny_function(*one.values[porosity]));
        for (const double eps : pours_) all.push_back(kozeny_function(eps));
        const auto line = fit_line(x, values_of(permeability));
        return line ? std::optional(RegressedMean{*line, sample_of(all)}) : std::nullopt;
    }
    [[nodiscard]] double mean_permeability() const {
        const auto found = regressed();
        return found ? found->mean() : sample(permeability).mean;
    }

    // Packings cannot help: the numerical part alone is too wide.
    [[nodiscard]] bool too_coarse() const {
        return members_.size() >= least() && numerical_half_width_m2() >= config_.until_sure * sample(permeability).mean;
    }
    [[nodiscard]] double reached() const {
        if (const auto found = regressed()) return std::hypot(found->half_width(), numerical_half_width_m2()) / found->mean();
        return relative_half_width(sample(permeability), numerical_half_width_m2());
    }
    [[nodiscard]] bool sure() const { return config_.until_sure > 0.0 && members_.size() >= least() && reached() <= config_.until_sure; }
    [[nodiscard]] bool out_of_time() const {
        return config_.until_sure > 0.0 && config_.max_time_s > 0.0 && watch_.seconds() > config_.max_time_s;
    }
    // Number of flows to begin, as far as is known now.
    [[nodiscard]] long wanted() const {
        const auto known = static_cast<long>(members_.size());
        if (config_.until_sure == 0.0) return config_.seeds;
        if (sure() || too_coarse()) return known;
        long expected = static_cast<long>(least());
        if (members_.size() >= least()) {
            const double k = mean_permeability(), numerical = numerical_half_width_m2() / k;
            if (const auto found = regressed())
                expected = static_cast<long>(
                    flows_for(found->line.residual_deviation / k, std::abs(found->line.slope) * found->pours.deviation / k,
                              std::sqrt(config_.until_sure * config_.until_sure - numerical * numerical), pours_per_flow()));
            else
                expected = static_cast<long>(packings_for(sample(permeability).relative_deviation(), config_.until_sure, numerical)
                                                 .value_or(config_.max_packings));
        }
        return std::clamp(expected, std::min(known + 1, config_.max_packings), config_.max_packings);
    }
    [[nodiscard]] std::size_t pours_per_flow() const { return static_cast<std::size_t>(config_.pours_per_flow); }

    void show_progress() {
        const auto known = static_cast<double>(members_.size());
        const std::string mean = members_.size() < least() ? std::string() : fmt::format(", mean k within {:.2g} %", 100.0 * reached()),
                          pours = many_pours() ? fmt::format(", {} of {} pours", pours_.size(), pours_wanted(wanted())) : std::string();
        progress_.update(std::min(1.0, (known - 1.0) / std::max(1.0, static_cast<double>(wanted()) - 1.0)),
                         fmt::format("{} packings known, {} more begun, {}{} wanted{}{}", members_.size(),
                                     flows_begun_ - static_cast<long>(members_.size()), config_.until_sure > 0.0 ? "about " : "", wanted(),
                                     pours, mean));
    }

    void write_table(const Path& file) const {
        std::vector<std::string> columns = {"seed"};
        for (const Quantity& quantity : reported_quantities) columns.emplace_back(quantity.name);
        columns.insert(columns.end(),
                       {"permeability_low_m2", "permeability_high_m2", "section_scatter", "friction", "porosity_of_measured_part"});
        Table table(columns);
        for (const Member& one : members_) {
            const auto& v = one.values;
            const auto& k = one.intervals[permeability];
            table.add(one.seed, v[0], v[1], v[2], v[3], v[4], v[5], k ? std::optional(k->low) : std::nullopt,
                      k ? std::optional(k->high) : std::nullopt, one.section_scatter, one.friction, one.measured_part_porosity);
        }
        table.write(file);
    }
    void write_pours(const Path& file) const {
        Table table({"seed", "porosity"});
        long seed = case_.settings.packing.seed;
        for (const double eps : pours_) table.add(seed++, eps);
        table.write(file);
    }

    [[nodiscard]] std::vector<double> frictions() const {
        std::vector<double> list;
        for (const Member& one : members_) list.push_back(one.friction);
        return list;
    }
    // Where friction varies between the packings: the line of a quantity on it, at the friction of the case.
    [[nodiscard]] std::optional<MeanAtInput> at_friction(std::size_t quantity) const {
        const packing::PackingConfig& packing = case_.settings.packing;
        if (!(packing.friction_uncertainty > 0.0)) return std::nullopt;
        std::vector<double> friction, values;
        for (const Member& one : members_)
            if (one.values[quantity]) {
                friction.push_back(one.friction);
                values.push_back(*one.values[quantity]);
            }
        const auto line = fit_line(friction, values);
        return line ? std::optional(MeanAtInput{*line, packing.friction, packing.friction_uncertainty}) : std::nullopt;
    }

    // Mean, deviation of one packing, and intervals of the mean and of the next packing.
    struct Estimate {
        double mean, deviation;
        std::optional<Interval> of_mean, of_next;
    };
    [[nodiscard]] Estimate estimate(std::size_t quantity) const {
        const Sides numerical = mean_half_widths(quantity).value_or(Sides{});
        if (const auto found = at_friction(quantity))
            return {found->mean(), found->line.residual_deviation, found->interval_of_mean(numerical), found->interval_of_next(numerical)};
        if (const auto found = regressed(); found && quantity == permeability)
            return {found->mean(), found->deviation(), found->interval_of_mean(numerical), found->interval_of_next(numerical)};
        const StudyEnd end = config_.until_sure > 0.0 ? StudyEnd::when_sure : StudyEnd::at_number;
        const Sample s = many_pours() && quantity == porosity ? sample_of(pours_) : sample(quantity);
        return {s.mean, s.deviation, interval_of_mean(s, numerical, end), interval_of_next(s, numerical, end)};
    }

    [[nodiscard]] Json quantity_json(std::size_t quantity) const {
        const Estimate e = estimate(quantity);
        const std::size_t packings = many_pours() && quantity == porosity ? pours_.size() : values_of(quantity).size();
        const std::optional<Sides> numerical = mean_half_widths(quantity);
        return {{"packings", packings},
                {"mean", e.mean},
                {"standard_deviation", packings > 1 ? Json(e.deviation) : Json(nullptr)},
                {"standard_deviation_interval",
                 packings > 1 ? json_of(interval_of_deviation(e.deviation, static_cast<double>(packings) - 1.0)) : Json(nullptr)},
                {"numerical_half_width", numerical ? Json(numerical->wider()) : Json(nullptr)},
                {"numerical_interval", numerical ? json_of(about(e.mean, *numerical)) : Json(nullptr)},
                {"interval_of_mean", json_of(e.of_mean)},
                {"interval_of_next", json_of(e.of_next)}};
    }

    // k of the bed whose porosity was measured, by the line of ln k on the logarithm of the Kozeny function; or why it is not known.
    [[nodiscard]] Json measured_bed() const {
        const double value = config_.measured_porosity[0], u = config_.measured_porosity[1];
        std::vector<double> porosities, x, y;
        for (const Member& one : members_) {
            porosities.push_back(one.measured_part_porosity);
            x.push_back(std::log(kozeny_function(one.measured_part_porosity)));
            y.push_back(std::log(*one.values[permeability]));
        }
        Json json = {{"porosity", value},
                     {"standard_uncertainty", u},
                     {"part", name_of(config_.measured_part)},
                     {"packings", members_.size()},
                     {"permeability_m2", nullptr},
                     {"interval_m2", nullptr}};
        const auto refuse = [&](const std::string& why) {
            log_warning("k of the bed of measured porosity: " + why);
            json["why"] = why;
            return json;
        };
        if (std::any_of(porosities.begin(), porosities.end(), [](double eps) { return std::isnan(eps); }))
            return refuse(fmt::format("the level of {:g} m lies above the top of at least one of the packings: choose levels inside the bed",
                                      config_.measured_between_m[1]));
        const auto [low, high] = std::minmax_element(porosities.begin(), porosities.end());
        json["porosity_range"] = {*low, *high};
        if (value < *low || value > *high)
            return refuse(fmt::format(
                "the packings do not bracket it: their porosities ({}) are {:.4f} to {:.4f}, and {:g} was measured. Check of which part it was "
                "measured (`measured_part`), or vary what makes beds {}: [packing] friction = {}, friction_uncertainty",
                name_of(config_.measured_part), *low, *high, value, value < *low ? "denser" : "looser",
                value < *low ? "a lower value" : "a higher value"));
        const auto line = fit_line(x, y);
        if (!line) return refuse("all packings have the same porosity");
        const double k = mean_permeability();
        const Sides numerical = (1.0 / k) * mean_half_widths(permeability).value_or(Sides{});
        const BedEstimate found = bed_of_porosity(*line, value, u, numerical);
        json["permeability_m2"] = found.permeability_m2;
        json["interval_m2"] = json_of(std::optional(found.interval_m2));
        json["slope"] = line->slope;
        json["standard_deviation_about_line"] = line->residual_deviation;
        json["standard_deviation_of_ln_k"] = sample_of(y).deviation;
        return json;
    }

    [[nodiscard]] double standard_error_m2() const {
        if (const auto found = regressed())
            return std::hypot(found->line.residual_deviation * std::sqrt(found->line.relative_variance_at(found->pours.mean)),
                              found->line.slope * found->pours.deviation / std::sqrt(static_cast<double>(pours_.size())));
        return estimate(permeability).deviation / std::sqrt(static_cast<double>(members_.size()));
    }

    [[nodiscard]] Json result() const {
        const Estimate k = estimate(permeability), eps = estimate(porosity);
        Json json = {
            {"packings", members_.size()},
            {"quantities", Json::object()},
            {"porosity_mean", eps.mean},
            {"porosity_standard_deviation", eps.deviation},
            {"permeability_mean_m2", k.mean},
            {"standard_deviation_between_packings_m2", k.deviation},
            {"standard_error_of_mean_m2", standard_error_m2()},
            {"numerical_half_width_m2", mean_half_widths(permeability) ? Json(numerical_half_width_m2()) : Json(nullptr)},
            {"unseen_share", unseen_share(members_.size())},
            {"meaning",
             "intervals of 95 %: Student's t for the scatter between packings, and the numerical half widths of one packing, added in "
             "quadrature on each side where they are known. They presume that these packings show the scatter: packings of another "
             "kind, up to unseen_share of all, may all be absent with a probability of 5 %"}};
        if (const auto found = regressed())
            json["pours"] = {{"packings", pours_.size()},
                             {"relative_deviation_about_line", found->line.residual_deviation / found->mean()},
                             {"relative_deviation_along_line", std::abs(found->line.slope) * found->pours.deviation / found->mean()}};
        if (const auto found = at_friction(permeability))
            json["friction"] = {{"value", found->input},
                                {"standard_uncertainty", found->input_uncertainty},
                                {"relative_effect_on_permeability", found->effect() / found->mean()}};
        if (!config_.measured_porosity.empty()) json["measured_porosity"] = measured_bed();
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
    std::vector<Member> members_;                          // flows, in the order of their seeds, without gaps
    std::vector<double> pours_;                            // porosities of the sections, the same
    std::map<long, std::string> flows_done_, pours_done_;  // seeds, with their error, in any order
    long flows_begun_ = 1, pours_begun_ = 1;
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
    const bool pours = config.pours_per_flow > 1;
    const auto number = [&](double scatter) {
        const double wanted = config.until_sure * std::sqrt(1.0 - numerical_share * numerical_share);
        const auto found = pours ? flows_for(usual_share_about_line * scatter, std::sqrt(1.0 - std::pow(usual_share_about_line, 2.0)) * scatter,
                                             wanted, static_cast<std::size_t>(config.pours_per_flow))
                                 : packings_for(scatter, config.until_sure, numerical_share * config.until_sure).value_or(least_packings);
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
    return {.text = text,
            .memory_bytes = each.memory_bytes,
            .wall_time_s = flows * each.wall_time_s + more_pours * pour.wall_time_s,
            .disk_bytes = flows * each.disk_bytes + more_pours * pour.disk_bytes};
}

}  // namespace

Stage make_seeds_stage(const Case& c) {
    if (const LbmConfig& lbm = c.settings.lbm; c.settings.packings.until_sure > 0.0 && lbm.walls == Walls::bounce_back && lbm.grids < 2)
        throw UserError("until_sure needs the numerical error of each packing, and one grid with bounce_back gives none",
                        {.where = "[lbm] grids", .allowed = "2 or more", .fix = "grids = 2, or walls = \"interpolated\""});
    const packing::PackingsConfig& packings = c.settings.packings;
    std::vector<std::string> outputs = {"seeds.csv"};
    if (packings.until_sure > 0.0 && packings.pours_per_flow > 1) outputs.emplace_back("pours.csv");
    return {.name = "seeds",
            .needs = {"lbm", last_stage},
            .configuration = c.settings.resolved_tables({"packings"}),
            .outputs = outputs,
            .run = [c](const Path& folder) { return SeedsStudy(c).run(folder); },
            .expect = [c] { return expect(c); },
            .result_version = 6};
}

}  // namespace porepack::study
