#include "packing/porosity.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace porepack::packing {
using namespace shapes;
using namespace vessels;

namespace {

struct LatticeSum {
    double solid = 0.0;
    long lines = 0;       // that lie inside the vessel at all heights of the section
    double partly = 0.0;  // length inside the vessel of the other lines, over that of the section
    double area = 0.0;    // mean over the heights, of the cells of the lines
    [[nodiscard]] double all_lines() const { return static_cast<double>(lines) + partly; }
};

LatticeSum sum_on_lattice(const Solid& solid, const Container& container, const Section& section, double spacing, double shift) {
    const Vec3 low = container.low();
    const Vec3 high = container.high();
    const int nx = static_cast<int>(std::ceil((high.x() - low.x()) / spacing));
    const int ny = static_cast<int>(std::ceil((high.y() - low.y()) / spacing));
    const double hx = (high.x() - low.x()) / nx;
    const double hy = (high.y() - low.y()) / ny;
    // A sum per row: the same on any number of threads.
    std::vector<LatticeSum> rows(static_cast<std::size_t>(ny));
#pragma omp parallel for schedule(dynamic, 8)
    for (int j = 0; j < ny; ++j) {
        LatticeSum& row = rows[static_cast<std::size_t>(j)];
        std::vector<Interval> inside, parts;
        for (int i = 0; i < nx; ++i) {
            const double x = low.x() + (i + shift) * hx;
            const double y = low.y() + (j + shift) * hy;
            container.vessel().column(x, y, inside);
            if (inside.empty()) continue;
            const bool whole = inside.size() == 1 && inside[0].low <= section.z0_m && inside[0].high >= section.z1_m;
            if (whole) ++row.lines;
            solid.column(x, y, parts);
            if (!whole) {
                for (const Interval& part : inside)
                    row.partly += std::max(0.0, std::min(part.high, section.z1_m) - std::max(part.low, section.z0_m)) / section.length();
                intersect(parts, inside);
            }
            for (const auto& part : parts) row.solid += std::max(0.0, std::min(part.high, section.z1_m) - std::max(part.low, section.z0_m));
        }
    }
    LatticeSum sum;
    for (const LatticeSum& row : rows) {
        sum.solid += row.solid;
        sum.lines += row.lines;
        sum.partly += row.partly;
    }
    sum.area = sum.all_lines() * hx * hy;
    return sum;
}

}  // namespace

Porosity porosity(const Solid& solid, const Container& container, const Section& section, long lines) {
    const double inner_area = container.vessel().mean_area(section.interval());
    if (const std::optional<double> volume = solid.volume_between(section.z0_m, section.z1_m)) {
        const double fraction = *volume / (inner_area * section.length());
        constexpr double rounding = 3.0 * 0x1p-24;  // of the three coordinates of an STL file
        return {.value = 1.0 - fraction, .uncertainty = rounding * fraction};
    }
    const double spacing = std::sqrt(2.0 * inner_area / static_cast<double>(lines));
    double values[2], area = 0.0;
    long used = 0;
    for (int lattice = 0; lattice < 2; ++lattice) {
        const LatticeSum sum = sum_on_lattice(solid, container, section, spacing, 0.25 + 0.5 * lattice);
        values[lattice] = 1.0 - sum.solid / (sum.all_lines() * section.length());
        used += std::lround(sum.all_lines());
        area += sum.area;
    }
    // The number of lines stands for the area: for grains away from the walls, its error is that of the solid volume.
    const double area_error = (1.0 - 0.5 * (values[0] + values[1])) * std::abs(area / (2.0 * inner_area) - 1.0);
    return {.value = 0.5 * (values[0] + values[1]),
            .uncertainty = 0.5 * std::abs(values[0] - values[1]) + area_error,
            .line_spacing_m = spacing,
            .lines = used};
}

}  // namespace porepack::packing
