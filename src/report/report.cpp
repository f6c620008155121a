#include "report/report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <tuple>
#include <utility>

#include "core/members_json.hpp"
#include "permeability/permeability.hpp"
#include "report/section.hpp"
#include "report/uses.hpp"

namespace porepack::report {
namespace fs = std::filesystem;

bool take_file(const ReportInput& input, const Path& file, const Path& folder) {
    const Path from = input.stage_folders / file;
    if (!fs::exists(from)) return false;
    fs::copy_file(from, folder / from.filename(), fs::copy_options::overwrite_existing);
    return true;
}

namespace {

std::vector<results::MainNumber> main_numbers_of(const ReportInput& input) {
    std::vector<results::MainNumber> list;
    const auto& [lbm, foam, seeds] = std::tie(input.results.lbm, input.results.foam, input.results.seeds);
    for (const auto& [quantity, name] : {std::pair("permeability_m2", "k"), std::pair("porosity", "porosity")}) {
        using results::Statements;
        for (const auto which : {&Statements::this_packing, &Statements::mean_of_such_packings, &Statements::next_such_packing})
            if (seeds || which != &Statements::next_such_packing)
                list.push_back({statement_label(input, name, which), sure_text(input, quantity, which)});
        if (const std::string bed = measured_bed_text(input, quantity); bed != dash)
            list.push_back({std::string(name) + ", the bed of measured porosity", bed});
    }
    const std::string not_run = "not run";
    const auto limit = gradient_limit(input);
    list.push_back({"K, " + input.fluid_text,
                    lbm ? with_powers_of_ten(
                              fmt::format("{:.3g} m/s", permeability::hydraulic_conductivity_m_per_s(lbm->permeability.m2, input.fluid))) +
                              (limit ? with_powers_of_ten(fmt::format(", up to a hydraulic gradient of {:.1g}", limit->gradient)) : "")
                        : not_run});
    std::string by_foam = not_run;
    if (foam) {
        const auto& [k, interval] = foam->permeability;
        by_foam = number_text(k, "{:.4g} m²") + (interval ? " (" + interval_text(interval) + ")" : "") + ", " +
                  difference(k, lbm ? std::optional(lbm->permeability.m2) : std::nullopt);
    }
    list.push_back({"k by OpenFOAM", by_foam});
    const auto& paths = input.results.tortuosity;
    list.push_back({"tortuosity, hydraulic", paths ? number_text(paths->hydraulic.tortuosity, "{:.4f}") : dash});
    const bool exact = paths && paths->geometric_paper_exact;
    const auto& dots = exact ? paths->geometric_paper_exact : paths ? paths->geometric_paper_pixels : std::nullopt;
    list.push_back({std::string("tortuosity, the paper's dots") + (exact ? " (exact)" : " (on slices)"),
                    dots ? number_text(dots->tortuosity, "{:.4f}") : dash});
    return list;
}

using results::QuantityUncertainty;

// The rows of quantities().
class Quantities {
public:
    explicit Quantities(const ReportInput& input) : input_(input) {}

