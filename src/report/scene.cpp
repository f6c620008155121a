// What was poured into what, and up to which gradient K holds.
#include <cmath>
#include <optional>
#include <string>
#include <tuple>

#include "core/json.hpp"
#include "permeability/permeability.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"
#include "vessels/config.hpp"

namespace porepack::report {
namespace {

std::string length_text(double metres) {
    return fmt::format("{:.4g} mm", 1e3 * metres);
}

// "60 grains (tetrapod, sphericity 0.530, 733 mm³)"
std::string grains_text(const results::CaseResults& results) {
    std::string text = fmt::format("{} grains", results.pack->grains);
    const auto& shape = results.shape;
    if (!shape) return text;
    text += " (" + shape->kind;
    if (shape->sphericity) text += ", sphericity " + number_text(shape->sphericity, "{:.3f}");
    return text + fmt::format(", {:.3g} mm³ each)", 1e9 * shape->volume_m3);
}

// "Then: 10 taps, vibrate, lid."
std::string protocol_text(const results::CaseResults& results) {
    std::string steps;
    if (results.pack->protocol)
        for (const results::ProtocolStep& step : results.pack->protocol->steps)
            if (step.kind != "pour") steps += (steps.empty() ? "" : ", ") + (step.taps ? fmt::format("{} taps", *step.taps) : step.kind);
    return steps.empty() ? std::string() : fmt::format(" Then: {}.", steps);
}

std::string solid_text(const ReportInput& input) {
    const Json &all = input.configuration, packing = all.value("packing", Json::object()), image = all.value("image", Json::object());
    const std::string container = vessels::container_text(all.value("container", Json::object()), length_text);
    const std::string file = image.value("file", std::string());
    if (!input.results.pack) {
        const auto surface = all.value("/shape/file"_json_pointer, std::string());
        if (!file.empty()) return fmt::format("The solid is that of the image {}.", file);
        return surface.empty() ? std::string() : fmt::format("The solid is the surface {} in {}.", surface, container);
    }
    if (!file.empty()) return fmt::format("{} were found in the scan {}, in {}.", grains_text(input.results), file, container);
    const std::string engine = packing.value("engine", std::string());
    if (engine == "none")
        return fmt::format("{} lie in {} as {} says.", grains_text(input.results), container, packing.value("file", std::string()));
    const char* made = packing.value("fill", std::string()) == "scatter" ? "scattered in" : "poured into";
    return fmt::format("{} were {} {} by {} (friction {:g}, seed {}).", grains_text(input.results), made, container,
                       engine == "liggghts" ? "LIGGGHTS" : "the built-in discrete element method", packing.value("friction", 0.0),
                       packing.value("seed", 0L)) +
           protocol_text(input.results);
}

}  // namespace

std::string scene_text(const ReportInput& input) {
    std::string text = solid_text(input);
    const auto& voxels = input.results.voxelise;
    if (!voxels) return text;
    const auto& [bed, section] = std::tie(voxels->bed_m, voxels->section_m);
    return text + fmt::format(" The bed reaches from z = {} to {}; porosity and permeability are those of its section from {} to {}.",
                              length_text(bed.low), length_text(bed.high), length_text(section.low), length_text(section.high));
}

// At the onset of inertia, the apparent permeability is 5 % below k: i = U / (0.95 K).
std::optional<GradientLimit> gradient_limit(const ReportInput& input) {
    constexpr double part = 0.05;
    if (!input.results.lbm) return std::nullopt;
    const auto& [lbm, inertia, bed] = std::tie(*input.results.lbm, input.results.forchheimer, input.results.descriptors);
    const double k = lbm.permeability.m2, nu = input.fluid.viscosity_Pa_s / input.fluid.density_kg_per_m3,
                 conductivity = permeability::hydraulic_conductivity_m_per_s(k, input.fluid);
    double velocity = 0.0;
    std::string from;
    if (inertia && inertia->lbm.fit.onset_reynolds) {
        velocity = *inertia->lbm.fit.onset_reynolds * nu / inertia->length_m;
        from = "as computed";
    } else if (bed && std::isfinite(bed->numbers.sauter_diameter_m)) {
        const double k_in = permeability::ergun_inertial_m(1.0, bed->numbers.sauter_diameter_m, lbm.porosity);
        velocity = permeability::velocity_at_onset_m_per_s(part, k, k_in, nu);
        from = "by Ergun's correlation";
    } else {
        return std::nullopt;
    }
    return GradientLimit{.gradient = velocity / ((1.0 - part) * conductivity), .from = from};
}

}  // namespace porepack::report
