#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>

#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace fs = std::filesystem;

std::optional<double> bed_porosity_of(const results::CaseResults& results) {
    if (const auto bed = bed_of(results)) return bed->porosity_bed;
    return results.image ? std::optional(results.image->porosity_bed) : std::nullopt;
}

ReportSection packing_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Packing"};
    section.header = {"quantity", "value", "95 %", "the paper"};
    const auto add = [&](const char* name, const std::string& value, const std::string& uncertainty = "", const std::string& paper = "") {
        if (value != dash) section.rows.push_back({name, value, uncertainty, paper});
    };
    const auto two = [&](double u, const char* from) {
        if (!std::isfinite(u)) return std::string(dash);
        constexpr double half_a_digit = 5e-5;  // of the four that are shown
        return 2.0 * u < half_a_digit ? fmt::format("exact to these digits ({})", from) : fmt::format("± {:.1e} ({})", 2.0 * u, from);
    };
    if (const auto& shape = input.results.shape) {
        add("grain", shape->kind);
        add("sphericity", number_text(shape->sphericity), number_text(shape->relative_error, "{:.1e} (relative)"));
        if (shape->diameter_m)
            add("capsule diameter d, length L", number_text(shape->diameter_m) + " m, " + number_text(shape->length_m) + " m");
    }
    const auto& pack = input.results.pack;
    const auto bed = bed_of(input.results);
    if (pack) add("grains", number_text(pack->grains, "{:.0f}"));
    if (bed) add("bed height", number_text(bed->bed_height_m) + " m");
    const auto& voxels = input.results.voxelise;
    if (voxels)
        add("porosity of the section", number_text(voxels->porosity, "{:.4f}"),
            two(voxels->porosity_uncertainty, "of this packing; the scatter between packings is not in it"),
            paper_number(input, "porosity"));
    add("porosity of the whole bed", number_text(bed_porosity_of(input.results), "{:.4f}"),
        bed ? two(bed->porosity_bed_uncertainty, "of this packing") : dash);
    if (pack) {
        add("maximum overlap of grains / d", number_text(pack->largest_overlap_relative_to_diameter));
        add("contacts", number_text(pack->contacts, "{:.0f}"));
        if (pack->pour) {
            add("coordination number (contacts with other grains, per grain)", number_text(pack->pour->coordination_number, "{:.2f}"));
            add("net force on a grain / its weight, mean", number_text(pack->pour->mean_force_over_weight, "{:.1e}"));
        }
    }
    if (pack && pack->protocol) {
        int number = 0;
        for (const results::ProtocolStep& step : pack->protocol->steps) {
            const std::string what = step.taps ? fmt::format("{} taps", *step.taps) : step.kind;
            const std::string name = step.kind == "pour" ? "bed as poured" : fmt::format("bed after step {}: {}", ++number, what);
            add(name.c_str(), fmt::format("porosity {:.4f}, {:.4g} m high{}", step.porosity, step.bed_height_m,
                                          step.reached ? "" : "; the aim of the step was not reached"));
        }
    }
    if (voxels) add("section", fmt::format("z = {:.4g} to {:.4g} m", voxels->section_m.low, voxels->section_m.high));
    if (fs::exists(folder / "packing.png")) section.pictures = {{"packing.png", "The packing: surface made by CGAL."}};
    const auto is_course = [](const results::ProtocolStep& step) { return step.taps.value_or(0) > 1 || step.kind == "vibrate"; };
    if (pack && pack->protocol && std::any_of(pack->protocol->steps.begin(), pack->protocol->steps.end(), is_course) &&
        take_file(input, "pack/protocol.csv", folder) && draw_plot(folder / "protocol.svg", "protocol"))
        section.pictures.emplace_back("protocol.svg",
                                      "The bed after the pour, each step and each tap. No contacts are given during "
                                      "vibration, when grains fly.");
    return section;
}

}  // namespace porepack::report
