#include "report/report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/members.hpp"
#include "core/table.hpp"
#include "report/plot.hpp"
#include "report/section.hpp"

namespace porepack::report {
using namespace core;
namespace fs = std::filesystem;
namespace {

// Porosity and k along z, if both are known.
void add_profile_plot(const ReportInput& input, const Path& folder, ReportSection& section) {
    const Path porosities = input.stage_folders / "voxelise" / "porosity.csv";
    const Json &parts = result_at(input, "lbm/subsections"), &bed = result_at(input, "voxelise/bed_m"),
               &planes = result_at(input, "lbm/section_m");
    if (!fs::exists(porosities) || !parts.is_array() || parts.empty() || !bed.is_array()) return;
    fs::copy_file(porosities, folder / "porosity.csv", fs::copy_options::overwrite_existing);
    Table table({"z0_m", "z1_m", "permeability_m2"});
    for (const Json& part : parts) table.add(part["z0_m"].get<double>(), part["z1_m"].get<double>(), part["permeability_m2"].get<double>());
    table.write(folder / "subsections.csv");
    if (draw_plot(folder / "along_z.svg", "along_z",
                  {{"z_low", bed[0].get<double>()},
                   {"z_high", bed[1].get<double>()},
                   {"section_low", planes[0].get<double>()},
                   {"section_high", planes[1].get<double>()},
                   {"permeability", result_at(input, "lbm/permeability_m2").get<double>()}}))
        section.pictures.emplace_back(
            "along_z.svg",
            "Along z: porosity of thin layers of the bed (the section is shaded), and k of parts of the section in "
            "the same flow (dashed: the whole section).");
}

void add_plots(const ReportInput& input, const Path& folder, std::vector<ReportSection>& sections) {
    const auto section = [&](const char* title) -> ReportSection& {
        return *std::find_if(sections.begin(), sections.end(), [&](const ReportSection& s) { return s.title == title; });
    };
    // The data are next to the script, so that names in it are relative: a path may contain any character.
    const Path history = input.stage_folders / "lbm" / "history.csv";
    if (fs::exists(history)) fs::copy_file(history, folder / "history.csv", fs::copy_options::overwrite_existing);
    if (fs::exists(history) &&
        draw_plot(folder / "convergence.svg", "convergence", {{"tolerance", result_at(input, "lbm/iteration_tolerance").get<double>()}}))
        section("Did it converge?")
            .pictures.emplace_back("convergence.svg",
                                   "Lattice Boltzmann on the finest grid: the run stops when the iteration error is below the tolerance at "
                                   "two checks. It is unknown at the first checks.");
    add_budget_picture(input, folder, section("Uncertainty budget of k"));
    add_descriptor_pictures(input, folder, section("Dimensionless numbers and the wall"));
    if (fs::exists(folder / "packing.png")) section("Packing").pictures = {{"packing.png", "The packing: surface made by CGAL."}};
    add_profile_plot(input, folder, section("Permeability"));
    add_falling_head_pictures(input, folder, section("Flow with inertia"), section("Falling head"), section("Measured against computed"));
    const Path flow = input.stage_folders / "lbm" / "flow.vti";
    if (fs::exists(flow) && draw_speed_slice(flow, folder))
        section("Permeability")
            .pictures.emplace_back(
                "speed.png",
                "Speed on the slice through the middle of y (0.5 % of it is faster than the bar's end), at a superficial "
                "velocity of 0.05 mm/s of water unless the case says otherwise. Beige: grains.");
}

Json main_numbers_of(const ReportInput& input) {
    Json list = Json::array();
    const auto add = [&](const std::string& label, const std::string& text) { list.push_back({{"label", label}, {"text", text}}); };
    const bool several = result_at(input, "seeds/packings").is_number();
    const std::string n = several ? fmt::format(" of {} packings", result_at(input, "seeds/packings").get<long>()) : "";
    for (const auto& [quantity, name] : {std::pair("permeability_m2", "k"), std::pair("porosity", "porosity")}) {
        add(std::string(name) + ", this packing", sure_text(input, quantity, "this_packing"));
        add(std::string(name) + ", mean" + (several ? n : std::string(" of such packings")),
            sure_text(input, quantity, "mean_of_such_packings"));
        if (several) add(std::string(name) + ", next packing", sure_text(input, quantity, "next_such_packing"));
        if (const std::string bed = sure_text(input, quantity, "bed_of_measured_porosity"); bed != "–")
            add(std::string(name) + ", the bed of measured porosity", bed);
    }
    const auto k_text = [&](const char* stage) {
        const Json& k = result_at(input, std::string(stage) + "/permeability_m2");
        const Json& interval = result_at(input, std::string(stage) + "/permeability_interval_m2");
        return k.is_number() ? number_text(k, "{:.4g} m²") + (interval.is_array() ? " (" + interval_text(interval) + ")" : "")
                             : std::string("not run");
    };
    const Json& k = result_at(input, "lbm/permeability_m2");
    const std::optional<GradientLimit> limit = gradient_limit(input);
    add("K, " + input.fluid_text,
        k.is_number()
            ? with_powers_of_ten(fmt::format("{:.3g} m/s", permeability::hydraulic_conductivity_m_per_s(k.get<double>(), input.fluid))) +
                  (limit ? with_powers_of_ten(fmt::format(", up to a hydraulic gradient of {:.1g}", limit->gradient)) : "")
            : "not run");
    add("k by OpenFOAM",
        result_at(input, "foam/permeability_m2").is_number()
            ? k_text("foam") + ", " + difference(result_at(input, "foam/permeability_m2"), result_at(input, "lbm/permeability_m2"))
            : "not run");
    add("tortuosity, hydraulic", number_text(result_at(input, "tortuosity/hydraulic/tortuosity_hydraulic"), "{:.4f}"));
    const bool exact = result_at(input, "tortuosity/geometric_paper_exact/tortuosity_geometric_paper").is_number();
    const std::string kind = exact ? "geometric_paper_exact" : "geometric_paper_pixels";
    add(std::string("tortuosity, the paper's dots") + (exact ? " (exact)" : " (on slices)"),
        number_text(result_at(input, "tortuosity/" + kind + "/tortuosity_geometric_paper"), "{:.4f}"));
    return list;
}

}  // namespace

const Json& result_at(const ReportInput& input, const std::string& path) {
    static const Json nothing;
    const auto slash = path.find('/');
    const auto stage = input.results.find(path.substr(0, slash));
    if (stage == input.results.end()) return nothing;
    const Json* here = &stage->second;
    std::size_t from = slash;
    while (from != std::string::npos) {
        const auto next = path.find('/', from + 1);
        const std::string key = path.substr(from + 1, next == std::string::npos ? next : next - from - 1);
        if (!here->is_object() || !here->contains(key)) return nothing;
        here = &(*here)[key];
        from = next;
    }
    return *here;
}

Json quantities(const ReportInput& input) {
    Json list = Json::array();
    const auto add = [&](const char* name, const std::string& path, const char* unit, const char* method, const Json& uncertainty,
                         const Json& converged) {
        const Json& value = result_at(input, path);
        if (!value.is_number()) return;
        const auto manifest = input.manifests.find(path.substr(0, path.find('/')));
        list.push_back({{"name", name},
                        {"value", value},
                        {"unit", unit},
                        {"method", method},
                        {"uncertainty", uncertainty},
                        {"converged", converged},
                        {"cost_s", manifest == input.manifests.end() ? Json(nullptr) : manifest->second["wall_time_s"]}});
    };
    const auto interval = [&](const std::string& path) -> Json {
        return result_at(input, path).is_array() ? Json{{"interval", result_at(input, path)}} : Json(nullptr);
    };
    // The interval of 95 %, and the standard uncertainty by its new name and by that of version 0.1, until 0.3.
    const auto standard = [&](const std::string& path, const Json& interval_of_95) -> Json {
        const Json& u = result_at(input, path);
        return u.is_number() ? Json{{"interval", interval_of_95}, {"standard_uncertainty", u}, {"plus_minus", u}} : Json(nullptr);
    };
    const auto computed = [&](const std::string& value, const std::string& uncertainty) {
        return standard(uncertainty, json_of(two_standard_uncertainties(result_at(input, value), result_at(input, uncertainty))));
    };
    const auto path_mean = [&](const std::string& kind) {
        return standard("tortuosity/" + kind + "/standard_error", json_of(interval_of_path_mean(input, kind)));
    };
    const std::string stage = input.results.contains("pack") ? "pack" : input.results.contains("image") ? "image" : "stl";
    add("porosity", "voxelise/porosity", "1", "exact capsules or triangles, vertical lines",
        computed("voxelise/porosity", "voxelise/porosity_uncertainty"), nullptr);
    add("porosity_bed", stage + "/porosity_bed", "1", "exact capsules or triangles, vertical lines",
        computed(stage + "/porosity_bed", stage + "/porosity_bed_uncertainty"), nullptr);
    add("permeability_lbm", "lbm/permeability_m2", "m2", "lattice Boltzmann", interval("lbm/permeability_interval_m2"),
        result_at(input, "lbm/converged"));
    add("permeability_lbm_darcy", "lbm/permeability_darcy", "darcy", "lattice Boltzmann", nullptr, result_at(input, "lbm/converged"));
    add("permeability_lbm_mean_of_seeds", "seeds/permeability_mean_m2", "m2", "lattice Boltzmann, several packings",
        standard("seeds/standard_error_of_mean_m2", interval_of_mean_permeability(input)), nullptr);
    add("permeability_foam", "foam/permeability_m2", "m2", "OpenFOAM, extrapolated when there are two meshes",
        interval("foam/permeability_interval_m2"), result_at(input, "foam/converged"));
    add("permeability_foam_darcy", "foam/permeability_darcy", "darcy", "OpenFOAM", nullptr, result_at(input, "foam/converged"));
    add("permeability_carman_kozeny_150", "falling-head/correlations/carman_kozeny_150_m2", "m2", "Eq. 2", nullptr, nullptr);
    add("permeability_carman_kozeny_180", "falling-head/correlations/carman_kozeny_180_m2", "m2", "Eq. 2 with 180", nullptr, nullptr);
    add("permeability_paper_fit", "falling-head/correlations/paper_fit_m2", "m2", "Eq. 22, corrected", nullptr, nullptr);
    add("tortuosity_geometric_paper_exact", "tortuosity/geometric_paper_exact/tortuosity_geometric_paper", "1", "the paper's dots, exact",
        path_mean("geometric_paper_exact"), nullptr);
    add("tortuosity_geometric_paper_pixels", "tortuosity/geometric_paper_pixels/tortuosity_geometric_paper", "1",
        "the paper's dots, on slices", path_mean("geometric_paper_pixels"), nullptr);
    add("tortuosity_shortest_path", "tortuosity/shortest_path/tortuosity_shortest_path", "1", "shortest paths, mean over starting points",
        path_mean("shortest_path"), nullptr);
    // The second is the name of version 0.1, until 0.3.
    for (const char* name : {"tortuosity_factor", "tortuosity_diffusive"})
        add(name, "tortuosity/diffusive/tortuosity_factor", "1", "eps D0/D_eff by diffusion, three grids",
            interval("tortuosity/diffusive/interval"), result_at(input, "tortuosity/diffusive/converged"));
    add("tortuosity_hydraulic", "tortuosity/hydraulic/tortuosity_hydraulic", "1", "flow.vti", nullptr, result_at(input, "lbm/converged"));
    for (const char* solver : {"lbm", "foam"}) {
        const std::string stage_of = solver, method = stage_of == "lbm" ? "lattice Boltzmann" : "OpenFOAM";
        add(stage_of == "lbm" ? "conductivity_lbm" : "conductivity_foam", stage_of + "/permeability_m2", "m/s",
            (method + ", " + input.fluid_text).c_str(), nullptr, result_at(input, stage_of + "/converged"));
        if (result_at(input, stage_of + "/permeability_m2").is_number())
            list.back()["value"] = permeability::hydraulic_conductivity_m_per_s(list.back()["value"].get<double>(), input.fluid);
    }
    return list;
}

Json write_report(ReportInput input, const Path& folder) {
    input.summary = scene_text(input);
    std::vector<ReportSection> sections = {uncertainty_section(input), budget_section(input),       permeability_section(input),
                                           packing_section(input),     tortuosity_section(input),   descriptors_section(input),
                                           inertia_section(input),     falling_head_section(input), causes_section(input),
                                           convergence_section(input), cost_section(input)};
    add_plots(input, folder, sections);
    for (ReportSection& section : sections)
        for (auto& row : section.rows)
            for (std::string& cell : row) cell = with_powers_of_ten(cell);
    const Json main_numbers = main_numbers_of(input);
    write_text(folder / "report.html", html_page(input, sections, main_numbers, folder));
    write_text(folder / "report.md", markdown_page(input, sections, main_numbers));
    write_json(folder / "merged.json", {{"format", "porepack-result"},
                                        {"version", 1},
                                        {"title", input.title},
                                        {"quantities", quantities(input)},
                                        {"uncertainty", result_at(input, "uncertainty/statements")},
                                        {"stages", input.results},
                                        {"manifests", input.manifests},
                                        {"versions", input.versions},
                                        {"configuration", input.configuration}});
    return {{"report", "report.html"}, {"main_numbers", main_numbers}, {"notes", input.notes}};
}

}  // namespace porepack::report
