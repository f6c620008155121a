// Causes of the difference between measured and computed permeabilities.
#include "analysis/falling_head/cause_analysis.hpp"
#include "stages/case_space.hpp"
#include "stages/falling_head.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace {

FlowsOfSample flows_of(const Case& c, double inertial_permeability_m) {
    const auto lbm = c.result<results::Lbm>();
    FlowsOfSample flows{.permeability_m2 = lbm.permeability.m2,
                        .inertial_permeability_m = inertial_permeability_m,
                        .largest_reynolds = 1.0,
                        .quasi_steady_inertia = lbm.inertia_coefficient_quasi_steady};
    if (c.settings.forchheimer.enabled) flows.largest_reynolds = c.result<results::Forchheimer>().lbm.grids.back().flows.back().reynolds;
    return flows;
}

}  // namespace

Stage make_causes_stage(const Case& c) {
    return {.name = "causes",
            .needs = falling_head_needs(c),
            .configuration = deciding_keys(c, {"container", "falling_head"}, {}, true),
            .outputs = {"causes.csv", "joint.csv"},
            .run =
                [c](const Path& folder) {
                    const InertialPermeability inertial = inertial_permeability(c, c.result<results::Voxelise>().porosity);
                    results::Causes result =
                        written(find_causes(case_pore_space(c).section_only(), flows_of(c, inertial.value_m), case_apparatus(c)), folder);
                    result.inertial_permeability_from = inertial.from;
                    return result;
                },
            .expect = [] { return Expectation{.text = "about 8500 simulated tests and three coarse flows", .wall_time_s = 60.0}; },
            .result_version = results::Causes::version};
}

}  // namespace porepack::stages
