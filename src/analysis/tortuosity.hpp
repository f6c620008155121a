// Tortuosities: four numbers with four names.
#pragma once

#include <array>
#include <vector>

#include "analysis/outcome.hpp"
#include "converters/config.hpp"
#include "converters/slices.hpp"
#include "core/choice.hpp"
#include "core/expectation.hpp"
#include "core/json_fwd.hpp"
#include "pore_space/pore_space.hpp"
#include "results/tortuosity.hpp"
#include "tortuosity/config.hpp"

namespace porepack::analysis {

enum class TortuosityKind { geometric_paper, shortest_path, hydraulic, diffusive };
constexpr std::array<core::Choice<TortuosityKind>, 4> choices_of(TortuosityKind) {
    return {{{TortuosityKind::geometric_paper, "geometric_paper"},
             {TortuosityKind::shortest_path, "shortest_path"},
             {TortuosityKind::hydraulic, "hydraulic"},
             {TortuosityKind::diffusive, "diffusive"}}};
}

[[nodiscard]] results::Diffusive compute_diffusive_tortuosity(const pore_space::PoreSpace& space,
                                                              const converters::GeometryConfig& geometry, core::Axis direction);
[[nodiscard]] Outcome<results::ShortestPath> compute_shortest_path(const pore_space::PoreSpace& space,
                                                                   const converters::GeometryConfig& geometry, core::Axis direction);
/// The paper's dots: in exact grains, or on the layers of an image.
[[nodiscard]] Outcome<results::GeometricPaper> compute_geometric_paper(const pore_space::PoreSpace& space,
                                                                       const tortuosity::TortuosityConfig& config);
[[nodiscard]] Outcome<results::GeometricPaper> compute_geometric_paper(const converters::SliceStack& slices,
                                                                       const tortuosity::TortuosityConfig& config);
/// Any of these kinds, as JSON; not the hydraulic one, which needs a flow.
[[nodiscard]] Outcome<core::Json> compute_tortuosity(TortuosityKind kind, const pore_space::PoreSpace& space,
                                                     const converters::GeometryConfig& geometry,
                                                     const tortuosity::TortuosityConfig& config);
/// Of flow.vti, or of an OpenFOAM case that has run. `section_m`: two heights, or empty: those that flow.vti names.
[[nodiscard]] results::HydraulicTortuosity compute_hydraulic_tortuosity(const core::Path& flow, const std::vector<double>& section_m);

[[nodiscard]] core::Expectation expect_tortuosity(TortuosityKind kind, double cells);

}  // namespace porepack::analysis
