// Coverage of the interval of `tolerance`: every flow of known answer, at several tolerances.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "benchmarks/coverage_rows.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "support/known_flows.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0 : values[values.size() / 2];
}

}  // namespace

Json coverage_benchmark(const std::vector<unsigned>& seeds, const std::vector<double>& tolerances) {
    Json cases = Json::array(), summary = Json::array();
    std::vector<LastGrids> runs;
    for (const double tolerance : tolerances) {
        std::vector<double> errors, half_widths;
        int covered = 0, reached = 0, solved = 0;
        double seconds = 0.0;
        for (const unsigned seed : seeds)
            for (const KnownFlow& known : random_known_flows(seed)) {
                const Stopwatch watch;
                try {
                    const LbmResult result =
                        lbm_permeability(known.space(), 0.1, {.direction = known.direction, .tolerance = tolerance, .max_time_s = 25.0});
                    if (!result.half_width) continue;
                    const double error = result.permeability_m2 / known.permeability_m2 - 1.0;
                    const double half = result.half_width->sum() / result.permeability_m2;
                    log_info("{}: error {:+.2f} %, half width {:.2f} %, {:.1f} s", known.name, 100.0 * error, 100.0 * half,
                             watch.seconds());
                    ++solved;
                    covered += std::abs(error) <= half ? 1 : 0;
                    reached += result.stopped_by.empty() ? 1 : 0;
                    errors.push_back(std::abs(error));
                    half_widths.push_back(half);
                    seconds += watch.seconds();
                    if (result.grids.size() >= 3) {
                        LastGrids run{.grains = grains_of(known.space(), result.fine()), .other_half_width = other_half_width(result)};
                        for (std::size_t i = 0; i < 3; ++i) {
                            const LbmGridResult& grid = result.grids[result.grids.size() - 3 + i];
                            run.nodes[i] = known.diameter_m / grid.voxel_size_m;
                            run.values[i] = grid.permeability_m2 / known.permeability_m2;
                        }
                        runs.push_back(run);
                    }
                    Json errors_on_grids = Json::array();
                    for (const LbmGridResult& grid : result.grids)
                        errors_on_grids.push_back(
                            {known.diameter_m / grid.voxel_size_m, grid.permeability_m2 / known.permeability_m2 - 1.0});
                    cases.push_back({{"tolerance", tolerance},
                                     {"case", known.name},
                                     {"error", error},
                                     {"half_width", half},
                                     {"covered", std::abs(error) <= half},
                                     {"nodes_per_diameter_and_error_of_grids", errors_on_grids},
                                     {"nodes_per_diameter", known.diameter_m / result.fine().voxel_size_m},
                                     {"seconds", watch.seconds()}});
                } catch (const Error& error) {
                    log_warning(fmt::format("{}: {}", known.name, error.what()));
                }
            }
        summary.push_back({{"tolerance", tolerance},
                           {"cases", solved},
                           {"tolerance_reached", reached},
                           {"covered", static_cast<double>(covered) / std::max(1, solved)},
                           {"median_error", median(errors)},
                           {"median_half_width", median(half_widths)},
                           {"seconds", seconds}});
    }
    return {{"summary", summary}, {"with_other_constants", with_other_constants(runs)}, {"cases", cases}};
}

}  // namespace porepack::benchmarks
