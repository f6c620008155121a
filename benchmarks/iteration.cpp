// The estimated iteration error of k against the true one, on random flows that are slow to become steady.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/json.hpp"
#include "core/table.hpp"
#include "support/slow_flows.hpp"

namespace porepack::benchmarks {
using namespace test;

Json iteration_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("iteration_study") : output;
    make_folder(folder);
    Table table({"flow", "nodes", "tau", "single", "from_coarser_grid", "tolerance", "steps", "estimate", "error"});
    std::vector<double> ratios, steps;
    long not_steady = 0;
    for (const unsigned seed : {2, 3}) {
        const std::vector<SlowFlow> flows = random_slow_flows(seed, quick ? 20 : 100);
        std::vector<SlowRun> runs(flows.size());
        // One flow per thread: they are small.
#pragma omp parallel for schedule(dynamic)
        for (std::size_t i = 0; i < flows.size(); ++i) runs[i] = run_until_constant(flows[i], 60000);
        for (std::size_t i = 0; i < flows.size(); ++i) {
            const SlowFlow& flow = flows[i];
            const SlowRun& run = runs[i];
            if (!run.constant) ++not_steady;
            for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
                const std::optional<SlowRun::Stop> stop = run.stop(tolerance);
                if (!stop || !run.constant) continue;
                table.add(flow.name, run.nodes, flow.relaxation_time, flow.precision == Precision::single_precision ? 1 : 0,
                          flow.from_coarser_grid ? 1 : 0, tolerance, stop->steps, stop->estimate, stop->error);
                ratios.push_back(stop->estimate / std::max(stop->error, 1e-12));
                steps.push_back(static_cast<double>(stop->steps));
            }
        }
    }
    table.write(folder / "iteration.csv");
    const auto share = [&](double least) {
        return static_cast<double>(std::count_if(ratios.begin(), ratios.end(), [&](double r) { return r >= least; })) /
               static_cast<double>(ratios.size());
    };
    std::sort(ratios.begin(), ratios.end());
    std::sort(steps.begin(), steps.end());
    return {{"runs", ratios.size()},
            {"flows_not_constant", not_steady},
            {"error_within_estimate", share(1.0)},
            {"error_within_twice_the_estimate", share(0.5)},
            {"error_within_five_times_the_estimate", share(0.2)},
            {"median_estimate_over_error", ratios[ratios.size() / 2]},
            {"median_steps", steps[steps.size() / 2]}};
}

}  // namespace porepack::benchmarks
