#include "lbm/sequence.hpp"

#include <fmt/format.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "lbm/layered_flow.hpp"
#include "lbm/uses.hpp"
#include "packing/packing.hpp"
#include "pore_space/percolation.hpp"
#include "pore_space/pore_space.hpp"
#include "pore_space/walls.hpp"

namespace porepack::lbm {
namespace {

std::vector<SubsectionResult> subsections(const LbmGridResult& grid, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                          const Section& planes, long parts) {
    std::vector<SubsectionResult> results;
    const double force = scheme.force[static_cast<std::size_t>(domain.drive.axis)], h = grid.voxel_size_m, height = grid.layer_height_m();
    const long layers = section.last_layer - section.first_layer + 1;
    if (domain.drive.axis != 2) return results;
    parts = std::min(parts, layers);
    for (long part = 0; part < parts; ++part) {
        const auto first = static_cast<std::size_t>(section.first_layer + layers * part / parts),
                   end = static_cast<std::size_t>(section.first_layer + layers * (part + 1) / parts);
        double flow = 0.0;
        for (std::size_t layer = first; layer < end; ++layer) flow += grid.run.layers.flow[layer];
        flow /= static_cast<double>(end - first);
        const double gradient = gradient_between(force, domain.drive, grid.run.layers, first, end - 1);
        const double z0 = planes.z0_m - section.first_layer * height;
        results.push_back({z0 + static_cast<double>(first) * height, z0 + static_cast<double>(end) * height,
                           flow * scheme.viscosity_lu() / (section.area_cells * gradient) * h * h});
    }
    return results;
}

std::vector<LayerGradient> layer_gradients(const LbmGridResult& grid, const Domain& domain, const Scheme& scheme,
                                           const FlowSection& section, const Section& planes) {
    std::vector<LayerGradient> gradients;
    if (domain.drive.axis != 2) return gradients;
    const auto first = static_cast<std::size_t>(section.first_layer), last = static_cast<std::size_t>(section.last_layer);
    const double force = scheme.force[2], height = grid.layer_height_m(),
                 mean = gradient_between(force, domain.drive, grid.run.layers, first, last);
    for (std::size_t layer = first; layer <= last; ++layer) {
        const double z0 = planes.z0_m + static_cast<double>(layer - first) * height;
        gradients.push_back({z0, z0 + height, gradient_between(force, domain.drive, grid.run.layers, layer, layer) / mean});
    }
    return gradients;
}

// The many small lists of the set-up stay with the C library otherwise.
void return_freed_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

Scheme with_tau(Scheme scheme, double tau) {
    scheme.tau = tau;
    return scheme;
}

}  // namespace

double iteration_tolerance(const LbmConfig& config) {
    return config.iteration_tolerance > 0.0 ? config.iteration_tolerance : config.tolerance > 0.0 ? 0.1 * config.tolerance : 1e-4;
}

FlowSection flow_section(const Grid& grid, const Container& container, const Section& section, const Drive& drive) {
    const auto axis = static_cast<std::size_t>(drive.axis);
    const double h = grid.spacing_m[axis];
    FlowSection flow{.last_layer = grid.whole_cells(axis) - 1};
    if (drive.axis == 2) {
        flow.area_cells = container.vessel().mean_area(section.interval()) / (h * h);
        flow.first_layer = std::max(0, static_cast<int>(std::lround((section.z0_m - grid.origin_m[2]) / h)));
        flow.last_layer = std::min(flow.last_layer, static_cast<int>(std::lround((section.z1_m - grid.origin_m[2]) / h)) - 1);
    } else {
        flow.area_cells = container.size()[1 - drive.axis] * container.size().z() / (h * h);
    }
    return flow;
}

Sequence::Sequence(const PoreSpace& space, const LbmConfig& config, const Path& checkpoint, const Communicator& parts,
                   std::shared_ptr<devices::Device> device)
    : space_(space), config_(config), checkpoint_(checkpoint), parts_(parts), device_(std::move(device)) {
    if (checkpoint_.empty() || agreed(parts_, std::filesystem::exists(checkpoint_) ? 1.0 : 0.0) == 0.0) return;
    saved_ = read_checkpoint(checkpoint_);
    attempts_ = saved_->attempts;
    result_.grids = saved_->grids;
    log_info("lattice Boltzmann: resumes from {} at step {} of grid {}", checkpoint_.string(), saved_->run.steps, result_.grids.size() + 1);
}

void Sequence::announce(std::vector<double> voxel_sizes_m, bool more) {
    announced_m_ = std::move(voxel_sizes_m);
    more_follow_ = more;
}

// The time of a grid grows with 1/h^3.5 (measured: nodes with 1/h^3, steps hardly, as the relaxation time follows).
void Sequence::show_progress(long steps, std::optional<double> share, std::string_view detail) {
    std::size_t number = 1;
    double later = 0.0;  // relative to this grid
    for (const double size : announced_m_) {
        number += size > 1.001 * size_m_ ? 1 : 0;
        if (size < 0.999 * size_m_) later += std::pow(size_m_ / size, 3.5);
    }
    // The relaxation time follows the voxel size, so that a grid needs about as many steps as the one before. The decay of the error is
    // another estimate; neither is better than the other.
    const double before = result_.grids.empty() ? 0.0 : 1.1 * static_cast<double>(result_.fine().run.steps);
    if (static_cast<double>(steps) < before) {
        const double like_before = static_cast<double>(steps) / before;
        share = std::sqrt(like_before * share.value_or(like_before));
    }
    std::optional<double> left;
    if (share && *share > 0.1) left = grid_watch_.seconds() * ((1.0 - *share) + later) / *share;
    const std::string which =
        announced_m_.size() < 2 && !more_follow_
            ? ""
            : fmt::format("grid {} of {}{}, ", number, std::max(number, announced_m_.size()), more_follow_ ? " or more" : "");
    progress_.update_left(left, which + std::string(detail));
}

void Sequence::remove_checkpoint() const {
    if (!checkpoint_.empty() && parts_.part() == 0) std::filesystem::remove(checkpoint_);
}

void Sequence::discard_grids() {
    result_.grids.clear();
    field_.reset();
}

LayeredFlow Sequence::take_flow() {
    // The voxels were freed when the nodes were known.
    const Grid whole = space_.plan_at(result_.fine().voxel_size_m).grid, own = slab(whole, field_->domain.drive.periodic[2]).without_halo();
    return layered_flow(space_.phases_on(own), std::move(*field_), whole, result_.fine(), force_, config_.superficial_velocity_m_per_s);
}

Scheme Sequence::scheme_for(double voxel_size_m, const Drive& drive) const {
    Scheme scheme = scheme_of(config_, space_.has_exact_walls(), drive);
    if (space_.ends == Ends::paper) scheme.force = {0.0, 0.0, 0.0};
    if (saved_) return with_tau(scheme, saved_->relaxation_time);
    if (!tuned()) return scheme;
    if (result_.grids.empty()) return with_tau(scheme, std::min(scheme.tau, max_tau_));
    const LbmGridResult& coarse = result_.grids.back();
    return with_tau(scheme, std::clamp(0.5 + (coarse.relaxation_time - 0.5) * viscosity_ratio(voxel_size_m), 0.55, max_tau_));
}

// Of the next grid to the last one. Viscous modes decay with nu / h^2, pressure modes with 1 / (nu L^2): the best nu grows with 1/h. Where
// the last grid needed many steps, its pores were too narrow for that, and half the viscosity is tried; a change that helped is repeated.
double Sequence::viscosity_ratio(double voxel_size_m) const {
    constexpr long many_steps = 1000;
    const LbmGridResult& last = result_.grids.back();
    const double natural = last.voxel_size_m / voxel_size_m;
    if (last.run.steps <= many_steps) return natural;
    if (result_.grids.size() < 2) return 0.5;
    const LbmGridResult& before = result_.grids[result_.grids.size() - 2];
    const bool was_lowered = last.relaxation_time < before.relaxation_time, helped = last.run.steps < before.run.steps;
    return was_lowered == helped ? 0.5 : natural;
}

bool Sequence::solve(double voxel_size_m, bool coarsest_of_many, double max_seconds) {
    ++attempts_;
    while (true) {
        try {
            return solve_once(voxel_size_m, coarsest_of_many, max_seconds);
        } catch (const FlowDiverged& fault) {
            if (!tuned() || tau_ < 0.7) throw;
            max_tau_ = 0.5 + 0.5 * (tau_ - 0.5);
            log_warning(fmt::format("{}; it is repeated with a relaxation time of at most {:.3g}", fault.what(), max_tau_));
            saved_.reset();
        }
    }
}

bool Sequence::solve_once(double voxel_size_m, bool coarsest_of_many, double max_seconds) {
    const Stopwatch set_up;
    const bool periodic = choose_drive(space_.container, config_.direction).periodic[2];
    auto [image, space, stretch] = cubic_voxels(space_, voxel_size_m, [&](const Grid& whole) { return slab(whole, periodic); });
    const Drive drive = choose_drive(space.container, config_.direction);
    if (space.ends == Ends::paper) require_paper_ends(drive, image.grid);
    size_m_ = image.grid.spacing_m[2];
    grid_watch_ = {};
    const Scheme scheme = scheme_for(voxel_size_m, drive);
    const std::optional<FlowWalls> walls = scheme.walls == Walls::interpolated ? space.walls() : std::nullopt;
    const double radius = space.ends == Ends::paper ? 0.5 * *space.container.tube_diameter() / image.grid.spacing_m[2] : 0.0;
    Domain domain = build_domain(image, drive, walls ? &*walls : nullptr, radius, parts_);
    const FlowSection section = flow_section(image.grid, space.container, space.section, drive);
    image = {};
    const double links = sum_of(parts_, static_cast<double>(domain.walls.size())),
                 narrow_links = sum_of(parts_, domain.narrow_share() * static_cast<double>(domain.walls.size()));
    LbmGridResult grid{.voxel_size_m = domain.grid.spacing_m[2],
                       .cells = {domain.grid.cells[0], domain.grid.cells[1], domain.grid.whole_cells(2)},
                       .nodes = static_cast<std::size_t>(domain.all_nodes),
                       .isolated_cells = domain.isolated_cells,
                       .wall_links = static_cast<std::size_t>(links),
                       .narrow_share = parts_.parts() == 1 ? domain.narrow_share()
                                       : links > 0.0       ? narrow_links / links
                                                           : 0.0,
                       .stretch = stretch,
                       .by_pressure = drive.by_pressure()};
    log_info("lattice Boltzmann: {} x {} x {} voxels of {:.4g} m, {} fluid nodes ({} isolated)", grid.cells[0], grid.cells[1],
             grid.cells[2], grid.voxel_size_m, grid.nodes, grid.isolated_cells);
    Solved solved{.scheme = scheme, .flow = nullptr};
    {
        const std::shared_ptr<const FlowPlan> of_domain = plan(domain);
        grid.set_up_seconds = agreed(parts_, set_up.seconds());
        if (!checkpoint_.empty()) identity_ = identity_of(space_, config_, domain);
        domain.forget_links();  // before populations need the memory
        return_freed_memory();
        if (!solve_flow(solved, *of_domain, domain, section, coarsest_of_many, max_seconds)) return false;
    }
    keep(std::move(grid), std::move(solved), std::move(domain), section);
    return true;
}

// Runs to the steady state, from the best available initial state. False when the time limit was reached.
bool Sequence::solve_flow(Solved& solved, const FlowPlan& plan, const Domain& domain, const FlowSection& section, bool search,
                          double max_seconds) {
    const ConvergenceCriterion criterion{.tolerance = iteration_tolerance(config_),
                                         .max_steps = config_.max_steps,
                                         .max_seconds = max_seconds,
                                         .stop_when_growing = tuned(),
                                         .progress = [this](auto steps, auto share, auto detail) { show_progress(steps, share, detail); }};
    const bool small = static_cast<double>(domain.all_nodes) <= nodes_of_search || domain.drive.axis != 2 || !domain.drive.by_pressure() ||
                       space_.own_grid();
    if (!saved_ && tuned() && search && small) {
        solved = fastest(plan, domain, solved.scheme, section, criterion);
    } else {
        if (!saved_ && tuned() && search) solved.scheme = with_tau(solved.scheme, relaxation_time_of_piece(domain, criterion));
        solved.flow = plan.start(solved.scheme);
        if (field_) field_ = with_layers_beyond(std::move(*field_), min_layers - 1);
        if (field_ && max_seconds == no_limit) {
            start_from(*solved.flow, domain, solved.scheme, std::move(*field_));
            field_.reset();
        } else if (field_) {  // it is the result if the time limit is reached
            start_from(*solved.flow, domain, solved.scheme, *field_);
        }
        tau_ = solved.scheme.tau;
        grid_watch_ = {};  // without the search
        solved.run = run(solved, domain, section, criterion, saved_ ? saved_run(*solved.flow, domain) : StokesRun{});
    }
    saved_.reset();
    if (!solved.run.converged && solved.run.seconds >= max_seconds) return false;
    if (!solved.run.converged)
        throw NumericalError(
            fmt::format("the flow is not steady after {} steps: iteration error {:.1e}, tolerance {:.1e}; no permeability is given",
                        solved.run.steps, solved.run.history.back().iteration_error, criterion.tolerance),
            {.fix = "raise max_steps, or loosen the tolerance"});
    return true;
}

// The results of the grid, and the flow field from which the next grid starts.
void Sequence::keep(LbmGridResult grid, Solved solved, Domain&& domain, const FlowSection& section) {
    grid.run = std::move(solved.run);
    grid.relaxation_time = solved.scheme.tau;
    grid.bytes_per_node = sum_of(parts_, solved.flow->bytes()) / static_cast<double>(domain.all_nodes);
    const double h2 = grid.voxel_size_m * grid.voxel_size_m;
    grid.permeability_m2 = grid.run.permeability_lu * h2;
    grid.permeability_volume_m2 = grid.run.permeability_volume_lu * h2;
    if (space_.computes_whole_bed() && domain.drive.axis == 2) {
        const double drop = solved.scheme.force[2] * domain.grid.whole_cells(2), length = space_.computed().length() / grid.voxel_size_m;
        grid.bed_permeability_m2 = solved.scheme.viscosity_lu() * grid.run.superficial_velocity_lu * length / drop * h2;
    }
    result_.subsections = subsections(grid, domain, solved.scheme, section, space_.section, config_.subsections);
    result_.gradients = layer_gradients(grid, domain, solved.scheme, section, space_.section);
    force_ = solved.scheme.force[static_cast<std::size_t>(domain.drive.axis)];
    field_ = take_field(*solved.flow, std::move(domain), solved.scheme);
    result_.grids.push_back(std::move(grid));
}

Grid Sequence::slab(const Grid& whole, bool periodic) {
    if (!cuts_) cuts_.emplace(space_, whole, parts_);
    return cuts_->slab_of(whole, periodic, parts_);
}

std::shared_ptr<const FlowPlan> Sequence::plan(const Domain& domain) const {
    const bool single_precision = config_.precision == Precision::single_precision;
    if (device_) return plan_flow(device_, single_precision, domain);
    return plan_flow(single_precision ? Kernel::cpu_single : Kernel::cpu_double, domain);
}

void Sequence::require_paper_ends(const Drive& drive, const Grid& grid) const {
    const bool reservoir = grid.origin_m[2] < space_.section.z0_m - 0.5 * grid.spacing_m[2];
    if (drive.axis != 2 || !drive.by_pressure() || !space_.container.tube_diameter() || !reservoir)
        throw UserError("the ends of the paper need a cylinder with a reservoir before the section",
                        {.fix = "set reservoir_m in [geometry], or ends = \"in_situ\" in [section]"});
}

// Keeps a checkpoint at the configured interval, and when the run is interrupted.
StokesRun Sequence::run(Solved& solved, const Domain& domain, const FlowSection& section, ConvergenceCriterion criterion,
                        StokesRun before) {
    Stopwatch since;
    if (!checkpoint_.empty())
        criterion.checkpoint = [&](const StokesRun& now, bool is_last) {
            if (!is_last && agreed(parts_, since.seconds()) < 60.0 * config_.checkpoint_minutes) return;
            since = {};
            SavedRun saved{
                .identity = identity_, .attempts = attempts_ - 1, .relaxation_time = solved.scheme.tau, .grids = result_.grids, .run = now};
            write_checkpoint(checkpoint_, saved, *solved.flow, domain);
            log_info("lattice Boltzmann: checkpoint at step {} in {}", now.steps, checkpoint_.string());
        };
    return run_to_steady(*solved.flow, domain, solved.scheme, section, criterion, std::move(before));
}

StokesRun Sequence::saved_run(Flow& flow, const Domain& domain) const {
    if (saved_->identity != identity_) throw CheckpointOfAnotherRun(checkpoint_);
    read_checkpoint_populations(checkpoint_, flow, domain);
    return saved_->run;
}

// The best relaxation time of a slice from the middle of the computed part. The viscous modes are the same, and the pressure along a
// long bed, whose mode is much slower there, is balanced layer by layer.
double Sequence::relaxation_time_of_piece(const Domain& domain, ConvergenceCriterion criterion) const {
    const Section computed = space_.computed();
    const double h = domain.grid.spacing_m[2], middle = 0.5 * (computed.z0_m + computed.z1_m),
                 layers = std::max(8.0, std::round(domain.grid.whole_cells(2) * nodes_of_search / static_cast<double>(domain.all_nodes)));
    const Section piece_planes = {middle - 0.5 * layers * h, middle + 0.5 * layers * h};
    // Where most pores are closed, a part may not have kept so much of an image.
    if (any_of(parts_, !space_.is_known(piece_planes))) return scheme_for(h, domain.drive).tau;
    const PoreSpace part = space_.with_section(piece_planes).section_only();
    const auto [image, piece, stretch] = cubic_voxels(part, h);
    const Drive drive = choose_drive(piece.container, config_.direction);
    const Scheme scheme = scheme_for(h, drive);
    const std::optional<FlowWalls> walls = scheme.walls == Walls::interpolated ? piece.walls() : std::nullopt;
    try {
        const Domain small = build_domain(image, drive, walls ? &*walls : nullptr);
        criterion.max_seconds = 0.2 * criterion.max_seconds;
        const Solved best =
            fastest(*plan(small), small, scheme, flow_section(image.grid, piece.container, piece.section, drive), criterion);
        log_info("lattice Boltzmann: relaxation time {:.3g}, found on {} nodes from the middle of the bed", best.scheme.tau, small.nodes());
        return best.scheme.tau;
    } catch (const DoesNotPercolate&) {
        return scheme.tau;
    }
}

// Tries viscosities by factors of two for the minimum number of steps. While none is stable, smaller ones are tried.
Sequence::Solved Sequence::fastest(const FlowPlan& plan, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                   ConvergenceCriterion criterion) const {
    criterion.progress = [tell = criterion.progress](auto steps, auto, auto detail) {
        tell(steps, std::nullopt, "relaxation time: " + std::string(detail));
    };
    std::optional<FlowDiverged> fault;  // of the last attempt that diverged
    const auto attempt = [&](double viscosity) {
        Solved solved{.scheme = with_tau(scheme, 0.5 + 3.0 * viscosity), .flow = nullptr};
        solved.flow = plan.start(solved.scheme);
        try {
            solved.run = run_to_steady(*solved.flow, domain, solved.scheme, section, criterion);
        } catch (const FlowDiverged& diverged) {
            fault = diverged;
            solved.run = {};
        }
        return solved;
    };
    const auto diverged = [](const Solved& solved) { return solved.run.history.empty(); };
    Solved best = attempt(scheme.viscosity_lu());
    for (const double factor : {2.0, 0.5}) {
        const double begin = best.scheme.viscosity_lu();
        if (factor > 1.0 && diverged(best)) continue;
        while (true) {
            const double viscosity = factor * best.scheme.viscosity_lu();
            if (0.5 + 3.0 * viscosity > max_tau_ || viscosity < 0.02) break;
            criterion.max_steps = std::min(criterion.max_steps, best.run.converged ? best.run.steps : criterion.max_steps);
            Solved other = attempt(viscosity);
            if (!diverged(best) && (!other.run.converged || (best.run.converged && other.run.steps >= best.run.steps))) break;
            best = std::move(other);
        }
        if (best.scheme.viscosity_lu() != begin) break;
    }
    if (diverged(best) && fault) throw *fault;
    return best;
}

}  // namespace porepack::lbm
