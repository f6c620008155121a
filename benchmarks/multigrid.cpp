// Would multigrid need fewer steps? Two grids: the defect of the flow on the fine grid drives a flow on a grid of twice the voxel size, and
// that flow is added to the fine one. Work is counted in steps of the fine grid, so that the reference kernel, whose populations can be
// changed node by node, is sufficient. The coarse flow is run nearly to its steady state: a cycle over more grids cannot converge faster
// per cycle than this one.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "lbm/layer_balance.hpp"
#include "lbm/permeability.hpp"
#include "lbm/sequence.hpp"
#include "lbm/start.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::benchmarks {
namespace {

using Populations = std::array<double, d3q19::directions>;

std::vector<Populations> populations(const Flow& flow, const Domain& domain) {
    std::vector<Populations> all(domain.nodes());
    flow.populations(0, std::as_writable_bytes(std::span(all)));
    return all;
}

void set_populations(Flow& flow, const std::vector<Populations>& all) {
    flow.set_populations(0, std::as_bytes(std::span(all)));
}

struct Level {
    Domain domain;
    FlowSection section;
    std::shared_ptr<const FlowPlan> plan;
    std::shared_ptr<const FlowPlan> fast;  // the kernel of this processor, where populations are not changed
};

Level level_of(const PoreSpace& space, double voxel_m) {
    const PhaseImage image = space.voxelise_at(voxel_m);
    const Drive drive = choose_drive(space.container, Axis::z);
    const auto walls = space.walls();
    Domain domain = build_domain(image, drive, &*walls);
    auto plan = plan_flow(Kernel::reference, domain);
    auto fast = plan_flow(Kernel::cpu_double, domain);
    return {std::move(domain), flow_section(image.grid, space.container, space.section, drive), std::move(plan), std::move(fast)};
}

double permeability_lu(const Layers& layers, const Level& level, const Scheme& scheme) {
    double sum = 0.0;
    for (const double rate : layers.flow) sum += rate;
    return sum / static_cast<double>(layers.flow.size()) * scheme.viscosity_lu() / (level.section.area_cells * scheme.force[2]);
}

// Defect of mass and momentum of the fine flow, per pair of steps: the mean over the fine nodes around each coarse node.
std::vector<Moments> restricted(const std::vector<Populations>& before, std::span<const Populations> after, const Domain& fine,
                                const Domain& coarse) {
    std::vector<Moments> sums(coarse.nodes(), Moments{0.0, {0, 0, 0}});
    const double ratio = coarse.grid.spacing_m[2] / fine.grid.spacing_m[2];
    std::size_t node = 0;
    fine.cells.for_each([&](std::size_t cell) {
        Moments defect{0.0, {0, 0, 0}};
        for (std::size_t q = 0; q < d3q19::directions; ++q) {
            const double change = after[node][q] - before[node][q];
            defect.density += change;
            for (std::size_t a = 0; a < 3; ++a) defect.velocity[a] += d3q19::c[q][a] * change;
        }
        ++node;
        const auto place = fine.grid.place(cell);
        const NodesAround around =
            nodes_around(coarse, {fine.grid.centre(0, place[0]), fine.grid.centre(1, place[1]), fine.grid.centre(2, place[2])});
        double all = 0.0;
        for (std::size_t corner = 0; corner < 8; ++corner) all += around.node[corner] >= 0 ? around.weight[corner] : 0.0;
        for (std::size_t corner = 0; corner < 8; ++corner) {
            if (around.node[corner] < 0) continue;
            Moments& sum = sums[static_cast<std::size_t>(around.node[corner])];
            const double share = around.weight[corner] / (all * ratio * ratio * ratio);
            sum.density += share * defect.density;
            for (std::size_t a = 0; a < 3; ++a) sum.velocity[a] += share * defect.velocity[a];
        }
    });
    return sums;
}

struct Variant {
    std::string name;
    double tau = 1.0;
    long fine_steps = 0;  // between two corrections; 0: no multigrid
};

constexpr long coarse_steps = 200;  // per correction

struct Point {
    double work, permeability_lu;
};

// The flow that the defect drives on the coarse grid, added to the fine one. For equal velocities in lattice units a force grows with the
// square of the voxel size, a density with the voxel size itself.
void add_correction(Flow& fine, const std::vector<Populations>& before, const Level& fine_level, const Level& coarse_level,
                    const Scheme& scheme) {
    Scheme undriven = scheme;
    undriven.force = {0, 0, 0};
    const double ratio = coarse_level.domain.grid.spacing_m[2] / fine_level.domain.grid.spacing_m[2];
    std::vector<Moments> source = restricted(before, populations(fine, fine_level.domain), fine_level.domain, coarse_level.domain);
    for (Moments& moments : source) {
        moments.density *= ratio;
        for (double& u : moments.velocity) u *= ratio * ratio;
    }
    const auto coarse = coarse_level.plan->start(undriven);
    for (long step = 0; step < coarse_steps; step += 2) {
        coarse->advance_two_steps();
        std::vector<Populations> of_coarse = populations(*coarse, coarse_level.domain);
        for (std::size_t x = 0; x < source.size(); ++x)
            for (int q = 0; q < d3q19::directions; ++q)
                of_coarse[x][static_cast<std::size_t>(q)] += Scheme::equilibrium(q, source[x].density, source[x].velocity);
        set_populations(*coarse, of_coarse);
    }
    const auto correction = fine_level.plan->start(undriven);
    start_from(*correction, fine_level.domain, undriven, take_field(*coarse, Domain(coarse_level.domain), undriven));
    const std::vector<Populations> added = populations(*correction, fine_level.domain);
    std::vector<Populations> of_fine = populations(fine, fine_level.domain);
    for (std::size_t x = 0; x < of_fine.size(); ++x)
        for (std::size_t q = 0; q < d3q19::directions; ++q) of_fine[x][q] += added[x][q];
    set_populations(fine, of_fine);
}

std::vector<Point> run(const Level& fine, const Level& coarse, const FlowField& start, const Scheme& of_case, const Variant& variant,
                       double largest_work) {
    Scheme scheme = of_case;
    scheme.tau = variant.tau;
    const auto flow = (variant.fine_steps > 0 ? fine.plan : fine.fast)->start(scheme);
    start_from(*flow, fine.domain, scheme, start);
    const LayerBalance balance(fine.domain, scheme, fine.section.area_cells, true);
    BalanceState state;
    const double coarse_share = static_cast<double>(coarse.domain.nodes()) / static_cast<double>(fine.domain.nodes());
    std::vector<Point> points;
    double work = 0.0;
    const long apart = variant.fine_steps > 0 ? variant.fine_steps : 40;
    while (work < largest_work) {
        for (long step = 0; step < apart - 2; step += 2) flow->advance_two_steps();
        std::vector<Populations> before;
        if (variant.fine_steps > 0) before = populations(*flow, fine.domain);
        flow->advance_two_steps();
        work += static_cast<double>(apart);
        const Layers layers = flow->layers(fine.domain);
        points.push_back({work, permeability_lu(layers, fine, scheme)});
        if (!std::isfinite(points.back().permeability_lu)) break;
        if (variant.fine_steps > 0) {
            add_correction(*flow, before, fine, coarse, scheme);
            work += static_cast<double>(coarse_steps) * coarse_share;
        }
        balance.correct(*flow, layers, points.back().permeability_lu, apart, state);
        // What the coarse grid has added to the layers is no gain of mass by the steps.
        if (variant.fine_steps > 0) state.density = flow->layers(fine.domain).density;
    }
    return points;
}

// Work from which on k stays within `tolerance` of the limit; nothing when it does not.
Json work_until(const std::vector<Point>& points, double limit, double tolerance) {
    Json work;
    for (auto point = points.rbegin(); point != points.rend() && std::abs(point->permeability_lu / limit - 1.0) < tolerance; ++point)
        work = point->work;
    return work;
}

Json rows_of(const std::string& name, const PoreSpace& space, double voxel_m, bool quick) {
    const Level fine = level_of(space, voxel_m), coarse = level_of(space, 2.0 * voxel_m);
    const Scheme scheme = scheme_of({}, true, fine.domain.drive);
    log_info("multigrid: {}, {} and {} nodes", name, fine.domain.nodes(), coarse.domain.nodes());
    Scheme first = scheme;
    first.tau = 1.0;
    const auto started = coarse.fast->start(first);
    [[maybe_unused]] const StokesRun begun = run_to_steady(*started, coarse.domain, first, coarse.section, {.tolerance = 1e-4});
    const FlowField start = take_field(*started, Domain(coarse.domain), first);

    std::vector<Variant> variants;
    for (const double tau : {0.7, 0.8, 1.0, 1.2, 1.5, 2.0}) variants.push_back({.name = "as now", .tau = tau});
    for (const double tau : {0.8, 1.2, 1.6})
        for (const long steps : {20L, 40L})
            if (!quick || (tau == 1.2 && steps == 40))
                variants.push_back({fmt::format("two grids, {} fine and {} coarse steps", steps, coarse_steps), tau, steps});
    const double limit = run(fine, coarse, start, scheme, {.name = "limit", .tau = 1.0}, 3000).back().permeability_lu;
    std::vector<std::vector<Point>> points(variants.size());
    Progress progress("multigrid, " + name);
    for (std::size_t v = 0; v < variants.size(); ++v) {
        points[v] = run(fine, coarse, start, scheme, variants[v], variants[v].fine_steps > 0 ? 400 : 1000);
        progress.update(static_cast<double>(v + 1) / static_cast<double>(variants.size()));
    }
    Json rows = Json::array();
    for (std::size_t v = 0; v < variants.size(); ++v) {
        Json row = {{"packing", name},
                    {"fine_nodes", fine.domain.nodes()},
                    {"coarse_nodes", coarse.domain.nodes()},
                    {"method", variants[v].name},
                    {"relaxation_time", variants[v].tau},
                    {"error_at_start", points[v].front().permeability_lu / limit - 1.0}};
        for (const auto& [key, tolerance] : {std::pair("work_to_5e-3", 5e-3), {"work_to_1e-3", 1e-3}, {"work_to_1e-4", 1e-4}})
            row[key] = work_until(points[v], limit, tolerance);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace

Json multigrid_benchmark(const std::vector<std::string>& packings, bool quick) {
    std::vector<Path> files(packings.begin(), packings.end());
    const Path settled = data_file("cases") / "paper_packing" / "settled";
    if (files.empty()) files = {settled / "tetrapod_053.json.gz", settled / "tetrapod_087.json.gz"};
    Json rows = Json::array();
    for (const Path& file : files) {
        const PoreSpace bed = pore_space_of(read_packing(file));
        const double d = bed.grain_size_m, middle = 0.5 * (bed.bed_bottom_m + bed.bed_top_m), length = 3.0;
        for (const Json& row :
             rows_of(file.filename().string(), bed.with_section({middle - 0.5 * length * d, middle + 0.5 * length * d}), d / 8.0, quick))
            rows.push_back(row);
    }
    return {{"multigrid", rows}};
}

}  // namespace porepack::benchmarks
