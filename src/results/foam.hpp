// Permeability by OpenFOAM: results/foam/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/members.hpp"
#include "openfoam/foam_result.hpp"
#include "results/permeability.hpp"

namespace porepack::results {

struct Foam {
    static constexpr const char* stage = "foam";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 4;
    Permeability permeability;
    double conductance_m3 = 0.0;  ///< as of lattice Boltzmann
    std::string method;
    std::string repeat_by_hand;
    std::string interval_meaning;
    std::optional<double> observed_order{}, grid_convergence_index{};
    core::Interval section_m;
    std::string ends;
    std::array<double, 2> buffers_m{};
    bool converged = false;
    long cells = 0, iterations = 0;  ///< of the finest mesh
    openfoam::FoamMeshResult fine = {};
    std::vector<openfoam::FoamMeshResult> meshes;
    double expected_memory_bytes = 0.0;
};
template <core::MembersOf<Foam> Self, typename Visit>
void visit_members(Self& foam, const Visit& visit) {
    visit("", foam.permeability);
    visit("conductance_m3", foam.conductance_m3);
    visit("method", foam.method);
    visit("repeat_by_hand", foam.repeat_by_hand);
    visit("interval_meaning", foam.interval_meaning);
    visit("observed_order", foam.observed_order);
    visit("grid_convergence_index", foam.grid_convergence_index);
    visit("section_m", foam.section_m);
    visit("ends", foam.ends);
    visit("buffers_m", foam.buffers_m);
    visit("converged", foam.converged);
    visit("cells", foam.cells);
    visit("iterations", foam.iterations);
    visit("fine", foam.fine);
    visit("meshes", foam.meshes);
    visit("expected_memory_bytes", foam.expected_memory_bytes);
}

}  // namespace porepack::results
