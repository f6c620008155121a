#include "design/design_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/build.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "core/owned_names.hpp"
#include "core/table.hpp"
#include "design/uses.hpp"
#include "report/page.hpp"
#include "report/picture.hpp"
#include "report/plot.hpp"
#include "stages/stages.hpp"
#include "study/grain_sheet.hpp"

namespace porepack::design {
using study::grain_sheet;
namespace {

double volume_m3(const SizedCandidate& grain) {
    return std::numbers::pi / 6.0 * std::pow(grain.size_m, 3);
}

std::string text_of(const Interval& wanted, const char* format) {
    const auto one = [&](double value) { return fmt::format(fmt::runtime(format), value); };
    return wanted.low == wanted.high ? one(wanted.low) : one(wanted.low) + " to " + one(wanted.high);
}

void write_proposals(const DesignResult& result, const Path& folder) {
    Table table({"proposal",
                 "shape",
                 "sphericity",
                 "convexity",
                 "equal_volume_diameter_m",
                 "volume_m3",
                 "capsule_diameter_m",
                 "expected_permeability_m2",
                 "expected_permeability_relative_deviation",
                 "expected_porosity",
                 "expected_porosity_deviation",
                 "extrapolated",
                 "packings",
                 "magnified_from",
                 "permeability_m2",
                 "permeability_low_m2",
                 "permeability_high_m2",
                 "porosity",
                 "porosity_low",
                 "porosity_high",
                 "hit",
                 "error"});
    const auto known = [](const Proposal& p, double value) { return p.error.empty() ? std::optional(value) : std::nullopt; };
    for (std::size_t i = 0; i < result.proposals.size(); ++i) {
        const Proposal& p = result.proposals[i];
        const SizedCandidate& g = p.grain;
        table.add(i + 1, g.candidate.family, g.candidate.form.sphericity, g.candidate.form.convexity, g.size_m, volume_m3(g),
                  g.candidate.form.thickness * g.size_m, expected_permeability_m2(g), g.prediction.log_permeability.standard_deviation,
                  g.prediction.porosity.value, g.prediction.porosity.standard_deviation, g.prediction.extrapolated ? "yes" : "no",
                  known(p, static_cast<double>(p.bed.packings)), p.magnified_from > 0 ? std::optional(p.magnified_from) : std::nullopt,
                  known(p, p.permeability_m2), known(p, p.permeability_interval_m2.low), known(p, p.permeability_interval_m2.high),
                  known(p, p.bed.porosity), known(p, p.porosity_interval.low), known(p, p.porosity_interval.high), p.hit ? "yes" : "no",
                  p.error);
    }
    table.write(folder / "proposals.csv");
}

// What can be reached: a curve of expected (porosity, k) per family; the goal as a box; the proposals with their intervals.
bool draw_reach(const DesignGoal& goal, const DesignResult& result, const Path& folder) {
    std::map<std::string, std::string> families;
    for (const SizedCandidate& one : result.reachable)
        families[one.candidate.family] +=
            fmt::format("{:.6g} {:.6g} {:d}\n", one.prediction.porosity.value, expected_permeability_m2(one), one.prediction.extrapolated);
    PlotValues values = {{"families", static_cast<double>(families.size())},
                         {"k_low", goal.permeability_m2.low},
                         {"k_high", goal.permeability_m2.high},
                         {"porosity_low", goal.porosity ? goal.porosity->low : 0.0},
                         {"porosity_high", goal.porosity ? goal.porosity->high : 1.0}};
    std::string data =
        "# expected porosity, k (m2), 1 if extrapolated, by family; then the proposals: porosity, low, high, k, low, high, number\n";
    std::size_t number = 0;
    for (const auto& [family, lines] : families) {
        values.emplace_back(fmt::format("family_{}", ++number), family);
        data += lines + "\n\n";
    }
    for (std::size_t i = 0; i < result.proposals.size(); ++i)
        if (const Proposal& p = result.proposals[i]; p.error.empty())
            data += fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {}\n", p.bed.porosity, p.porosity_interval.low,
                                p.porosity_interval.high, p.permeability_m2, p.permeability_interval_m2.low,
                                p.permeability_interval_m2.high, i + 1);
    write_text(folder / "reach.dat", data);
    return draw_plot(folder / "reach.svg", "reach", values, {.width = 620, .height = 400});
}

bool draw_grains(const DesignResult& result, const Path& folder) {
    std::vector<Shape> grains;
    double largest = 0.0;
    for (const Proposal& p : result.proposals) {
        grains.push_back(make_shape(scaled(p.grain.candidate.shape, p.grain.size_m)));
        largest = std::max(largest, p.grain.candidate.form.feret * p.grain.size_m);
    }
    if (grains.empty()) return false;
    io::write_stl(folder / "grains.stl", grain_sheet(grains, static_cast<long>(grains.size()), 1.1 * largest));
    return report::draw_picture(folder / "grains.stl", folder / "grains.png", {"--front"});
}

ReportSection proposals_section(const DesignResult& result) {
    ReportSection section{
        .title = "Proposals",
        .intro =
            "Expected: by the surrogate, before the bed was poured, ± one standard deviation. Computed: mean of the packings, with "
            "its interval of 95 %, from the scatter between its packings and that of all known beds.",
        .header = {"", "grain", "expected k (m²), ± standard deviation", "computed k (m²), 95 %", "expected porosity, ± standard deviation",
                   "computed porosity, 95 %", ""}};
    for (std::size_t i = 0; i < result.proposals.size(); ++i) {
        const Proposal& p = result.proposals[i];
        const Prediction& expected = p.grain.prediction;
        section.rows.push_back(
            {std::to_string(i + 1), description(p.grain),
             fmt::format("{:.3g} ± {:.0f} %", expected_permeability_m2(p.grain), 100.0 * expected.log_permeability.standard_deviation),
             p.error.empty() ? fmt::format("{:.3g} {}", p.permeability_m2, percent_text(p.permeability_m2, p.permeability_interval_m2))
                             : "failed: " + p.error,
             fmt::format("{:.3f} ± {:.3f}", expected.porosity.value, expected.porosity.standard_deviation),
             p.error.empty() ? fmt::format("{:.3f} ({:.3f} to {:.3f})", p.bed.porosity, p.porosity_interval.low, p.porosity_interval.high)
                             : "–",
             fmt::format("{}{}", p.hit ? "hit" : "",
                         p.magnified_from > 0 ? fmt::format(" (proposal {}, magnified)", p.magnified_from) : "")});
        section.links.push_back(fmt::format("proposal_{}/case.toml", i + 1));
    }
    return section;
}

}  // namespace

