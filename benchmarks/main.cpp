// The program `porepack_benchmark`: measurements without pass or fail. `porepack benchmark ...` calls it.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/build.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "core/passive_waiting.hpp"

namespace porepack::benchmarks {
namespace {

struct Request {
    std::string name;
    std::vector<std::string> cases;
    Path folder;
    bool quick = false;
    std::optional<unsigned> seed;
};

struct Benchmark {
    const char* name;
    Json (*run)(const Request&);
};

std::vector<Path> paths(const std::vector<std::string>& names) {
    return {names.begin(), names.end()};
}

constexpr Benchmark benchmarks[] = {
    {"coverage",
     [](const Request& r) {
         if (r.seed) return coverage_seed_benchmark(*r.seed, r.quick ? 4 : 100);
         if (r.cases.size() > 1) return coverage_checks_benchmark(r.cases[0], r.cases[1], r.folder);
         if (!r.cases.empty()) return coverage_random_benchmark(r.cases.front(), !r.quick, r.folder);
         return coverage_benchmark({9, 10}, {0.02, 0.01, 0.005});
     }},
    {"cross-check", [](const Request& r) { return cross_check_benchmark(paths(r.cases), r.folder); }},
    {"design-scatter", [](const Request& r) { return design_scatter_benchmark(r.cases); }},
    {"foam", [](const Request& r) { return foam_benchmark(r.folder); }},
    {"gray", [](const Request& r) { return gray_benchmark(r.quick); }},
    {"inertia", [](const Request& r) { return inertia_benchmark(r.quick, r.folder); }},
    {"iteration", [](const Request& r) { return iteration_benchmark(r.quick, r.folder); }},
    {"lbm", [](const Request& r) { return lbm_benchmark(r.quick, r.folder); }},
    {"memory", [](const Request& r) { return memory_benchmark(r.quick, r.cases, r.folder); }},
    {"multigrid", [](const Request& r) { return multigrid_benchmark(r.cases, r.quick); }},
    {"packing", [](const Request& r) { return packing_benchmark(r.cases, r.quick, r.folder); }},
    {"fit", [](const Request& r) { return fit_benchmark(r.quick, r.folder); }},
    {"segment", [](const Request& r) { return segment_benchmark(r.quick, r.folder); }},
    {"section", [](const Request& r) { return section_benchmark(r.cases, r.quick, r.folder); }},
    {"section-scatter", [](const Request& r) { return section_scatter_benchmark(r.folder); }},
    {"shapes", [](const Request&) { return shapes_benchmark(); }},
    {"slabs", [](const Request& r) { return slabs_benchmark(r.quick); }},
    {"speed-error", [](const Request& r) { return speed_error_benchmark(r.quick, r.folder); }},
    {"stopping", [](const Request& r) { return stopping_benchmark(r.cases); }},
    {"tortuosity", [](const Request& r) { return tortuosity_benchmark(r.quick, r.folder); }},
};

Json run(const Request& request) {
    std::vector<std::string> names;
    for (const Benchmark& benchmark : benchmarks) {
        names.emplace_back(benchmark.name);
        if (request.name != benchmark.name) continue;
        if (request.seed && (request.name != "coverage" || !request.cases.empty()))
            throw UserError("--seed has no effect here", {.fix = "porepack_benchmark coverage --seed N, without a file"});
        if (!request.folder.empty()) require_writable(request.folder);
        Json result = benchmark.run(request);
        result["machine"] = processor_name();
        result["threads"] = thread_count();
        result["git_hash"] = git_hash();
        if (!request.folder.empty()) write_json(request.folder / (request.name + ".json"), result);
        return result;
    }
    throw UserError("no such benchmark: " + request.name, {.allowed = fmt::format("{}", fmt::join(names, ", "))});
}

int main_or_throw(int argc, char** argv) {
    CLI::App app("Measurements of porepack: values without pass or fail.", "porepack_benchmark");
    Request request;
    std::string folder;
    int threads = 0;
    bool json = false;
    app.add_option("name", request.name,
                   "coverage, cross-check, design-scatter, fit, foam, gray, inertia, iteration, lbm, memory, multigrid, packing, section, "
                   "section-scatter, segment, shapes, speed-error, stopping, tortuosity")
        ->required();
    app.add_option("cases", request.cases,
                   "for cross-check: folders with case.toml; for packing: parts (engines, grains_with_faces, spheres_of_320_faces; "
                   "default: all); for section: parts (arrays, lengths, plane_pressures, slices_053, slices_087); for coverage: a CSV file "
                   "of rows on random packings, to which the missing ones are added (--quick: none), and a second one for checks of their "
                   "references; for design-scatter: study.csv of studies; for stopping: seeds.csv of "
                   "studies, whose packings are resampled; for memory: a number of fluid nodes (one run, porosity 0.7, single precision); "
                   "for multigrid: packing.json files");
    app.add_option("--output", folder, "folder for <name>.json and figures");
    app.add_option("--threads", threads, "threads of parallel loops (default: OMP_NUM_THREADS, else the cores that this process may use)")
        ->check(CLI::Range(1, 1024));
    app.add_option(
        "--seed", request.seed,
        "for coverage: draws 100 cases of known answer (--quick: 4) of each kind of interval (k with exact, gray and bounce-back "
        "walls, tortuosity factor, falling head), and counts how many intervals hold the answer");
    app.add_flag("--quick", request.quick,
                 "for coverage, fit, gray, iteration, lbm, memory, multigrid, packing, section, segment, speed-error and tortuosity: "
                 "minutes instead "
                 "of half an hour");
    app.add_flag("--json", json, "accepted for compatibility: the result is always JSON");
    app.footer("Example:\n  porepack_benchmark lbm --output lbm_speed");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& fault) {
        if (fault.get_exit_code() == 0) return app.exit(fault);
        throw UserError(fault.what(), {.fix = "porepack_benchmark --help shows what is allowed"});
    }
    set_thread_count(threads);
    request.folder = folder;
    fmt::print("{}\n", run(request).dump(2));
    return 0;
}

}  // namespace
}  // namespace porepack::benchmarks

int main(int argc, char** argv) {
    porepack::core::wait_passively(argv);
    porepack::core::return_large_blocks();
    porepack::core::install_signal_handlers();
    try {
        return porepack::benchmarks::main_or_throw(argc, argv);
    } catch (const porepack::core::Error& error) {
        fmt::print(stderr, "error: {}\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& fault) {
        fmt::print(stderr, "error: {}\n", fault.what());
        return static_cast<int>(porepack::core::ExitCode::machine);
    }
}
