#include "study/shape_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "core/parallel.hpp"
#include "core/table.hpp"
#include "report/plot.hpp"
#include "shapes/shape.hpp"
#include "study/grain_sheet.hpp"
#include "study/uses.hpp"

namespace porepack::study {
namespace {

constexpr std::array kinds = {ShapeKind::tetrahedron, ShapeKind::dolos, ShapeKind::tetrapod};

// Five of each kind in rows, side by side.
TriangleSurface sheet_of_grains(double volume_m3) {
    std::vector<Shape> grains;
    for (const ShapeKind kind : kinds)
        for (const double sphericity : {0.99, 0.87, 0.74, 0.53, 0.43}) {
            const Dimensions size = dimensions_for(kind, sphericity, volume_m3, Cavity::open);
            grains.push_back(make_preset(kind, size.diameter_m, size.length_m));
        }
    return grain_sheet(grains, 5, 4.4 * std::cbrt(volume_m3));
}

}  // namespace

Json run_shape_sweep(double volume_m3, const Path& folder) {
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
        const ShapeKind kind = kinds[i / count];
        sizes[i] = dimensions_for(kind, sphericities[i % count], volume_m3, Cavity::open);
        omega[i] = std::min(1.0, volume_m3 / hull(make_preset(kind, sizes[i].diameter_m, sizes[i].length_m)).volume_m3);
#pragma omp critical
        progress.update(++done / (3.0 * static_cast<double>(count)));
    });
    Table table({"kind", "sphericity", "diameter_m", "length_m", "convexity", "cavity"});
    table.digits = 10;
    std::map<ShapeKind, std::vector<double>> convexity;
    for (std::size_t i = 0; i < 3 * count; ++i) {
        convexity[kinds[i / count]].push_back(omega[i]);
        table.add(std::string(name_of(kinds[i / count])), sphericities[i % count], sizes[i].diameter_m, sizes[i].length_m, omega[i],
                  "open");
    }
    table.write(folder / "sweep.csv");
    if (draw_plot(folder / "convexity.svg", "convexity")) (void)draw_plot(folder / "convexity.png", "convexity");
    write_stl(folder / "grains.stl", sheet_of_grains(volume_m3));

    Json result = {{"rows", 3 * sphericities.size()}, {"cavity", "open"}};
    double largest = 0.0, at = 0.0;
    for (std::size_t i = 0; i < sphericities.size(); ++i)
        if (const double difference = convexity[ShapeKind::tetrahedron][i] - convexity[ShapeKind::tetrapod][i]; difference > largest) {
            largest = difference;
            at = sphericities[i];
        }
    result["largest_convexity_difference"] = largest;
    result["at_sphericity"] = at;
    return result;
}

}  // namespace porepack::study
