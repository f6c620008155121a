// Error against cost of every method for a permeability: both solvers and the paper's scheme, on flows of known answer and on a packing.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/table.hpp"
#include "openfoam/foam.hpp"
#include "pore_space/pore_space.hpp"
#include "report/plot.hpp"
#include "stages/stages.hpp"
#include "study/case_pipeline.hpp"
#include "support/known_flows.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

double cpu_seconds() {
    double sum = 0.0;
    for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
        rusage usage{};
        getrusage(who, &usage);
        sum += static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
               1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
    }
    return sum;
}

// A flow to solve, with an exact answer or that of a fine grid.
struct Target {
    std::string name;
    Packing packing;
    Section section;
    double grain_size_m = 0.0, permeability_m2 = 0.0;
    bool exact = true, with_foam = true;
};

struct Row {
    std::string target, method, resolution;
    double error = 0.0, wall_s = 0.0, core_s = 0.0, peak_memory_bytes = 0.0;
    bool exact = true;
};

template <typename Solve>
void add_row(std::vector<Row>& rows, const Target& target, const std::string& method, const std::string& resolution, const Solve& solve) {
    reset_peak_memory();
    const Stopwatch watch;
    const double before = cpu_seconds();
    try {
        double memory = 0.0;
        const double k = solve(memory);
        rows.push_back({target.name, method, resolution, k / target.permeability_m2 - 1.0, watch.seconds(), cpu_seconds() - before,
                        std::max(memory, peak_memory_bytes()), target.exact});
        log_info("{}, {}, {}: error {:+.2f} %, {:.3g} core seconds", target.name, method, resolution, 100.0 * rows.back().error,
                 rows.back().core_s);
    } catch (const Error& error) {
        log_warning(fmt::format("{}, {}, {}: {}", target.name, method, resolution, error.what()));
    }
}

PoreSpace space_of(const Target& target) {
    return pore_space_of(target.packing).with_section(target.section);
}

void add_lbm(std::vector<Row>& rows, const Target& target) {
    const PoreSpace space = space_of(target);
    struct Kind {
        const char* name;
        Walls walls;
        Collision collision;
        long grids;
    };
    for (const Kind& kind : {Kind{"LBM, interpolated walls", Walls::interpolated, Collision::trt, 3},
                             {"LBM, bounce-back", Walls::bounce_back, Collision::trt, 3},
                             {"the paper's LBM (BGK)", Walls::bounce_back, Collision::bgk, 1}})
        for (const double nodes : {10.0, 20.0, 40.0}) {
            // On a packing the next finer grid takes a quarter of an hour.
            if (!target.exact && nodes > (kind.collision == Collision::bgk ? 10.0 : 20.0)) continue;
            add_row(rows, target, kind.name, fmt::format("{:g} nodes per diameter", nodes), [&](double&) {
                const LbmResult result =
                    lbm_permeability(space, target.grain_size_m / nodes,
                                     {.walls = kind.walls, .collision = kind.collision, .iteration_tolerance = 1e-4, .grids = kind.grids});
                return result.fine().permeability_m2;
            });
        }
    for (const double tolerance : {0.05, 0.01, 0.005, 0.0025}) {
        if (tolerance < 0.005 && !target.exact) continue;
        add_row(rows, target, "LBM, to a tolerance", fmt::format("{:g}", tolerance),
                [&](double&) { return lbm_permeability(space, target.grain_size_m / 10.0, {.tolerance = tolerance}).permeability_m2; });
    }
}

