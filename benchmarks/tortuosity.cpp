// Parameters of the paper's tortuosity, and error against seconds of the others.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "report/plot.hpp"
#include "stages/stages.hpp"
#include "support/known_flows.hpp"
#include "tortuosity/tortuosity.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Bed {
    std::string name;
    Packing packing;
    Section section;
    double porosity = 0.0;
};

// Spheres of 5 mm without contact, at random positions.
Bed separate_spheres(double share) {
    Bed bed{.name = fmt::format("separate spheres, {:.2f}", 1.0 - share), .packing = {}, .section = {0.0, 0.1}};
    bed.packing.container = parse_container("box:0.1,0.1,0.1:periodic");
    const double r = 0.0025;
    bed.packing.shapes = {make_preset(ShapeKind::sphere, 2.0 * r, 0.0)};
    const auto count = static_cast<std::size_t>(share * 1e-3 / (4.0 / 3.0 * std::numbers::pi * r * r * r));
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> place(0.0, 0.1);
    std::vector<std::vector<Vec3>> cells(20 * 20 * 20);
    const auto cell = [](int x, int y, int z) {
        return static_cast<std::size_t>(((z + 20) % 20 * 20 + (y + 20) % 20) * 20 + (x + 20) % 20);
    };
    while (bed.packing.bodies.size() < count) {
        const Vec3 at(place(random), place(random), place(random));
        const int x = static_cast<int>(at.x() / 0.005), y = static_cast<int>(at.y() / 0.005), z = static_cast<int>(at.z() / 0.005);
        bool free = true;
        for (int i = -1; i <= 1 && free; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k)
                    for (const Vec3& other : cells[cell(x + i, y + j, z + k)]) {
                        Vec3 between = at - other;
                        for (int a = 0; a < 3; ++a) between[a] -= 0.1 * std::round(between[a] / 0.1);
                        free = free && between.norm() > 2.0 * r;
                    }
        if (!free) continue;
        cells[cell(x, y, z)].push_back(at);
        bed.packing.bodies.push_back({.shape = 0, .position_m = at});
    }
    return bed;
}

Bed settled(const char* name, const char* file) {
    Bed bed{.name = name, .packing = read_packing(data_file("cases/paper_packing/settled") / file), .section = {0.03, 0.13}};
    return bed;
}

double limit_for_separate_spheres(double eps) {
    return 1.0 + (1.0 - eps) * (3.0 * std::numbers::pi / 8.0 - 1.0);
}

// The paper's method on one bed: as published, then with one parameter changed at a time.
Json study(const Bed& bed) {
    const Grains grains(bed.packing);
    const auto value = [&](TortuosityConfig config) {
        const GeometricPaperResult result = geometric_paper_exact(grains, bed.packing.container, bed.section, config);
        return Json{
            {"value", result.value}, {"standard_error", result.standard_error}, {"rejections_per_point", result.rejections_per_point}};
    };
    Json json = {{"bed", bed.name}, {"porosity", bed.porosity}, {"exact", value({})}};
    for (const double pixel : {5e-5, 1e-4, 2e-4, 4e-4})
        json["pixel"].push_back({{"pixel_m", pixel}, {"result", value({.dot_pixel_m = pixel})}});
    for (const double slice : {5e-5, 1e-4, 2e-4, 4e-4, 8e-4}) {
        json["slice"].push_back({{"slice_spacing_m", slice},
                                 {"exact", value({.slice_spacing_m = slice})},
                                 {"pixel_of_0.2_mm", value({.slice_spacing_m = slice, .dot_pixel_m = 2e-4})}});
    }
    for (const double dots : {0.0025, 0.005, 0.01})
        json["dots"].push_back({{"dot_spacing_m", dots}, {"exact", value({.dot_spacing_m = dots})}});
    log_info("{}: porosity {:.3f}, exact {:.4f}", bed.name, bed.porosity, json["exact"]["value"].get<double>());
    return json;
}

void draw_study(const Path& folder, const Json& beds) {
    std::string pixels, porosities;
    for (const Json& bed : beds) {
        const double exact = bed["exact"]["value"].get<double>();
        pixels += fmt::format("\"{}\"\n0 {:.5f}\n", bed["bed"].get<std::string>(), exact);
        porosities += fmt::format("{:.4f} {:.5f}", bed["porosity"].get<double>(), exact);
        for (const Json& row : bed["pixel"]) {
            pixels += fmt::format("{:g} {:.5f}\n", 1e3 * row["pixel_m"].get<double>(), row["result"]["value"].get<double>());
            porosities += fmt::format(" {:.5f}", row["result"]["value"].get<double>());
        }
        pixels += "\n\n";
        porosities += "\n";
    }
    write_text(folder / "pixels.dat", pixels);
    write_text(folder / "porosities.dat", porosities);
    draw_plot(folder / "tortuosity_study.svg", "tortuosity_study", {{"beds", static_cast<double>(beds.size())}},
              {.width = 900, .height = 400});
}

// From an axis point at distance D before a sphere's centre to the plane at D behind it.
Json shortest_path_errors() {
    const double R = 0.9973, D = 1.2;
    const double exact = (std::sqrt(D * D - R * R) + R * std::asin(R / D) + D) / (2.0 * D);
    Packing packing{
        .container = parse_container("box:2.4,2.4,2.4"), .shapes = {make_preset(ShapeKind::sphere, 2.0 * R, 0.0)}, .bodies = {}};
    packing.bodies.push_back({.position_m = Vec3::Constant(1.2)});
    const PoreSpace space = pore_space_of(packing).with_section({0.0, 2.4});
    Json rows = Json::array();
    for (const int n : {5, 10, 20, 40}) {
        Stopwatch watch;
        const double taut = shortest_path(space, 1.0 / n, Axis::z, 100000).maximum / exact - 1.0;
        const double taut_seconds = watch.seconds();
        watch = {};
        const double voxels = shortest_path(space.voxelise_at(1.0 / n), 2, {false, false, false}).maximum / exact - 1.0;
        rows.push_back({{"voxels_per_radius", n},
                        {"error_exact_grains", taut},
                        {"seconds_exact_grains", taut_seconds},
                        {"error_voxels", voxels},
                        {"seconds_voxels", watch.seconds()}});
    }
    return rows;
}

