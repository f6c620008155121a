// The causes, one row each: differences from the ideal test, in the order of the report.
#include "falling_head/causes.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "falling_head/falling_head.hpp"
#include "falling_head/scenario.hpp"

namespace porepack::falling_head {
namespace {

using Rows = std::vector<ScenarioRow>;

// The water in the sample has the inertia of a column of m sample lengths; m is at least 1/porosity (straight pores).
void add_inertia(Rows& rows, const SampleTruth& truth, const FallingHeadConfig& full) {
    const double smallest_m = 1.0 / truth.porosity;
    for (const double m : {std::max(smallest_m, inertia_coefficient(full)), smallest_m})
        rows.push_back({"inertia of the water",
                        fmt::format("it starts at rest and has to be slowed down; m = {:.2f}{}", m,
                                    m == smallest_m ? ", 1/porosity: the minimum" : ""),
                        [m](Scenario& s) {
                            s.apparatus.column_inertia = true;
                            s.apparatus.inertia_coefficient = m;
                        }});
}

void add_meshes(Rows& rows, const FallingHeadConfig& full) {
    if (!(full.screen_opening_m > 0.0)) return;
    const auto screens = [&full](long below, long above, double wire_m, double free_share) {
        return [=, opening_m = full.screen_opening_m](Scenario& s) {
            s.apparatus.screen_opening_m = opening_m;
            s.apparatus.screen_wire_m = wire_m;
            s.apparatus.screens_below = below;
            s.apparatus.screens_above = above;
            s.apparatus.screen_free_fraction = free_share;
        };
    };
    for (const double wire_m : {0.5 * full.screen_wire_m, full.screen_wire_m}) {
        const std::string size = fmt::format("wires of {:g} mm", 1e3 * wire_m);
        rows.push_back({"wire screen below", size, screens(1, 0, wire_m, 1.0)});
        if (full.screens_below > 1)
            rows.push_back({"second wire screen below", size + ", both together", screens(full.screens_below, 0, wire_m, 1.0)});
        if (full.screens_above > 0) rows.push_back({"wire screen on top", size, screens(0, full.screens_above, wire_m, 1.0)});
    }
    rows.push_back(
        {"wire screen below, half covered", "grains cover half of the openings", screens(full.screens_below, 0, full.screen_wire_m, 0.5)});
}

// The reference of the levels matters: if they are read from the sample's top, the head is wrong as well; on the tube only the length.
void add_heights(Rows& rows) {
    for (const bool from_top : {true, false})
        for (const double longer_m : {-5e-3, 5e-3})
            rows.push_back(
                {"sample height",
                 fmt::format("true height {:+g} mm, level read {}", 1e3 * longer_m, from_top ? "from its top" : "on a fixed scale"),
                 [=](Scenario& s) {
                     s.apparatus.sample_length_m += longer_m;
                     if (!from_top) s.apparatus.level_offset_m -= longer_m;
                 }});
}

// Each cause separately, as a change of the bare apparatus.
Rows single_causes(const ScenarioStudy& study, const SampleTruth& truth, const FallingHeadConfig& config) {
    const FallingHeadConfig& full = study.full();
    const auto sample = [&](double viscous, double inertial) {
        return [resistance = study.sample(viscous, inertial)](Scenario& s) { s.resistance = resistance; };
    };
    Rows rows = {{"evaluation itself", "Eq. 18 obeyed exactly: what the quadratic does"}};
    add_inertia(rows, truth, full);
    add_meshes(rows, full);
    if (full.loss_coefficient > 0.0)
        rows.push_back({"inlet and outlet", fmt::format("they take {:g} v^2/2", full.loss_coefficient),
                        [loss = full.loss_coefficient](Scenario& s) { s.apparatus.loss_coefficient = loss; }});
    rows.push_back({"structure at the ends", "by the packing's porosity profile", sample(truth.ends_viscous, truth.ends_inertial)});
    rows.push_back({"grains aligned at the wire screen", "lowest layer, one grain high, 0.1 less porous",
                    sample(truth.aligned_viscous, truth.aligned_inertial)});
    for (const double offset_m : {-2e-3, 2e-3})
        rows.push_back({"level offset", fmt::format("true water level {:+g} mm", 1e3 * offset_m),
                        [=](Scenario& s) { s.apparatus.level_offset_m = offset_m; }});
    add_heights(rows);
    rows.push_back({.name = "noise of the frames", .what = "1 mm, one standard deviation, each frame", .noise_m = 1e-3});
    for (const auto& window_m : {std::vector<double>{0.1, 0.7}, std::vector<double>{0.7, 1.3}})
        rows.push_back({.name = "window",
                        .what = fmt::format("{:g} to {:g} m instead of {:g} to {:g} m", window_m[0], window_m[1], config.window_m[0],
                                            config.window_m[1]),
                        .window_m = window_m});
    rows.push_back({"turbulent coefficients", "1/k x 1.24, 1/k_in x 0.84 (Fand et al. 1987)", sample(1.24, 0.84)});
    return rows;
}

// Several causes at once, as changes of the test with all effects of the apparatus.
Rows joint_causes(const ScenarioStudy& study, const SampleTruth& truth) {
    // The aligned layer is one of the end effects: both are added.
    const Resistance worst = study.sample(1.24 * (truth.ends_viscous + truth.aligned_viscous - 1.0),
                                          0.84 * (truth.ends_inertial + truth.aligned_inertial - 1.0));
    const auto maximum = [worst](Scenario& s) {
        s.apparatus.level_offset_m = -2e-3;
        s.apparatus.screen_free_fraction = 0.5;
        s.resistance = worst;
    };
    Rows rows = {{"together", "inertia of the water, all wire screens, structure at the ends"}};
    for (const double offset_m : {-2e-3, 2e-3})
        rows.push_back({"together, with an offset", fmt::format("the same, true water level {:+g} mm", 1e3 * offset_m),
                        [=](Scenario& s) { s.apparatus.level_offset_m = offset_m; }});
    rows.push_back({"together, maximum", "the same, level -2 mm, screens half covered, aligned, turbulent", maximum});
    rows.push_back({"together, maximum, height too", "and sample -5 mm, level read from its top", [maximum](Scenario& s) {
                        maximum(s);
                        s.apparatus.sample_length_m -= 5e-3;
                    }});
    rows.push_back({.name = "together, with noise", .what = "1 mm, one standard deviation, each frame", .noise_m = 1e-3});
    return rows;
}

// The test with the water's inertia, all screens and losses, and the structure at the sample's ends.
Scenario with_all(const ScenarioStudy& study, const SampleTruth& truth) {
    const FallingHeadConfig& full = study.full();
    Scenario all = study.base();
    all.apparatus.column_inertia = true;
    all.apparatus.screen_opening_m = full.screen_opening_m;
    all.apparatus.screen_wire_m = full.screen_wire_m;
    all.apparatus.screen_free_fraction = full.screen_free_fraction;
    all.apparatus.loss_coefficient = full.loss_coefficient;
    all.resistance = study.sample(truth.ends_viscous, truth.ends_inertial);
    return all;
}

// Darcy's law alone at the middle of the window: the viscous fraction of the head.
double viscous_share_of_head(const SampleTruth& truth, const FallingHeadConfig& config, const FallingHeadConfig& apparatus) {
    const FallingHead darcy_free(truth.permeability_m2, truth.inertial_permeability_m, apparatus);
    const double middle = 0.5 * (config.window_m[0] + config.window_m[1]), L = config.sample_length_m;
    const double v = darcy_free.speed_at(middle), head = config.gravity_m_per_s2 * (middle + L) / L;
    return config.kinematic_viscosity_m2_per_s * v / truth.permeability_m2 / head;
}

}  // namespace

ProfileFactors profile_factors(const std::vector<double>& layers, double central) {
    ProfileFactors factors{0.0, 0.0};
    const auto cube = [](double e) { return e * e * e; };
    for (const double e : layers) {
        factors.viscous += (1.0 - e) * (1.0 - e) / cube(e);
        factors.inertial += (1.0 - e) / cube(e);
    }
    const auto count = static_cast<double>(layers.size());
    factors.viscous *= cube(central) / ((1.0 - central) * (1.0 - central)) / count;
    factors.inertial *= cube(central) / (1.0 - central) / count;
    return factors;
}

CauseStudy study_causes(const SampleTruth& truth, const FallingHeadConfig& config, double factor) {
    const ScenarioStudy study(truth, config);
    const Scenario base = study.base(), all = with_all(study, truth);
    CauseStudy result;
    for (const ScenarioRow& row : single_causes(study, truth, config)) result.causes.push_back(study.evaluate(row, base));
    result.viscous_share = viscous_share_of_head(truth, config, base.apparatus);
    const double found = 1.0 / result.viscous_share;
    result.causes.push_back(
        {.name = "Darcy's law alone", .what = "no inertial term in the evaluation", .factor = found, .low = found, .high = found});
    for (const ScenarioRow& row : joint_causes(study, truth)) result.together.push_back(study.evaluate(row, all));
    if (factor > 0.0) {
        result.explaining_offset_m = study.explaining_offset(base, factor);
        result.explaining_offset_with_all_m = study.explaining_offset(all, factor);
    }
    return result;
}

}  // namespace porepack::falling_head
