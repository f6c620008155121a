// Pours of grains with faces: seconds, cost per step, and spheres as polyhedra against exact ones.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "benchmarks/packing.hpp"
#include "core/json.hpp"
#include "core/log.hpp"
#include "packing/grains.hpp"
#include "packing/packing.hpp"
#include "packing/porosity.hpp"
#include "pouring/dem/capsule_pour.hpp"
#include "shapes/config.hpp"
#include "shapes/rounded_body.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {

namespace {

// An icosahedron whose edges are halved twice: 320 faces, the volume of a sphere.
std::shared_ptr<const RoundedBody> faceted_sphere(double diameter_m) {
    const double golden = std::numbers::phi;
    PolyhedronSize size;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-golden, golden})
            for (const Vec3& corner : {Vec3(0.0, a, b), Vec3(a, b, 0.0), Vec3(b, 0.0, a)}) size.corners_m.push_back(corner.normalized());
    const double shortest = 2.0 / std::sqrt(1.0 + golden * golden);
    const auto near = [&](int i, int j) {
        return (size.corners_m[static_cast<std::size_t>(i)] - size.corners_m[static_cast<std::size_t>(j)]).norm() < 1.1 * shortest;
    };
    for (int i = 0; i < 12; ++i)
        for (int j = i + 1; j < 12; ++j)
            for (int k = j + 1; k < 12; ++k)
                if (near(i, j) && near(j, k) && near(k, i)) size.faces.push_back({i, j, k});
    for (int halving = 0; halving < 2; ++halving) {
        std::map<std::pair<int, int>, int> middles;
        const auto middle = [&](int i, int j) {
            const auto [place, fresh] = middles.try_emplace({std::min(i, j), std::max(i, j)}, static_cast<int>(size.corners_m.size()));
            if (fresh)
                size.corners_m.push_back(
                    (size.corners_m[static_cast<std::size_t>(i)] + size.corners_m[static_cast<std::size_t>(j)]).normalized());
            return place->second;
        };
        std::vector<std::vector<int>> smaller;
        for (const auto& face : size.faces) {
            const int a = middle(face[0], face[1]), b = middle(face[1], face[2]), c = middle(face[2], face[0]);
            smaller.insert(smaller.end(), {{face[0], a, c}, {a, face[1], b}, {c, b, face[2]}, {a, b, c}});
        }
        size.faces = smaller;
    }
    for (auto& face : size.faces) {
        const auto at = [&](std::size_t n) { return size.corners_m[static_cast<std::size_t>(face[n])]; };
        if ((at(1) - at(0)).cross(at(2) - at(0)).dot(at(0)) < 0.0) std::swap(face[1], face[2]);
    }
    size.rounding_m = 0.02;
    const auto body = make_polyhedron(size);
    return body->scaled(diameter_m * std::cbrt(std::numbers::pi / 6.0 / surface_measures(*body).volume_m3));
}

}  // namespace

Json spheres_of_faces(const PackingBench& bench) {
    constexpr double diameter = 0.009;
    const Container tube = make_cylinder(0.05, 0.3);
    const auto porosity_of = [&](const Shape& shape, long seed) {
        const PackingConfig config{.fill = Fill::lattice, .seed = seed, .grains = bench.quick ? 50 : 100};
        const PourResult pour = dem::pour_with_capsules({{.shape = shape, .number_fraction = 1.0}}, tube, config, bench.folder / "spheres");
        const Grains grains(pour.packing);
        log_info("{}: {:.0f} s, {} steps", shape.id, pour.wall_time_s, pour.steps);
        return porosity(grains, tube, {0.01, grains.bounds().high.z() - 0.015}, 20000).value;
    };
    Json rows = Json::array();
    std::vector<double> differences;
    for (long seed = 1; seed <= (bench.quick ? 1 : 5); ++seed) {
        const double exact = porosity_of(make_preset(ShapeKind::sphere, diameter, 0.0), seed),
                     faces = porosity_of({.id = "sphere of 320 faces", .body = faceted_sphere(diameter)}, seed);
        rows.push_back({{"seed", seed}, {"porosity_exact", exact}, {"porosity_of_faces", faces}});
        differences.push_back(faces - exact);
    }
    double mean = 0.0, squares = 0.0;
    for (const double one : differences) mean += one / static_cast<double>(differences.size());
    for (const double one : differences) squares += (one - mean) * (one - mean);
    Json result = {{"rows", rows}, {"mean_difference", mean}};
    if (const auto n = static_cast<double>(differences.size()); n > 1.0) result["standard_error"] = std::sqrt(squares / (n - 1.0) / n);
    return result;
}

Json grains_with_faces(const PackingBench& bench) {
    struct Task {
        const char* name;
        RingSize size;
        double tube_m, height_m;
        long grains;
    };
    const Task tasks[] = {
        {"cylinders, tube of 10 diameters",
         {.diameter_m = 0.008, .height_m = 0.008, .rounding_m = 0.00018},
         0.08,
         bench.quick ? 0.3 : 1.0,
         bench.quick ? 100 : 1000},
        {"rings, tube of 6 diameters",
         {.diameter_m = 0.01, .inner_diameter_m = 0.007, .height_m = 0.01, .rounding_m = 0.00018},
         0.06,
         bench.quick ? 0.3 : 1.0,
         bench.quick ? 30 : 300},
    };
    Json rows = Json::array();
    for (const Fill fill : {Fill::lattice, Fill::batches})  // batches take several times as long
        for (const Task& task : tasks) {
            const std::vector<ShapeShare> shape = {{.shape = {.id = task.name, .body = make_ring(task.size)}, .number_fraction = 1.0}};
            const Container tube = make_cylinder(task.tube_m, task.height_m);
            PackingConfig config{.fill = fill, .grains = task.grains};
            if (fill == Fill::batches) {
                config.batch_grains = 50;
                config.drop_height_m = 0.2;  // rings that fall from higher would pass through each other
            }
            const PourPlan plan = plan_pour(shape, tube, config);
            const PourResult pour = dem::pour_with_capsules(shape, tube, config, bench.folder / "faced");
            const Grains grains(pour.packing);
            const Overlaps overlaps = find_overlaps(pour.packing);
            const auto count = static_cast<double>(task.grains);
            rows.push_back({{"grains", task.grains},
                            {"shape", task.name},
                            {"fill", name_of(fill)},
                            {"steps", pour.steps},
                            {"seconds", pour.wall_time_s},
                            {"expected_seconds", plan.expected_wall_time_s},
                            {"us_per_grain_and_step", 1e6 * pour.wall_time_s / count / static_cast<double>(pour.steps)},
                            {"porosity_bed", porosity(grains, tube, {0.0, grains.bounds().high.z()}, 20000).value},
                            {"coordination_number", 2.0 * static_cast<double>(overlaps.contacts) / count},
                            {"largest_overlap_over_thickness", overlaps.largest_between_grains_m / finest_diameter(pour.packing)}});
            log_info("{} {}, {}: {:.0f} s, {} steps", task.grains, task.name, name_of(fill), pour.wall_time_s, pour.steps);
        }
    return rows;
}

}  // namespace porepack::benchmarks
