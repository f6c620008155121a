// Union and repair: the grains' meshes become one closed surface without faults in single precision, the precision of the STL file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "converters/contact_joints.hpp"
#include "converters/grain_mesh.hpp"
#include "converters/mesh_intersections.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/parallel.hpp"
#include "shapes/distance.hpp"

namespace porepack::converters {
namespace {

constexpr int maximum_repairs = 7;      // rounds of thinner grains with one contact gap
constexpr double largest_change = 0.1;  // deviation and contact gap, of the thickness of the grains

// The cost of a step, for the time left, in meshes of one image: that of uniting two meshes grows with the images in them, and the last
// unions have one thread.
double threads_of(std::size_t tasks) {
    return std::min(static_cast<double>(tasks), static_cast<double>(thread_count()));
}
double cost_of_union(std::size_t meshes) {
    double cost = 0.0;
    for (double images = 2.0; meshes > 1; meshes = (meshes + 1) / 2, images *= 2.0)
        cost += static_cast<double>(meshes / 2) * images / threads_of(meshes / 2);
    return cost;
}

// Unions pairwise as a tree, neighbours in z first.
Mesh unite_group(std::vector<Mesh> meshes, const std::function<void(double cost)>& done) {
    double images = 2.0;
    for (; meshes.size() > 1; images *= 2.0) {
        const std::size_t pairs = meshes.size() / 2;
        parallel_for(pairs, [&](std::size_t p) {
            unite_into(meshes[2 * p], meshes[2 * p + 1]);
#pragma omp critical
            done(images / threads_of(pairs));
        });
        std::vector<Mesh> next;
        for (std::size_t p = 0; p < meshes.size(); p += 2) next.push_back(std::move(meshes[p]));
        meshes = std::move(next);
    }
    return std::move(meshes.front());
}

// Of corners and middles of facets and edges from the exact surface of all images; at most `cap`.
double largest_deviation(const TriangleSurface& surface, const Grains& grains, double deviation, double cap) {
    // Lists of what is near a triangle are fast. Through periodic sides they hold other images than the surface, and beyond their reach
    // they are not complete.
    const bool listed = !grains.packing().container.any_periodic();
    double worst = 0.0;
#pragma omp parallel reduction(max : worst)
    {
        std::vector<Capsule> capsules;
        std::vector<PlacedShape> bodies;
#pragma omp for schedule(dynamic, 256)
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            Vec3 corner[3];
            for (std::size_t c = 0; c < 3; ++c) {
                const auto& p = surface.points[static_cast<std::size_t>(surface.triangles[t][c])];
                corner[c] = Vec3(p[0], p[1], p[2]);
            }
            const Vec3 middle = (corner[0] + corner[1] + corner[2]) / 3.0;
            double reach = 4.0 * deviation;
            for (const Vec3& at : corner) reach = std::max(reach, (at - middle).norm() + 4.0 * deviation);
            capsules.clear();
            bodies.clear();
            if (listed) {
                grains.capsules_near(middle, reach, capsules);
                grains.bodies_near(middle, reach, bodies);
            }
            for (const Vec3& at : {corner[0], middle, Vec3((corner[0] + corner[1]) / 2.0), Vec3((corner[1] + corner[2]) / 2.0)}) {
                double nearest = capsules.empty() ? cap : signed_distance(capsules, at);
                for (const PlacedShape& body : bodies) nearest = std::min(nearest, signed_distance(body, at));
                if (!listed || std::abs(nearest) > 4.0 * deviation) nearest = *grains.distance(at, cap);
                worst = std::max(worst, std::min(cap, std::abs(nearest)));
            }
        }
    }
    return worst;
}

// How the grains become one surface. Grains in point contact are joined there (contact_joints.hpp); grains that overlap by more than the
// deviation of their facets, and those whose joint did not succeed, are one group, which CGAL unites as a whole.
struct Plan {
    const Grains& grains;
    const std::vector<Grains::Image>& images;
    const std::vector<GrainContact>& contacts;
    double deviation_m, contact_gap_m;
    std::vector<bool> united;                               ///< by contact: needs the union of both grains
    std::vector<int> thinned;                               ///< by image: number of times by contact_gap_m
    std::map<std::pair<std::size_t, int>, Mesh> unit = {};  ///< by shape and thinning: what was made so far

