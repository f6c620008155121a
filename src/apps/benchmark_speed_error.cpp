// Error against cost of every way to a permeability: both solvers and the paper's scheme, on flows of known answer and on a packing.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/benchmark.hpp"
#include "apps/pipeline.hpp"
#include "apps/stages.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "lbm/known.hpp"
#include "report/report.hpp"

namespace porepack {
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

// A flow to solve: exact answer or a fine one.
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

LbmScene lbm_scene(const Target& target, const Grains& grains) {
    return {.voxels =
                [&](double size) {
                    return voxelise(grains, target.packing.container, target.section,
                                    plan_voxels(target.packing.container, target.section, size, 0.0, 1.0));
                },
            .solid = &grains,
            .container = target.packing.container,
            .section = target.section,
            .grain_size_m = target.grain_size_m};
}

void add_lbm(std::vector<Row>& rows, const Target& target) {
    const Grains grains(target.packing);
    const LbmScene scene = lbm_scene(target, grains);
    struct Kind {
        const char *name, *walls, *collision;
        long grids;
    };
    for (const Kind& kind : {Kind{"LBM, interpolated walls", "interpolated", "trt", 3},
                             {"LBM, bounce-back", "bounce_back", "trt", 3},
                             {"the paper's LBM (BGK)", "bounce_back", "bgk", 1}})
        for (const double nodes : {10.0, 20.0, 40.0}) {
            // On a packing the next finer grid takes a quarter of an hour.
            if (!target.exact && nodes > (std::string(kind.collision) == "bgk" ? 10.0 : 20.0)) continue;
            add_row(rows, target, kind.name, fmt::format("{:g} nodes a diameter", nodes), [&](double&) {
                const LbmResult result = lbm_permeability(
                    scene, target.grain_size_m / nodes,
                    {.walls = kind.walls, .collision = kind.collision, .iteration_tolerance = 1e-4, .grids = kind.grids}, false);
                return result.fine().permeability_m2;
            });
        }
    for (const double tolerance : {0.05, 0.01, 0.005, 0.0025}) {
        if (tolerance < 0.005 && !target.exact) continue;
        add_row(rows, target, "LBM, to a tolerance", fmt::format("{:g}", tolerance), [&](double&) {
            return lbm_permeability(scene, target.grain_size_m / 10.0, {.tolerance = tolerance}, false).permeability_m2;
        });
    }
}

void add_foam(std::vector<Row>& rows, const Target& target, bool quick, const Path& folder) {
    const FoamScene scene = foam_scene(target.packing, target.section, target.grain_size_m);
    std::vector<double> cells, values;
    double wall = 0.0, core = 0.0;
    // Grains of a packing are capsules that many cells cross; a cell of a fifth of their diameter is fine already.
    for (const double across : target.exact ? std::vector<double>{14.0, 20.0, 28.0, 40.0} : std::vector<double>{3.0, 4.2, 6.0, 8.4}) {
        if (quick && across > 28.0) continue;
        const std::size_t before = rows.size();
        add_row(rows, target, "OpenFOAM", fmt::format("{:g} cells a diameter", across), [&](double& memory) {
            const FoamResult result =
                foam_permeability(scene, {.meshes = 1}, target.grain_size_m / across, home_folder() / "openfoam_cases",
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

// The cheapest way whose error is below `limit` on all flows with an exact answer that it was tried on, and at least two of them if
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
        return fmt::format("{} ({}): {:.2g} core seconds a flow", way->first.first, way->first.second,
                           way->second.core / static_cast<double>(way->second.targets.size()));
    };
    const auto* best = cheapest("");
    if (best == nullptr) return fmt::format("For {:g} %: none of these ways.", 100.0 * limit);
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
    const std::string file = "speed_error.dat";  // beside the script
    std::string data,
        commands = fmt::format(
            "set multiplot layout {},2\nset logscale xy\nset grid\nset key outside bottom center horizontal maxcols 3 samplen 1 "
            "font ',9'\nset xlabel 'core seconds'\nset ylabel 'error of k (%)'\nset yrange [0.01:100]\nset format x '%g'\n",
            (targets.size() + 1) / 2);
    std::size_t block = 0;
    for (const std::string& target : targets) {
        commands += fmt::format("set title '{}'\nplot 1 with lines dt 2 lc rgb 'gray' notitle", target);
        std::vector<std::pair<double, double>> points;
        const auto add_block = [&](const std::vector<std::pair<double, double>>& list, const std::string& style) {
            for (const auto& [x, y] : list) data += fmt::format("{:.6g} {:.6g}\n", x, y);
            data += "\n\n";
            commands += fmt::format(", '{}' index {} using 1:2 with {}", file, block++, style);
        };
        for (const std::string& method : methods) {
            std::vector<std::pair<double, double>> list;
            for (const Row& row : rows)
                if (row.target == target && row.method == method)
                    list.emplace_back(row.core_s, std::max(1e-3, 100.0 * std::abs(row.error)));
            if (list.empty()) continue;
            points.insert(points.end(), list.begin(), list.end());
            std::sort(list.begin(), list.end());
            add_block(list, fmt::format("linespoints pt 7 title \"{}\"", method));
        }
        std::sort(points.begin(), points.end());
        std::vector<std::pair<double, double>> front;
        for (const auto& point : points)
            if (front.empty() || point.second < front.back().second) front.push_back(point);
        add_block(front, "lines lw 8 lc rgb '#a0c0c0c0' title 'Pareto front'");
        commands += "\n";
    }
    write_text(folder / file, data);
    const double height = 460.0 * static_cast<double>((targets.size() + 1) / 2);
    for (const auto& [name, terminal] : {std::pair{"speed_error.svg", "svg size 1000,{} font 'DejaVu Sans,12' background 'white'"},
                                         {"speed_error.png", "pngcairo size 1000,{} font 'DejaVu Sans,10'"}})
        draw_plot(folder / name, fmt::format("set terminal {}\nset output '{}'\n", fmt::format(fmt::runtime(terminal), height), name) +
                                     commands + "unset multiplot\n");
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
    // At a place that favours no solver.
    const Vec3 place(0.21, 0.37, 0.11);
    add_array("simple cubic 0.343", sphere_array(0.343, 15.39949, simple_cubic, place));
    add_array("body-centred 0.6", sphere_array(0.6, 88.8734, body_centred, place));
    if (!quick) {
        add_array("simple cubic touching", sphere_array(std::acos(-1.0) / 6.0, 42.1005, simple_cubic, place));
        Case c = read_case(home_folder() / "cases" / "cross_check");
        c.output = folder / "packing";
        (void)run_case(c, "pack");
        Target bed{"tetrapods 0.53", read_packing(c.results() / "pack" / "packing.json"), {}, 0.0, 0.0, false, true};
        bed.section = {c.settings.geometry.section_m.at(0), c.settings.geometry.section_m.at(1)};
        bed.grain_size_m = smallest_diameter(bed.packing.shapes.front());
        const Grains grains(bed.packing);
        bed.permeability_m2 =
            lbm_permeability(lbm_scene(bed, grains), bed.grain_size_m / 10.0, {.tolerance = 0.004}, false).permeability_m2;
        targets.push_back(bed);
    }
    std::vector<Row> rows;
    for (const Target& target : targets) {
        add_lbm(rows, target);
        if (target.with_foam) add_foam(rows, target, quick, folder / "openfoam");
    }
    Json list = Json::array(), sentences = Json::array();
    std::string table = "case,method,resolution,error,wall_s,core_s,peak_memory_bytes\n";
    for (const Row& row : rows) {
        list.push_back({{"case", row.target},
                        {"method", row.method},
                        {"resolution", row.resolution},
                        {"error", row.error},
                        {"wall_s", row.wall_s},
                        {"core_s", row.core_s},
                        {"peak_memory_bytes", row.peak_memory_bytes}});
        table += fmt::format("{},\"{}\",{},{:.6g},{:.6g},{:.6g},{:.4g}\n", row.target, row.method, row.resolution, row.error, row.wall_s,
                             row.core_s, row.peak_memory_bytes);
    }
    for (const double limit : {0.05, 0.01, 0.002}) sentences.push_back(sentence(rows, limit));
    write_text(folder / "speed_error.csv", table);
    draw(rows, folder);
    return {{"sentences", sentences}, {"rows", list}};
}

}  // namespace porepack