void add_foam(std::vector<Row>& rows, const Target& target, bool quick, const Path& folder) {
    const FoamScene scene = foam_scene_of(target.packing, target.section, target.grain_size_m);
    std::vector<double> cells, values;
    double wall = 0.0, core = 0.0;
    // Each capsule of a packing spans many cells; a cell of one fifth of its diameter is already fine.
    for (const double across : target.exact ? std::vector<double>{14.0, 20.0, 28.0, 40.0} : std::vector<double>{3.0, 4.2, 6.0, 8.4}) {
        if (quick && across > 28.0) continue;
        const std::size_t before = rows.size();
        add_row(rows, target, "OpenFOAM", fmt::format("{:g} cells per diameter", across), [&](double& memory) {
            const FoamResult result = foam_permeability(scene, {.meshes = 1}, target.grain_size_m / across, data_file("openfoam_cases"),
                                                        folder / fmt::format("{}_{:g}", target.name, across));
            cells.push_back(static_cast<double>(result.fine().cells));
            values.push_back(result.permeability_m2);
            memory = result.fine().peak_memory_bytes;
            return result.permeability_m2;
        });
        if (rows.size() == before) continue;
        wall += rows.back().wall_s;
        core += rows.back().core_s;
        if (cells.size() < 3) continue;
        Row together = rows.back();
        const auto last = [](const std::vector<double>& list) { return std::span(list).last(3); };
        together.method = "OpenFOAM, three meshes";
        together.error = extrapolate_meshes(last(cells), last(values)).value / target.permeability_m2 - 1.0;
        together.wall_s = wall;
        together.core_s = core;
        rows.push_back(together);
    }
}

// The cheapest method with errors below `limit` on all flows with an exact answer to which it was applied, and at least two of them if
// there are.
std::string sentence(const std::vector<Row>& rows, double limit) {
    struct Way {
        double worst = 0.0, core = 0.0;
        std::set<std::string> targets;
    };
    std::map<std::pair<std::string, std::string>, Way> ways;
    std::set<std::string> targets;
    for (const Row& row : rows) {
        if (!row.exact) continue;
        Way& way = ways[{row.method, row.resolution}];
        way.worst = std::max(way.worst, std::abs(row.error));
        way.core += row.core_s;
        way.targets.insert(row.target);
        targets.insert(row.target);
    }
    const auto cheapest = [&](const std::string& prefix) {
        const std::pair<const std::pair<std::string, std::string>, Way>* best = nullptr;
        for (const auto& way : ways)
            if (way.first.first.starts_with(prefix) && way.second.worst <= limit &&
                way.second.targets.size() >= std::min<std::size_t>(2, targets.size()) &&
                (best == nullptr || way.second.core / static_cast<double>(way.second.targets.size()) <
                                        best->second.core / static_cast<double>(best->second.targets.size())))
                best = &way;
        return best;
    };
    const auto told = [&](const auto* way) {
        return fmt::format("{} ({}): {:.2g} core seconds per flow", way->first.first, way->first.second,
                           way->second.core / static_cast<double>(way->second.targets.size()));
    };
    const auto* best = cheapest("");
    if (best == nullptr) return fmt::format("For {:g} %: none of these methods.", 100.0 * limit);
    std::string text = fmt::format("For {:g} % the cheapest is {}", 100.0 * limit, told(best));
    const auto* foam = cheapest("OpenFOAM");
    text += foam != nullptr && foam != best ? fmt::format("; {}", told(foam)) : "; OpenFOAM does not reach it here";
    const auto* paper = cheapest("the paper's");
    return text + (paper != nullptr ? fmt::format("; {}.", told(paper)) : "; the paper's scheme does not reach it here.");
}

