#include "analysis/uncertainty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/uses.hpp"
#include "core/table.hpp"
#include "results/quantities.hpp"
#include "results/results.hpp"
#include "uncertainty/budget.hpp"

namespace porepack::analysis {
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
std::optional<double> overlap_of_solid(const std::optional<PoreSpace>& bed, const results::Pack& pack) {
    if (!bed) return std::nullopt;
    const PoreSpace& space = *bed;
    const double d = space.grain_size_m, height = pack.bed.bed_height_m,
                 solid = (1.0 - pack.bed.porosity_bed) * space.container.vessel().mean_area({0.0, height}) * height;
    constexpr double cylinders_over_spheres = 2.5;
    return cylinders_over_spheres * static_cast<double>(pack.contacts) * std::numbers::pi * 0.5 * d *
           std::pow(pack.mean_overlap_relative_to_diameter * d, 2.0) / solid;
}

// Of the interval of lattice Boltzmann itself.
void add_parts(std::vector<BudgetRow>& rows, const results::Lbm& lbm) {
    if (!lbm.half_width_parts_m2) return;
    const results::HalfWidthParts& parts = *lbm.half_width_parts_m2;
    const auto add = [&](const char* source, std::optional<double> half, Evidence evidence, const char* origin, bool above = true) {
        if (!half || !(*half > 0.0)) return;
        const double u = *half / (coverage_factor * lbm.permeability.m2);
        rows.push_back({source, {u, above ? u : 0.0}, Part::numerical, evidence, origin});
    };
    add("grid", parts.grid, Evidence::measured, "change of k between the grids");
    add("iteration", parts.iteration, Evidence::measured, "energy of the unsteady flow, twice the estimate");
    add("mass balance", parts.mass_balance, Evidence::measured, "flow rate through the planes against the mean over the layers");
    add("rounding", parts.precision, Evidence::bounded, "number format of the populations");
    add("stretched box", parts.stretch, Evidence::bounded, "the periodic box is stretched to whole numbers of cubic voxels");
    add("gray levels, or places of walls", parts.threshold, Evidence::measured,
        "k with the solid fraction moved by two standard errors of the gray levels, or of the walls around balls");
    add("blur", parts.blur, Evidence::judged, "k with twice the variance of the blur; blur makes k too large", false);
}

void add_packing(std::vector<BudgetRow>& rows, const std::optional<PoreSpace>& space, const results::Pack& pack, double porosity) {
    if (const auto share = overlap_of_solid(space, pack))
        rows.push_back({overlap_row, both(permeability_change(porosity, *share) / coverage_factor), Part::numerical, Evidence::bounded,
                        fmt::format("{:.1e} of the solid lies in two grains", *share)});
    if (pack.fit)
        rows.push_back({sizes_row, both(permeability_change(porosity, std::abs(pack.fit->solid_change)) / coverage_factor), Part::numerical,
                        Evidence::judged, fmt::format("fitted sizes change the solid by {:+.2f} %", 100.0 * pack.fit->solid_change)});
}

void add_friction(std::vector<BudgetRow>& rows, const pouring::PackingConfig& packing, const results::CaseResults& results) {
    if (results.seeds && results.seeds->friction)
        rows.push_back({"friction", both(results.seeds->friction->relative_effect_on_permeability), Part::input, Evidence::measured,
                        fmt::format("friction {:g} with standard uncertainty {:g}, varied between {} packings", packing.friction,
                                    packing.friction_uncertainty, results.seeds->packings)});
    else if (results.pack && packing.engine != pouring::Engine::none && !results.pack->fit)
        rows.push_back({"friction", both(usual_friction_effect), Part::hint, Evidence::judged,
                        fmt::format("tetrapods of 0.53, if friction is known to {:g}; [packing] friction_uncertainty measures it, and a "
                                    "measured porosity removes most of it",
                                    usual_friction_uncertainty)});
}

std::vector<BudgetRow> rows_of_permeability(const results::CaseResults& results, const BedOfCase& bed) {
    const results::Lbm& lbm = *results.lbm;
    const double k = lbm.permeability.m2;
    std::vector<BudgetRow> rows;
    add_parts(rows, lbm);
    if (const auto change = lbm.averaged_image_change)
        rows.push_back({"resolution of the image", both(std::abs(*change)), Part::hint, Evidence::measured,
                        fmt::format("k of the image averaged over 2 x 2 x 2 voxels is {:+.2g} % off", 100.0 * *change)});
    if (const auto& foam = results.foam)
        rows.push_back(
            {solver_row, both(between_methods(k, lbm.permeability.interval_m2, foam->permeability.m2, foam->permeability.interval_m2)),
             Part::numerical, Evidence::judged,
             fmt::format("OpenFOAM is {:+.1f} % off; what both intervals leave unexplained", 100.0 * (foam->permeability.m2 / k - 1.0))});
    if (results.pack) add_packing(rows, bed.space, *results.pack, lbm.porosity);
    if (const auto& section = bed.section)
        rows.push_back({section_row, both(section->relative), Part::hint, Evidence::measured,
                        fmt::format("{:.2g} % ({:.2g} to {:.2g} %, from a section of {:.1f} grain diameters)", 100.0 * section->relative,
                                    100.0 * section->interval.low, 100.0 * section->interval.high, section->diameters)});
    add_friction(rows, bed.packing, results);
    if (const auto& seeds = results.seeds)
        rows.push_back({"packing to packing", both(seeds->standard_deviation_between_packings_m2 / seeds->permeability_mean_m2),
                        Part::scatter, Evidence::measured, fmt::format("{} packings", seeds->packings)});
    return rows;
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
void add_packings(results::Statements& statements, const results::CaseResults& results, const std::string& quantity,
                  const std::vector<BudgetRow>& rows) {
    if (const auto* seeds = results.seeds ? find(results.seeds->quantities, quantity) : nullptr) {
        const Sides other = seeds->mean * other_half_widths(rows);
        const auto statement = [&](const std::optional<Interval>& known) {
            return results::Statement{.value = seeds->mean,
                                      .interval = known ? std::optional(widened(*known, seeds->mean, other)) : std::nullopt,
                                      .packings = seeds->packings};
        };
        statements.mean_of_such_packings = statement(seeds->interval_of_mean);
        statements.next_such_packing = statement(seeds->interval_of_next);
        return;
    }
    std::string why = "not known from one packing";
    for (const BudgetRow& row : rows)
        if (const double scatter = row.relative_standard_uncertainty.wider(); row.source == section_row) {
            why += fmt::format("; the layers of this one suggest a scatter of {}", row.origin);
            if (const auto needed = packings_for(scatter, 0.05); scatter > 0.0 && needed)
                why += fmt::format("; with {:.2g} %, about {} packings would give the mean within 5 %", 100.0 * scatter, *needed);
        }
    statements.mean_of_such_packings = statements.next_such_packing = {.why = why};
}

// k of the bed whose porosity was measured; its interval holds the numerical error of one packing, but not what other_half_widths() adds.
results::StatementOfBed statement_of_bed(const results::MeasuredBed& found, const std::vector<BudgetRow>& rows) {
    results::StatementOfBed bed{.statement = {.value = found.permeability_m2, .packings = found.packings, .why = found.why},
                                .measured_porosity = found.porosity,
                                .measured_standard_uncertainty = found.standard_uncertainty,
                                .measured_part = found.part};
    if (found.permeability_m2 && found.interval_m2) {
        const double k = *found.permeability_m2;
        bed.statement.interval = widened(*found.interval_m2, k, k * other_half_widths(rows));
    }
    return bed;
}

// The solver's own interval holds grid, iteration, mass balance, rounding, and gray levels and blur of an image, and was calibrated as
// their sum; the rest is added in quadrature, each side by itself.
std::optional<Interval> interval_of_this_packing(const results::Permeability& k, const std::vector<BudgetRow>& rows) {
    return k.interval_m2 ? std::optional(widened(*k.interval_m2, k.m2, k.m2 * other_half_widths(rows))) : std::nullopt;
}

// A standard uncertainty, of the lines of the quadrature and of the gray levels of an image. The scatter of the tortuosities between
// paths and starting points is not an error of the computation.
std::optional<Interval> interval_of_porosity(double porosity, const results::Voxelise& voxels) {
    const double u = voxels.porosity_uncertainty;
    return std::isfinite(u) ? std::optional(about(porosity, both(2.0 * u))) : std::nullopt;
}

}  // namespace

results::Uncertainty state_uncertainty(const results::CaseResults& results, const BedOfCase& bed) {
    if (!results.lbm) throw std::logic_error("no uncertainty without a permeability");
    results::Uncertainty sure{
        .budget_of_permeability = rows_of_permeability(results, bed),
        .meaning =
            "intervals of 95 %; this packing: numerical errors only; mean: Student's t of the packings, and the numerical error; next: one "
            "more packing; bed of measured porosity: k of a bed that exists, from its porosity"};
    for (const results::Quantity& quantity : results::reported_quantities) {
        const auto value = quantity.value(results);
        if (!value || !std::isfinite(*value)) continue;
        const std::string name = quantity.name;
        const std::vector<BudgetRow> rows = name == "permeability_m2" ? sure.budget_of_permeability : std::vector<BudgetRow>();
        results::Statements statements{.this_packing = {.value = *value, .interval = quantity.interval(results)}};
        if (name == "permeability_m2") statements.this_packing.interval = interval_of_this_packing(results.lbm->permeability, rows);
        if (name == "porosity" && results.voxelise) statements.this_packing.interval = interval_of_porosity(*value, *results.voxelise);
        add_packings(statements, results, name, rows);
        if (name == "permeability_m2" && results.seeds && results.seeds->measured_porosity)
            statements.bed_of_measured_porosity = statement_of_bed(*results.seeds->measured_porosity, rows);
        sure.statements.emplace_back(name, statements);
    }
    return sure;
}

}  // namespace porepack::analysis
