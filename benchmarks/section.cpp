// k of a section in its bed: the pressure on a plane, the length of the buffers, k against the length of the section.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "core/table.hpp"
#include "lbm/permeability.hpp"
#include "lbm/sequence.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"
#include "report/plot.hpp"
#include "support/known_flows.hpp"

namespace porepack::benchmarks {
using namespace test;
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

// Spheres of diameter 1, placed at random without overlap, periodic in x and y.
PoreSpace random_spheres() {
    Packing packing{.container = vessels::make_box({4.0, 4.0, 10.0}, {true, true, false}),
                    .shapes = {make_preset(ShapeKind::sphere, 1.0, 0.0)},
                    .bodies = {}};
    std::mt19937 random(1);
    const auto uniform = [&](double length) { return length * static_cast<double>(random()) / 4294967296.0; };
    for (int attempt = 0; attempt < 200000 && packing.bodies.size() < 95; ++attempt) {
        const double x = uniform(4.0), y = uniform(4.0), z = 0.5 + uniform(9.0);
        const bool free = std::none_of(packing.bodies.begin(), packing.bodies.end(), [&](const Body& other) {
            Vec3 apart = Vec3(x, y, z) - other.position_m;
            for (const int axis : {0, 1}) apart[axis] -= 4.0 * std::round(apart[axis] / 4.0);
            return apart.norm() < 1.0;
        });
        if (free) packing.bodies.push_back({.shape = 0, .position_m = {x, y, z}});
    }
    return pore_space_of(std::move(packing));
}

// The flow through it on one grid, as layers and as a field.
struct Window {
    FlowField field;
    Layers layers;
    std::vector<WallLink> walls;
    double viscosity = 0.0, force = 0.0, area_cells = 0.0;

    Window(const PoreSpace& space, double voxel_m) {
        const PhaseImage image = space.voxelise_at(voxel_m);
        const std::optional<FlowWalls> exact = space.walls();
        const Drive drive = choose_drive(space.container, Axis::z);
        Domain domain = build_domain(image, drive, &*exact);
        const Scheme scheme = scheme_of({.relaxation_time = 1.2}, true, drive);
        const FlowSection section = flow_section(image.grid, space.container, space.section, drive);
        const auto flow = make_flow(Kernel::cpu_double, domain, scheme);
        layers = run_to_steady(*flow, domain, scheme, section, {.tolerance = 1e-5}).layers;
        walls = domain.walls;
        viscosity = scheme.viscosity_lu();
        force = scheme.force[2];
        area_cells = section.area_cells;
        field = take_field(*flow, std::move(domain), scheme);
    }

    [[nodiscard]] double flow(std::size_t first, std::size_t last) const {
        double sum = 0.0;
        for (std::size_t layer = first; layer <= last; ++layer) sum += layers.flow[layer];
        return sum / static_cast<double>(last - first + 1);
    }
    // In cells, by the pressure gradient between the planes before and behind these layers.
    [[nodiscard]] double permeability(std::size_t first, std::size_t last, PlanePressure pressure) const {
        return flow(first, last) * viscosity / (area_cells * gradient_between(force, field.domain.drive, layers, first, last, pressure));
    }
    // By the dissipation: squares of the differences of velocity along links between nodes, and from nodes to walls.
    [[nodiscard]] double permeability_by_dissipation(std::size_t first, std::size_t last) const {
        const Domain& domain = field.domain;
        const auto squared = [&](std::size_t one, std::int64_t other) {
            double sum = 0.0;
            for (std::size_t axis = 1; axis < 4; ++axis) {
                const double u = static_cast<double>(field.moments[one][axis]) -
                                 (other < 0 ? 0.0 : static_cast<double>(field.moments[static_cast<std::size_t>(other)][axis]));
                sum += u * u;
            }
            return sum;
        };
        const auto inside = [&](std::size_t layer) { return layer >= first && layer <= last; };
        double dissipation = 0.0;
        for (std::size_t node = 0; node < domain.nodes(); ++node) {
            const auto at = domain.grid.place(domain.cells.cell(node));
            for (std::size_t axis = 0; axis < 3; ++axis) {
                auto next = at;
                next[axis] = axis < 2 ? (at[axis] + 1) % domain.grid.cells[axis] : at[axis] + 1;
                if (next[2] >= domain.grid.cells[2]) continue;
                const std::int64_t other = domain.node_at(next);
                const double share = 0.5 * (inside(static_cast<std::size_t>(at[2])) ? 1.0 : 0.0) +
                                     0.5 * (inside(static_cast<std::size_t>(next[2])) ? 1.0 : 0.0);
                if (other >= 0 && share > 0.0) dissipation += share * squared(node, other);
            }
        }
        for (const WallLink& wall : walls) {
            const auto& c = d3q19::c[wall.q];
            if (std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]) == 1 && inside(domain.layer_of_cell(domain.cells.cell(wall.node))))
                dissipation += squared(wall.node, -1) / std::max(0.1, wall.fraction());
        }
        const double q = flow(first, last);
        return q * q * static_cast<double>(last - first + 1) / (area_cells * dissipation);
    }
};

