// Solves a sequence of grids, each started from the previous one; resumes from a checkpoint.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/files.hpp"
#include "core/log.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/slabs.hpp"
#include "lbm/start.hpp"
#include "packing/grains.hpp"
#include "packing/section.hpp"

namespace porepack::lbm {

/// Area of the container and the layers of the section, in cells of the grid; of a slab, those of the whole.
[[nodiscard]] FlowSection flow_section(const geometry::Grid& grid, const vessels::Container& container, const packing::Section& section,
                                       const pore_space::Drive& drive);

/// Iteration error of k at which the run on a grid stops: that of the configuration, or what auto means.
[[nodiscard]] double iteration_tolerance(const LbmConfig& config);

inline constexpr double nodes_of_search = 2e5;  ///< the best viscosity is searched on at most about this number of nodes

class Sequence {
public:
    static constexpr double no_limit = 1e300;

    /// `space` and `config` must outlive it. Resumes from the file `checkpoint` if it exists, and updates it; none if empty.
    Sequence(const pore_space::PoreSpace& space, const LbmConfig& config, const core::Path& checkpoint,
             const core::Communicator& parts = core::no_communicator(), std::shared_ptr<devices::Device> device = nullptr);

    /// Instead of cuts of its own.
    void cut(SlabCuts cuts) { cuts_ = std::move(cuts); }
    [[nodiscard]] LbmResult& result() { return result_; }
    /// Number of grids started, including omitted ones.
    [[nodiscard]] long attempts() const { return attempts_; }
    [[nodiscard]] std::size_t done() const { return result_.grids.size(); }
    [[nodiscard]] double voxel_size_done() const { return result_.grids.back().voxel_size_m; }
    /// The voxel sizes that will be solved, coarse to fine, for the time left; with `more`, finer ones may follow.
    void announce(std::vector<double> voxel_sizes_m, bool more);
    void remove_checkpoint() const;
    /// Forgets all grids: their pores were open by chance.
    void discard_grids();
    /// Of the last grid, in SI units; the sequence keeps it no longer.
    [[nodiscard]] geometry::LayeredFlow take_flow();

    /// False when the time limit was reached before the flow was steady; the grid is then omitted. On the coarsest grid the best
    /// viscosity is determined.
    /// A flow that grows is repeated with a smaller viscosity.
    bool solve(double voxel_size_m, bool coarsest_of_many, double max_seconds);

private:
    bool solve_once(double voxel_size_m, bool coarsest_of_many, double max_seconds);
    struct Solved {
        Scheme scheme;
        std::unique_ptr<Flow> flow;
        StokesRun run = {};
    };
    [[nodiscard]] bool tuned() const { return config_.relaxation_time == 0.0 && config_.collision == Collision::trt; }
    [[nodiscard]] double viscosity_ratio(double voxel_size_m) const;
    [[nodiscard]] Scheme scheme_for(double voxel_size_m, const pore_space::Drive& drive) const;
    [[nodiscard]] std::shared_ptr<const FlowPlan> plan(const Domain& domain) const;
    [[nodiscard]] Solved fastest(const FlowPlan& plan, const Domain& domain, const Scheme& scheme, const FlowSection& section,
                                 ConvergenceCriterion criterion) const;
    [[nodiscard]] double relaxation_time_of_piece(const Domain& domain, ConvergenceCriterion criterion) const;
    [[nodiscard]] bool solve_flow(Solved& solved, const FlowPlan& plan, const Domain& domain, const FlowSection& section, bool search,
                                  double max_seconds);
    void keep(LbmGridResult grid, Solved solved, Domain&& domain, const FlowSection& section);
    [[nodiscard]] StokesRun saved_run(Flow& flow, const Domain& domain) const;
    StokesRun run(Solved& solved, const Domain& domain, const FlowSection& section, ConvergenceCriterion criterion, StokesRun before);
    /// The slab of this part, with its halo.
    [[nodiscard]] geometry::Grid slab(const geometry::Grid& whole, bool periodic);
    void require_paper_ends(const pore_space::Drive& drive, const geometry::Grid& grid) const;

    const pore_space::PoreSpace& space_;
    const LbmConfig& config_;
    core::Path checkpoint_;
    const core::Communicator& parts_;
    std::shared_ptr<devices::Device> device_;  ///< none: the processor
    std::optional<SlabCuts> cuts_;             ///< from the first grid on
    std::optional<SavedRun> saved_;            ///< contents of the checkpoint, until the run has resumed from it
    std::string identity_;                     ///< of the grid and all settings
    long attempts_ = 0;
    std::optional<FlowField> field_;
    double force_ = 0.0;
    double tau_ = 0.0;      ///< of the flow that runs
    double max_tau_ = 2.0;  ///< of those that are chosen automatically: above, walls in pores of a few nodes can be unstable
    LbmResult result_;
    void show_progress(long steps, std::optional<double> share, std::string_view detail);
    std::vector<double> announced_m_;
    bool more_follow_ = false;
    double size_m_ = 0.0;  ///< of the voxels of the grid that runs
    core::Stopwatch grid_watch_;
    core::Progress progress_{"lattice Boltzmann"};
};

}  // namespace porepack::lbm