Json diffusive_errors() {
    // Sangani & Acrivos 1983, insulating spheres in simple cubic order, solid fraction 0.343.
    const double f = 0.343;
    const auto L = [](int i) { return -(2.0 * i - 1.0) / (2.0 * i); };
    const double D =
        1.0 - 3.0 * f /
                  (2.0 + f +
                   1.3047 * L(2) * std::pow(f, 10.0 / 3.0) * (1.0 + 0.2305 * L(3) * std::pow(f, 11.0 / 3.0)) /
                       (1.0 - 0.4054 * L(2) * std::pow(f, 7.0 / 3.0)) +
                   0.07231 * L(3) * std::pow(f, 14.0 / 3.0) + 0.1526 * L(4) * std::pow(f, 6.0) + 0.0105 * L(5) * std::pow(f, 22.0 / 3.0));
    const double exact = (1.0 - f) / D;
    Json rows = Json::array();
    for (const int n : {10, 20, 40, 80}) {
        const PoreSpace space = test::sphere_array(f, 1.0, test::simple_cubic(), Vec3(0.13, 0.27, 0.41)).space();
        const auto run = [&](const char* walls, const auto& solve) {
            const Stopwatch watch;
            const DiffusiveResult result = solve();
            rows.push_back({{"walls", walls},
                            {"voxels_per_side", n},
                            {"error", result.value / exact - 1.0},
                            {"iterations", result.iterations},
                            {"seconds", watch.seconds()}});
        };
        const std::array<bool, 3> around = {true, true, true};
        run("exact", [&] { return diffusive_on_grid(space, 1.0 / n, Axis::z, {.porosity = 1.0 - f}); });
        run("voxels", [&] { return diffusive_tortuosity(space.voxelise_at(1.0 / n), 2, around); });
    }
    return rows;
}

// Basis of three of the values, on the packing of tetrapods: paths and concentration seen along y.
void draw_kinds(const Path& folder, const Bed& bed) {
    const Grains grains(bed.packing);
    const Section section{0.03, 0.09};
    const auto lines = [&](const char* file, const std::vector<std::vector<Vec3>>& ways) {
        std::string text;
        for (const auto& way : ways) {
            if (std::abs(way.front().y()) > 0.012) continue;
            for (const Vec3& point : way) text += fmt::format("{:.3f} {:.3f}\n", 1e3 * point.x(), 1e3 * point.z());
            text += "\n";
        }
        write_text(folder / file, text);
    };
    lines("paths_geometric.dat", geometric_paper_exact(grains, bed.packing.container, section, {}).paths_m);
    const PoreSpace space = pore_space_of(bed.packing).with_section(section);
    lines("paths_shortest.dat", shortest_path(space, 5e-4, Axis::z).paths_m);
    const PhaseImage image = space.voxelise_at(5e-4);
    const DiffusiveResult diffusion = diffusive_on_grid(space, 5e-4, Axis::z);
    std::string text;
    const int j = image.grid.cells[1] / 2;
    for (int k = 0; k < image.grid.cells[2]; ++k) {
        for (int i = 0; i < image.grid.cells[0]; ++i) {
            const std::size_t cell = image.grid.index(i, j, k);
            text += image.phase[cell] == Phase::pore
                        ? fmt::format("{:.2f} {:.2f} {:.4f}\n", 1e3 * image.grid.centre(0, i), 1e3 * image.grid.centre(2, k),
                                      diffusion.concentration[cell])
                        : fmt::format("{:.2f} {:.2f} NaN\n", 1e3 * image.grid.centre(0, i), 1e3 * image.grid.centre(2, k));
        }
        text += "\n";
    }
    write_text(folder / "concentration.dat", text);
    draw_plot(folder / "tortuosity_kinds.png", "tortuosity_kinds", {}, {.width = 550, .height = 165, .font = 6});
}

}  // namespace

Json tortuosity_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("tortuosity_study") : output;
    make_folder(folder);
    std::vector<Bed> beds = {separate_spheres(0.1), separate_spheres(0.3)};
    if (!quick)
        for (const auto& [name, file] :
             {std::pair("tetrapods, 0.53", "tetrapod_053.json.gz"), std::pair("tetrapods, 0.81", "tetrapod_081.json.gz"),
              std::pair("tetrapods, 0.87", "tetrapod_087.json.gz"), std::pair("tetrahedra, 0.74", "tetrahedron_074.json.gz")})
            beds.push_back(settled(name, file));
    Json studies = Json::array();
    for (Bed& bed : beds) {
        bed.porosity = porosity(Grains(bed.packing), bed.packing.container, bed.section).value;
        studies.push_back(study(bed));
        studies.back()["limit_for_separate_spheres"] = limit_for_separate_spheres(bed.porosity);
        studies.back()["the_papers_equation_20"] = -2.4 * bed.porosity + 3.27;
    }
    draw_study(folder, studies);
    if (!quick) draw_kinds(folder, beds[2]);
    return {{"geometric_paper", studies},
            {"shortest_path_past_a_sphere", shortest_path_errors()},
            {"diffusive_simple_cubic", diffusive_errors()}};
}

}  // namespace porepack::benchmarks