void draw(const std::vector<Row>& rows, const Path& folder) {
    std::vector<std::string> targets, methods;
    for (const Row& row : rows) {
        if (std::find(targets.begin(), targets.end(), row.target) == targets.end()) targets.push_back(row.target);
        if (std::find(methods.begin(), methods.end(), row.method) == methods.end()) methods.push_back(row.method);
    }
    // One block per method that ran on a target, and last the Pareto-optimal points; gnuplot reads the blocks of target t from
    // first_blocks[t] on. A word of a list contains no space.
    std::string data, target_names, first_blocks = "0";
    std::size_t blocks = 0;
    const auto add_block = [&](const std::string& title, const std::vector<std::pair<double, double>>& list) {
        data += fmt::format("\"{}\"\n", title);
        for (const auto& [x, y] : list) data += fmt::format("{:.6g} {:.6g}\n", x, y);
        data += "\n\n";
        ++blocks;
    };
    for (const std::string& target : targets) {
        std::vector<std::pair<double, double>> points;
        for (const std::string& method : methods) {
            std::vector<std::pair<double, double>> list;
            for (const Row& row : rows)
                if (row.target == target && row.method == method)
                    list.emplace_back(row.core_s, std::max(1e-3, 100.0 * std::abs(row.error)));
            if (list.empty()) continue;
            points.insert(points.end(), list.begin(), list.end());
            std::sort(list.begin(), list.end());
            add_block(method, list);
        }
        std::sort(points.begin(), points.end());
        std::vector<std::pair<double, double>> front;
        for (const auto& point : points)
            if (front.empty() || point.second < front.back().second) front.push_back(point);
        add_block("Pareto front", front);
        std::string word = target;
        std::replace(word.begin(), word.end(), ' ', '~');
        target_names += word + " ";
        first_blocks += fmt::format(" {}", blocks);
    }
    write_text(folder / "speed_error.dat", data);
    for (const char* picture : {"speed_error.svg", "speed_error.png"})
        draw_plot(folder / picture, "speed_error",
                  {{"targets", static_cast<double>(targets.size())}, {"target_names", target_names}, {"first_blocks", first_blocks}},
                  {.width = 1000, .height = 460 * static_cast<int>((targets.size() + 1) / 2)});
}

}  // namespace

Json speed_error_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("speed_error") : output;
    make_folder(folder);
    std::vector<Target> targets;
    const auto add_array = [&](const char* name, KnownFlow flow) {
        targets.push_back({name,
                           flow.packing,
                           {0.0, 1.0},
                           flow.diameter_m,
                           flow.permeability_m2,
                           true,
                           std::string(name).find("touching") == std::string::npos});
    };
    // At a position on the grid that favours no solver.
    const Vec3 place(0.21, 0.37, 0.11);
    add_array("simple cubic 0.343", sphere_array(0.343, 15.39949, simple_cubic(), place));
    add_array("body-centred 0.6", sphere_array(0.6, 88.8734, body_centred(), place));
    if (!quick) {
        add_array("simple cubic touching", sphere_array(std::acos(-1.0) / 6.0, 42.1005, simple_cubic(), place));
        Case c = read_case(data_file("cases/cross_check"));
        c.output = folder / "packing";
        (void)run_pipeline(case_pipeline(c), "pack");
        Target bed{"tetrapods 0.53", read_packing(c.results() / "pack" / "packing.json"), {}, 0.0, 0.0, false, true};
        bed.section = {c.settings.geometry.section_m.at(0), c.settings.geometry.section_m.at(1)};
        bed.grain_size_m = smallest_diameter(bed.packing.shapes.front());
        bed.permeability_m2 = lbm_permeability(space_of(bed), bed.grain_size_m / 10.0, {.tolerance = 0.004}).permeability_m2;
        targets.push_back(bed);
    }
    std::vector<Row> rows;
    for (const Target& target : targets) {
        add_lbm(rows, target);
        if (target.with_foam) add_foam(rows, target, quick, folder / "openfoam");
    }
    Json list = Json::array(), sentences = Json::array();
    Table table({"case", "method", "resolution", "error", "wall_s", "core_s", "peak_memory_bytes"});
    table.digits = 6;
    for (const Row& row : rows) {
        list.push_back({{"case", row.target},
                        {"method", row.method},
                        {"resolution", row.resolution},
                        {"error", row.error},
                        {"wall_s", row.wall_s},
                        {"core_s", row.core_s},
                        {"peak_memory_bytes", row.peak_memory_bytes}});
        table.add(row.target, row.method, row.resolution, row.error, row.wall_s, row.core_s, row.peak_memory_bytes);
    }
    for (const double limit : {0.05, 0.01, 0.002}) sentences.push_back(sentence(rows, limit));
    table.write(folder / "speed_error.csv");
    draw(rows, folder);
    return {{"sentences", sentences}, {"rows", list}};
}

}  // namespace porepack::benchmarks