    void add(const std::string& name, const std::string& stage, double value, const char* unit, const std::string& method,
             const std::optional<QuantityUncertainty>& uncertainty = {}, const std::optional<bool>& converged = {}) {
        if (!std::isfinite(value)) return;
        const auto manifest = input_.manifests.find(stage);
        results::ReportedQuantity row{
            .name = name, .value = value, .unit = unit, .method = method, .uncertainty = uncertainty, .converged = converged};
        if (manifest != input_.manifests.end()) row.cost_s = manifest->second.at("wall_time_s").get<double>();
        list_.push_back(std::move(row));
    }
    [[nodiscard]] static std::optional<QuantityUncertainty> interval(const std::optional<Interval>& of_95) {
        return of_95 ? std::optional(QuantityUncertainty{.interval = of_95}) : std::nullopt;
    }
    [[nodiscard]] static std::optional<QuantityUncertainty> standard(double u, const std::optional<Interval>& of_95) {
        return std::isfinite(u) ? std::optional(QuantityUncertainty{.interval = of_95, .standard_uncertainty = u}) : std::nullopt;
    }
    /// Of a value that the computation knows to `u`.
    [[nodiscard]] static std::optional<QuantityUncertainty> computed(double value, double u) {
        return standard(u, two_standard_uncertainties(value, u));
    }
    [[nodiscard]] const std::vector<results::ReportedQuantity>& list() const { return list_; }

private:
    const ReportInput& input_;
    std::vector<results::ReportedQuantity> list_;
};

void add_solver(Quantities& list, const std::string& stage, const std::string& method, const std::string& method_of_k,
                const results::Permeability& k, bool converged) {
    list.add("permeability_" + stage, stage, k.m2, "m2", method_of_k, Quantities::interval(k.interval_m2), converged);
    list.add("permeability_" + stage + "_darcy", stage, k.m2 / permeability::darcy_m2, "darcy", method, {}, converged);
}

void add_conductivity(Quantities& list, const ReportInput& input, const char* name, const char* stage, const std::string& method,
                      const results::Permeability& k, bool converged) {
    list.add(name, stage, permeability::hydraulic_conductivity_m_per_s(k.m2, input.fluid), "m/s", method + ", " + input.fluid_text, {},
             converged);
}

void add_tortuosities(Quantities& list, const results::Tortuosity& found, std::optional<bool> flow_converged) {
    const auto path_mean = [](double mean, double standard_error, long number) {
        return Quantities::standard(standard_error, interval_of_path_mean(mean, standard_error, number));
    };
    const char* stage = results::Tortuosity::stage;
    if (const auto& dots = found.geometric_paper_exact)
        list.add("tortuosity_geometric_paper_exact", stage, dots->tortuosity, "1", "the paper's dots, exact",
                 path_mean(dots->tortuosity, dots->standard_error, dots->paths));
    if (const auto& dots = found.geometric_paper_pixels)
        list.add("tortuosity_geometric_paper_pixels", stage, dots->tortuosity, "1", "the paper's dots, on slices",
                 path_mean(dots->tortuosity, dots->standard_error, dots->paths));
    if (const auto& path = found.shortest_path)
        list.add("tortuosity_shortest_path", stage, path->tortuosity, "1", "shortest paths, mean over starting points",
                 path_mean(path->tortuosity, path->standard_error, path->starts));
    if (const auto& factor = found.diffusive)
        list.add("tortuosity_factor", stage, factor->tortuosity_factor, "1", "eps D0/D_eff by diffusion, three grids",
                 Quantities::interval(factor->interval), factor->converged);
    list.add("tortuosity_hydraulic", stage, found.hydraulic.tortuosity, "1", "flow.vti", {}, flow_converged);
}

}  // namespace

std::vector<results::ReportedQuantity> quantities(const ReportInput& input) {
    Quantities list(input);
    const auto& results = input.results;
    const char* lines = "exact shapes or triangles, vertical lines";
    if (const auto& voxels = results.voxelise)
        list.add("porosity", "voxelise", voxels->porosity, "1", lines,
                 Quantities::computed(voxels->porosity, voxels->porosity_uncertainty));
    if (const auto porosity = bed_porosity_of(results)) {
        const auto bed = bed_of(results);
        list.add("porosity_bed",
                 results.pack    ? "pack"
                 : results.image ? "image"
                                 : "stl",
                 *porosity, "1", lines, bed ? Quantities::computed(*porosity, bed->porosity_bed_uncertainty) : std::nullopt);
    }
    if (const auto& lbm = results.lbm) add_solver(list, "lbm", "lattice Boltzmann", "lattice Boltzmann", lbm->permeability, lbm->converged);
    if (const auto& seeds = results.seeds)
        list.add("permeability_lbm_mean_of_seeds", "seeds", seeds->permeability_mean_m2, "m2", "lattice Boltzmann, several packings",
                 Quantities::standard(seeds->standard_error_of_mean_m2, interval_of_mean_permeability(input)));
    if (const auto& foam = results.foam)
        add_solver(list, "foam", "OpenFOAM", "OpenFOAM, extrapolated when there are two meshes", foam->permeability, foam->converged);
    if (const auto& test = results.falling_head; test && test->correlations) {
        const auto& [ck150, ck180, fit] = *test->correlations;
        if (ck150) list.add("permeability_carman_kozeny_150", "falling-head", *ck150, "m2", "Eq. 2");
        if (ck180) list.add("permeability_carman_kozeny_180", "falling-head", *ck180, "m2", "Eq. 2 with 180");
        if (fit) list.add("permeability_paper_fit", "falling-head", *fit, "m2", "Eq. 22, corrected");
    }
    if (const auto& found = results.tortuosity)
        add_tortuosities(list, *found, results.lbm ? std::optional(results.lbm->converged) : std::nullopt);
    if (const auto& lbm = results.lbm)
        add_conductivity(list, input, "conductivity_lbm", "lbm", "lattice Boltzmann", lbm->permeability, lbm->converged);
    if (const auto& foam = results.foam)
        add_conductivity(list, input, "conductivity_foam", "foam", "OpenFOAM", foam->permeability, foam->converged);
    return list.list();
}

results::Report write_report(const ReportInput& input, const Path& folder) {
    Page page{.title = input.title,
              .summary = scene_text(input),
              .answer = answer_of(input),
              .bed = input.bed ? bed_view_html(*input.bed) : std::string(),
              .notes = input.notes,
              .main_numbers = main_numbers_of(input),
              .sections = {uncertainty_section(input), budget_section(input, folder), permeability_section(input, folder),
                           packing_section(input, folder), tortuosity_section(input), descriptors_section(input, folder),
                           inertia_section(input, folder), falling_head_section(input, folder), causes_section(input, folder),
                           convergence_section(input, folder), cost_section(input)},
              .versions = input.versions,
              .configuration = input.configuration};
    for (ReportSection& section : page.sections)
        for (auto& row : section.rows)
            for (std::string& cell : row) cell = with_powers_of_ten(cell);
    write_text(folder / "report.html", html_page(page, folder));
    write_text(folder / "report.md", markdown_page(page));
    const auto& sure = input.results.uncertainty;
    write_json(folder / "merged.json", {{"format", "porepack-result"},
                                        {"version", 1},
                                        {"title", input.title},
                                        {"quantities", json_of(quantities(input))},
                                        {"uncertainty", sure ? json_of(sure->statements) : Json(nullptr)},
                                        {"stages", input.documents},
                                        {"manifests", input.manifests},
                                        {"versions", input.versions},
                                        {"configuration", input.configuration}});
    return {.main_numbers = page.main_numbers, .notes = page.notes};
}

}  // namespace porepack::report