// k between two planes five diameters apart that move through the spheres, inside one flow, by (a) the mean pressure of the planes, (b) the
// flux-weighted one and (c) the dissipation.
Json plane_pressures(const std::vector<double>& nodes_per_diameter) {
    const PoreSpace space = random_spheres().with_section({2.0, 8.0}).with_ends(Ends::in_situ, 2.0);
    Json rows = Json::array();
    for (const double nodes : nodes_per_diameter) {
        const Window window(space, 1.0 / nodes);
        const auto below = static_cast<std::size_t>(std::lround(std::ceil(space.buffers_m[0] * nodes - 1e-9)));
        for (int shift = 0; shift < 8; ++shift) {
            const auto first = below + static_cast<std::size_t>(std::lround(0.125 * shift * nodes));
            const std::size_t last = first + static_cast<std::size_t>(std::lround(5.0 * nodes)) - 1;
            rows.push_back({{"nodes_per_diameter", nodes},
                            {"shift_diameters", 0.125 * shift},
                            {"mean_pressure", window.permeability(first, last, PlanePressure::mean) / (nodes * nodes)},
                            {"flux_weighted_pressure", window.permeability(first, last, PlanePressure::flux_weighted) / (nodes * nodes)},
                            {"dissipation", window.permeability_by_dissipation(first, last) / (nodes * nodes)}});
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

Json section_benchmark(const std::vector<std::string>& parts, bool quick, const Path& output) {
    const Path folder = output.empty() ? Path("section_study") : output;
    make_folder(folder);
    const std::vector<double> buffers = quick ? std::vector<double>{0.0, 1.5} : std::vector<double>{0.0, 0.5, 1.0, 1.5};
    const auto loose = [] { return settled("tetrapods, 0.53", "tetrapod_053.json.gz", 9e-4); };
    const auto dense = [] { return settled("tetrapods, 0.87", "tetrapod_087.json.gz", 1e-3); };
    const std::vector<std::pair<std::string, std::function<Json()>>> known = {
        {"arrays", [] { return cut_arrays(); }},
        {"lengths", [&] { return lengths(loose(), folder); }},
        {"plane_pressures",
         [&] {
             return plane_pressures(quick ? std::vector<double>{6, 10} : std::vector<double>{6, 10, 20, 30});
         }},
        {"slices_053", [&] { return slices(loose(), 0.024, buffers); }},
        {"slices_087", [&] { return slices(dense(), 0.024, buffers); }}};
    Json result;
    for (const auto& [name, run] : known) {
        if (!parts.empty() && std::find(parts.begin(), parts.end(), name) == parts.end()) continue;
        result[name] = run();
        write_json(folder / "section.json", result);
    }
    if (result.is_null())
        throw UserError("no part of this benchmark has the name " + parts.front(),
                        {.allowed = "arrays, lengths, plane_pressures, slices_053, slices_087"});
    return result;
}

}  // namespace porepack::benchmarks
