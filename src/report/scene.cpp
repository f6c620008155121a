// What was poured into what, and up to which gradient K holds.
#include <cmath>

#include "permeability/permeability.hpp"
#include "report/section.hpp"

namespace porepack::report {
using namespace core;
namespace {

std::string length_text(double metres) {
    return fmt::format("{:.4g} mm", 1e3 * metres);
}

// "60 grains (tetrapod, sphericity 0.530, 733 mm³)"
std::string grains_text(const ReportInput& input) {
    const Json &kind = result_at(input, "shape/kind"), &sphericity = result_at(input, "shape/sphericity"),
               &volume = result_at(input, "shape/volume_m3");
    std::string text = number_text(result_at(input, "pack/grains"), "{:.0f}") + " grains";
    if (!kind.is_string()) return text;
    text += " (" + kind.get<std::string>();
    if (sphericity.is_number()) text += ", sphericity " + number_text(sphericity, "{:.3f}");
    if (volume.is_number()) text += fmt::format(", {:.3g} mm³ each", 1e9 * volume.get<double>());
    return text + ")";
}

std::string container_text(const Json& container) {
    if (container.value("kind", "") == "cylinder" && container.value("diameter_m", 0.0) > 0.0)
        return fmt::format("a cylinder {} wide and {} high", length_text(container["diameter_m"].get<double>()),
                           length_text(container.value("height_m", 0.0)));
    if (const Json& size = container.value("size_m", Json()); size.is_array() && size.size() == 3)
        return fmt::format("a box of {} x {} x {}", length_text(size[0].get<double>()), length_text(size[1].get<double>()),
                           length_text(size[2].get<double>()));
    return "its container";
}

std::string solid_text(const ReportInput& input) {
    const Json &all = input.configuration, packing = all.value("packing", Json::object()), image = all.value("image", Json::object());
    const std::string container = container_text(all.value("container", Json::object())), file = image.value("file", std::string());
    if (!result_at(input, "pack/grains").is_number()) {
        const auto surface = all.value("/shape/file"_json_pointer, std::string());
        if (!file.empty()) return fmt::format("The solid is that of the image {}.", file);
        return surface.empty() ? std::string() : fmt::format("The solid is the surface {} in {}.", surface, container);
    }
    if (!file.empty()) return fmt::format("{} were found in the scan {}, in {}.", grains_text(input), file, container);
    const std::string engine = packing.value("engine", std::string());
    if (engine == "none")
        return fmt::format("{} lie in {} as {} says.", grains_text(input), container, packing.value("file", std::string()));
    return fmt::format("{} were poured into {} by {} (friction {:g}, seed {}).", grains_text(input), container,
                       engine == "liggghts" ? "LIGGGHTS" : "the built-in discrete element method", packing.value("friction", 0.0),
                       packing.value("seed", 0L));
}

}  // namespace

std::string scene_text(const ReportInput& input) {
    std::string text = solid_text(input);
    const Json &bed = result_at(input, "voxelise/bed_m"), &section = result_at(input, "voxelise/section_m");
    if (bed.is_array())
        text += fmt::format(" The bed reaches from z = {} to {}", length_text(bed[0].get<double>()), length_text(bed[1].get<double>()));
    if (bed.is_array() && section.is_array())
        text += fmt::format("; porosity and permeability are those of its section from {} to {}", length_text(section[0].get<double>()),
                            length_text(section[1].get<double>()));
    return text + (bed.is_array() ? "." : "");
}

// At the onset of inertia, the apparent permeability is 5 % below k: i = U / (0.95 K).
std::optional<GradientLimit> gradient_limit(const ReportInput& input) {
    constexpr double part = 0.05;
    const Json &k = result_at(input, "lbm/permeability_m2"), &porosity = result_at(input, "lbm/porosity");
    if (!k.is_number()) return std::nullopt;
    const double nu = input.fluid.viscosity_Pa_s / input.fluid.density_kg_per_m3,
                 conductivity = permeability::hydraulic_conductivity_m_per_s(k.get<double>(), input.fluid);
    const Json &onset = result_at(input, "forchheimer/lbm/onset_reynolds"), &length = result_at(input, "forchheimer/length_m"),
               &sauter = result_at(input, "descriptors/numbers/sauter_diameter_m");
    double velocity = 0.0;
    std::string from;
    if (onset.is_number() && length.is_number()) {
        velocity = onset.get<double>() * nu / length.get<double>();
        from = "as computed";
    } else if (sauter.is_number() && porosity.is_number()) {
        // k_apparent / k = 1 / (1 + (U/nu) k / k_in)
        const double k_in = permeability::ergun_inertial_m(1.0, sauter.get<double>(), porosity.get<double>());
        velocity = part / (1.0 - part) * nu * k_in / k.get<double>();
        from = "by Ergun's correlation";
    } else {
        return std::nullopt;
    }
    return GradientLimit{.gradient = velocity / ((1.0 - part) * conductivity), .from = from};
}

}  // namespace porepack::report
