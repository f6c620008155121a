// The estimated iteration error of k against the true one, on random flows that are slow to become steady.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/json.hpp"
#include "core/parallel.hpp"
#include "core/table.hpp"
#include "support/inertial_runs.hpp"
#include "support/slow_flows.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

// Where runs end, and how far they are from the steady flow there.
class Stops {
public:
    // Nothing where the run does not end, or has no steady flow to compare with.
    std::optional<SlowRun::Stop> add(const SlowRun& run, double tolerance) {
        const std::optional<SlowRun::Stop> stop = run.stop(tolerance);
        if (!stop || !run.constant) return std::nullopt;
        ratios_.push_back(stop->estimate / std::max(stop->error, 1e-12));
        steps_.push_back(static_cast<double>(stop->steps));
        return stop;
    }
    [[nodiscard]] Json json() {
        if (ratios_.empty()) return {{"runs", 0}};
        const auto share = [&](double least) {
            return static_cast<double>(std::count_if(ratios_.begin(), ratios_.end(), [&](double r) { return r >= least; })) /
                   static_cast<double>(ratios_.size());
        };
        std::sort(ratios_.begin(), ratios_.end());
        std::sort(steps_.begin(), steps_.end());
        return {{"runs", ratios_.size()},
                {"error_within_estimate", share(1.0)},
                {"error_within_twice_the_estimate", share(0.5)},
                {"error_within_five_times_the_estimate", share(0.2)},
                {"median_estimate_over_error", ratios_[ratios_.size() / 2]},
                {"median_steps", steps_[steps_.size() / 2]}};
    }

private:
    std::vector<double> ratios_, steps_;
};

constexpr double tolerances[] = {1e-2, 1e-3, 1e-4};

Json of_creeping_flows(bool quick, const Path& file) {
    Table table({"flow", "nodes", "tau", "single", "from_coarser_grid", "tolerance", "steps", "estimate", "error"});
    Stops stops;
    long not_steady = 0;
    for (const unsigned seed : {2, 3}) {
        const std::vector<SlowFlow> flows = random_slow_flows(seed, quick ? 20 : 100);
        std::vector<SlowRun> runs(flows.size());
        // One flow per thread: they are small.
        parallel_for(flows.size(), [&](std::size_t i) { runs[i] = run_until_constant(flows[i], 60000); });
        for (std::size_t i = 0; i < flows.size(); ++i) {
            const SlowFlow& flow = flows[i];
            if (!runs[i].constant) ++not_steady;
            for (const double tolerance : tolerances)
                if (const auto stop = stops.add(runs[i], tolerance))
                    table.add(flow.name, runs[i].nodes, flow.relaxation_time, flow.precision == Precision::single_precision ? 1 : 0,
                              flow.from_coarser_grid ? 1 : 0, tolerance, stop->steps, stop->estimate, stop->error);
        }
    }
    table.write(file);
    Json result = stops.json();
    result["flows_not_constant"] = not_steady;
    return result;
}

Json of_flows_with_inertia(bool quick, const Path& file) {
    Table table({"flow", "nodes", "reynolds", "tolerance", "steps", "estimate", "error"});
    Stops stops;
    for (const InertialRun& flow : random_inertial_runs(11, quick ? 4 : 16, 18.0, 1e-6))
        for (const double tolerance : tolerances)
            if (const auto stop = stops.add(flow.run, tolerance))
                table.add(flow.name, flow.run.nodes, flow.reynolds, tolerance, stop->steps, stop->estimate, stop->error);
    table.write(file);
    return stops.json();
}

}  // namespace

Json iteration_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("iteration_study") : output;
    make_folder(folder);
    return {{"creeping_flow", of_creeping_flows(quick, folder / "iteration.csv")},
            {"with_inertia", of_flows_with_inertia(quick, folder / "iteration_with_inertia.csv")}};
}

}  // namespace porepack::benchmarks
