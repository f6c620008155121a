#include "analysis/pressure_drop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "permeability/pressure_drop.hpp"

namespace porepack::analysis {
namespace {

// The errors of walls, too: the fit of k_in counts them as one common part, here each flow stands for itself.
InertialCurve curve_with_wall_errors(const lbm::InertialSeries& series) {
    InertialCurve curve{.permeability_m2 = series.creeping_permeability_m2, .flows = {}};
    for (const lbm::InertialFlow& flow : series.flows) {
        const double walls = flow.in_time ? 0.5 * flow.in_time->wall_half_width() : 0.0;
        curve.flows.push_back({flow.reynolds, flow.permeability_m2, std::hypot(flow.error(), walls)});
    }
    return curve;
}

std::string command_for(const PressureDropQuestion& question, double reynolds) {
    return fmt::format("porepack forchheimer {} --openfoam false --reynolds {:.3g},{:.3g},{:.3g}", question.name, 0.3 * reynolds,
                       0.6 * reynolds, 1.2 * reynolds);
}

// The flows with inertia of the case, or what their lack means.
InertialFactor factor_of(const results::CaseResults& found, const PressureDropQuestion& question, double velocity, double viscosity,
                         std::optional<double> reynolds) {
    const InertialFactor neglected = creeping_factor(velocity, found.lbm->permeability.m2, viscosity);
    if (!found.forchheimer) {
        if (neglected.half_width <= largest_neglected_inertia) return neglected;
        throw UserError(fmt::format("inertia may add {:.2g} % to this pressure drop, and the case has no flows with inertia",
                                    100.0 * neglected.half_width),
                        {.where = question.name,
                         .allowed = fmt::format("without them: up to a superficial velocity of {:.3g} m/s",
                                                velocity * largest_neglected_inertia / neglected.half_width),
                         .fix = reynolds ? command_for(question, *reynolds) : "porepack forchheimer computes them in packings"});
    }
    const auto& grids = found.forchheimer->lbm.grids;
    const InertialCurve fine = curve_with_wall_errors(grids.back());
    if (*reynolds > fine.flows.back().reynolds * (1.0 + 1e-6))
        throw UserError(fmt::format("the flows with inertia end at a Reynolds number of {:.4g}; this flow rate has {:.4g}",
                                    fine.flows.back().reynolds, *reynolds),
                        {.where = question.name,
                         .fix = found.forchheimer->lbm.stopped_by ? "a smaller flow rate: " + *found.forchheimer->lbm.stopped_by
                                                                  : command_for(question, *reynolds)});
    return inertial_factor(fine, grids.size() > 1 ? std::optional(curve_with_wall_errors(grids[grids.size() - 2])) : std::nullopt,
                           *reynolds);
}

std::string meaning_of(const results::CaseResults& found, const InertialFactor& factor, std::optional<double> reynolds) {
    std::string meaning = "k: " + found.lbm->interval_meaning + "; inertia: ";
    if (!found.forchheimer) return meaning + fmt::format("neglected, about {:.2g} %", 100.0 * factor.half_width);
    const auto& grids = found.forchheimer->lbm.grids;
    if (grids.size() < 2 || grids[grids.size() - 2].flows.empty())
        return meaning + "errors of the flows on one grid, without its error, and what is uncertain between them";
    const double last = grids[grids.size() - 2].flows.back().reynolds;
    return meaning + fmt::format("the change to the coarser grid{}, errors of the flows, and what is uncertain between them",
                                 *reynolds > last * 1.1 ? fmt::format(" (its last flow has Re {:.3g}; beyond, in proportion)", last) : "");
}

}  // namespace

results::PressureDrop pressure_drop(const results::CaseResults& found, const PressureDropQuestion& question) {
    if (!found.lbm) throw UserError("the case has no permeability yet", {.where = question.name, .fix = "porepack lbm " + question.name});
    const auto& k = found.lbm->permeability;
    if (found.lbm->direction != Axis::z)
        throw UserError("the case's permeability is not that along the bed's axis",
                        {.where = question.name, .fix = "direction = \"z\" in [lbm]"});
    if (!k.interval_m2)
        throw UserError("the case's permeability has no interval", {.where = question.name, .fix = "three grids: [lbm] grids = 3"});
    const auto& fluid = question.properties;
    const double nu = fluid.viscosity_Pa_s / fluid.density_kg_per_m3, porosity = found.lbm->porosity;
    const double velocity =
        question.superficial_velocity_m_per_s ? *question.superficial_velocity_m_per_s : *question.flow_rate_m3_per_s / question.area_m2;
    results::PressureDrop result{.fluid = question.fluid,
                                 .density_kg_per_m3 = fluid.density_kg_per_m3,
                                 .viscosity_Pa_s = fluid.viscosity_Pa_s,
                                 .flow_rate_m3_per_s = velocity * question.area_m2,
                                 .superficial_velocity_m_per_s = velocity,
                                 .porosity = porosity,
                                 .permeability_m2 = k.m2};
    const auto& section = found.lbm->section_m;
    const auto bed = results::bed_of(found);
    result.length_m = question.length_m ? *question.length_m : bed ? bed->bed_height_m : section.high - section.low;
    result.length_is = question.length_m ? "as given" : bed ? "height of the bed, with the section's k" : "of the section";
    if (found.forchheimer)
        result.reynolds = velocity * found.forchheimer->length_m / nu;
    else if (question.equivalent_diameter_m)
        result.reynolds = velocity * *question.equivalent_diameter_m / nu;
    const InertialFactor factor = factor_of(found, question, velocity, nu, result.reynolds);
    const PressureGradient gradient = pressure_gradient(velocity, fluid, k.m2, *k.interval_m2, factor);
    result.inertia_factor = factor.value;
    result.inertia_half_width = factor.half_width;
    result.pressure_gradient_Pa_per_m = gradient.value;
    result.pressure_drop_Pa = gradient.value * result.length_m;
    result.pressure_drop_interval_Pa = {gradient.interval.low * result.length_m, gradient.interval.high * result.length_m};
    result.interval_meaning = meaning_of(found, factor, result.reynolds);
    if (found.uncertainty) {
        const results::Statements* const statements = core::find(found.uncertainty->statements, "permeability_m2");
        const auto& next = statements != nullptr ? statements->next_such_packing.interval : std::nullopt;
        if (next && next->low > 0.0) {  // from few packings, k of the next one may be anything
            const PressureGradient other = pressure_gradient(velocity, fluid, k.m2, *next, factor);
            result.next_such_packing_Pa = Interval{other.interval.low * result.length_m, other.interval.high * result.length_m};
        }
    }
    if (const auto& sauter = question.sauter_diameter_m) {
        result.reynolds_modified = velocity * *sauter / (nu * (1.0 - porosity));
        result.ergun_Pa = ergun_gradient(velocity, fluid, *sauter, porosity) * result.length_m;
        result.erdim_Pa = erdim_gradient(velocity, fluid, *sauter, porosity) * result.length_m;
    }
    if (constexpr double atmosphere = 101325.0; fluid.density_kg_per_m3 < 10.0 && result.pressure_drop_Pa > 0.05 * atmosphere)
        log_warning(
            fmt::format("a gas that loses {:.3g} Pa expands on its way: this is computed with one density", result.pressure_drop_Pa));
    return result;
}

}  // namespace porepack::analysis
