// Tortuosities of four kinds: results/tortuosity/result.json.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/choice.hpp"
#include "core/interval.hpp"
#include "core/members.hpp"

namespace porepack::results {

/// The paper's dots.
struct GeometricPaper {
    std::string kind = "geometric_paper";
    std::string geometry;  ///< "exact" or "pixels"
    double tortuosity = 0.0;
    double standard_error = 0.0, standard_deviation = 0.0;  ///< over paths; NaN of one
    long paths = 0, slices = 0;
    double rejections_per_point = 0.0;
    std::string paths_file;
    core::OptionalKey<double> pixel_m = {};
};
template <core::MembersOf<GeometricPaper> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("kind", found.kind);
    visit("geometry", found.geometry);
    visit("tortuosity_geometric_paper", found.tortuosity);
    visit("standard_error", found.standard_error);
    visit("standard_deviation", found.standard_deviation);
    visit("paths", found.paths);
    visit("slices", found.slices);
    visit("rejections_per_point", found.rejections_per_point);
    visit("paths_file", found.paths_file);
    visit("pixel_m", found.pixel_m);
}

struct ShortestPath {
    std::string kind = "shortest_path";
    core::Axis direction = core::Axis::z;
    std::string geometry;
    double voxel_size_m = 0.0;
    double tortuosity = 0.0;
    std::string meaning = "mean over starting points on the first end plane";
    double standard_error = 0.0, standard_deviation = 0.0;
    double minimum = 0.0, maximum = 0.0;
    long starts = 0, blocked_starts = 0;
    std::string paths_file;
};
template <core::MembersOf<ShortestPath> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("kind", found.kind);
    visit("direction", found.direction);
    visit("geometry", found.geometry);
    visit("voxel_size_m", found.voxel_size_m);
    visit("tortuosity_shortest_path", found.tortuosity);
    visit("meaning", found.meaning);
    visit("standard_error", found.standard_error);
    visit("standard_deviation", found.standard_deviation);
    visit("tortuosity_shortest_path_minimum", found.minimum);
    visit("tortuosity_shortest_path_maximum", found.maximum);
    visit("starts", found.starts);
    visit("blocked_starts", found.blocked_starts);
    visit("paths_file", found.paths_file);
}

struct DiffusiveGrid {
    double voxel_size_m = 0.0, tortuosity_factor = 0.0;
};
template <core::MembersOf<DiffusiveGrid> Self, typename Visit>
void visit_members(Self& grid, const Visit& visit) {
    visit("voxel_size_m", grid.voxel_size_m);
    visit("tortuosity_factor", grid.tortuosity_factor);
}

/// The tortuosity factor, eps D0/D_eff.
struct Diffusive {
    std::string kind = "diffusive";
    core::Axis direction = core::Axis::z;
    double tortuosity_factor = 0.0;
    std::string meaning = "porosity times D0 over D_eff";
    std::optional<core::Interval> interval{};  ///< of 95 %
    double relative_diffusivity = 0.0;         ///< D_eff/D0
    double porosity = 0.0, porosity_flowing = 0.0;
    double voxel_size_m = 0.0;
    long iterations = 0;
    double residual = 0.0, flux_imbalance = 0.0;
    bool converged = false;
    std::vector<DiffusiveGrid> grids;
    std::string ends;
    core::OptionalKey<std::string> no_interval_because = {}, note = {};
    core::OptionalKey<core::Interval> interval_of_the_grids = {};  ///< of a gray image: without its gray levels and blur
};
template <core::MembersOf<Diffusive> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("kind", found.kind);
    visit("direction", found.direction);
    visit("tortuosity_factor", found.tortuosity_factor);
    visit("meaning", found.meaning);
    visit("interval", found.interval);
    visit("relative_diffusivity", found.relative_diffusivity);
    visit("porosity", found.porosity);
    visit("porosity_flowing", found.porosity_flowing);
    visit("voxel_size_m", found.voxel_size_m);
    visit("iterations", found.iterations);
    visit("residual", found.residual);
    visit("flux_imbalance", found.flux_imbalance);
    visit("converged", found.converged);
    visit("grids", found.grids);
    visit("ends", found.ends);
    visit("no_interval_because", found.no_interval_because);
    visit("note", found.note);
    visit("interval_of_the_grids", found.interval_of_the_grids);
}

/// Of the flow.
struct HydraulicTortuosity {
    std::string kind = "hydraulic";
    core::OptionalKey<std::string> solver = {};
    core::Axis direction = core::Axis::z;
    double tortuosity = 0.0;
    std::optional<double> uncertainty{};
};
template <core::MembersOf<HydraulicTortuosity> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("kind", found.kind);
    visit("solver", found.solver);
    visit("direction", found.direction);
    visit("tortuosity_hydraulic", found.tortuosity);
    visit("uncertainty", found.uncertainty);
}

struct Tortuosity {
    static constexpr const char* stage = "tortuosity";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 4;
    core::OptionalKey<GeometricPaper> geometric_paper_exact = {}, geometric_paper_pixels = {};
    core::OptionalKey<ShortestPath> shortest_path = {};
    core::OptionalKey<Diffusive> diffusive = {};
    HydraulicTortuosity hydraulic = {};
};
template <core::MembersOf<Tortuosity> Self, typename Visit>
void visit_members(Self& tortuosity, const Visit& visit) {
    visit("geometric_paper_exact", tortuosity.geometric_paper_exact);
    visit("geometric_paper_pixels", tortuosity.geometric_paper_pixels);
    visit("shortest_path", tortuosity.shortest_path);
    visit("diffusive", tortuosity.diffusive);
    visit("hydraulic", tortuosity.hydraulic);
}

}  // namespace porepack::results
