// k by all methods, and along z.
#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>
#include <tuple>

#include "core/table.hpp"
#include "permeability/permeability.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace fs = std::filesystem;
namespace {

// Porosity and k along z, if both are known.
void add_profile_plot(const ReportInput& input, const Path& folder, ReportSection& section) {
    const auto& [lbm, voxels] = std::tie(input.results.lbm, input.results.voxelise);
    if (!lbm || lbm->subsections.empty() || !voxels || !take_file(input, "voxelise/porosity.csv", folder)) return;
    Table table({"z0_m", "z1_m", "permeability_m2"});
    for (const auto& part : lbm->subsections) table.add(part.z0_m, part.z1_m, part.permeability_m2);
    table.write(folder / "subsections.csv");
    if (draw_plot(folder / "along_z.svg", "along_z",
                  {{"z_low", voxels->bed_m.low},
                   {"z_high", voxels->bed_m.high},
                   {"section_low", lbm->section_m.low},
                   {"section_high", lbm->section_m.high},
                   {"permeability", lbm->permeability.m2}}))
        section.pictures.emplace_back(
            "along_z.svg",
            "Along z: porosity of thin layers of the bed (the section is shaded), and k of parts of the section in "
            "the same flow (dashed: the whole section).");
}

// What a reader must know before the numbers.
std::string notes_of(const ReportInput& input) {
    std::string notes;
    const auto& lbm = input.results.lbm;
    const auto& pack = input.results.pack;
    if (pack && pack->overlap_allowed)
        notes +=
            fmt::format("Note: grains overlap each other by up to {} diameters and walls by up to {} (overlap_allowed in packing.json). ",
                        number_text(pack->largest_overlap_relative_to_diameter, "{:.2g}"),
                        number_text(pack->largest_wall_overlap_relative_to_diameter, "{:.2g}"));
    if (const auto& voxels = input.results.voxelise; voxels && voxels->film_thickness_m)
        notes += fmt::format("Note: a film of {} m lies on all grains and counts as solid; the films overlap where grains touch. ",
                             number_text(*voxels->film_thickness_m, "{:.4g}"));
    if (const auto& voxels = input.results.voxelise; voxels && voxels->closing_radius_m)
        notes += fmt::format("Note: menisci between the grains count as solid, which no ball of a radius of {} m reaches. ",
                             number_text(*voxels->closing_radius_m, "{:.4g}"));
    if (const auto& shape = input.results.shape; lbm && shape && shape->maximum_feret_diameter_m)
        if (lbm->section_m.high - lbm->section_m.low < *shape->maximum_feret_diameter_m)
            notes += "Note: the section is shorter than one maximum Feret diameter of a grain: it hardly represents the packing. ";
    return notes;
}

std::string intro_of(const ReportInput& input) {
    std::string intro =
        "k = mu U L / dP, with U the flow rate over the inner area of the container and dP between the planes of the section. "
        "K = k rho g / mu is the hydraulic conductivity."
        " The intervals are numerical: they hold the errors of grids and iteration in this one packing. That of a mean of packings (95 %) "
        "holds their scatter, too.";
    if (const auto limit = gradient_limit(input))
        intro += with_powers_of_ten(fmt::format(
            " K holds up to a hydraulic gradient of about {:.1g}: there, inertia makes it 5 % smaller, {}.", limit->gradient, limit->from));
    return notes_of(input) + intro;
}

}  // namespace

std::optional<Interval> interval_of_mean_permeability(const ReportInput& input) {
    if (const auto& sure = input.results.uncertainty)
        if (const auto* k = find(sure->statements, "permeability_m2"); k != nullptr && k->mean_of_such_packings.interval)
            return k->mean_of_such_packings.interval;
    if (!input.results.seeds) return std::nullopt;
    const auto* k = find(input.results.seeds->quantities, "permeability_m2");
    return k != nullptr ? k->interval_of_mean : std::nullopt;
}

ReportSection permeability_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Permeability", .intro = intro_of(input)};
    section.header = {"method", "k (m²)", "interval (m²)", "k (darcy)", "K, " + input.fluid_text + " (m/s)", "against LBM"};
    const auto& [lbm, foam, seeds] = std::tie(input.results.lbm, input.results.foam, input.results.seeds);
    const auto add = [&](const std::string& method, double k, const std::string& interval) {
        section.rows.push_back({method, number_text(k), interval, fmt::format("{:.4g}", k / permeability::darcy_m2),
                                with_powers_of_ten(fmt::format("{:.3g}", permeability::hydraulic_conductivity_m_per_s(k, input.fluid))),
                                difference(k, lbm ? std::optional(lbm->permeability.m2) : std::nullopt)});
    };
    if (lbm) {
        add("lattice Boltzmann", lbm->permeability.m2, interval_text(lbm->permeability.interval_m2));
        if (lbm->grids.size() > 1)
            for (auto grid = lbm->grids.rbegin(); grid != lbm->grids.rend(); ++grid)
                add(fmt::format("lattice Boltzmann, voxels of {:.3g} m alone", grid->voxel_size_m), grid->permeability_m2, "none");
    }
    if (seeds)
        add(fmt::format("lattice Boltzmann, mean of {} packings", seeds->packings), seeds->permeability_mean_m2,
            fmt::format("{}, of the mean (standard deviation between packings {})", interval_text(interval_of_mean_permeability(input)),
                        number_text(seeds->standard_deviation_between_packings_m2, "{:.3g}")));
    if (foam) {
        add("OpenFOAM", foam->permeability.m2, interval_text(foam->permeability.interval_m2));
        if (foam->meshes.size() > 1)
            for (auto mesh = foam->meshes.rbegin(); mesh != foam->meshes.rend(); ++mesh)
                add(fmt::format("OpenFOAM, mesh of {} cells alone", mesh->cells), mesh->permeability_m2, "none");
    }
    if (const auto& test = input.results.falling_head; test && test->correlations) {
        const auto& [ck150, ck180, fit] = *test->correlations;
        if (ck150) add("Carman-Kozeny, constant 150 (Eq. 2)", *ck150, "none");
        if (ck180) add("Carman-Kozeny, constant 180", *ck180, "none");
        if (fit) add("the paper's fit (Eq. 22, corrected)", *fit, "none");
    }
    add_profile_plot(input, folder, section);
    const Path flow = input.stage_folders / "lbm" / "flow.vti";
    if (fs::exists(flow) && draw_speed_slice(flow, folder))
        section.pictures.emplace_back(
            "speed.png",
            "Speed on the slice through the middle of y (0.5 % of it is faster than the bar's end), at a superficial "
            "velocity of 0.05 mm/s of water unless the case says otherwise. Beige: grains.");
    return section;
}

}  // namespace porepack::report
