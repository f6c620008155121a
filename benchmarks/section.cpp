// k of a section in its bed: the pressure on a plane, the length of the buffers, k against the length of the section.
#include <fmt/format.h>

#include <cmath>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/log.hpp"
#include "core/table.hpp"
#include "lbm/known.hpp"
#include "lbm/permeability.hpp"
#include "report/plot.hpp"

namespace porepack::benchmarks {
using namespace core;
using namespace packing;
using namespace converters;
using namespace lbm;
using namespace report;
namespace {

struct Bed {
    const char* name;
    PoreSpace space;
    double voxel_m;
    double middle_m;  ///< height of the middle of the bed, on a layer of voxels
};

Bed settled(const char* name, const char* file, double voxel_m) {
    PoreSpace space = pore_space_of(read_packing(data_file("cases") / "paper_packing" / "settled" / file));
    return {name, space, voxel_m, voxel_m * std::round(0.5 * (space.bed_bottom_m + space.bed_top_m) / voxel_m)};
}

LbmConfig one_grid(long subsections = 1) {
    return {.iteration_tolerance = 2e-4, .grids = 1, .subsections = subsections};
}

LbmResult flow_through(const Bed& bed, const Section& section, Ends ends, double buffer_m, long subsections = 1) {
    return lbm_permeability(bed.space.with_section(section).with_ends(ends, buffer_m), bed.voxel_m, one_grid(subsections));
}

// ---- which pressure

// k of the layers [first, last] with this pressure on their planes.
double permeability_of(const LbmGridResult& grid, const PoreSpace& space, std::size_t first, std::size_t last, PlanePressure pressure) {
    const Drive drive = choose_drive(space.container, Axis::z);
    const Scheme scheme = scheme_of(one_grid(), true, drive);
    const Layers& layers = grid.run.layers;
    double flow = 0.0;
    for (std::size_t layer = first; layer <= last; ++layer) flow += layers.flow[layer] / static_cast<double>(last - first + 1);
    const double h = grid.voxel_size_m, nu = (grid.relaxation_time - 0.5) / 3.0;
    const double gradient = gradient_between(scheme.force[2], drive, layers, first, last, pressure);
    return flow * nu / gradient * h * h * h * h / space.container.inner_area_m2();
}

// Windows of 20 mm whose planes move through the grains in steps of a quarter of the capsule diameter, inside one flow.
Json plane_pressures(const Bed& bed, const std::vector<double>& nodes_per_diameter) {
    const double d = bed.space.grain_size_m, length = 5.0 * d;
    const PoreSpace space = bed.space.with_section({bed.middle_m - 4.0 * d, bed.middle_m + 4.0 * d}).with_ends(Ends::in_situ, 2.0 * d);
    LbmConfig config = one_grid();
    config.grids = 3;
    Json rows = Json::array();
    for (const double nodes : nodes_per_diameter) {
        const LbmResult result = lbm_permeability(space, d / nodes, config);
        const LbmGridResult& grid = result.fine();
        const auto before = static_cast<std::size_t>(std::lround(std::ceil(space.buffers_m[0] / grid.voxel_size_m - 1e-9)));
        for (int shift = 0; shift < 12; ++shift) {
            const auto first = before + static_cast<std::size_t>(std::lround(0.25 * shift * d / grid.voxel_size_m));
            const std::size_t last = first + static_cast<std::size_t>(std::lround(length / grid.voxel_size_m)) - 1;
            rows.push_back({{"nodes_per_diameter", nodes},
                            {"shift_diameters", 0.25 * shift},
                            {"flux_weighted_m2", permeability_of(grid, space, first, last, PlanePressure::flux_weighted)},
                            {"mean_m2", permeability_of(grid, space, first, last, PlanePressure::mean)}});
        }
    }
    return rows;
}

// ---- how long a buffer

// Ten slices, each run alone with buffers of several lengths, against the same slices inside the flow through the whole bed.
Json slices(const Bed& bed, double slice_m, const std::vector<double>& buffers_in_diameters) {
    const double layers = std::round(slice_m / bed.voxel_m), slice = layers * bed.voxel_m, z0 = bed.middle_m - 5.0 * slice;
    const LbmResult whole = flow_through(bed, {z0, z0 + 10.0 * slice}, Ends::in_situ, 1.0, 10);
    Json rows = Json::array();
    for (const double buffer : buffers_in_diameters) {
        double resistance = 0.0;
        Json row = {{"buffer_diameters", buffer}, {"error", Json::array()}};
        for (int i = 0; i < 10; ++i) {
            const double low = z0 + i * slice;
            const bool planes = buffer == 0.0;
            const double k =
                flow_through(bed, {low, low + slice}, planes ? Ends::planes : Ends::in_situ, buffer * bed.space.equivalent_diameter_m)
                    .permeability_m2;
            resistance += 0.1 / k;
            row["error"].push_back(k / whole.subsections[static_cast<std::size_t>(i)].permeability_m2 - 1.0);
        }
        row["harmonic_mean_error"] = 1.0 / resistance / whole.fine().permeability_volume_m2 - 1.0;
        log_info("{}: buffer of {} diameters: {}", bed.name, buffer, row.dump());
        rows.push_back(row);
    }
    return {{"slice_m", slice},
            {"permeability_m2", whole.fine().permeability_volume_m2},
            {"subsections", json_of(whole.subsections)},
            {"rows", rows}};
}

// ---- k against the length of the section

Json lengths(const Bed& bed, const Path& folder) {
    const double long_buffer_m = 0.05;
    Table table({"length_m", "planes_m2", "in_situ_m2"});
    Json rows = Json::array();
    for (const double length : {0.015, 0.03, 0.06, 0.12, 0.24}) {
        const double half = bed.voxel_m * std::round(0.5 * length / bed.voxel_m);
        const Section section{bed.middle_m - half, bed.middle_m + half};
        const double planes = flow_through(bed, section, Ends::planes, 0.0).permeability_m2,
                     in_situ = flow_through(bed, section, Ends::in_situ, long_buffer_m).permeability_m2;
        table.add(section.length(), planes, in_situ);
        rows.push_back({{"length_m", section.length()}, {"planes_m2", planes}, {"in_situ_m2", in_situ}});
    }
    table.write(folder / "section_length.csv");
    draw_plot(folder / "section_length.svg", "section_length", {}, {.width = 640, .height = 420});
    return rows;
}

// ---- arrays cut anywhere

// Three layers of a cubic array in a box that is periodic in x and y alone, the section one period long at any height.
Json cut_arrays() {
    Json rows = Json::array();
    for (const SphereDrag& drag : sphere_drags()) {
        if (drag.simple_cubic == 0.0 || drag.solid_fraction < 0.2) continue;
        const KnownFlow array = three_layers(drag.solid_fraction, drag.simple_cubic);
        for (const double low : {1.75, 2.0, 2.2}) {
            const PoreSpace space = pore_space_of(array.packing).with_section({low, low + 1.0});
            const auto error = [&](Ends ends) {
                return lbm_permeability(space.with_ends(ends), 1.0 / 40, one_grid()).permeability_m2 / array.permeability_m2 - 1.0;
            };
            rows.push_back({{"solid_fraction", drag.solid_fraction},
                            {"z0_m", low},
                            {"error_in_situ", error(Ends::in_situ)},
                            {"error_planes", error(Ends::planes)}});
        }
    }
    return rows;
}

}  // namespace

Json section_benchmark(bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("section_study") : output;
    make_folder(folder);
    const Bed loose = settled("tetrapods, 0.53", "tetrapod_053.json.gz", 9e-4);
    Json result;
    result["arrays"] = cut_arrays();
    result["lengths"] = lengths(loose, folder);
    result["plane_pressures"] = plane_pressures(loose, quick ? std::vector<double>{6, 10} : std::vector<double>{6, 10, 20});
    result["slices_053"] = slices(loose, 0.024, {0.0, 0.5, 1.0, 1.5});
    if (!quick) result["slices_087"] = slices(settled("tetrapods, 0.87", "tetrapod_087.json.gz", 1e-3), 0.024, {0.0, 0.5, 1.0, 1.5});
    return result;
}

}  // namespace porepack::benchmarks
