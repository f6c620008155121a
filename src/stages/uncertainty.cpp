// How sure the numbers are: the uncertainty budget of k, and for each quantity what is known of this packing, of the mean of such packings
// and of the next one (docs/uncertainty.md).
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/table.hpp"
#include "stages/results.hpp"
#include "stages/stages.hpp"
#include "uncertainty/budget.hpp"
#include "uncertainty/quantities.hpp"

namespace porepack::stages {
using namespace core;
using namespace pore_space;
using namespace permeability;
using namespace uncertainty;
using namespace pipeline;
namespace fs = std::filesystem;
namespace {

constexpr const char *solver_row = "solver", *overlap_row = "overlap of grains at contacts", *sizes_row = "sizes of fitted grains",
                     *section_row = "section length";

// Effect on ln k of an uncertainty of 0.1 of the friction between grains (cases/friction_study: tetrapods of 0.53).
constexpr double usual_friction_uncertainty = 0.1, usual_friction_effect = 0.12;

Sides both(double width) {
    return {width, width};
}

// Grains that touch overlap in the computation, so their union is smaller than the sum of their volumes. Two spheres of radius R that
// overlap by s share pi R s^2 / 2, crossing cylinders pi R s^2 / sin(angle), on average 2.5 times as much; the mean square of the overlaps
// is about twice the square of their mean. Nothing where grains overlap on purpose: that is the geometry.
std::optional<double> overlap_of_solid(const Case& c, const Json& pack) {
    if (pack.value("overlap_allowed", false)) return std::nullopt;
    const auto mean = number_at(pack, "/mean_overlap_relative_to_diameter"), contacts = number_at(pack, "/contacts"),
               porosity = number_at(pack, "/porosity_bed"), height = number_at(pack, "/bed_height_m");
    if (!mean || !contacts || !porosity || !height) return std::nullopt;
    const PoreSpace space = case_pore_space(c);
    const double d = space.grain_size_m, solid = (1.0 - *porosity) * space.container.inner_area_m2() * *height;
    constexpr double cylinders_over_spheres = 2.5;
    return cylinders_over_spheres * *contacts * std::numbers::pi * 0.5 * d * std::pow(*mean * d, 2.0) / solid;
}

}  // namespace

std::optional<SectionScatter> section_scatter_of(const Case& c) {
    const Path file = c.stage_folder("lbm") / "gradient.csv";
    if (!fs::exists(file)) return std::nullopt;
    std::vector<double> gradient;
    double low = 0.0, high = 0.0;
    for (const auto& row : read_table(file)) {
        if (gradient.empty()) low = row.at(0);
        high = row.at(1);
        gradient.push_back(row.at(2));
    }
    const PoreSpace space = case_pore_space(c);
    return section_scatter(gradient, high - low, space.equivalent_diameter_m);
}

namespace {

std::vector<BudgetRow> rows_of_permeability(const Case& c, const Json& results) {
    const Json& lbm = results.at("lbm");
    const double k = lbm.at("permeability_m2").get<double>();
    std::vector<BudgetRow> rows;
    const auto add_part = [&](const char* source, const char* key, Evidence evidence, const char* origin, bool above = true) {
        const auto half = number_at(lbm, std::string("/half_width_parts_m2/") + key);
        if (!half || !(*half > 0.0)) return;
        const double u = *half / (coverage_factor * k);
        rows.push_back({source, {u, above ? u : 0.0}, Part::numerical, evidence, origin});
    };
    add_part("grid", "grid", Evidence::measured, "change of k between the grids");
    add_part("iteration", "iteration", Evidence::measured, "energy of the unsteady flow, twice the estimate");
    add_part("mass balance", "mass_balance", Evidence::measured, "flow rate through the planes against the mean over the layers");
    add_part("rounding", "precision", Evidence::bounded, "number format of the populations");
    add_part("stretched box", "stretch", Evidence::bounded, "the periodic box is stretched to whole numbers of cubic voxels");
    add_part("gray levels", "threshold", Evidence::measured, "k with the solid fraction moved by two standard errors of the gray levels");
    add_part("blur", "blur", Evidence::judged, "k with twice the variance of the blur; blur makes k too large", false);
    if (const auto change = number_at(lbm, "/averaged_image_change"))
        rows.push_back({"resolution of the image", both(std::abs(*change)), Part::hint, Evidence::measured,
                        fmt::format("k of the image averaged over 2 x 2 x 2 voxels is {:+.2g} % off", 100.0 * *change)});
    if (const auto foam = number_at(results, "/foam/permeability_m2"))
        rows.push_back({solver_row,
                        both(between_methods(k, interval_at(lbm, "/permeability_interval_m2"), *foam,
                                             interval_at(results, "/foam/permeability_interval_m2"))),
                        Part::numerical, Evidence::judged,
                        fmt::format("OpenFOAM is {:+.1f} % off; what both intervals leave unexplained", 100.0 * (*foam / k - 1.0))});
    if (results.contains("pack"))
        if (const auto share = overlap_of_solid(c, results["pack"]))
            rows.push_back({overlap_row, both(permeability_change(lbm.at("porosity").get<double>(), *share) / coverage_factor),
                            Part::numerical, Evidence::bounded, fmt::format("{:.1e} of the solid lies in two grains", *share)});
    if (const auto change = number_at(results, "/pack/fit/solid_change"))
        rows.push_back({sizes_row, both(permeability_change(lbm.at("porosity").get<double>(), std::abs(*change)) / coverage_factor),
                        Part::numerical, Evidence::judged, fmt::format("fitted sizes change the solid by {:+.2f} %", 100.0 * *change)});
    if (const auto section = section_scatter_of(c))
        rows.push_back({section_row, both(section->relative), Part::hint, Evidence::measured,
                        fmt::format("{:.2g} % ({:.2g} to {:.2g} %, from a section of {:.1f} grain diameters)", 100.0 * section->relative,
                                    100.0 * section->interval.low, 100.0 * section->interval.high, section->diameters)});
    const pouring::PackingConfig& packing = c.settings.packing;
    if (const auto effect = number_at(results, "/seeds/friction/relative_effect_on_permeability"))
        rows.push_back({"friction", both(*effect), Part::input, Evidence::measured,
                        fmt::format("friction {:g} with standard uncertainty {:g}, varied between {} packings", packing.friction,
                                    packing.friction_uncertainty, results["seeds"].at("packings").get<long>())});
    else if (results.contains("pack") && packing.engine != pouring::Engine::none && !c.from_fit())
        rows.push_back({"friction", both(usual_friction_effect), Part::hint, Evidence::judged,
                        fmt::format("tetrapods of 0.53, if friction is known to {:g}; [packing] friction_uncertainty measures it, and a "
                                    "measured porosity removes most of it",
                                    usual_friction_uncertainty)});
    if (const auto mean = number_at(results, "/seeds/permeability_mean_m2"))
        rows.push_back({"packing to packing", both(*number_at(results, "/seeds/standard_deviation_between_packings_m2") / *mean),
                        Part::scatter, Evidence::measured, fmt::format("{} packings", results["seeds"].at("packings").get<long>())});
    return rows;
}

Json statement(double value, const std::optional<Interval>& interval, long packings) {
    return {{"value", value}, {"interval", json_of(interval)}, {"packings", packings}};
}

// Half widths of 95 % by the contributions that the solver's own interval does not hold, relative.
Sides other_half_widths(const std::vector<BudgetRow>& rows) {
    Sides sum;
    for (const BudgetRow& row : rows)
        if (row.source == solver_row || row.source == overlap_row || row.source == sizes_row)
            sum = in_quadrature(sum, coverage_factor * row.relative_standard_uncertainty);
    return sum;
}

// The next packings, from those of the study, whose intervals hold the solver's own; without a study, what the layers of this packing
// suggest.
void add_packings(Json& statements, const Json& results, const std::string& quantity, const std::vector<BudgetRow>& rows) {
    const Json::json_pointer at("/seeds/quantities/" + quantity);
    if (results.contains(at)) {
        const Json& seeds = results.at(at);
        const double mean = seeds.at("mean").get<double>();
        const Sides other = mean * other_half_widths(rows);
        for (const auto& [name, key] :
             {std::pair("mean_of_such_packings", "/interval_of_mean"), std::pair("next_such_packing", "/interval_of_next")}) {
            const auto known = interval_at(seeds, key);
            statements[name] =
                statement(mean, known ? std::optional(widened(*known, mean, other)) : std::nullopt, seeds.at("packings").get<long>());
        }
        return;
    }
    std::string why = "not known from one packing";
    for (const BudgetRow& row : rows)
        if (const double scatter = row.relative_standard_uncertainty.wider(); row.source == section_row) {
            why += fmt::format("; the layers of this one suggest a scatter of {}", row.origin);
            if (const auto needed = packings_for(scatter, 0.05); scatter > 0.0 && needed)
                why += fmt::format("; with {:.2g} %, about {} packings would give the mean within 5 %", 100.0 * scatter, *needed);
        }
    for (const char* name : {"mean_of_such_packings", "next_such_packing"})
        statements[name] = {{"value", nullptr}, {"interval", nullptr}, {"packings", 1}, {"why", why}};
}

// k of the bed whose porosity was measured; its interval holds the numerical error of one packing, but not what other_half_widths() adds.
Json measured_bed(const Json& seeds, const std::vector<BudgetRow>& rows) {
    const Json& found = seeds.at("measured_porosity");
    Json json = {{"value", found.at("permeability_m2")}, {"interval", nullptr}, {"packings", found.at("packings")}};
    for (const char* key : {"porosity", "standard_uncertainty", "part"}) json["measured_" + std::string(key)] = found.at(key);
    if (found.contains("why")) json["why"] = found["why"];
    if (const auto interval = interval_at(found, "/interval_m2")) {
        const double k = found["permeability_m2"].get<double>();
        json["interval"] = json_of(std::optional(widened(*interval, k, k * other_half_widths(rows))));
    }
    return json;
}

Json statements_of(const Json& results, const std::string& quantity, double value, const std::optional<Interval>& here,
                   const std::vector<BudgetRow>& rows = {}) {
    Json statements;
    statements["this_packing"] = statement(value, here, 1);
    add_packings(statements, results, quantity, rows);
    return statements;
}

// The solver's own interval holds grid, iteration, mass balance, rounding, and gray levels and blur of an image, and was calibrated as
// their sum; the rest is added in quadrature, each side by itself.
std::optional<Interval> interval_of_this_packing(const Json& lbm, const std::vector<BudgetRow>& rows) {
    const double k = lbm.at("permeability_m2").get<double>();
    const auto own = interval_at(lbm, "/permeability_interval_m2");
    return own ? std::optional(widened(*own, k, k * other_half_widths(rows))) : std::nullopt;
}

Json run_uncertainty(const Case& c, const std::vector<std::string>& needs) {
    Json results = Json::object();
    for (const std::string& stage : needs)
        if (fs::exists(c.stage_folder(stage))) results[stage] = c.result_of(stage);  // an optional stage may have failed
    const Json& lbm = results.at("lbm");
    const std::vector<BudgetRow> rows = rows_of_permeability(c, results);
    // A standard uncertainty, of the lines of the quadrature and of the gray levels of an image. The scatter of the tortuosities between
    // paths and starting points is not an error of the computation.
    const auto u = number_at(results, "/voxelise/porosity_uncertainty");
    Json statements = Json::object();
    for (const Quantity& quantity : reported_quantities) {
        const auto value = number_at(results, quantity.value);
        if (!value) continue;
        const std::string name = quantity.name;
        if (name == "permeability_m2") {
            statements[name] = statements_of(results, name, *value, interval_of_this_packing(lbm, rows), rows);
            if (results.contains("/seeds/measured_porosity"_json_pointer))
                statements[name]["bed_of_measured_porosity"] = measured_bed(results["seeds"], rows);
        } else if (name == "porosity")
            statements[name] = statements_of(results, name, *value, u ? std::optional(about(*value, both(2.0 * *u))) : std::nullopt);
        else
            statements[name] = statements_of(results, name, *value, interval_at(results, quantity.interval));
    }
    return {
        {"budget_of_permeability", json_of(rows)},
        {"statements", statements},
        {"meaning",
         "intervals of 95 %; this packing: numerical errors only; mean: Student's t of the packings, and the numerical error; next: one "
         "more packing; bed of measured porosity: k of a bed that exists, from its porosity"}};
}

}  // namespace

Stage make_uncertainty_stage(const Case& c, const std::vector<std::string>& stages) {
    std::vector<std::string> needs;
    for (const std::string& stage : stages)
        for (const char* used : {"pack", "voxelise", "lbm", "foam", "seeds", "tortuosity"})
            if (stage == used) needs.push_back(stage);
    return {.name = "uncertainty",
            .needs = needs,
            .configuration = deciding_keys(c, {"container"}, {}, true),
            .run = [c, needs](const Path&) { return run_uncertainty(c, needs); },
            .result_version = 3};
}

}  // namespace porepack::stages