    [[nodiscard]] bool in_contact(const GrainContact& contact) const { return contact.gap < contact_gap_m; }
    [[nodiscard]] bool grazing(const GrainContact& contact) const { return contact.gap > -4.0 * deviation_m; }
};

// By how much a grain is thinner after so many times. Faces that press on each other overlap all over: they come apart only when each round
// takes twice as much as the last one.
double taken_off(const Shape& shape, int times, double contact_gap_m) {
    return (shape.body != nullptr ? std::pow(2.0, times) - 1.0 : static_cast<double>(times)) * contact_gap_m;
}

// Of the shapes and thinnings that are not there yet.
void add_unit_meshes(Plan& plan) {
    std::vector<std::pair<std::size_t, int>> missing;
    for (std::size_t i = 0; i < plan.images.size(); ++i)
        if (const auto key = std::pair(plan.grains.packing().bodies[plan.images[i].body].shape, plan.thinned[i]);
            plan.unit.try_emplace(key).second)
            missing.push_back(key);
    parallel_for(missing.size(), [&](std::size_t m) {
        const auto [index, times] = missing[m];
        const Shape& shape = plan.grains.packing().shapes[index];
        const double thinner = taken_off(shape, times, plan.contact_gap_m);
        const Mesh mesh = grain_mesh(shape, 0.9 * plan.deviation_m * std::pow(0.9, times), thinner, times);
        plan.unit.at(missing[m]) = without_slivers(mesh, plan.contact_gap_m);
    });
}

// The mesh of each image: its grain's mesh, moved, its corners near others on the exact surface; in a group, united with a bridge to every
// later grain of the group in contact.
std::vector<Mesh> image_meshes(Plan& plan, const std::vector<std::size_t>& group_of, const std::function<void(double cost)>& done) {
    add_unit_meshes(plan);
    std::vector<std::vector<const GrainContact*>> of_image(plan.images.size());
    for (const auto& contact : plan.contacts) {
        if (!plan.grazing(contact)) continue;
        of_image[contact.first].push_back(&contact);
        of_image[contact.second].push_back(&contact);
    }
    std::vector<Mesh> meshes(plan.images.size());
    parallel_for(plan.images.size(), [&](std::size_t i) {
        const auto& image = plan.images[i];
        const Body& body = plan.grains.packing().bodies[image.body];
        meshes[i] = moved_mesh(plan.unit.at({body.shape, plan.thinned[i]}), body.position_m + image.shift, body.orientation);
        std::set<std::size_t> near;
        for (const GrainContact* contact : of_image[i]) near.insert(contact->first == i ? contact->second : contact->first);
        std::vector<PlacedShape> others;
        for (const std::size_t other : near) others.push_back(plan.grains.placed(plan.images[other]));
        keep_apart(meshes[i], plan.grains.placed(image), others, plan.deviation_m, plan.thinned[i]);
        for (const GrainContact* contact : of_image[i])
            if (contact->first == i && plan.in_contact(*contact) && group_of[i] == group_of[contact->second]) {
                Mesh box = bridge_mesh(bridge_of(*contact, plan.contact_gap_m, plan.deviation_m,
                                                 plan.thinned[contact->first] + plan.thinned[contact->second]));
                unite_into(meshes[i], box);
            }
#pragma omp critical
        done(1.0 / threads_of(plan.images.size()));
    });
    return meshes;
}

// Joins and unites all grains. A contact whose joint does not succeed is marked as `united`, and all is done again.
TriangleSurface unite_grains(Plan& plan, const std::string& task) {
    while (true) {
        std::vector<std::pair<std::size_t, std::size_t>> united;
        for (std::size_t c = 0; c < plan.contacts.size(); ++c)
            if (plan.united[c]) united.emplace_back(plan.contacts[c].first, plan.contacts[c].second);
        auto groups = clusters_of(plan.images.size(), united);
        std::vector<std::size_t> group_of(plan.images.size());
        for (std::size_t g = 0; g < groups.size(); ++g)
            for (const std::size_t i : groups[g]) group_of[i] = g;
        std::vector<Joint> joints;
        std::vector<std::size_t> contact_of;
        for (std::size_t c = 0; c < plan.contacts.size(); ++c) {
            const GrainContact& contact = plan.contacts[c];
            if (!plan.in_contact(contact) || group_of[contact.first] == group_of[contact.second]) continue;
            joints.push_back({&contact, group_of[contact.first], group_of[contact.second]});
            contact_of.push_back(c);
        }
        Progress progress(task);
        double all = static_cast<double>(plan.images.size() + joints.size()) / thread_count(), so_far = 0.0;
        for (const auto& group : groups) all += cost_of_union(group.size());
        const auto done = [&](double cost) { progress.update(std::min(1.0, (so_far += cost) / all)); };

        auto meshes = image_meshes(plan, group_of, done);
        std::vector<Facets> bodies;
        for (auto& group : groups) {
            std::sort(group.begin(), group.end(),
                      [&](std::size_t p, std::size_t q) { return plan.images[p].bounds.low.z() < plan.images[q].bounds.low.z(); });
            std::vector<Mesh> members;
            members.reserve(group.size());
            for (const std::size_t i : group) members.push_back(std::move(meshes[i]));
            const bool single = members.size() == 1;
            const Mesh body = unite_group(std::move(members), done);
            bodies.push_back(facets_of(single ? body : without_slivers(body, plan.contact_gap_m)));
        }
        const auto failed = join_bodies(bodies, joints, plan.contact_gap_m, plan.deviation_m,
                                        [&](std::size_t n) { done(static_cast<double>(n) / thread_count()); });
        if (failed.empty()) {
            Facets surface;
            for (const Facets& body : bodies) surface.insert(surface.end(), body.begin(), body.end());
            return surface_of(surface);
        }
        log_info("surface: {} of {} contacts cannot be joined on their own; the grains there are united as a whole", failed.size(),
                 joints.size());
        for (const std::size_t j : failed) plan.united[contact_of[j]] = true;
    }
}

// Grains whose surface is near one of the places.
std::set<std::size_t> grains_at(const std::vector<Vec3>& places, const Grains& grains, double reach) {
    std::set<std::size_t> bodies;
    for (const Vec3& place : places)
        for (const auto& image : grains.images())
            if (signed_distance(grains.placed(image), place) < reach) bodies.insert(image.body);
    return bodies;
}

// Replaces the triangles around the places where the surface crosses itself (CGAL's local repair); keeps the surface if that leaves as
// many faults.
void repair_crossings(TriangleSurface& surface, SurfaceCheck& check, double reach) {
    auto mesh = mesh_of(surface);
    std::set<std::array<long, 3>> cells;  // of size `reach`, around the places
    const auto cell_of = [&](double x, double y, double z) {
        return std::array{std::lround(x / reach), std::lround(y / reach), std::lround(z / reach)};
    };
    for (const Vec3& place : check.fault_places)
        for (int offset = 0; offset < 27; ++offset) {
            auto cell = cell_of(place.x(), place.y(), place.z());
            cell[0] += offset % 3 - 1;
            cell[1] += offset / 3 % 3 - 1;
            cell[2] += offset / 9 - 1;
            cells.insert(cell);
        }
    std::vector<Mesh::Face_index> near;
    for (const auto face : mesh->faces())
        for (const auto corner : vertices_around_face(mesh->halfedge(face), *mesh))
            if (const Point& p = mesh->point(corner); cells.contains(cell_of(p.x(), p.y(), p.z()))) {
                near.push_back(face);
                break;
            }
    repair_self_intersections(*mesh, near);
    TriangleSurface repaired = surface_of(facets_of(*mesh));
    SurfaceCheck again = check_surface(repaired);
    log_info("surface: local repair leaves {} of {} faults after rounding to single precision", again.fault_places.size(),
             check.fault_places.size());
    // A fault without a place could not be fixed by thinning the grains there.
    const bool fewer = !again.fault_places.empty() && again.fault_places.size() < check.fault_places.size();
    if (!again.fault.empty() && !fewer) return;
    surface = std::move(repaired);
    check = std::move(again);
}

void require_volume(double volume_m3, const Grains& grains, const Container& container, double largest_error) {
    if (container.any_periodic()) return;
    const Section all{std::min(0.0, grains.bounds().low.z()), std::max(container.height(), grains.bounds().high.z())};
    const double exact = (1.0 - porosity(grains, container, all).value) * container.vessel().mean_area(all.interval()) * all.length();
    const double error = volume_m3 / exact - 1.0;
    if (std::abs(error) > largest_error)
        throw UserError(
            fmt::format("the volume of the surface differs from that of the grains by {:.2g} %", 100.0 * error),
            {.allowed = fmt::format("{:g} %", 100.0 * largest_error), .fix = "use a smaller surface_deviation_m or contact_gap_m"});
}

// The surface with one contact gap; its check names the faults that are left, if any.
//
// Single precision moves corners by up to 1e-7 of their coordinates, which can make facets with small gaps cross. Crossings are repaired in
// place where that is possible. Else the grains at such a place are thinned by the contact gap and get other facets, turned and finer ones,
// and the union is made again.
SurfaceResult surface_with_gap(const Grains& grains, double deviation, double contact_gap) {
    SurfaceResult result{.contact_gap_m = contact_gap};
    const auto& images = grains.images();
    const auto contacts = find_contacts(grains, std::max(4.0 * deviation, contact_gap));
    Plan plan{.grains = grains,
              .images = images,
              .contacts = contacts,
              .deviation_m = deviation,
              .contact_gap_m = contact_gap,
              .united = {},
              .thinned = thin_coincident(images.size(), contacts, contact_gap)};
    std::vector<std::pair<std::size_t, std::size_t>> joined;
    for (const auto& contact : contacts) {
        plan.united.push_back(plan.in_contact(contact) && !plan.grazing(contact));
        if (plan.in_contact(contact)) joined.emplace_back(contact.first, contact.second);
    }
    result.bridges = static_cast<long>(joined.size());
    for (const auto& cluster : clusters_of(images.size(), joined))
        if (cluster.size() > 1) result.joined_grains += static_cast<long>(cluster.size());

    for (int round = 0;; ++round) {
        result.surface = unite_grains(plan, round == 0 ? "surface (CGAL)" : fmt::format("surface (CGAL), repair {}", round));
        SurfaceCheck& check = result.check = check_surface(result.surface);
        if (check.self_intersecting) repair_crossings(result.surface, check, 2.0 * deviation);
        const auto& crossings = check.fault_places;
        if (check.fault.empty() || crossings.empty() || round == maximum_repairs) break;
        const std::set<std::size_t> faulty = grains_at(crossings, grains, 2.0 * deviation);
        for (std::size_t i = 0; i < images.size(); ++i) plan.thinned[i] += faulty.contains(images[i].body) ? 1 : 0;
        log_info("surface: {} faults after rounding to single precision; {} grains are thinned", crossings.size(), faulty.size());
    }
    std::set<std::size_t> shrunk;
    for (std::size_t i = 0; i < images.size(); ++i)
        if (plan.thinned[i] > 0) shrunk.insert(images[i].body);
    result.shrunk_grains = static_cast<long>(shrunk.size());
    return result;
}

// Grains from meshes deviate from their files by more than a hundredth of their thickness.
double automatic_deviation(const Packing& packing, double d) {
    const bool mesh = std::any_of(packing.shapes.begin(), packing.shapes.end(), [&](const Shape& shape) {
        return shape.body != nullptr && !shape.body->convex() && shape.body->facets(0.005 * d, 0.0).empty();
    });
    return (mesh ? 0.02 : 0.005) * d;
}

}  // namespace

