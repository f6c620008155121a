#include "report/section.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cmath>

#include "core/log.hpp"

namespace porepack {
namespace fs = std::filesystem;
namespace {

// Numbers of the paper (section 8 of its results) for the grain at hand, where there are any.
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
    const Json& kind = at(input, "shape/kind");
    const Json& sphericity = at(input, "shape/sphericity");
    if (!kind.is_string() || !sphericity.is_number()) return "";
    for (const auto& entry : paper_numbers)
        if (kind == entry.kind && quantity == entry.quantity && std::abs(sphericity.get<double>() - entry.sphericity) < 0.006)
            return entry.text;
    return "";
}

std::string interval_text(const Json& interval) {
    if (!interval.is_array()) return "none";
    return fmt::format("{:.4g} to {:.4g}", interval[0].get<double>(), interval[1].get<double>());
}

std::string difference(const Json& value, const Json& reference) {
    if (!value.is_number() || !reference.is_number()) return "–";
    return fmt::format("{:+.1f} %", 100.0 * (value.get<double>() / reference.get<double>() - 1.0));
}

std::string percent(const Json& value) {
    return value.is_number() ? fmt::format("{:.2g} %", 100.0 * value.get<double>()) : "–";
}

ReportSection permeability_section(const ReportInput& input) {
    const Json& lbm = at(input, "lbm/permeability_m2");
    ReportSection section{
        .title = "Permeability",
        .intro = "k = mu U L / dP, with U the flow rate over the inner area of the container and dP between the planes of the section."};
    section.header = {"method", "k (m²)", "interval (m²)", "k (darcy)", "K, water (m/s)", "against LBM"};
    const auto add = [&](const std::string& method, const Json& k, const std::string& interval) {
        if (!k.is_number()) return;
        const double value = k.get<double>();
        section.rows.push_back({method, number(k), interval, fmt::format("{:.4g}", value / 9.869233e-13),
                                fmt::format("{:.3g}", value * 9.81e6), difference(k, lbm)});
    };
    add("lattice Boltzmann", lbm, interval_text(at(input, "lbm/permeability_interval_m2")));
    if (const Json& grids = at(input, "lbm/grids"); grids.size() > 1)
        for (auto grid = grids.rbegin(); grid != grids.rend(); ++grid)
            add(fmt::format("lattice Boltzmann, voxels of {:.3g} m alone", grid->at("voxel_size_m").get<double>()),
                grid->at("permeability_m2"), "none");
    if (const Json& mean = at(input, "seeds/permeability_mean_m2"); mean.is_number())
        add(fmt::format("lattice Boltzmann, mean of {} packings", at(input, "seeds/packings").get<long>()), mean,
            fmt::format("standard deviation between packings {:.3g}, numerical half width {:.3g}",
                        at(input, "seeds/standard_deviation_between_packings_m2").get<double>(),
                        at(input, "seeds/numerical_half_width_m2").get<double>()));
    add("OpenFOAM", at(input, "foam/permeability_m2"), interval_text(at(input, "foam/permeability_interval_m2")));
    if (const Json& meshes = at(input, "foam/meshes"); meshes.size() > 1)
        for (auto mesh = meshes.rbegin(); mesh != meshes.rend(); ++mesh)
            add(fmt::format("OpenFOAM, mesh of {} cells alone", mesh->at("cells").get<long>()), mesh->at("permeability_m2"), "none");
    add("Carman-Kozeny, constant 150 (Eq. 2)", at(input, "falling-head/correlations/carman_kozeny_150_m2"), "none");
    add("Carman-Kozeny, constant 180", at(input, "falling-head/correlations/carman_kozeny_180_m2"), "none");
    add("the paper's fit (Eq. 22, corrected)", at(input, "falling-head/correlations/paper_fit_m2"), "none");
    return section;
}

ReportSection packing_section(const ReportInput& input) {
    ReportSection section{.title = "Packing"};
    section.header = {"quantity", "value", "uncertainty", "the paper"};
    const auto add = [&](const char* name, const std::string& value, const std::string& uncertainty, const std::string& paper = "") {
        if (value != "–") section.rows.push_back({name, value, uncertainty, paper});
    };
    const std::string stage = input.results.contains("pack") ? "pack" : "stl";
    add("grain", at(input, "shape/kind").is_string() ? at(input, "shape/kind").get<std::string>() : "–", "");
    add("sphericity", number(at(input, "shape/sphericity")), number(at(input, "shape/relative_error"), "{:.1e} (relative)"));
    add("capsule diameter d, length L",
        at(input, "shape/diameter_m").is_number()
            ? number(at(input, "shape/diameter_m")) + " m, " + number(at(input, "shape/length_m")) + " m"
            : "–",
        "");
    add("grains", number(at(input, stage + "/grains"), "{:.0f}"), "");
    add("bed height", number(at(input, stage + "/bed_height_m")) + " m", "");
    add("porosity of the section", number(at(input, "voxelise/porosity"), "{:.4f}"),
        number(at(input, "voxelise/porosity_uncertainty"), "± {:.1e} (quadrature; one packing, so no scatter)"),
        paper_number(input, "porosity"));
    add("porosity of the whole bed", number(at(input, stage + "/porosity_bed"), "{:.4f}"),
        number(at(input, stage + "/porosity_bed_uncertainty"), "± {:.1e} (quadrature)"));
    add("largest overlap of grains / d", number(at(input, stage + "/largest_overlap_relative_to_diameter")), "");
    add("contacts", number(at(input, stage + "/contacts"), "{:.0f}"), "");
    add("coordination number (touching grains a grain)", number(at(input, stage + "/coordination_number"), "{:.2f}"), "");
    add("net force on a grain / its weight, mean", number(at(input, stage + "/mean_force_over_weight"), "{:.1e}"), "");
    const Json& z = at(input, "voxelise/section_m");
    if (z.is_array()) add("section", fmt::format("z = {:.4g} to {:.4g} m", z[0].get<double>(), z[1].get<double>()), "");
    return section;
}

ReportSection tortuosity_section(const ReportInput& input) {
    ReportSection section{
        .title = "Tortuosity",
        .intro =
            "Four different numbers: the paper's path through dots (exact, and on pictures, where it grows with the pixel), "
            "the shortest way through the pores, the flow's detour, and the slowing of diffusion."};
    section.header = {"kind", "value", "uncertainty", "the paper"};
    const auto add = [&](const std::string& name, const Json& value, const std::string& uncertainty, const std::string& paper) {
        if (value.is_number()) section.rows.push_back({name, number(value, "{:.4f}"), uncertainty, paper});
    };
    add("geometric_paper, exact", at(input, "tortuosity/geometric_paper_exact/tortuosity_geometric_paper"),
        number(at(input, "tortuosity/geometric_paper_exact/standard_error"), "± {:.1e} (standard error over paths)"),
        paper_number(input, "tortuosity"));
    add("geometric_paper, pixels of " + number(at(input, "tortuosity/geometric_paper_pixels/pixel_m")) + " m",
        at(input, "tortuosity/geometric_paper_pixels/tortuosity_geometric_paper"),
        number(at(input, "tortuosity/geometric_paper_pixels/standard_error"), "± {:.1e} (standard error over paths)"),
        paper_number(input, "tortuosity"));
    add("shortest_path, mean over starting points", at(input, "tortuosity/shortest_path/tortuosity_shortest_path"),
        number(at(input, "tortuosity/shortest_path/standard_error"), "± {:.1e} (standard error over starting points)"), "");
    add("hydraulic", at(input, "tortuosity/hydraulic/tortuosity_hydraulic"), "none", "");
    const Json interval = at(input, "tortuosity/diffusive/interval");
    add("diffusive", at(input, "tortuosity/diffusive/tortuosity_diffusive"),
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
    add("LBM: iteration error of k", percent(at(input, "lbm/iteration_error")));
    add("LBM: flow rate, largest difference between planes", percent(at(input, "lbm/flow_imbalance")));
    add("LBM: time steps", number(at(input, "lbm/steps"), "{:.0f}"));
    add("LBM: fluid nodes", number(at(input, "lbm/fine/fluid_nodes"), "{:.0f}"));
    add("LBM: pore cells that no flow reaches", number(at(input, "lbm/fine/isolated_cells"), "{:.0f}"));
    add("LBM: node updates a second", number(at(input, "lbm/updates_per_second"), "{:.3g}"));
    add("OpenFOAM: iterations (finest mesh)", number(at(input, "foam/iterations"), "{:.0f}"));
    add("OpenFOAM: cells (finest mesh)", number(at(input, "foam/cells"), "{:.0f}"));
    add("OpenFOAM: flow in against flow out", percent(at(input, "foam/fine/flow_imbalance")));
    add("OpenFOAM: meshed / exact pore volume", number(at(input, "foam/fine/mesh_volume_ratio"), "{:.4f}"));
    return section;
}

ReportSection cost_section(const ReportInput& input) {
    ReportSection section{.title = "Cost"};
    section.header = {"stage", "wall time", "largest memory", "seed", "processes"};
    double sum = 0.0;
    for (const char* stage :
         {"shape", "pack", "stl", "voxelise", "slices", "lbm", "foam", "tortuosity", "forchheimer", "falling-head", "causes"}) {
        const auto found = input.manifests.find(stage);
        if (found == input.manifests.end()) continue;
        const Json& m = found->second;
        sum += m.value("wall_time_s", 0.0);
        section.rows.push_back({stage, human_time(m.value("wall_time_s", 0.0)), human_bytes(m.value("peak_memory_bytes", 0.0)),
                                std::to_string(m.value("seed", 0L)), std::to_string(m.value("processes", 1L))});
    }
    section.rows.push_back({"all", human_time(sum), "", "", ""});
    return section;
}

void add_plots(const ReportInput& input, const Path& folder, std::vector<ReportSection>& sections) {
    const auto section = [&](const char* title) -> ReportSection& {
        return *std::find_if(sections.begin(), sections.end(), [&](const ReportSection& s) { return s.title == title; });
    };
    // The data lie beside the script, so that names in it are relative: a path may hold any character.
    const Path history = input.stage_folders / "lbm" / "history.csv";
    if (fs::exists(history)) fs::copy_file(history, folder / "history.csv", fs::copy_options::overwrite_existing);
    if (fs::exists(history) &&
        draw_plot(
            folder / "convergence.svg",
                "set datafile separator ','\nset logscale y\nset format y '10^{%T}'\nset xlabel 'time step'\nset ylabel 'relative'\nset "
                "key top right\n"
                "plot 'history.csv' every ::2 using 1:($3>0?$3:NaN) with lines lw 2 lc rgb '#205080' title 'iteration error of k', "
                "'history.csv' every ::2 using 1:($4>0?$4:NaN) with lines lw 2 lc rgb '#c07020' title 'difference of flow rate between planes'\n"))
        section("Did it converge?")
            .pictures.emplace_back("convergence.svg",
                                   "Lattice Boltzmann on the finest grid: the run stops when both lines have fallen below the gate.");
    add_falling_head_pictures(input, folder, section("Flow with inertia"), section("Falling head"), section("Measured against computed"));
    const Path flow = input.stage_folders / "lbm" / "flow.vti";
    if (fs::exists(flow)) {
        const double top = draw_speed_slice(flow, folder / "speed.png");
        section("Permeability")
            .pictures.emplace_back("speed.png", fmt::format("Speed on the slice y = middle, z up: dark 0, yellow {:.2g} m/s and more "
                                                            "(water at 0.05 mm/s superficial velocity unless the case says otherwise).",
                                                            top));
    }
}

std::string base64(const std::string& bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(size));
    return text;
}

std::string escaped(const std::string& text) {
    std::string out;
    for (const char ch : text) out += ch == '<' ? "&lt;" : ch == '>' ? "&gt;" : ch == '&' ? "&amp;" : std::string(1, ch);
    return out;
}

constexpr const char* style =
    R"(body{font:15px/1.45 'DejaVu Sans',Helvetica,Arial,sans-serif;color:#222;max-width:900px;margin:2em auto;padding:0 1em}
h1{font-size:1.6em;margin-bottom:.2em}h2{font-size:1.2em;margin-top:1.8em;border-bottom:1px solid #bbb}
table{border-collapse:collapse;margin:.6em 0;width:100%}th,td{text-align:left;padding:.25em .7em .25em 0;border-bottom:1px solid #ddd;font-size:.92em;vertical-align:top}
th{color:#555;font-weight:600}figure{margin:1em 0;break-inside:avoid}figure img,figure svg{max-width:100%;max-height:560px;height:auto}
figcaption{font-size:.85em;color:#555}.main{display:flex;flex-wrap:wrap;gap:.6em 2em;margin:1em 0}.main div b{display:block;font-size:1.25em}
.main div{font-size:.88em;color:#555}.main b{color:#111}.note{background:#fff3d6;padding:.5em .8em}pre{font-size:.75em;background:#f5f5f5;padding:.8em;white-space:pre-wrap}
@media print{body{margin:0;max-width:none}h2{break-after:avoid}tr{break-inside:avoid}})";

std::string html_page(const ReportInput& input, const std::vector<ReportSection>& sections, const Json& main_numbers, const Path& folder) {
    std::string html =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\"><title>" +
        escaped(input.title) + "</title><style>" + style + "</style></head><body>\n";
    html += "<h1>" + escaped(input.title) + "</h1>\n";
    for (const auto& note : input.notes) html += "<p class=\"note\">" + escaped(note) + "</p>\n";
    html += "<div class=\"main\">";
    for (const auto& entry : main_numbers)
        html += "<div>" + escaped(entry["label"].get<std::string>()) + "<b>" + escaped(entry["text"].get<std::string>()) + "</b></div>";
    html += "</div>\n";
    for (const auto& section : sections) {
        if (section.rows.empty() && section.pictures.empty()) continue;
        html += "<h2>" + escaped(section.title) + "</h2>\n";
        if (!section.intro.empty()) html += "<p>" + escaped(section.intro) + "</p>\n";
        html += "<table><tr>";
        for (const auto& head : section.header) html += "<th>" + escaped(head) + "</th>";
        html += "</tr>\n";
        for (const auto& row : section.rows) {
            html += "<tr>";
            for (const auto& cell : row) html += "<td>" + escaped(cell) + "</td>";
            html += "</tr>\n";
        }
        html += "</table>\n";
        for (const auto& [file, caption] : section.pictures) {
            const std::string bytes = read_text(folder / file);
            const std::string picture = file.ends_with(".svg")
                                            ? bytes.substr(bytes.find("<svg"))
                                            : "<img alt=\"" + escaped(caption) + "\" src=\"data:image/png;base64," + base64(bytes) + "\">";
            html += "<figure>" + picture + "<figcaption>" + escaped(caption) + "</figcaption></figure>\n";
        }
    }
    html += "<h2>Versions and configuration</h2>\n<pre>" + escaped(input.versions.dump(2)) + "</pre>\n<pre>" +
            escaped(input.configuration.dump(2)) + "</pre>\n</body></html>\n";
    return html;
}

std::string markdown_page(const ReportInput& input, const std::vector<ReportSection>& sections, const Json& main_numbers) {
    std::string text = "# " + input.title + "\n\n";
    for (const auto& note : input.notes) text += "> " + note + "\n\n";
    for (const auto& entry : main_numbers)
        text += "- " + entry["label"].get<std::string>() + ": **" + entry["text"].get<std::string>() + "**\n";
    for (const auto& section : sections) {
        if (section.rows.empty() && section.pictures.empty()) continue;
        text += "\n## " + section.title + "\n\n";
        if (!section.intro.empty()) text += section.intro + "\n\n";
        std::string rule = "|";
        text += "|";
        for (const auto& head : section.header) {
            text += " " + head + " |";
            rule += "---|";
        }
        text += "\n" + rule + "\n";
        for (const auto& row : section.rows) {
            text += "|";
            for (const auto& cell : row) text += " " + cell + " |";
            text += "\n";
        }
        for (const auto& [file, caption] : section.pictures) text += "\n![" + caption + "](report/" + file + ")\n*" + caption + "*\n";
    }
    text += "\n## Versions and configuration\n\n```json\n" + input.versions.dump(2) + "\n" + input.configuration.dump(2) + "\n```\n";
    return text;
}

Json main_numbers_of(const ReportInput& input) {
    Json list = Json::array();
    const auto add = [&](const std::string& label, const std::string& text) { list.push_back({{"label", label}, {"text", text}}); };
    const Json& pores = at(input, "voxelise/porosity");
    add("porosity of the section", number(pores, "{:.4f}"));
    const auto k_text = [&](const char* stage) {
        const Json& k = at(input, std::string(stage) + "/permeability_m2");
        const Json& interval = at(input, std::string(stage) + "/permeability_interval_m2");
        return k.is_number() ? number(k, "{:.4g} m²") + (interval.is_array() ? " (" + interval_text(interval) + ")" : "")
                             : std::string("not run");
    };
    add("k by lattice Boltzmann", k_text("lbm"));
    add("k by OpenFOAM", at(input, "foam/permeability_m2").is_number()
                             ? k_text("foam") + ", " + difference(at(input, "foam/permeability_m2"), at(input, "lbm/permeability_m2"))
                             : "not run");
    add("tortuosity, hydraulic", number(at(input, "tortuosity/hydraulic/tortuosity_hydraulic"), "{:.4f}"));
    const bool exact = at(input, "tortuosity/geometric_paper_exact/tortuosity_geometric_paper").is_number();
    const std::string kind = exact ? "geometric_paper_exact" : "geometric_paper_pixels";
    add("tortuosity, " + kind, number(at(input, "tortuosity/" + kind + "/tortuosity_geometric_paper"), "{:.4f}"));
    return list;
}

}  // namespace

namespace {
const Json nothing;
}  // namespace

const Json& at(const ReportInput& input, const std::string& path) {
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
        const Json& value = at(input, path);
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
        return at(input, path).is_array() ? Json{{"interval", at(input, path)}} : Json(nullptr);
    };
    const auto plus_minus = [&](const std::string& path) -> Json {
        return at(input, path).is_number() ? Json{{"plus_minus", at(input, path)}} : Json(nullptr);
    };
    const std::string stage = input.results.contains("pack") ? "pack" : "stl";
    add("porosity", "voxelise/porosity", "1", "exact capsules or triangles, vertical lines", plus_minus("voxelise/porosity_uncertainty"),
        nullptr);
    add("porosity_bed", stage + "/porosity_bed", "1", "exact capsules or triangles, vertical lines",
        plus_minus(stage + "/porosity_bed_uncertainty"), nullptr);
    add("permeability_lbm", "lbm/permeability_m2", "m2", "lattice Boltzmann", interval("lbm/permeability_interval_m2"),
        at(input, "lbm/converged"));
    add("permeability_lbm_darcy", "lbm/permeability_darcy", "darcy", "lattice Boltzmann", nullptr, at(input, "lbm/converged"));
    add("conductivity_lbm", "lbm/conductivity_m_per_s", "m/s", "lattice Boltzmann, water", nullptr, at(input, "lbm/converged"));
    add("permeability_lbm_mean_of_seeds", "seeds/permeability_mean_m2", "m2", "lattice Boltzmann, several packings",
        plus_minus("seeds/standard_error_of_mean_m2"), nullptr);
    add("permeability_foam", "foam/permeability_m2", "m2", "OpenFOAM, extrapolated when there are two meshes",
        interval("foam/permeability_interval_m2"), at(input, "foam/converged"));
    add("permeability_foam_darcy", "foam/permeability_darcy", "darcy", "OpenFOAM", nullptr, at(input, "foam/converged"));
    add("conductivity_foam", "foam/conductivity_m_per_s", "m/s", "OpenFOAM, water", nullptr, at(input, "foam/converged"));
    add("permeability_carman_kozeny_150", "falling-head/correlations/carman_kozeny_150_m2", "m2", "Eq. 2", nullptr, nullptr);
    add("permeability_carman_kozeny_180", "falling-head/correlations/carman_kozeny_180_m2", "m2", "Eq. 2 with 180", nullptr, nullptr);
    add("permeability_paper_fit", "falling-head/correlations/paper_fit_m2", "m2", "Eq. 22, corrected", nullptr, nullptr);
    add("tortuosity_geometric_paper_exact", "tortuosity/geometric_paper_exact/tortuosity_geometric_paper", "1", "the paper's dots, exact",
        plus_minus("tortuosity/geometric_paper_exact/standard_error"), nullptr);
    add("tortuosity_geometric_paper_pixels", "tortuosity/geometric_paper_pixels/tortuosity_geometric_paper", "1",
        "the paper's dots, on slices", plus_minus("tortuosity/geometric_paper_pixels/standard_error"), nullptr);
    add("tortuosity_shortest_path", "tortuosity/shortest_path/tortuosity_shortest_path", "1", "shortest ways, mean over starting points",
        plus_minus("tortuosity/shortest_path/standard_error"), nullptr);
    add("tortuosity_diffusive", "tortuosity/diffusive/tortuosity_diffusive", "1", "diffusion, three grids",
        interval("tortuosity/diffusive/interval"), at(input, "tortuosity/diffusive/converged"));
    add("tortuosity_hydraulic", "tortuosity/hydraulic/tortuosity_hydraulic", "1", "flow.vti", nullptr, at(input, "lbm/converged"));
    return list;
}

Json write_report(const ReportInput& input, const Path& folder) {
    std::vector<ReportSection> sections = {permeability_section(input), packing_section(input),      tortuosity_section(input),
                                           inertia_section(input),      falling_head_section(input), causes_section(input),
                                           convergence_section(input),  cost_section(input)};
    if (fs::exists(folder / "packing.png")) sections[1].pictures = {{"packing.png", "The packing as the surface that CGAL made of it."}};
    add_plots(input, folder, sections);
    const Json main_numbers = main_numbers_of(input);
    write_text(folder / "report.html", html_page(input, sections, main_numbers, folder));
    write_text(folder / "report.md", markdown_page(input, sections, main_numbers));
    write_json(folder / "merged.json", {{"format", "porepack-result"},
                                        {"version", 1},
                                        {"title", input.title},
                                        {"quantities", quantities(input)},
                                        {"stages", input.results},
                                        {"manifests", input.manifests},
                                        {"versions", input.versions},
                                        {"configuration", input.configuration}});
    return {{"report", "report.html"}, {"main_numbers", main_numbers}, {"notes", input.notes}};
}

}  // namespace porepack
