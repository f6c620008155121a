// Coverage of the interval of k on random packings: rows in a CSV file, which are kept as they come, and a table of them.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/binomial_interval.hpp"
#include "benchmarks/coverage_rows.hpp"
#include "benchmarks/random_beds.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::benchmarks {
namespace {

// The first table was computed with a wider interval.
constexpr int beds_of_the_first_table = 40;
constexpr std::array<double, 2> first_tolerances = {0.05, 0.02}, later_tolerances = {0.02, 0.006};

void compute(int bed, std::vector<CoverageRow>& rows, const Path& file, const Path& folder) {
    const auto missing = [&](int position, double tolerance) {
        return std::none_of(rows.begin(), rows.end(),
                            [&](const CoverageRow& r) { return r.bed == bed && r.position == position && r.tolerance == tolerance; });
    };
    const bool first = bed < beds_of_the_first_table;
    const std::array<double, 2>& tolerances = first ? first_tolerances : later_tolerances;
    if (!missing(1, tolerances[1])) return;
    const RandomBed made = random_bed(bed, folder);
    std::optional<LbmResult> reference;
    for (const int position : {0, 1}) {
        const PoreSpace space = pore_space_of(made, position);
        for (const double tolerance : tolerances) {
            if (!missing(position, tolerance)) continue;
            if (!reference) reference = reference_run(pore_space_of(made, 0), first ? reference_nodes : reference_nodes_of_later_beds);
            const Stopwatch watch;
            const LbmResult result = lbm_permeability(space, 0.0, {.tolerance = tolerance});
            CoverageRow row{.bed = bed, .position = position, .tolerance = tolerance, .porosity = space.porosity(20000).value};
            last_grids(*reference, space, row.reference_nodes, row.references_m2);
            last_grids(result, space, row.nodes, row.values_m2);
            row.reference_other_half_width = other_half_width(*reference);
            row.other_half_width = other_half_width(result);
            row.seconds = watch.seconds();
            rows.push_back(row);
            write_rows(file, rows);
            log_info("bed {} ({}), position {}, tolerance {:g}: {:+.2f} %, {:.0f} s", bed, made.name, position, tolerance,
                     100.0 * (row.values_m2[2] / reference_of(row).value_m2 - 1.0), row.seconds);
        }
    }
}

struct Coverage {
    long rows = 0, held = 0;
    std::map<int, bool> beds = {};  ///< all runs of the bed held
    double median_error = 0.0, median_half_width = 0.0;
};
template <typename Choose>
Coverage coverage_of(const std::vector<CoverageRow>& rows, const GridErrorConstants& constants, const Choose& choose) {
    std::vector<double> errors, half_widths;
    Coverage coverage;
    for (const CoverageRow& row : rows) {
        if (!choose(row)) continue;
        const Extrapolation found = extrapolate(row.nodes, row.values_m2);
        const double error = std::abs(found.value / reference_of(row).value_m2 - 1.0),
                     half = grid_half_width(found, row.nodes[2], grains_of_random_bed(row.bed, row.porosity), constants) / found.value +
                            row.other_half_width;
        ++coverage.rows;
        coverage.held += error <= half ? 1 : 0;
        bool& bed = coverage.beds.try_emplace(row.bed, true).first->second;
        bed = bed && error <= half;
        errors.push_back(error);
        half_widths.push_back(half);
    }
    if (coverage.rows == 0) return coverage;
    for (std::vector<double>* list : {&errors, &half_widths}) std::sort(list->begin(), list->end());
    coverage.median_error = errors[errors.size() / 2];
    coverage.median_half_width = half_widths[half_widths.size() / 2];
    return coverage;
}

// The runs of one bed are not independent: the interval of the probability is that of the beds.
Json to_json(const Coverage& c) {
    const auto beds = static_cast<long>(c.beds.size());
    const long held = std::count_if(c.beds.begin(), c.beds.end(), [](const auto& bed) { return bed.second; });
    const Interval interval = binomial_interval(held, beds);
    return {{"runs", c.rows},
            {"held", c.held},
            {"beds", beds},
            {"beds_with_all_runs_held", held},
            {"interval_of_beds", {interval.low, interval.high}},
            {"median_error", c.median_error},
            {"median_half_width", c.median_half_width},
            {"ratio", c.median_half_width / c.median_error}};
}

// The constants were chosen with the first table in sight.
bool is_first(const CoverageRow& row) {
    return row.bed < beds_of_the_first_table;
}
bool is_later(const CoverageRow& row) {
    return !is_first(row);
}

}  // namespace

Json coverage_random_benchmark(const Path& file, bool compute_missing, const Path& folder) {
    std::vector<CoverageRow> rows = read_rows(file);
    Json failed = Json::array();
    if (compute_missing)
        for (int bed = 0; bed < random_beds; ++bed) {
            try {
                compute(bed, rows, file, folder.empty() ? Path("coverage_beds") : folder);
            } catch (const NumericalError& error) {
                log_warning(fmt::format("bed {}: {}", bed, error.what()));
                failed.push_back({{"bed", bed}, {"error", error.what()}});
            }
        }
    std::vector<LastGrids> later;
    for (const CoverageRow& row : rows)
        if (is_later(row)) {
            const double truth = reference_of(row).value_m2;
            later.push_back({.nodes = row.nodes,
                             .values = {row.values_m2[0] / truth, row.values_m2[1] / truth, row.values_m2[2] / truth},
                             .grains = grains_of_random_bed(row.bed, row.porosity),
                             .other_half_width = row.other_half_width});
        }
    double seconds = 0.0;
    std::vector<double> references;
    for (const CoverageRow& row : rows) {
        seconds += row.seconds;
        references.push_back(reference_of(row).half_width);
    }
    std::sort(references.begin(), references.end());
    return {{"rows", rows.size()},
            {"beds_without_result", failed},
            {"half_width_of_the_references",
             {{"median", references.empty() ? 0.0 : references[references.size() / 2]},
              {"largest", references.empty() ? 0.0 : references.back()}}},
            {"seconds_of_the_runs", seconds},
            {"to_fit", to_json(coverage_of(rows, {}, is_first))},
            {"to_judge", to_json(coverage_of(rows, {}, is_later))},
            {"judge_with_other_constants", with_other_constants(later)}};
}

}  // namespace porepack::benchmarks
