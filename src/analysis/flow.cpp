#include "analysis/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "analysis/device_use.hpp"
#include "analysis/gray_parts.hpp"
#include "analysis/uses.hpp"
#include "core/communicator.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/table.hpp"
#include "io/image.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/permeability.hpp"
#include "lbm/sequence.hpp"
#include "lbm/slabs.hpp"
#include "scans/ball_walls.hpp"
#include "scans/gray_input.hpp"

namespace porepack::analysis {
namespace {

Table history_of(const LbmGridResult& grid) {
    Table table({"step", "permeability_m2", "iteration_error", "flow_imbalance", "expected_permeability_m2"});
    const double h2 = grid.voxel_size_m * grid.voxel_size_m;
    for (const auto& point : grid.run.history)
        table.add(point.step, point.permeability_volume_lu * h2,
                  point.iteration_error < 1.0 ? std::optional(point.iteration_error) : std::nullopt, point.flow_imbalance,
                  point.expected_volume_lu * h2);
    return table;
}

Table gradients_of(const LbmResult& result) {
    Table table({"z0_m", "z1_m", "relative_gradient"});
    for (const auto& [z0, z1, gradient] : result.gradients) table.add(z0, z1, gradient);
    return table;
}

std::string interval_meaning(const LbmResult& result, const PoreSpace& space, const Scheme& scheme) {
    if (!result.half_width) return "too few grids: no uncertainty";
    if (space.gray() && scans::has_walls_of_balls(*space.gray()))
        return "three grids, and the places of the walls between the voxels; judged on voxelised arrays and packings (docs/images.md)";
    if (space.gray()) return "three grids, gray levels and blur; judged on spheres (docs/images.md)";
    std::string meaning = scheme.walls == Walls::interpolated ? "three grids: covers the exact value in at least 95 % of the known cases"
                                                              : "two grids, first order, at least 6 %: held in 90 of 100 arrays and ducts";
    if (result.half_width->stretch_m2 > 0.0) meaning += "; with the stretch of the periodic box to whole voxels";
    return meaning;
}

// In a box that is periodic in x and y, the upper plane moves to a layer of voxels.
Section evaluated_section(const PoreSpace& space, const LbmGridResult& grid) {
    Section section = space.section;
    if (!space.container.any_periodic() || space.container.periodic()[2]) return section;
    section.z1_m = section.z0_m + std::max(1.0, std::round(section.length() / grid.voxel_size_m)) * grid.voxel_size_m;
    return section;
}

std::optional<results::HalfWidthParts> half_width_parts(const LbmResult& result, bool gray) {
    if (!result.half_width) return std::nullopt;
    const IntervalParts& parts = *result.half_width;
    results::HalfWidthParts found{
        .grid = parts.grid_m2, .iteration = parts.iteration_m2, .mass_balance = parts.mass_balance_m2, .precision = parts.precision_m2};
    if (parts.stretch_m2 != 0.0) found.stretch = parts.stretch_m2;
    if (gray) {
        found.threshold = parts.threshold_m2;
        found.blur = parts.blur_m2;
    }
    return found;
}

std::string method_of(const LbmConfig& config, const Scheme& scheme) {
    return fmt::format("D3Q19 {}, linear equilibrium, {}, {} precision",
                       config.collision == Collision::bgk ? "BGK" : "two relaxation times",
                       scheme.walls == Walls::interpolated ? "interpolated walls" : "half-way bounce-back", name_of(config.precision));
}

results::Lbm result_of(const LbmResult& result, const PoreSpace& space, double porosity, const LbmConfig& config) {
    const LbmGridResult& fine = result.fine();
    const Scheme scheme = scheme_of(config, space.has_exact_walls(), {});
    results::Lbm found{.permeability = {result.permeability_m2, result.interval_m2()},
                       .half_width_parts_m2 = half_width_parts(result, space.gray() != nullptr),
                       .averaged_image_change = result.averaged_image_change,
                       .interval_meaning = interval_meaning(result, space, scheme),
                       .permeability_bed_m2 = result.bed_permeability_m2(),
                       .permeability_by_volume_average_m2 = fine.permeability_volume_m2,
                       .method = method_of(config, scheme) + (result.device == "cpu" ? "" : ", by " + result.device),
                       .device = result.device,
                       .direction = config.direction,
                       .driven_by = space.ends == Ends::paper ? "the inlet's flow rate"
                                    : fine.by_pressure        ? "pressure planes"
                                                              : "body force",
                       .section_m = evaluated_section(space, fine).interval(),
                       .porosity = porosity,
                       .ends = fine.by_pressure ? std::string(name_of(space.ends)) : "periodic",
                       .buffers_m = space.buffers_m,
                       .converged = fine.run.converged,
                       .iteration_error = fine.run.iteration_error,
                       .iteration_tolerance = iteration_tolerance(config),
                       .flow_imbalance = fine.run.flow_imbalance,
                       .hydraulic_tortuosity = fine.run.hydraulic_tortuosity,
                       .inertia_coefficient_quasi_steady = fine.run.kinetic_energy_factor / porosity,
                       .magic_parameter = scheme.magic,
                       .steps = fine.run.steps,
                       .updates_per_second = fine.run.updates_per_second,
                       .fine = fine,
                       .grids = result.grids,
                       .subsections = result.subsections,
                       .peak_memory_bytes = largest_of(ranks(), peak_memory_bytes())};
    if (config.direction == Axis::z)
        found.conductance_m3 =
            result.permeability_m2 * space.container.vessel().mean_area(found.section_m) / (found.section_m.high - found.section_m.low);
    if (config.tolerance > 0.0)
        found.reached = {.tolerance = config.tolerance,
                         .tolerance_reached = result.stopped_by.empty(),
                         .stopped_by = result.stopped_by.empty() ? std::nullopt : std::optional(result.stopped_by)};
    if (fine.by_pressure && space.ends == Ends::planes) found.permeability_planes_m2 = result.permeability_m2;
    return found;
}

}  // namespace

Expectation expect_flow(const PoreSpace& space, const LbmConfig& config, double voxel_size_m, double pores) {
    (void)choose_drive(space.container, config.direction);  // throws for a direction that is not possible
    const double across = std::isfinite(space.grain_size_m) ? space.grain_size_m : 10.0 * voxel_size_m;
    const VoxelPlan plan = space.own_grid()
                               ? space.plan_at(voxel_size_m)
                               : plan_voxels(space.container, space.section, voxel_size_m, {space.buffers_m, space.reservoir_m}, across);
    const double cells = static_cast<double>(plan.grid.size());
    const double steps_of_tuned = 85.0 * std::log(1.0 / iteration_tolerance(config));
    const double pore_length = pores * space.computed().length() + 2.0 * space.reservoir_m;
    const double fluid = space.container.vessel().mean_area(space.computed().interval()) * pore_length / std::pow(plan.voxel_size_m, 3);
    const RunSize size{.cells = cells,
                       .nodes = fluid,
                       .links_per_node = expected_links_per_node(pores, across / plan.voxel_size_m),
                       .bytes_per_number = bytes_of(config.precision)};
    Expectation expected{.memory_bytes = lbm_memory_bytes(size)};
    // With a relaxation time that follows the voxel size, a grid needs as many steps as the others; otherwise the steps grow with the
    // square of the pores' width in voxels. The search on the coarsest of several grids takes about five runs on it.
    const bool tuned = config.relaxation_time == 0.0 && config.collision == Collision::trt;
    const double steps =
        tuned && config.grids > 1 ? steps_of_tuned : std::max(steps_of_tuned, 4.0 * std::pow(across / plan.voxel_size_m, 2.0));
    const double ratio = std::pow(config.grid_ratio, -3.0), grids = static_cast<double>(config.grids);
    const double all_grids =
        (1.0 - std::pow(ratio, grids)) / (1.0 - ratio) + (tuned && config.grids > 1 ? 4.0 * std::pow(ratio, grids - 1.0) : 0.0);
    const double set_up_s = 5e-7 * fluid, rate = lattice_updates_per_second * (config.precision == Precision::single_precision ? 1.6 : 1.0);
    expected.wall_time_s = (config.tensor ? 3.0 : 1.0) * all_grids * (steps * fluid / rate + set_up_s);
    expected.disk_bytes = config.fields == FieldFiles::none ? 0.0 : 16.0 * fluid;
    expected.text = fmt::format("{} x {} x {} voxels of {:.4g} m, about {:.2g} fluid nodes", plan.grid.cells[0], plan.grid.cells[1],
                                plan.grid.cells[2], plan.voxel_size_m, fluid);
    if (const double beyond = space.computed().length() - space.section.length(); beyond > 0.0)
        expected.text += fmt::format(", {:.0f} % of them in the buffers beyond the section", 100.0 * pores * beyond / pore_length);
    expected.text += use_of_device(config.device, size, expected.wall_time_s);
    if (config.tolerance > 0.0)
        expected.text += fmt::format(
            "; with a tolerance the grids go from 6 voxels per diameter to what {:g} needs; the numbers shown are for this grid",
            config.tolerance);
    return expected;
}

Expectation expect_flow(const PoreSpace& space, const GeometryConfig& geometry, const LbmConfig& config) {
    return expect_flow(space, config, space.voxel_size_m(geometry.voxel_size_m), space.porosity(4000).value);
}

namespace {

// Of the one with the largest slab.
double bytes_of_rank(double memory_bytes, long ranks, const PoreSpace& space, double voxel_size_m, const LbmConfig& config,
                     const core::Communicator& counted_by = no_communicator()) {
    if (ranks < 2) return memory_bytes;
    return program_bytes + largest_slab(space, voxel_size_m, config, ranks, counted_by) * (memory_bytes - program_bytes);
}

}  // namespace

Expectation on_ranks(Expectation expected, long ranks, const PoreSpace& space, double voxel_size_m, const LbmConfig& config) {
    if (ranks < 2) return expected;
    if (config.device != "cpu")
        throw UserError(fmt::format("{} ranks and the device {}", ranks, config.device),
                        {.allowed = "a device computes the flow of one process", .fix = "--device cpu, or no --ranks"});
    if (const long most = max_parts(space, voxel_size_m, config); ranks > most) throw too_many_parts(ranks, most);
    expected.text += fmt::format("; {} ranks with up to {} each", ranks,
                                 human_bytes(bytes_of_rank(expected.memory_bytes, ranks, space, voxel_size_m, config)));
    const double shared_layers = 2.0 * static_cast<double>(ranks) / space.plan_at(voxel_size_m).grid.cells[2];
    expected.memory_bytes = static_cast<double>(ranks) * program_bytes + (1.0 + shared_layers) * (expected.memory_bytes - program_bytes);
    return expected;
}

ComputedFlow compute_flow(PoreSpace space, const GeometryConfig& geometry, const LbmConfig& config, const Path& checkpoint) {
    const VoxelPlan plan = space.plan_at(space.voxel_size_m(geometry.voxel_size_m));
    const double voxel = plan.voxel_size_m;
    const auto& cells = plan.grid.cells;
    const Expectation expected = expect_flow(space, geometry, config);
    const double expected_bytes = bytes_of_rank(expected.memory_bytes, ranks().parts(), space, voxel, config, ranks());
    require_memory(ranks_here() * expected_bytes, fmt::format("the flow on {} x {} x {} voxels", cells[0], cells[1], cells[2]),
                   "use a larger voxel size or a shorter section");
    const double porosity = space.porosity().value;
    LbmRun run{.with_flow = true, .checkpoint = checkpoint};
    std::optional<GrayVariants> variants;
    keep_own_part(space, variants, run, voxel, config, porosity);
    LbmResult result;
    OptionalKey<results::Tensor> tensor;
    if (config.tensor) {
        TensorResult all = lbm_tensor(space, voxel, config, run);
        tensor = all.permeability_m2;
        result = std::move(all.runs[index_of(config.direction)]);
    } else {
        result = lbm_permeability(space, voxel, config, run);
        add_gray_parts(result, space, config, run, std::move(variants));
    }
    ComputedFlow flow{.outcome = {result_of(result, space, porosity, config), {.tables = {{"history.csv", history_of(result.fine())}}}}};
    flow.outcome.result.permeability_tensor_m2 = tensor;
    flow.outcome.result.expected_memory_bytes = expected_bytes;
    if (!result.gradients.empty()) flow.outcome.files.tables.emplace_back("gradient.csv", gradients_of(result));
    flow.field = std::move(result.flow);
    return flow;
}

}  // namespace porepack::analysis
