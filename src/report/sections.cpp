// The tables of the report: packing, tortuosity, convergence, cost.
#include <cmath>

#include "core/log.hpp"
#include "core/members_json.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace fs = std::filesystem;
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
    const auto& shape = input.results.shape;
    if (!shape || !shape->sphericity) return "";
    for (const auto& entry : paper_numbers)
        if (shape->kind == entry.kind && quantity == entry.quantity && std::abs(*shape->sphericity - entry.sphericity) < 0.006)
            return entry.text;
    return "";
}

std::string percent(double value) {
    return std::isfinite(value) ? fmt::format("{:.2g} %", 100.0 * value) : dash;
}

}  // namespace

std::optional<double> bed_porosity_of(const results::CaseResults& results) {
    if (const auto bed = bed_of(results)) return bed->porosity_bed;
    return results.image ? std::optional(results.image->porosity_bed) : std::nullopt;
}

bool take_file(const ReportInput& input, const Path& file, const Path& folder) {
    const Path from = input.stage_folders / file;
    if (!fs::exists(from)) return false;
    fs::copy_file(from, folder / from.filename(), fs::copy_options::overwrite_existing);
    return true;
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
    if (voxels) add("section", fmt::format("z = {:.4g} to {:.4g} m", voxels->section_m.low, voxels->section_m.high));
    if (fs::exists(folder / "packing.png")) section.pictures = {{"packing.png", "The packing: surface made by CGAL."}};
    return section;
}

ReportSection tortuosity_section(const ReportInput& input) {
    ReportSection section{
        .title = "Tortuosity",
        .intro =
            "Four different numbers: the path of the paper through dots (exact, and on slice images, where it grows with the pixel size), "
            "the shortest path through the pores, the mean path of the flow, and the tortuosity factor eps D0/D_eff of diffusion."};
    const std::string paper = paper_number(input, "tortuosity");
    if (!paper.empty())
        section.intro += fmt::format(
            " The paper states {} for this grain, by the same dots. It is not reached with exact sections: coarse pixels and thick slices "
            "explain a part of the difference (docs/tortuosity.md).",
            paper);
    section.header = {"kind", "value", "interval (95 %)", "the paper"};
    if (!input.results.tortuosity) return section;
    const results::Tortuosity& found = *input.results.tortuosity;
    const auto add = [&](const std::string& name, double value, const std::string& uncertainty, const std::string& of_paper = "") {
        section.rows.push_back({name, number_text(value, "{:.4f}"), uncertainty, of_paper});
    };
    const auto mean_over = [](double mean, double standard_error, long number, const char* what) {
        const auto interval = interval_of_path_mean(mean, standard_error, number);
        return interval ? fmt::format("{:.4f} to {:.4f} (mean over {})", interval->low, interval->high, what) : std::string("none");
    };
    const auto add_dots = [&](const std::string& name, const results::GeometricPaper& dots) {
        add(name, dots.tortuosity, mean_over(dots.tortuosity, dots.standard_error, dots.paths, "paths"), paper);
    };
    if (const auto& dots = found.geometric_paper_exact) add_dots("the paper's dots, exact", *dots);
    if (const auto& dots = found.geometric_paper_pixels)
        add_dots("the paper's dots, on slices with pixels of " + number_text(dots->pixel_m) + " m", *dots);
    if (const auto& path = found.shortest_path)
        add("shortest path, mean over starting points", path->tortuosity,
            mean_over(path->tortuosity, path->standard_error, path->starts, "starting points"));
    add("hydraulic", found.hydraulic.tortuosity, "none");
    if (const auto& factor = found.diffusive)
        add("tortuosity factor (diffusive)", factor->tortuosity_factor,
            factor->interval ? fmt::format("{:.3f} to {:.3f} (three grids)", factor->interval->low, factor->interval->high) : "none");
    return section;
}

ReportSection convergence_section(const ReportInput& input, const Path& folder) {
    ReportSection section{.title = "Did it converge?"};
    section.header = {"check", "value"};
    const auto add = [&](const char* name, const std::string& value) {
        if (value != dash) section.rows.push_back({name, value});
    };
    if (const auto& lbm = input.results.lbm) {
        add("LBM: iteration error of k", percent(lbm->iteration_error));
        add("LBM: flow rate, maximum difference between layers", percent(lbm->flow_imbalance));
        add("LBM: time steps", number_text(lbm->steps, "{:.0f}"));
        add("LBM: fluid nodes", number_text(lbm->fine.nodes, "{:.0f}"));
        add("LBM: pore cells without flow", number_text(lbm->fine.isolated_cells, "{:.0f}"));
        add("LBM: node updates per second", number_text(lbm->updates_per_second, "{:.3g}"));
        // The data are next to the script, so that names in it are relative: a path may contain any character.
        if (take_file(input, "lbm/history.csv", folder) &&
            draw_plot(folder / "convergence.svg", "convergence", {{"tolerance", lbm->iteration_tolerance}}))
            section.pictures.emplace_back(
                "convergence.svg",
                "Lattice Boltzmann on the finest grid: the run stops when the iteration error is below the tolerance at two checks. It is "
                "unknown at the first checks.");
    }
    if (const auto& foam = input.results.foam) {
        add("OpenFOAM: iterations (finest mesh)", number_text(foam->iterations, "{:.0f}"));
        add("OpenFOAM: cells (finest mesh)", number_text(foam->cells, "{:.0f}"));
        add("OpenFOAM: flow in against flow out", percent(foam->fine.flow_imbalance));
        add("OpenFOAM: meshed / exact pore volume", number_text(foam->fine.mesh_volume_ratio, "{:.4f}"));
    }
    return section;
}

ReportSection cost_section(const ReportInput& input) {
    ReportSection section{.title = "Cost"};
    section.header = {"stage", "wall time", "peak memory", "seed", "processes"};
    double sum = 0.0;
    for (const std::string& stage : input.stages) {
        const auto cost = from_json_members<results::StageCost>(input.manifests.at(stage), stage + "/manifest.json");
        sum += cost.wall_time_s;
        section.rows.push_back({stage, human_time(cost.wall_time_s), human_bytes(cost.peak_memory_bytes), std::to_string(cost.seed),
                                std::to_string(cost.processes)});
    }
    section.rows.push_back({"all", human_time(sum), "", "", ""});
    return section;
}

}  // namespace porepack::report
