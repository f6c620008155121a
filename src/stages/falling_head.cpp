// The falling-head test of the case's packing, simulated.
#include "stages/falling_head.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "analysis/falling_head/simulation.hpp"
#include "permeability/permeability.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;
namespace {

// Not of an image.
std::optional<GrainForm> grain_of(const Case& c) {
    return c.from_image() ? std::nullopt : grain_form(c.result<results::Shape>());
}

results::FallingHead run_case_falling_head(const Case& c, const Path& folder) {
    const auto lbm = c.result<results::Lbm>();
    const double pores = c.result<results::Voxelise>().porosity;
    const InertialPermeability inertial = inertial_permeability(c, pores);
    const bool whole_bed = lbm.permeability_bed_m2.has_value();
    const double k = lbm.permeability_bed_m2.value_or(lbm.permeability.m2);
    results::FallingHead result = written(simulate_falling_head(k, inertial.value_m, case_apparatus(c), true), folder);
    result.permeability_from = whole_bed ? "lbm, the whole bed with its free ends" : "lbm, the section";
    result.inertial_permeability_from = inertial.from;
    result.correlations = correlations_of(grain_of(c), pores);
    return result;
}

}  // namespace

// From the stage with the most reliable value.
InertialPermeability inertial_permeability(const Case& c, double pores) {
    if (c.settings.forchheimer.enabled)
        return {c.result<results::Forchheimer>().inertial_permeability_m,
                "the flows with inertia (lattice Boltzmann), extrapolated to the test's Reynolds numbers"};
    const auto grain = grain_of(c);
    if (!grain) return {std::numeric_limits<double>::infinity(), "none: Darcy's law alone"};
    return {ergun_inertial_m(grain->sphericity, grain->equal_volume_diameter_m, pores), "Ergun"};
}

FallingHeadConfig case_apparatus(const Case& c) {
    FallingHeadConfig config = c.settings.falling_head;
    if (config.inertia_coefficient > 0.0 || !fs::exists(c.stage_folder("voxelise") / "result.json")) return config;
    const double pores = c.result<results::Voxelise>().porosity;
    std::optional<double> factor;
    if (c.settings.tortuosity.diffusive && fs::exists(c.stage_folder("tortuosity") / "result.json"))
        if (const auto kinds = c.result<results::Tortuosity>(); kinds.diffusive) factor = kinds.diffusive->tortuosity_factor;
    config.inertia_coefficient = estimated_inertia_coefficient(pores, factor);
    return config;
}

std::vector<std::string> falling_head_needs(const Case& c) {
    std::vector<std::string> needs = {"voxelise", "lbm"};
    if (!c.from_image()) needs.insert(needs.begin(), "shape");
    if (c.settings.forchheimer.enabled) needs.emplace_back("forchheimer");
    if (c.settings.tortuosity.diffusive) needs.emplace_back("tortuosity");  // for the inertia coefficient
    return needs;
}

Stage make_falling_head_stage(const Case& c) {
    return {.name = "falling-head",
            .needs = falling_head_needs(c),
            .configuration = c.settings.resolved_tables({"falling_head"}),
            .outputs = {"falling_head.csv"},
            .run = [c](const Path& folder) { return run_case_falling_head(c, folder); },
            .result_version = results::FallingHead::version};
}

}  // namespace porepack::stages
