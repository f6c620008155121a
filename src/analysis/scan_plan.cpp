#include "analysis/scan_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <vector>

#include "analysis/fit_image.hpp"
#include "analysis/flow.hpp"
#include "analysis/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "core/table.hpp"
#include "imaging/write_volume.hpp"
#include "inputs/pore_space_input.hpp"
#include "packing/structure.hpp"
#include "scans/shape_points.hpp"

namespace porepack::analysis {
namespace {

struct Trial {
    ScannerConfig scanner;
    long found = 0, wrong = 0;
    std::optional<double> porosity, permeability_m2;  // none where no grain was found
    std::size_t doubts = 0;
    double fit_s = 0.0;
};

std::vector<std::vector<shapes::Capsule>> capsules_of(const Packing& packing) {
    std::vector<std::vector<shapes::Capsule>> all;
    for (const Body& body : packing.bodies) all.push_back(world_capsules(packing, body));
    return all;
}

// Whole grains of the truth whose capsules' ends all lie within half a radius of a fitted grain's, and fitted grains that are near none.
void compare_poses(const Packing& truth, const Packing& fitted, Trial& trial) {
    const auto exact = capsules_of(truth), found = capsules_of(fitted);
    const std::vector<bool> whole = whole_grains(truth);
    std::vector<bool> used(found.size(), false);
    for (std::size_t i = 0; i < exact.size(); ++i)
        for (std::size_t f = 0; f < found.size(); ++f)
            if (found[f].size() == exact[i].size() && !used[f] &&
                scans::largest_difference_m(exact[i], found[f]) < 0.5 * exact[i][0].radius) {
                used[f] = true;
                trial.found += whole[i] ? 1 : 0;
                break;
            }
    trial.wrong = std::count(used.begin(), used.end(), false);
}

struct Numbers {
    double porosity, permeability_m2;
};

Numbers numbers_of(const Path& file, const Section& section, double voxel_size_m) {
    const GeometryConfig geometry{.voxel_size_m = voxel_size_m, .section_m = {section.z0_m, section.z1_m}};
    const PoreSpace space = inputs::load_pore_space(file, {.geometry = geometry, .section = {.ends = Ends::planes}});
    lbm::LbmConfig config;
    config.grids = 1;
    config.fields = lbm::FieldFiles::none;
    return {.porosity = space.porosity().value, .permeability_m2 = compute_flow(space, geometry, config).outcome.result.permeability.m2};
}

// Voxel sizes in diameters d of the thinnest capsule.
ScanPlanConfig with_standard_values(ScanPlanConfig config, double d) {
    if (config.voxel_sizes_m.empty()) config.voxel_sizes_m = {d / 12.0, d / 8.0, d / 6.0};
    if (config.views.empty()) config.views = {0.0};
    if (config.counts.empty()) config.counts = {20000.0, 2000.0};
    return config;
}

results::ScanTrial result_of(const Trial& trial, const Numbers& truth, double d, double within) {
    results::ScanTrial row{.voxel_size_m = trial.scanner.voxel_size_m,
                           .voxels_per_diameter = d / trial.scanner.voxel_size_m,
                           .views = trial.scanner.views,
                           .counts = trial.scanner.counts,
                           .whole_grains_found = trial.found,
                           .false_grains = trial.wrong,
                           .doubts = trial.doubts,
                           .fit_s = trial.fit_s};
    if (trial.porosity) row.porosity_error = *trial.porosity - truth.porosity;
    if (trial.permeability_m2) row.permeability_error = *trial.permeability_m2 / truth.permeability_m2 - 1.0;
    row.good = row.permeability_error && std::abs(*row.permeability_error) <= within;
    return row;
}

Table table_of(const std::vector<results::ScanTrial>& rows) {
    Table table({"voxel_size_m", "voxels_per_diameter", "views", "counts", "whole_grains_found", "false_grains", "porosity_error",
                 "permeability_error", "doubts", "good", "fit_s"});
    for (const auto& row : rows)
        table.add(row.voxel_size_m, row.voxels_per_diameter, static_cast<double>(row.views), row.counts,
                  static_cast<double>(row.whole_grains_found), static_cast<double>(row.false_grains), row.porosity_error,
                  row.permeability_error, static_cast<double>(row.doubts), row.good ? 1.0 : 0.0, row.fit_s);
    return table;
}

}  // namespace

std::size_t number_of_scans(const ScanPlanConfig& config) {
    const ScanPlanConfig all = with_standard_values(config, 1.0);
    return all.voxel_sizes_m.size() * all.views.size() * all.counts.size();
}

Outcome<results::ScanPlan> plan_scan(const Packing& packing, const Section& part, const ScannerConfig& scanner, const ScanPlanConfig& given,
                                     const Path& folder) {
    double feret = 0.0;
    for (const shapes::Shape& shape : packing.shapes) feret = std::max(feret, maximum_feret_diameter(shape));
    const Section inner{feret, part.length() - feret};
    if (inner.length() < 0.5 * feret)
        throw UserError(fmt::format("the part is {:g} m high: grains cut by its ends leave no section to compare", part.length()),
                        {.where = "--part", .allowed = fmt::format("{:g} m or more", 2.5 * feret)});
    const Packing truth = cut_out(packing, part);
    const double d = finest_diameter(packing);
    const ScanPlanConfig config = with_standard_values(given, d);
    const Path scan = folder / "scan.nrrd", exact = folder / "truth.json", work = folder / "fit";
    make_folder(work);
    write_packing(exact, truth);
    const Numbers flow = numbers_of(exact, inner, d / 10.0);
    results::ScanPlan plan{.section_m = {part.z0_m + inner.z0_m, part.z0_m + inner.z1_m},
                           .porosity_exact = flow.porosity,
                           .permeability_exact_m2 = flow.permeability_m2,
                           .within = config.within};
    for (const double voxel_size : config.voxel_sizes_m)
        for (const double views : config.views)
            for (const double counts : config.counts) {
                Trial trial{.scanner = scanner};
                trial.scanner.voxel_size_m = voxel_size;
                trial.scanner.views = std::lround(views);
                trial.scanner.counts = counts;
                const SimulatedScan image = scan_packing(packing, part, trial.scanner);
                imaging::write_volume(scan, imaging::source_of(image.grid, image.values));
                const Stopwatch watch;
                try {
                    const bool tube = packing.container.tube_diameter() && scanner.tube_wall_m > 0.0;
                    const results::Fit found = written(
                        fit_image(scan, {.find_container = tube}, tube ? std::nullopt : std::optional(truth.container), packing.shapes),
                        work);
                    trial.fit_s = watch.seconds();
                    trial.doubts = found.doubts.size();
                    compare_poses(truth, read_packing(work / "packing.json"), trial);
                    const Numbers fitted = numbers_of(work / "packing.json", inner, d / 10.0);
                    trial.porosity = fitted.porosity;
                    trial.permeability_m2 = fitted.permeability_m2;
                } catch (const UserError& refused) {  // no gray levels, no tube, no grain: a row without numbers
                    log_warning(fmt::format("voxels of {:g} m, {:g} counts: {}", voxel_size, counts, refused.what()));
                    trial.fit_s = watch.seconds();
                    trial.doubts = 1;
                }
                plan.rows.push_back(result_of(trial, flow, d, config.within));
                log_info("{}", json_of(plan.rows.back()).dump());
            }
    std::filesystem::remove_all(work);
    std::filesystem::remove(scan);
    std::filesystem::remove(exact);
    const auto whole = whole_grains(truth);
    plan.whole_grains = std::count(whole.begin(), whole.end(), true);
    for (const auto& row : plan.rows)
        if (row.good && row.voxel_size_m > plan.coarsest_good_voxel_size_m.value_or(0.0))
            plan.coarsest_good_voxel_size_m = row.voxel_size_m;
    return {plan, {.tables = {{"plan.csv", table_of(plan.rows)}}}};
}

}  // namespace porepack::analysis
