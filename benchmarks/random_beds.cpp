#include "benchmarks/random_beds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>

#include "pore_space/pore_space.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {
namespace {

constexpr double d = 4e-3;  // of the capsules
constexpr std::array kinds = {ShapeKind::sphere, ShapeKind::tetrapod, ShapeKind::rod};
constexpr std::array kind_names = {"spheres", "tetrapods", "rods"};
enum class Sides { cylinder, box, periodic };
constexpr std::array side_names = {"cylinder", "box", "periodic"};
enum class Way { poured, apart, overlapping };
constexpr std::array way_names = {"poured", "apart", "overlapping"};
constexpr std::array<double, 4> porosities_apart = {0.80, 0.75, 0.72, 0.78};
constexpr std::array<double, 6> porosities_overlapping = {0.30, 0.40, 0.50, 0.60, 0.70, 0.35};

Shape shape_of(int kind) {
    constexpr std::array<double, 3> lengths = {0.0, 2.2, 3.0};  // in diameters
    return make_preset(kinds[static_cast<std::size_t>(kind)], d, lengths[static_cast<std::size_t>(kind)] * d);
}

Container container_of(Sides sides, double width, double height) {
    if (sides == Sides::cylinder) return vessels::make_cylinder(width, height);
    if (sides == Sides::periodic) return vessels::make_box({width, width, 5.0 * d}, {true, true, true});
    return vessels::make_box({width, width, height});
}

double gap_of(const Packing& packing, const Body& first, const Body& second) {
    Body nearest = second;
    for (int axis = 0; axis < 3; ++axis)
        if (const double side = packing.container.size()[axis]; packing.container.periodic()[static_cast<std::size_t>(axis)])
            nearest.position_m[axis] += side * std::round((first.position_m[axis] - second.position_m[axis]) / side);
    double least = 1e300;
    for (const Capsule& one : world_capsules(packing, first))
        for (const Capsule& other : world_capsules(packing, nearest)) least = std::min(least, gap(one, other));
    return least;
}

bool inside(const Packing& packing, const Body& body) {
    const Container& container = packing.container;
    for (const Capsule& capsule : world_capsules(packing, body))
        for (const Vec3& end : {capsule.a, capsule.b}) {
            if (container.wall_distance(end) < capsule.radius) return false;
            if (!container.periodic()[2] && (end.z() < capsule.radius || end.z() > container.height() - capsule.radius)) return false;
        }
    return true;
}

// Grains at random poses until the porosity is reached.
void place(Packing& packing, double porosity_wanted, bool overlapping, std::mt19937_64& random) {
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::normal_distribution<double> normal;
    const Vec3 low = packing.container.low(), size = packing.container.high() - low;
    const double volume = measure(packing.shapes[0], 1e-6).volume_m3,
                 space = packing.container.inner_area_m2() * packing.container.height();
    // Of grains that overlap at random, exp(-number x volume / space) stays open.
    const double number = overlapping ? -std::log(porosity_wanted) * space / volume : (1.0 - porosity_wanted) * space / volume;
    for (long attempt = 0; attempt < 400000 && static_cast<double>(packing.bodies.size()) < number; ++attempt) {
        const Body body{.shape = 0,
                        .position_m = low + Vec3(uniform(random), uniform(random), uniform(random)).cwiseProduct(size),
                        .orientation = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized()};
        if (!inside(packing, body)) continue;
        const bool free = overlapping || std::none_of(packing.bodies.begin(), packing.bodies.end(),
                                                      [&](const Body& other) { return gap_of(packing, body, other) < 0.0; });
        if (free) packing.bodies.push_back(body);
    }
}

Packing poured(const Shape& shape, const Container& container, unsigned seed, const Path& folder) {
    PackingConfig config{.fill = Fill::lattice, .seed = static_cast<long>(seed), .fill_height_m = 0.45 * container.height()};
    make_folder(folder);
    return dem::pour_with_capsules({{.shape = shape, .number_fraction = 1.0}}, container, config, folder).packing;
}

Sides sides_of(int index) {
    return static_cast<Sides>(index / 3 % 3);
}

// In diameters; the first number of the bed's random sequence.
double usual_width(std::mt19937_64& random) {
    return 8.0 + 0.5 * static_cast<double>(random() % 3);
}

}  // namespace

