// Flows with inertia: results/forchheimer/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "lbm/inertial_series.hpp"
#include "permeability/forchheimer.hpp"
#include "permeability/inertial_laws.hpp"

namespace porepack::results {

struct InertiaByLattice {
    std::string method;
    std::vector<lbm::InertialSeries> grids;                    ///< coarse to fine
    std::optional<double> creeping_permeability_grid_error{};  ///< relative change between the two finest grids
    std::optional<std::string> stopped_by{};                   ///< why there is no flow at a larger Reynolds number
    permeability::ForchheimerFit fit = {};                     ///< on the finest grid
    permeability::InertialLaws laws = {};
    std::optional<double> inertial_permeability_grid_error{};
    std::string interval_meaning;
};
template <core::MembersOf<InertiaByLattice> Self, typename Visit>
void visit_members(Self& part, const Visit& visit) {
    visit("method", part.method);
    visit("grids", part.grids);
    visit("creeping_permeability_grid_error", part.creeping_permeability_grid_error);
    visit("stopped_by", part.stopped_by);
    visit("", part.fit);
    visit("laws", part.laws);
    visit("inertial_permeability_grid_error", part.inertial_permeability_grid_error);
    visit("interval_meaning", part.interval_meaning);
}

struct FlowByFoam {
    double reynolds = 0.0, permeability_m2 = 0.0;  ///< of the section alone
    double pressure_drop_m2_per_s2 = 0.0;
    double momentum_share = 0.0;
    long iterations = 0;
};
template <core::MembersOf<FlowByFoam> Self, typename Visit>
void visit_members(Self& flow, const Visit& visit) {
    visit("reynolds", flow.reynolds);
    visit("permeability_m2", flow.permeability_m2);
    visit("pressure_drop_m2_per_s2", flow.pressure_drop_m2_per_s2);
    visit("momentum_share", flow.momentum_share);
    visit("iterations", flow.iterations);
}

struct InertiaByFoam {
    std::string method;
    double cell_size_m = 0.0;
    long cells = 0;
    double mesh_volume_ratio = 0.0;
    double wall_time_s = 0.0;
    std::string interval_meaning;
    std::string repeat_by_hand;
    std::optional<std::string> stopped_by{};
    std::vector<FlowByFoam> flows;  ///< the first is creeping flow
    // Of four flows or more.
    core::OptionalKey<permeability::ForchheimerFit> fit = {};
    core::OptionalKey<permeability::InertialLaws> laws = {};
};
template <core::MembersOf<InertiaByFoam> Self, typename Visit>
void visit_members(Self& part, const Visit& visit) {
    visit("method", part.method);
    visit("cell_size_m", part.cell_size_m);
    visit("cells", part.cells);
    visit("mesh_volume_ratio", part.mesh_volume_ratio);
    visit("wall_time_s", part.wall_time_s);
    visit("interval_meaning", part.interval_meaning);
    visit("repeat_by_hand", part.repeat_by_hand);
    visit("stopped_by", part.stopped_by);
    visit("flows", part.flows);
    visit("", part.fit);
    visit("laws", part.laws);
}

struct Forchheimer {
    static constexpr const char* stage = "forchheimer";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 4;
    double length_m = 0.0;  ///< of the Reynolds numbers
    std::string length_is;
    double porosity = 0.0;
    core::Interval section_m;
    std::string ends;
    std::array<double, 2> buffers_m{};
    double free_water_m = 0.0;
    bool converged = false;
    double ergun_inertial_permeability_m = 0.0;
    InertiaByLattice lbm;
    core::OptionalKey<InertiaByFoam> openfoam = {};
    double inertial_permeability_m = 0.0;
    core::Interval inertial_permeability_interval_m;
    std::string interval_meaning;
    std::string beyond_largest_reynolds;  ///< what k_in is there
    double expected_memory_bytes = 0.0, peak_memory_bytes = 0.0;
};
template <core::MembersOf<Forchheimer> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("length_m", found.length_m);
    visit("length_is", found.length_is);
    visit("porosity", found.porosity);
    visit("section_m", found.section_m);
    visit("ends", found.ends);
    visit("buffers_m", found.buffers_m);
    visit("free_water_m", found.free_water_m);
    visit("converged", found.converged);
    visit("ergun_inertial_permeability_m", found.ergun_inertial_permeability_m);
    visit("lbm", found.lbm);
    visit("openfoam", found.openfoam);
    visit("inertial_permeability_m", found.inertial_permeability_m);
    visit("inertial_permeability_interval_m", found.inertial_permeability_interval_m);
    visit("interval_meaning", found.interval_meaning);
    visit("beyond_largest_reynolds", found.beyond_largest_reynolds);
    visit("expected_memory_bytes", found.expected_memory_bytes);
    visit("peak_memory_bytes", found.peak_memory_bytes);
}

}  // namespace porepack::results