SurfaceOptions surface_options(const GeometryConfig& geometry) {
    return {.deviation_m = geometry.surface_deviation_m, .contact_gap_m = geometry.contact_gap_m};
}

geometry::TriangleSurface surface_of_grain(const Shape& shape, double deviation_m) {
    geometry::TriangleSurface surface;
    append(surface, grain_mesh(shape, deviation_m, 0.0, 0));
    return surface;
}

SurfaceResult make_surface(const Packing& packing, const SurfaceOptions& options) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain");
    const double d = finest_diameter(packing);
    const double deviation = options.deviation_m > 0.0 ? options.deviation_m : automatic_deviation(packing, d);
    for (const auto& [key, value] : {std::pair("surface_deviation_m", deviation), std::pair("contact_gap_m", options.contact_gap_m)})
        if (value > largest_change * d)
            throw UserError(
                fmt::format("{:g} m would change the grains: they are {:g} m thick", value, d),
                {.where = key, .allowed = fmt::format("at most {:g} m", largest_change * d), .fix = "use a smaller value, or auto"});
    const Grains grains(packing);
    const std::vector<double> gaps =
        options.contact_gap_m > 0.0 ? std::vector{options.contact_gap_m} : std::vector{1e-4 * d, 1e-3 * d, 1e-2 * d};
    SurfaceResult result;
    for (const double gap : gaps) {
        result = surface_with_gap(grains, deviation, gap);
        if (result.check.fault.empty()) break;
        const std::string faults = fmt::format("the surface still has faults at {} places with a contact gap of {:.2g} m: {}",
                                               result.check.fault_places.size(), gap, result.check.fault);
        if (gap == gaps.back()) throw NumericalError(faults, {.fix = "change surface_deviation_m slightly, or set contact_gap_m larger"});
        log_info("surface: {}; made again with a larger one", faults);
    }
    require_volume(result.check.volume_m3, grains, packing.container, options.max_volume_error);
    result.deviation_m = largest_deviation(result.surface, grains, deviation, d);
    return result;
}

}  // namespace porepack::converters