Json to_json(const DesignGoal& goal) {
    const auto pair = [](const Interval& x) { return Json({x.low, x.high}); };
    Json json = {{"permeability_m2", pair(goal.permeability_m2)},
                 {"porosity", goal.porosity ? pair(*goal.porosity) : Json(nullptr)},
                 {"container", vessels::to_json(goal.container)},
                 {"volume_m3", goal.volume_m3 > 0.0 ? Json(goal.volume_m3) : Json("free")},
                 {"shapes", Json::array()},
                 {"sphericity", pair(goal.sphericity)},
                 {"convexity", pair(goal.convexity)},
                 {"thinnest_m", goal.thinnest_m},
                 {"mass_kg", pair(goal.mass_kg)},
                 {"packings", goal.packings},
                 {"seed", goal.seed},
                 {"within", goal.within}};
    for (const ShapeKind kind : goal.kinds) json["shapes"].push_back(name_of(kind));
    if (!goal.own_shape.empty()) json["shapes"].push_back(goal.own_shape.string());
    for (const FreeParameter& free : goal.free) json["free"].push_back({{"name", free.name}, {"range", {free.low, free.high}}});
    return json;
}

double expected_permeability_m2(const SizedCandidate& grain) {
    return std::exp(grain.prediction.log_permeability.value) * grain.size_m * grain.size_m;
}

std::string description(const SizedCandidate& grain) {
    const GrainForm& form = grain.candidate.form;
    return fmt::format("{}, sphericity {:.3f}, volume {:.3g} mm³, capsules {:.3g} mm thick", grain.candidate.family, form.sphericity,
                       1e9 * volume_m3(grain), 1e3 * form.thickness * grain.size_m);
}

const std::vector<std::string>& design_files() {
    static const std::vector<std::string> names = {"proposals.csv", "design.json",   "design.html", "reach.dat",
                                                   "reach.svg",     "reach.gnuplot", "grains.png"};
    return names;
}

void write_design(const DesignGoal& goal, const DesignResult& result, const std::vector<KnownBed>& known, const Path& folder) {
    OwnedNames(folder).add(design_files());
    write_proposals(result, folder);
    const ScatterOfBeds k = permeability_scatter(known), porosity = porosity_scatter(known);
    Json proposals = Json::array();
    for (const Proposal& p : result.proposals)
        proposals.push_back({{"grain", description(p.grain)},
                             {"permeability_m2", p.error.empty() ? Json(p.permeability_m2) : Json(nullptr)},
                             {"porosity", p.error.empty() ? Json(p.bed.porosity) : Json(nullptr)},
                             {"hit", p.hit}});
    write_json(folder / "design.json", {{"goal", to_json(goal)},
                                        {"verdict", name_of(result.verdict)},
                                        {"text", result.text},
                                        {"proposals", proposals},
                                        {"full", json_of(result.full)},
                                        {"beds_known", known.size()},
                                        {"scatter_between_packings",
                                         {{"permeability_relative", json_of(k.typical())},
                                          {"porosity", json_of(porosity.typical())},
                                          {"permeability_common_weight", json_of(k.common_weight())},
                                          {"porosity_common_weight", json_of(porosity.common_weight())}}},
                                        {"program_version", program_version()},
                                        {"git_hash", git_hash()}});

    Page page;
    page.title = "Design: k = " + text_of(goal.permeability_m2, "{:.3g}") + " m²" +
                 (goal.porosity ? ", porosity " + text_of(*goal.porosity, "{:.3g}") : std::string());
    page.versions = {{"porepack", program_version()}, {"git_hash", git_hash()}};
    page.configuration = to_json(goal);
    if (!result.text.empty()) page.notes = {result.text};
    ReportSection reach{.title = "What can be reached"};
    if (draw_reach(goal, result, folder))
        reach.pictures.emplace_back("reach.svg",
                                    "Lines: expected porosity and k of the allowed grains; dotted: extrapolated. Grey: the goal. Points: "
                                    "computed proposals with their "
                                    "intervals of 95 %.");
    ReportSection rows = proposals_section(result);
    if (draw_grains(result, folder)) rows.pictures.emplace_back("grains.png", "The proposed grains, in order, at one scale.");
    page.main_numbers = {{"verdict", std::string(name_of(result.verdict))}, {"proposals", std::to_string(result.proposals.size())}};
    if (result.full) page.main_numbers.push_back({"k in the whole container", fmt::format("{:.3g} m²", result.full->permeability_m2)});
    page.sections = {rows, reach};
    write_text(folder / "design.html", html_page(page, folder));
}

}  // namespace porepack::design
