#include "benchmarks/coverage_rows.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include "core/json.hpp"
#include "core/table.hpp"
#include "lbm/grid_result.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/pore_space.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {
namespace {

const std::vector<std::string> columns = {"bed",
                                          "position",
                                          "tolerance",
                                          "porosity",
                                          "reference_nodes_1",
                                          "reference_nodes_2",
                                          "reference_nodes_3",
                                          "reference_1_m2",
                                          "reference_2_m2",
                                          "reference_3_m2",
                                          "reference_other_half_width",
                                          "nodes_1",
                                          "nodes_2",
                                          "nodes_3",
                                          "value_1_m2",
                                          "value_2_m2",
                                          "value_3_m2",
                                          "other_half_width",
                                          "seconds"};

}  // namespace

std::vector<CoverageRow> read_rows(const Path& file) {
    std::vector<CoverageRow> rows;
    if (!std::filesystem::exists(file)) return rows;
    for (const auto& v : read_table(file))
        rows.push_back({.bed = static_cast<int>(v.at(0)),
                        .position = static_cast<int>(v.at(1)),
                        .tolerance = v.at(2),
                        .porosity = v.at(3),
                        .reference_nodes = {v.at(4), v.at(5), v.at(6)},
                        .references_m2 = {v.at(7), v.at(8), v.at(9)},
                        .reference_other_half_width = v.at(10),
                        .nodes = {v.at(11), v.at(12), v.at(13)},
                        .values_m2 = {v.at(14), v.at(15), v.at(16)},
                        .other_half_width = v.at(17),
                        .seconds = v.at(18)});
    return rows;
}

void write_rows(const Path& file, const std::vector<CoverageRow>& rows) {
    Table table(columns);
    for (const CoverageRow& r : rows)
        table.add(r.bed, r.position, r.tolerance, r.porosity, r.reference_nodes[0], r.reference_nodes[1], r.reference_nodes[2],
                  r.references_m2[0], r.references_m2[1], r.references_m2[2], r.reference_other_half_width, r.nodes[0], r.nodes[1],
                  r.nodes[2], r.values_m2[0], r.values_m2[1], r.values_m2[2], r.other_half_width, r.seconds);
    table.write(file);
}

Reference reference_of(const CoverageRow& row) {
    const auto richardson = [&](std::size_t coarse, std::size_t fine) {
        return row.references_m2[fine] + (row.references_m2[fine] - row.references_m2[coarse]) /
                                             (std::pow(row.reference_nodes[fine] / row.reference_nodes[coarse], 2.0) - 1.0);
    };
    const double value = richardson(1, 2);
    return {value, std::abs(1.0 - richardson(0, 1) / value) + row.reference_other_half_width};
}

LbmResult reference_run(const PoreSpace& space, double nodes) {
    const double pores = space.porosity(4000).value * space.container.inner_area_m2() *
                         (space.container.periodic()[2] ? space.section.length() : space.computed().length());
    return lbm_permeability(space, std::cbrt(pores / nodes), {.iteration_tolerance = 2e-4, .grids = 3, .grid_ratio = 1.35});
}

double other_half_width(const LbmResult& result) {
    const IntervalParts parts = result.half_width.value();
    return (parts.sum() - parts.grid_m2) / result.permeability_m2;
}

void last_grids(const LbmResult& result, const PoreSpace& space, std::array<double, 3>& nodes, std::array<double, 3>& values_m2) {
    for (std::size_t i = 0; i < 3; ++i) {
        const LbmGridResult& grid = result.grids.at(result.grids.size() - 3 + i);
        nodes[i] = space.known_grain_diameter_m() / grid.voxel_size_m;
        values_m2[i] = grid.permeability_m2;
    }
}

Json with_other_constants(const std::vector<LastGrids>& runs) {
    static constexpr GridErrorConstants tried[] = {
        {}, {.floor_many = 0.03}, {.floor_many = 0.05}, {.of_change_many = 0.3}, {.of_change_many = 0.8, .floor_many = 0.08}};
    const auto median = [](std::vector<double> values) {
        std::sort(values.begin(), values.end());
        return values.empty() ? 0.0 : values[values.size() / 2];
    };
    Json list = Json::array();
    for (const GridErrorConstants& constants : tried) {
        long held = 0;
        std::vector<double> errors, half_widths;
        for (const LastGrids& run : runs) {
            const Extrapolation found = extrapolate(run.nodes, run.values);
            errors.push_back(std::abs(found.value - 1.0));
            half_widths.push_back(grid_half_width(found, run.nodes[2], run.grains, constants) / found.value + run.other_half_width);
            held += errors.back() <= half_widths.back() ? 1 : 0;
        }
        list.push_back({{"of_change_many", constants.of_change_many},
                        {"floor_many", constants.floor_many},
                        {"runs", runs.size()},
                        {"held", held},
                        {"median_error", median(errors)},
                        {"median_half_width", median(half_widths)}});
    }
    return list;
}

}  // namespace porepack::benchmarks
