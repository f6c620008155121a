#include "analysis/descriptors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "analysis/uses.hpp"
#include "core/table.hpp"
#include "lbm/wall_effect.hpp"
#include "packing/structure.hpp"
#include "permeability/descriptors.hpp"

namespace porepack::analysis {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

PackedBed bed_of(const PoreSpace& space, const results::Lbm& lbm) {
    // Of a surface, grain_size_m is 4 volume / area. Grains that overlap on purpose hide an unknown part of their area.
    double surface = 4.0 / space.grain_size_m;
    if (space.packing()) surface = space.packing()->overlap_allowed ? unknown : 6.0 / grain_means(*space.packing()).sauter_diameter_m;
    if (space.closing_radius_m > 0.0) surface = unknown;
    return {.porosity = lbm.porosity,
            .permeability_m2 = lbm.permeability.m2,
            .equivalent_diameter_m = space.equivalent_diameter_m,
            .surface_per_solid_per_m = surface,
            .wall_per_bed_per_m = space.container.vessel().side_per_volume()};
}

// In a cylinder, from the flow field: profiles against the radius, and k of the core.
std::optional<results::WallEffect> wall_effect(const PoreSpace& space, const FlowImage* flow, double permeability_m2, Files& files) {
    const double grain = space.equivalent_diameter_m, diameter = space.container.tube_diameter().value_or(0.0);
    if (diameter == 0.0 || flow == nullptr || !(grain > 0.0)) return std::nullopt;
    const long rings = std::clamp(std::lround(2.0 * diameter / grain), 6L, 40L);  // of about a quarter of a grain's diameter
    Table table({"r0_m", "r1_m", "porosity", "relative_velocity"});
    for (const Ring& ring : radial_profile(*flow, space.section, diameter, rings))
        table.add(ring.r0_m, ring.r1_m, ring.porosity, ring.relative_velocity);
    files.tables.emplace_back("radial.csv", table);
    const double ratio = core_over_tube(*flow, space.section, diameter, grain);
    return results::WallEffect{.layer_m = grain, .core_over_tube_permeability = ratio, .permeability_core_m2 = ratio * permeability_m2};
}

std::optional<results::Tensor> tensor_of(const Eigen::Matrix3d& matrix) {
    if (matrix.isZero()) return std::nullopt;
    results::Tensor rows{};
    for (int i = 0; i < 3; ++i) rows[static_cast<std::size_t>(i)] = {matrix(i, 0), matrix(i, 1), matrix(i, 2)};
    return rows;
}

// How the grains of the whole bed lie and touch.
std::optional<results::BedStructure> bed_structure(const PoreSpace& space, Files& files) {
    if (!space.packing()) return std::nullopt;
    constexpr double gap_of_diameter = 1e-3;  // grains that only just touch, as in a given packing
    const Container& container = space.container;
    const Vec3 inner = container.high() - container.low();
    const double range = std::min(4.0 * space.equivalent_diameter_m, 0.5 * std::min(inner.x(), inner.y()));
    const Structure found = structure_of(*space.packing(), gap_of_diameter * space.grain_size_m, range, 40);
    Table contacts({"neighbours", "grains"}), distribution({"r0_m", "r1_m", "radial_distribution"});
    for (std::size_t n = 0; n < found.grains_with_neighbours.size(); ++n) contacts.add(n, found.grains_with_neighbours[n]);
    for (const RadialBin& bin : found.radial_distribution) distribution.add(bin.r0_m, bin.r1_m, bin.distribution);
    files.tables.emplace_back("contacts.csv", contacts);
    files.tables.emplace_back("radial_distribution.csv", distribution);
    return results::BedStructure{.orientation_tensor = tensor_of(found.orientation),
                                 .contact_orientation_tensor = tensor_of(found.contact_orientation),
                                 .mean_neighbours = found.mean_neighbours,
                                 .contact_points = found.contact_points};
}

// The flows with inertia beside correlations for beds.
std::vector<results::FrictionPoint> friction_points(const results::Forchheimer& forchheimer, const PackedBed& bed,
                                                    const BedNumbers& numbers, const Container& container, Files& files) {
    constexpr double viscosity = 1e-6;  // of water; the friction factor depends on the Reynolds number alone
    const double relative =
        container.tube_diameter() ? numbers.sauter_diameter_m / *container.tube_diameter() : unknown;  // a correction for cylinders
    Table table({"reynolds_modified", "friction_factor", "ergun", "carman_1937", "eisfeld_schnitzlein"});
    std::vector<results::FrictionPoint> points;
    for (const InertialFlow& flow : forchheimer.lbm.grids.back().flows) {
        const double velocity = flow.reynolds * viscosity / forchheimer.length_m;
        const Friction found = friction_of(velocity, viscosity, flow.permeability_m2, numbers.sauter_diameter_m, bed.porosity);
        const results::FrictionPoint point{.reynolds_modified = found.reynolds,
                                           .friction_factor = found.factor,
                                           .ergun = ergun_friction(found.reynolds),
                                           .carman_1937 = carman_friction(found.reynolds),
                                           .eisfeld_schnitzlein = eisfeld_schnitzlein_friction(found.reynolds, relative, bed.porosity)};
        table.add(point.reynolds_modified, point.friction_factor, point.ergun, point.carman_1937, point.eisfeld_schnitzlein);
        points.push_back(point);
    }
    files.tables.emplace_back("friction.csv", table);
    return points;
}

}  // namespace

Outcome<results::Descriptors> describe_bed(const PoreSpace& space, const results::Lbm& lbm, const FlowImage* flow,
                                           const std::optional<results::Forchheimer>& forchheimer) {
    const PackedBed bed = bed_of(space, lbm);
    const BedNumbers numbers = bed_numbers(bed);
    Files files;
    results::Descriptors result{
        .porosity = bed.porosity,
        .permeability_m2 = bed.permeability_m2,
        .equivalent_diameter_m = bed.equivalent_diameter_m > 0.0 ? std::optional(bed.equivalent_diameter_m) : std::nullopt,
        .surface_per_solid_per_m = bed.surface_per_solid_per_m,
        .wall_per_bed_per_m = bed.wall_per_bed_per_m,
        .numbers = numbers,
        .wall = wall_effect(space, flow, bed.permeability_m2, files),
        .structure = bed_structure(space, files)};
    if (forchheimer) result.friction = friction_points(*forchheimer, bed, numbers, space.container, files);
    return {result, files};
}

}  // namespace porepack::analysis
