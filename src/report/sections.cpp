// The tables of the report: permeability, packing, tortuosity, convergence, cost.
#include "report/section.hpp"

#include <fmt/format.h>

#include <cmath>
#include <regex>

#include "core/log.hpp"
#include "uncertainty/sample.hpp"

namespace porepack::report {
using namespace core;
namespace {

// Numbers of the paper (section 8 of its results) for this grain, if there are any.
struct PaperNumber {
    const char *kind, *quantity, *text;
    double sphericity;
};
constexpr PaperNumber paper_numbers[] = {
    {"tetrapod", "porosity", "0.70 (DEM), 0.685 (CT)", 0.53},
    {"tetrapod", "porosity", "0.78 (DEM)", 0.47},
    {"tetrapod", "tortuosity", "1.58 (DEM), 1.61 (CT)", 0.53},
    {"tetrahedron", "tortuosity", "2.4 (DEM)", 0.74},
};

std::string paper_number(const ReportInput& input, const std::string& quantity) {
    const Json& kind = result_at(input, "shape/kind");
    const Json& sphericity = result_at(input, "shape/sphericity");
    if (!kind.is_string() || !sphericity.is_number()) return "";
    for (const auto& entry : paper_numbers)
        if (kind == entry.kind && quantity == entry.quantity && std::abs(sphericity.get<double>() - entry.sphericity) < 0.006)
            return entry.text;
    return "";
}

}  // namespace

std::string with_powers_of_ten(const std::string& text) {
    static const std::regex power("([0-9])e([+-])0*([0-9]+)");  // of a number
    constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string result;
    auto rest = text.cbegin();
    for (std::sregex_iterator match(text.begin(), text.end(), power), end; match != end; ++match) {
        result.append(rest, (*match)[1].second).append("\u00a0×\u00a010").append((*match)[2] == "-" ? "⁻" : "");
        for (const char digit : (*match)[3].str()) result += digits[digit - '0'];
        rest = (*match)[0].second;
    }
    result.append(rest, text.cend());
    // The unit stays with its number.
    if (const std::size_t unit = result.find(" m"); unit != std::string::npos && unit + 2 < result.size() && rest != text.cbegin())
        result.replace(unit, 1, "\u00a0");
    return result;
}

std::string interval_text(const Json& interval) {
    if (!interval.is_array()) return "none";
    return fmt::format("{} to {}", number_text(interval[0]), number_text(interval[1]));
}

std::string percent_text(double value, const Interval& interval) {
    const Sides percent = 100.0 / std::abs(value) * half_widths(value, interval);
    // A porosity from exact grains has only the error of the quadrature: its digits would say nothing.
    if (percent.wider() < smallest_percent_shown) return "(exact to these digits)";
    constexpr double rounding = 1e-6;  // of a symmetric interval, far below the digits shown
    if (std::abs(percent.below - percent.above) <= rounding * percent.wider())
        return fmt::format("± {:.2g} %", 0.5 * (percent.below + percent.above));
    const std::string below = fmt::format("{:.2g}", percent.below), above = fmt::format("{:.2g}", percent.above);
    return below == above ? fmt::format("± {} %", below) : fmt::format("(− {} %, + {} %)", below, above);
}

std::string difference(const Json& value, const Json& reference) {
    if (!value.is_number() || !reference.is_number()) return "–";
    const double percent = 100.0 * (value.get<double>() / reference.get<double>() - 1.0);
    constexpr double half_a_digit = 0.05;
    return std::abs(percent) < half_a_digit ? "0.0 %" : fmt::format("{:+.1f} %", percent);
}

namespace {

std::string percent(const Json& value) {
    return value.is_number() ? fmt::format("{:.2g} %", 100.0 * value.get<double>()) : "–";
}

}  // namespace

const Json& interval_of_mean_permeability(const ReportInput& input) {
    const Json& stated = result_at(input, "uncertainty/statements/permeability_m2/mean_of_such_packings/interval");
    return stated.is_array() ? stated : result_at(input, "seeds/quantities/permeability_m2/interval_of_mean");
}

std::optional<Interval> two_standard_uncertainties(const Json& value, const Json& standard_uncertainty) {
    if (!value.is_number() || !standard_uncertainty.is_number()) return std::nullopt;
    const double half = 2.0 * standard_uncertainty.get<double>();
    return about(value.get<double>(), {half, half});
}

std::optional<Interval> interval_of_path_mean(const ReportInput& input, const std::string& kind) {
    const Json &error = result_at(input, "tortuosity/" + kind + "/standard_error"),
               &paths = result_at(input, "tortuosity/" + kind + "/paths"), &starts = result_at(input, "tortuosity/" + kind + "/starts");
    const Json &value = result_at(input, "tortuosity/" + kind + "/tortuosity_" + (kind == "shortest_path" ? kind : "geometric_paper")),
               &number = paths.is_number() ? paths : starts;
    if (!value.is_number() || !error.is_number() || !number.is_number() || number.get<double>() < 2.0) return std::nullopt;
    const double half = uncertainty::students_t(number.get<double>() - 1.0) * error.get<double>();
    return about(value.get<double>(), {half, half});
}

ReportSection permeability_section(const ReportInput& input) {
    const Json& lbm = result_at(input, "lbm/permeability_m2");
    ReportSection section{
        .title = "Permeability",
        .intro =
            "k = mu U L / dP, with U the flow rate over the inner area of the container and dP between the planes of the section. "
            "K = k rho g / mu is the hydraulic conductivity."};
    section.intro +=
        " The intervals are numerical: they hold the errors of grids and iteration in this one packing. That of a mean of packings (95 %) "
        "holds their scatter, too.";
    if (const auto limit = gradient_limit(input))
        section.intro += with_powers_of_ten(fmt::format(
            " K holds up to a hydraulic gradient of about {:.1g}: there, inertia makes it 5 % smaller, {}.", limit->gradient, limit->from));
    const Json &planes = result_at(input, "lbm/section_m"), &feret = result_at(input, "shape/maximum_feret_diameter_m");
    if (planes.is_array() && feret.is_number() && planes[1].get<double>() - planes[0].get<double>() < feret.get<double>())
        section.intro =
            "Note: the section is shorter than one maximum Feret diameter of a grain: it hardly represents the packing. " + section.intro;
    if (result_at(input, "pack/overlap_allowed").is_boolean())
        section.intro =
            fmt::format("Note: grains overlap each other by up to {} diameters and walls by up to {} (overlap_allowed in packing.json). {}",
                        number_text(result_at(input, "pack/largest_overlap_relative_to_diameter"), "{:.2g}"),
                        number_text(result_at(input, "pack/largest_wall_overlap_relative_to_diameter"), "{:.2g}"), section.intro);
    section.header = {"method", "k (m²)", "interval (m²)", "k (darcy)", "K, " + input.fluid_text + " (m/s)", "against LBM"};
    const auto add = [&](const std::string& method, const Json& k, const std::string& interval) {
        if (!k.is_number()) return;
        const double value = k.get<double>();
        section.rows.push_back({method, number_text(k), interval, fmt::format("{:.4g}", value / 9.869233e-13),
                                with_powers_of_ten(fmt::format("{:.3g}", permeability::hydraulic_conductivity_m_per_s(value, input.fluid))),
                                difference(k, lbm)});
    };
    add("lattice Boltzmann", lbm, interval_text(result_at(input, "lbm/permeability_interval_m2")));
    if (const Json& grids = result_at(input, "lbm/grids"); grids.size() > 1)
        for (auto grid = grids.rbegin(); grid != grids.rend(); ++grid)
            add(fmt::format("lattice Boltzmann, voxels of {:.3g} m alone", grid->at("voxel_size_m").get<double>()),
                grid->at("permeability_m2"), "none");
    if (const Json& mean = result_at(input, "seeds/permeability_mean_m2"); mean.is_number())
        add(fmt::format("lattice Boltzmann, mean of {} packings", result_at(input, "seeds/packings").get<long>()), mean,
            fmt::format("{}, of the mean (standard deviation between packings {})", interval_text(interval_of_mean_permeability(input)),
                        number_text(result_at(input, "seeds/standard_deviation_between_packings_m2"), "{:.3g}")));
    add("OpenFOAM", result_at(input, "foam/permeability_m2"), interval_text(result_at(input, "foam/permeability_interval_m2")));
    if (const Json& meshes = result_at(input, "foam/meshes"); meshes.size() > 1)
        for (auto mesh = meshes.rbegin(); mesh != meshes.rend(); ++mesh)
            add(fmt::format("OpenFOAM, mesh of {} cells alone", mesh->at("cells").get<long>()), mesh->at("permeability_m2"), "none");
    add("Carman-Kozeny, constant 150 (Eq. 2)", result_at(input, "falling-head/correlations/carman_kozeny_150_m2"), "none");
    add("Carman-Kozeny, constant 180", result_at(input, "falling-head/correlations/carman_kozeny_180_m2"), "none");
    add("the paper's fit (Eq. 22, corrected)", result_at(input, "falling-head/correlations/paper_fit_m2"), "none");
    return section;
}

ReportSection packing_section(const ReportInput& input) {
    ReportSection section{.title = "Packing"};
    section.header = {"quantity", "value", "95 %", "the paper"};
    const auto add = [&](const char* name, const std::string& value, const std::string& uncertainty, const std::string& paper = "") {
        if (value != "–") section.rows.push_back({name, value, uncertainty, paper});
    };
    const auto two = [&](const std::string& path, const char* from) {
        const Json& u = result_at(input, path);
        if (!u.is_number()) return std::string("–");
        constexpr double half_a_digit = 5e-5;  // of the four that are shown
        return 2.0 * u.get<double>() < half_a_digit ? fmt::format("exact to these digits ({})", from)
                                                    : fmt::format("± {:.1e} ({})", 2.0 * u.get<double>(), from);
    };
    const std::string stage = input.results.contains("pack") ? "pack" : input.results.contains("image") ? "image" : "stl";
    add("grain", result_at(input, "shape/kind").is_string() ? result_at(input, "shape/kind").get<std::string>() : "–", "");
    add("sphericity", number_text(result_at(input, "shape/sphericity")),
        number_text(result_at(input, "shape/relative_error"), "{:.1e} (relative)"));
    add("capsule diameter d, length L",
        result_at(input, "shape/diameter_m").is_number()
            ? number_text(result_at(input, "shape/diameter_m")) + " m, " + number_text(result_at(input, "shape/length_m")) + " m"
            : "–",
        "");
    add("grains", number_text(result_at(input, stage + "/grains"), "{:.0f}"), "");
    add("bed height", number_text(result_at(input, stage + "/bed_height_m")) + " m", "");
    add("porosity of the section", number_text(result_at(input, "voxelise/porosity"), "{:.4f}"),
        two("voxelise/porosity_uncertainty", "of this packing; the scatter between packings is not in it"),
        paper_number(input, "porosity"));
    add("porosity of the whole bed", number_text(result_at(input, stage + "/porosity_bed"), "{:.4f}"),
        two(stage + "/porosity_bed_uncertainty", "of this packing"));
    add("maximum overlap of grains / d", number_text(result_at(input, stage + "/largest_overlap_relative_to_diameter")), "");
    add("contacts", number_text(result_at(input, stage + "/contacts"), "{:.0f}"), "");
    add("coordination number (contacts with other grains, per grain)",
        number_text(result_at(input, stage + "/coordination_number"), "{:.2f}"), "");
    add("net force on a grain / its weight, mean", number_text(result_at(input, stage + "/mean_force_over_weight"), "{:.1e}"), "");
    const Json& z = result_at(input, "voxelise/section_m");
    if (z.is_array()) add("section", fmt::format("z = {:.4g} to {:.4g} m", z[0].get<double>(), z[1].get<double>()), "");
    return section;
}

ReportSection tortuosity_section(const ReportInput& input) {
    ReportSection section{
        .title = "Tortuosity",
        .intro =
            "Four different numbers: the path of the paper through dots (exact, and on slice images, where it grows with the pixel size), "
            "the shortest path through the pores, the mean path of the flow, and the tortuosity factor eps D0/D_eff of diffusion."};
    if (const std::string paper = paper_number(input, "tortuosity"); !paper.empty())
        section.intro += fmt::format(
            " The paper states {} for this grain, by the same dots. It is not reached with exact sections: coarse pixels and thick slices "
            "explain a part of the difference (docs/tortuosity.md).",
            paper);
    section.header = {"kind", "value", "interval (95 %)", "the paper"};
    const auto add = [&](const std::string& name, const Json& value, const std::string& uncertainty, const std::string& paper) {
        if (value.is_number()) section.rows.push_back({name, number_text(value, "{:.4f}"), uncertainty, paper});
    };
    const auto path_mean = [&](const std::string& kind, const char* over) {
        const auto interval = interval_of_path_mean(input, kind);
        return interval ? fmt::format("{:.4f} to {:.4f} (mean over {})", interval->low, interval->high, over) : std::string("none");
    };
    add("the paper's dots, exact", result_at(input, "tortuosity/geometric_paper_exact/tortuosity_geometric_paper"),
        path_mean("geometric_paper_exact", "paths"), paper_number(input, "tortuosity"));
    add("the paper's dots, on slices with pixels of " + number_text(result_at(input, "tortuosity/geometric_paper_pixels/pixel_m")) + " m",
        result_at(input, "tortuosity/geometric_paper_pixels/tortuosity_geometric_paper"), path_mean("geometric_paper_pixels", "paths"),
        paper_number(input, "tortuosity"));
    add("shortest path, mean over starting points", result_at(input, "tortuosity/shortest_path/tortuosity_shortest_path"),
        path_mean("shortest_path", "starting points"), "");
    add("hydraulic", result_at(input, "tortuosity/hydraulic/tortuosity_hydraulic"), "none", "");
    const Json interval = result_at(input, "tortuosity/diffusive/interval");
    add("tortuosity factor (diffusive)", result_at(input, "tortuosity/diffusive/tortuosity_factor"),
        interval.is_array() ? fmt::format("{:.3f} to {:.3f} (three grids)", interval[0].get<double>(), interval[1].get<double>()) : "none",
        "");
    return section;
}

ReportSection convergence_section(const ReportInput& input) {
    ReportSection section{.title = "Did it converge?"};
    section.header = {"check", "value"};
    const auto add = [&](const char* name, const std::string& value) {
        if (value != "–") section.rows.push_back({name, value});
    };
    add("LBM: iteration error of k", percent(result_at(input, "lbm/iteration_error")));
    add("LBM: flow rate, maximum difference between layers", percent(result_at(input, "lbm/flow_imbalance")));
    add("LBM: time steps", number_text(result_at(input, "lbm/steps"), "{:.0f}"));
    add("LBM: fluid nodes", number_text(result_at(input, "lbm/fine/fluid_nodes"), "{:.0f}"));
    add("LBM: pore cells without flow", number_text(result_at(input, "lbm/fine/isolated_cells"), "{:.0f}"));
    add("LBM: node updates per second", number_text(result_at(input, "lbm/updates_per_second"), "{:.3g}"));
    add("OpenFOAM: iterations (finest mesh)", number_text(result_at(input, "foam/iterations"), "{:.0f}"));
    add("OpenFOAM: cells (finest mesh)", number_text(result_at(input, "foam/cells"), "{:.0f}"));
    add("OpenFOAM: flow in against flow out", percent(result_at(input, "foam/fine/flow_imbalance")));
    add("OpenFOAM: meshed / exact pore volume", number_text(result_at(input, "foam/fine/mesh_volume_ratio"), "{:.4f}"));
    return section;
}

ReportSection cost_section(const ReportInput& input) {
    ReportSection section{.title = "Cost"};
    section.header = {"stage", "wall time", "peak memory", "seed", "processes"};
    double sum = 0.0;
    for (const std::string& stage : input.stages) {
        const Json& m = input.manifests.at(stage);
        sum += m.value("wall_time_s", 0.0);
        section.rows.push_back({stage, human_time(m.value("wall_time_s", 0.0)), human_bytes(m.value("peak_memory_bytes", 0.0)),
                                std::to_string(m.value("seed", 0L)), std::to_string(m.value("processes", 1L))});
    }
    section.rows.push_back({"all", human_time(sum), "", "", ""});
    return section;
}

}  // namespace porepack::report
