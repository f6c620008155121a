#include "analysis/falling_head/cause_analysis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "analysis/falling_head/cause_figures.hpp"
#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "falling_head/column.hpp"
#include "lbm/paper_scheme.hpp"
#include "lbm/wall_effect.hpp"
#include "record/resolved_config.hpp"

namespace porepack::analysis {
namespace {

results::Cause result_of(const CauseFactors& found) {
    return {.cause = found.cause.name,
            .what = found.cause.what,
            .range = {found.cause.low, found.cause.high},
            .unit = found.cause.unit,
            .factors = {found.at_low, found.at_high},
            .source = found.cause.source,
            .evidence = evidence_of(found.cause)};
}

results::JointCauses result_of(const JointFactors& joint) {
    return {.what = joint.what,
            .range_factor = joint.range_factor,
            .draws = joint.draws,
            .without_k = joint.without_k,
            .median = joint.median,
            .interval = {joint.low, joint.high},
            .reaches = joint.reaches};
}

// Porosities of layers of `height` metres from the floor up.
std::vector<double> porosity_layers(const PoreSpace& space, double sample_length_m, double height) {
    const auto count = static_cast<std::size_t>(std::max(2L, std::lround(sample_length_m / height)));
    const double layer = sample_length_m / static_cast<double>(count);
    std::vector<double> layers;
    for (std::size_t i = 0; i < count; ++i)
        layers.push_back(space.with_section({layer * static_cast<double>(i), layer * static_cast<double>(i + 1)}).porosity(4000).value);
    return layers;
}

// What would change the computed k, not the measured one: the paper's scheme, and a computation without the wall.
results::ComputationEffects effects_on_the_computation(const PoreSpace& space, double porosity, double grain_m) {
    log_info("causes: the paper's lattice Boltzmann scheme, and the wall");
    const double middle = 0.5 * (space.section.z0_m + space.section.z1_m), half = std::min(1.5 * grain_m, 0.5 * space.section.length());
    return {.paper_scheme_over_porepack = paper_scheme_ratio(space.grain_size_m, 1.0 - porosity),
            .core_over_tube = core_over_tube_permeability(space.with_section({middle - half, middle + half}), grain_m)};
}

}  // namespace

Outcome<results::Causes> find_causes(const PoreSpace& space, const FlowsOfSample& flows, const FallingHeadConfig& config) {
    const std::optional<double> tube = space.container.tube_diameter();
    if (!tube || !space.packing())
        throw UserError("the causes are those of a packing in a tube", {.where = "[falling_head] causes", .fix = "causes = false"});
    if (space.bed_top_m < config.sample_length_m)
        throw UserError(fmt::format("the bed is {:g} m high, the sample {:g} m", space.bed_top_m, config.sample_length_m),
                        {.where = "sample_length_m", .fix = "pour more grains, or shorten the sample"});
    const double grain = grain_means(*space.packing()).equivalent_diameter_m, central = space.porosity().value;
    const std::vector<double> layers = porosity_layers(space, config.sample_length_m, 0.5 * grain);
    const ProfileFactors ends = profile_factors(layers, central);
    const ProfileFactors dense = profile_factors({std::max(0.1, central - 0.1)}, central);
    const double share = std::min(1.0, grain / config.sample_length_m);
    log_info("causes: simulated tests, evaluated as in the paper");
    const SampleTruth sample{.permeability_m2 = flows.permeability_m2,
                             .inertial_permeability_m = flows.inertial_permeability_m,
                             .porosity = central,
                             .ends_viscous = ends.viscous,
                             .ends_inertial = ends.inertial,
                             .aligned_viscous = 1.0 + share * (dense.viscous - 1.0),
                             .aligned_inertial = 1.0 + share * (dense.inertial - 1.0),
                             .tube_diameter_m = *tube,
                             .grain_diameter_m = grain,
                             .largest_reynolds = flows.largest_reynolds,
                             .quasi_steady_inertia = flows.quasi_steady_inertia};
    const CauseStudy study = study_causes(sample, config, config.computed_over_measured);
    const double nu = config.kinematic_viscosity_m2_per_s;
    const auto reynolds = [&](double length) {
        return std::array{study.speed_top_m_per_s * length / nu, study.speed_bottom_m_per_s * length / nu};
    };
    const double wanted = config.computed_over_measured;
    results::Causes result{.permeability_m2 = flows.permeability_m2,
                           .inertial_permeability_m = flows.inertial_permeability_m,
                           .porosity_central = central,
                           .inertia_coefficient = inertia_coefficient(config),
                           .porosity_layers = layers,
                           .viscous_share_of_head = study.viscous_share,
                           .reynolds = {reynolds(grain), reynolds(*tube)},
                           .evaluation_alone = study.evaluation_alone,
                           .darcy_alone = study.darcy_alone,
                           .to_explain = wanted > 0.0 ? std::optional(wanted) : std::nullopt,
                           .sample = sample,
                           .apparatus = resolved_config(config),
                           .computation = effects_on_the_computation(space, central, grain)};
    for (const CauseFactors& found : study.causes) result.causes.push_back(result_of(found));
    for (const JointFactors& joint : study.joint) result.joint.push_back(result_of(joint));
    return {result, files_of_causes(study, sample, config)};
}

}  // namespace porepack::analysis
