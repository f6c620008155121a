#include "apps/sweep.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/parallel.hpp"
#include "report/report.hpp"
#include "shapes/shape.hpp"

namespace porepack {
namespace {

constexpr const char* kinds[] = {"tetrahedron", "dolos", "tetrapod"};

// Five of each kind in rows, side by side, as one surface in metres.
TriangleSurface sheet_of_grains(double volume_m3) {
    Packing sheet;
    sheet.container.kind = Container::Kind::box;
    const double pitch = 4.4 * std::cbrt(volume_m3);
    constexpr double shown[] = {0.99, 0.87, 0.74, 0.53, 0.43};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 5; ++column) {
            const Dimensions size = dimensions_for(kinds[row], shown[column], volume_m3, Cavity::open);
            sheet.shapes.push_back(make_preset(kinds[row], size.diameter_m, size.length_m));
            sheet.bodies.push_back(
                {.shape = sheet.shapes.size() - 1,
                 .position_m = Vec3((0.5 + column) * pitch, 0.5 * pitch, (0.5 + row) * pitch),
                 .orientation = Quaternion(Eigen::AngleAxisd(0.45, Vec3::UnitX()) * Eigen::AngleAxisd(0.5, Vec3::UnitZ()))});
        }
    sheet.container.size_m = Vec3(5.0 * pitch, pitch, 3.0 * pitch);
    return make_surface(sheet, {.deviation_m = 0.01 * smallest_diameter(sheet.shapes.back())}).surface;
}

}  // namespace

Json sweep_stage(double volume_m3, const Path& folder) {
    // The rows of the paper's axis, 0.99 down to 0.43.
    std::vector<double> sphericities;
    for (int i = 0; i <= 56; ++i) sphericities.push_back(0.99 - 0.01 * i);
    const std::size_t count = sphericities.size();
    std::vector<Dimensions> sizes(3 * count);
    std::vector<double> omega(3 * count);
    Progress progress("sweep");
    double done = 0.0;
    parallel_for(3 * count, [&](std::size_t i) {
        // Open: then every sphericity has one solution, and the three curves are the paper's.
        const char* kind = kinds[i / count];
        sizes[i] = dimensions_for(kind, sphericities[i % count], volume_m3, Cavity::open);
        omega[i] = std::min(1.0, volume_m3 / hull(make_preset(kind, sizes[i].diameter_m, sizes[i].length_m).capsules).volume_m3);
#pragma omp critical
        progress.update(++done / (3.0 * static_cast<double>(count)));
    });
    std::string table = "kind,sphericity,diameter_m,length_m,convexity,cavity\n";
    std::map<std::string, std::vector<double>> convexity;
    for (std::size_t i = 0; i < 3 * count; ++i) {
        convexity[kinds[i / count]].push_back(omega[i]);
        table += fmt::format("{},{:.2f},{:.10g},{:.10g},{:.8f},open\n", kinds[i / count], sphericities[i % count], sizes[i].diameter_m,
                             sizes[i].length_m, omega[i]);
    }
    write_text(folder / "sweep.csv", table);
    std::string commands =
        "set xlabel 'sphericity {/Symbol Y}'\nset ylabel 'convexity {/Symbol W}'\nset key right bottom\nset xrange [0.4:1]\nset yrange "
        "[0:1]\nset "
        "datafile separator ','\n";
    std::string plots = "plot";
    for (const char* kind : kinds)
        plots += fmt::format("{} '< grep {} sweep.csv' using 2:5 with linespoints pt 7 ps 0.4 lw 2 title '{}'", kind == kinds[0] ? "" : ",",
                             kind, kind);
    if (draw_plot(folder / "convexity.svg", commands + plots + "\n")) (void)draw_plot(folder / "convexity.png", commands + plots + "\n");
    write_stl(folder / "grains.stl", sheet_of_grains(volume_m3));

    Json result = {{"rows", 3 * sphericities.size()}, {"cavity", "open"}};
    double largest = 0.0, at = 0.0;
    for (std::size_t i = 0; i < sphericities.size(); ++i)
        if (const double difference = convexity["tetrahedron"][i] - convexity["tetrapod"][i]; difference > largest) {
            largest = difference;
            at = sphericities[i];
        }
    result["largest_convexity_difference"] = largest;
    result["at_sphericity"] = at;
    return result;
}

}  // namespace porepack