double grains_of_random_bed(int index, double porosity) {
    std::mt19937_64 random(static_cast<std::uint64_t>(1000 + index));
    const double width = usual_width(random), area = width * width;
    const double volume = sides_of(index) == Sides::cylinder ? 0.25 * std::numbers::pi * area * 2.0
                          : sides_of(index) == Sides::box    ? area * 2.0
                                                             : area * 5.0;
    return (1.0 - porosity) * volume;
}

RandomBed random_bed(int index, const Path& folder, double wide_diameters) {
    const int kind = index % 3, turn = index / 3;
    const Sides sides = sides_of(index);
    // Grains cannot be poured into a box that is periodic along z.
    const auto way = sides == Sides::periodic ? (index % 2 == 0 ? Way::apart : Way::overlapping) : static_cast<Way>((turn / 3 + kind) % 3);
    std::mt19937_64 random(static_cast<std::uint64_t>(1000 + index));
    const double usual = usual_width(random), width = (wide_diameters > 0.0 ? wide_diameters : usual) * d;
    RandomBed bed{.name = {}, .packing = {}, .section_diameters = sides == Sides::periodic ? 0.0 : wide_diameters > 0.0 ? 4.0 : 2.0};
    Packing& packing = bed.packing;
    packing.container = container_of(sides, width, way == Way::poured ? 26.0 * d : 11.0 * d);
    packing.shapes = {shape_of(kind)};
    if (way == Way::poured) {
        packing = poured(packing.shapes[0], packing.container, static_cast<unsigned>(index + 1),
                         folder / fmt::format("bed_{}{}", index, wide_diameters > 0.0 ? "_wide" : ""));
    } else {
        const auto turns = static_cast<std::size_t>(index);
        place(packing, way == Way::apart ? porosities_apart[turns % 4] : porosities_overlapping[turns % 6], way == Way::overlapping,
              random);
        packing.overlap_allowed = way == Way::overlapping;
    }
    bed.name = fmt::format("{} {} {} {:.0f}d", kind_names[static_cast<std::size_t>(kind)], side_names[static_cast<std::size_t>(sides)],
                           way_names[static_cast<std::size_t>(way)], width / d);
    return bed;
}

PoreSpace pore_space_of(const RandomBed& bed, int position) {
    Packing packing = bed.packing;
    const Container& container = packing.container;
    if (position > 0 && container.tube_diameter()) {
        const Quaternion turn(Eigen::AngleAxisd(0.6, Vec3::UnitZ()));
        for (Body& body : packing.bodies) {
            body.position_m = turn * body.position_m;
            body.orientation = turn * body.orientation;
        }
    } else if (position > 0 && container.periodic()[2]) {
        for (Body& body : packing.bodies)
            for (int axis = 0; axis < 3; ++axis) {
                double& x = body.position_m[axis];
                x += (0.137 + 0.211 * axis) * d;
                x -= container.size()[axis] * std::floor(x / container.size()[axis]);
            }
    }
    PoreSpace space = pore_space::pore_space_of(std::move(packing));
    if (position > 0 && !container.tube_diameter() && !container.periodic()[2]) space.grain_size_m /= 1.05;
    if (bed.section_diameters == 0.0) return space;
    const double middle = 0.5 * (space.bed_bottom_m + space.bed_top_m), half = 0.5 * bed.section_diameters * d;
    return space.with_section({middle - half, middle + half}).with_ends(Ends::in_situ);
}

}  // namespace porepack::benchmarks
