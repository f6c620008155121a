// Solves grid after grid, each started from the one before; goes on from a checkpoint.
#pragma once

#include "lbm/permeability.hpp"
#include "lbm/start.hpp"

namespace porepack {

/// Area of the container and the layers of the section, in cells of the image.
[[nodiscard]] FlowSection flow_section(const PhaseImage& image, const Container& container, const Section& section, const Drive& drive);

class Sequence {
public:
    static constexpr double no_limit = 1e300;

    /// `scene` and `config` must outlive it.
    Sequence(const LbmScene& scene, const LbmConfig& config);

    [[nodiscard]] LbmResult& result() { return result_; }
    /// Grids that were begun, those left out included.
    [[nodiscard]] long attempts() const { return attempts_; }
    [[nodiscard]] std::size_t done() const { return result_.grids.size(); }
    [[nodiscard]] double voxel_size_done() const { return result_.grids.back().voxel_size_m; }
    /// Of the last grid, in SI units.
    [[nodiscard]] FlowImage flow() const;

    /// False when the time ran out before the gate was passed; the grid is then left out. On the coarsest of many grids the best
    /// viscosity is looked for.
    bool solve(double voxel_size_m, bool coarsest_of_many, double max_seconds);

private:
    struct Solved {
        Scheme scheme;
        std::unique_ptr<Flow> flow;
        StokesRun run = {};
    };
    [[nodiscard]] bool tuned() const { return config_.relaxation_time == 0.0 && config_.collision == "trt"; }
    [[nodiscard]] Scheme scheme_for(double voxel_size_m, const Drive& drive) const;
    [[nodiscard]] Solved make(const Domain& domain, const Scheme& scheme) const;
    [[nodiscard]] Solved fastest(const Domain& domain, const Scheme& scheme, const FlowSection& section, StokesGate gate) const;
    [[nodiscard]] StokesRun saved_run(Flow& flow) const;
    StokesRun run(Solved& solved, const Domain& domain, const FlowSection& section, StokesGate gate, StokesRun before);
    void require_paper_ends(const Drive& drive, const Grid& grid) const;

    const LbmScene& scene_;
    const LbmConfig& config_;
    std::optional<Json> saved_;  ///< header of the checkpoint to go on from
    std::string digest_;         ///< of the grid and all settings
    long attempts_ = 0;
    PhaseImage image_;
    std::optional<FlowField> field_;
    double force_ = 0.0;
    LbmResult result_;
};

}  // namespace porepack
