// Dimensionless numbers of the bed, the part of the wall, the structure: results/descriptors/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/members.hpp"
#include "permeability/descriptors.hpp"
#include "results/tensor.hpp"

namespace porepack::results {

/// In a cylinder, from the flow field.
struct WallEffect {
    double layer_m = 0.0;
    double core_over_tube_permeability = 0.0;  ///< NaN where the layers meet
    double permeability_core_m2 = 0.0;
    std::string meaning =
        "mean velocity more than layer_m from the wall over that of the tube: an estimate of k of an infinitely wide bed, which would "
        "also have the porosity of the core";
};
template <core::MembersOf<WallEffect> Self, typename Visit>
void visit_members(Self& wall, const Visit& visit) {
    visit("layer_m", wall.layer_m);
    visit("core_over_tube_permeability", wall.core_over_tube_permeability);
    visit("permeability_core_m2", wall.permeability_core_m2);
    visit("meaning", wall.meaning);
}

/// How the grains of the whole bed lie and touch; none: no capsule with an axis, no contact.
struct BedStructure {
    std::optional<Tensor> orientation_tensor{}, contact_orientation_tensor{};
    double mean_neighbours = 0.0;
    long contact_points = 0;
};
template <core::MembersOf<BedStructure> Self, typename Visit>
void visit_members(Self& structure, const Visit& visit) {
    visit("orientation_tensor", structure.orientation_tensor);
    visit("contact_orientation_tensor", structure.contact_orientation_tensor);
    visit("mean_neighbours", structure.mean_neighbours);
    visit("contact_points", structure.contact_points);
}

/// A flow with inertia beside correlations for beds.
struct FrictionPoint {
    double reynolds_modified = 0.0, friction_factor = 0.0, ergun = 0.0, carman_1937 = 0.0;
    double eisfeld_schnitzlein = 0.0;  ///< NaN: not in a cylinder
};
template <core::MembersOf<FrictionPoint> Self, typename Visit>
void visit_members(Self& point, const Visit& visit) {
    visit("reynolds_modified", point.reynolds_modified);
    visit("friction_factor", point.friction_factor);
    visit("ergun", point.ergun);
    visit("carman_1937", point.carman_1937);
    visit("eisfeld_schnitzlein", point.eisfeld_schnitzlein);
}

struct Descriptors {
    static constexpr const char* stage = "descriptors";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    double porosity = 0.0, permeability_m2 = 0.0;
    std::optional<double> equivalent_diameter_m{};
    double surface_per_solid_per_m = 0.0;  ///< NaN: not known
    double wall_per_bed_per_m = 0.0;
    permeability::BedNumbers numbers = {};
    std::optional<WallEffect> wall{};
    std::optional<BedStructure> structure{};
    std::optional<std::vector<FrictionPoint>> friction{};
};
template <core::MembersOf<Descriptors> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("porosity", found.porosity);
    visit("permeability_m2", found.permeability_m2);
    visit("equivalent_diameter_m", found.equivalent_diameter_m);
    visit("surface_per_solid_per_m", found.surface_per_solid_per_m);
    visit("wall_per_bed_per_m", found.wall_per_bed_per_m);
    visit("numbers", found.numbers);
    visit("wall", found.wall);
    visit("structure", found.structure);
    visit("friction", found.friction);
}

}  // namespace porepack::results
