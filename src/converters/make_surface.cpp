// Union and repair: the grains' meshes become one closed surface without faults in single precision, the precision of the STL file.
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>

#include "converters/contact_bridges.hpp"
#include "converters/grain_mesh.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/parallel.hpp"

namespace porepack::converters {
using namespace core;
using namespace io;
using namespace shapes;
using namespace packing;
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

constexpr double largest_change = 0.1;  // deviation and contact gap, of the smallest capsule diameter

// The cost of a step, for the time left: that of uniting two meshes grows with the images in them, and the last unions have one thread.
double threads_of(std::size_t tasks) {
    return std::min(static_cast<double>(tasks), static_cast<double>(thread_count()));
}
double cost_of_cluster(std::size_t meshes) {
    double cost = static_cast<double>(meshes) / threads_of(meshes);
    for (double images = 2.0; meshes > 1; meshes = (meshes + 1) / 2, images *= 2.0)
        cost += static_cast<double>(meshes / 2) * images / threads_of(meshes / 2);
    return cost;
}

// Unions pairwise as a tree, neighbours in z first.
Mesh unite_cluster(std::vector<Mesh> meshes, const std::function<void(double cost)>& done) {
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

// Coordinates rounded to Real; equal points become one. Points and triangles are sorted, because CGAL's order depends on the number of
// threads.
template <typename Real>
TriangleSurface in_order(const TriangleSurface& surface) {
    const auto rounded = [](const std::array<double, 3>& p) {
        constexpr Real zero = 0;  // no minus zero
        return std::array<Real, 3>{static_cast<Real>(p[0]) + zero, static_cast<Real>(p[1]) + zero, static_cast<Real>(p[2]) + zero};
    };
    std::map<std::array<Real, 3>, int> number;
    for (const auto& p : surface.points) number.try_emplace(rounded(p), 0);
    TriangleSurface result;
    for (auto& [point, index] : number) {
        index = static_cast<int>(result.points.size());
        result.points.push_back({point[0], point[1], point[2]});
    }
    for (const auto& t : surface.triangles) {
        std::array<int, 3> corners{};
        for (std::size_t c = 0; c < 3; ++c) corners[c] = number.at(rounded(surface.points[static_cast<std::size_t>(t[c])]));
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
        if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0]) result.triangles.push_back(corners);
    }
    std::sort(result.triangles.begin(), result.triangles.end());
    return result;
}

// Coordinates as in the STL file.
TriangleSurface round_to_single(const TriangleSurface& surface) {
    return in_order<float>(surface);
}

double largest_deviation(const TriangleSurface& surface, const Grains& grains, double cap) {
    double worst = 0.0;
#pragma omp parallel for schedule(dynamic, 256) reduction(max : worst)
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        Vec3 corner[3];
        for (std::size_t c = 0; c < 3; ++c) {
            const auto& p = surface.points[static_cast<std::size_t>(surface.triangles[t][c])];
            corner[c] = Vec3(p[0], p[1], p[2]);
        }
        const Vec3 middle = (corner[0] + corner[1] + corner[2]) / 3.0;
        for (const Vec3& at : {corner[0], middle, Vec3((corner[0] + corner[1]) / 2.0), Vec3((corner[1] + corner[2]) / 2.0)})
            worst = std::max(worst, std::abs(grains.distance(at, cap)));
    }
    return worst;
}

// The mesh of each image: its grain's mesh, moved, separated from grains not in contact, united with a bridge to every later grain in
// contact.
std::vector<Mesh> image_meshes(const Packing& packing, const std::vector<Grains::Image>& images, const std::vector<GrainContact>& contacts,
                               const std::vector<int>& thinned, double deviation, double contact_gap,
                               const std::function<void(double cost)>& done) {
    std::map<std::pair<std::size_t, int>, Mesh> unit;  // by shape and thinning
    for (const auto& image : images) {
        const auto key = std::pair(packing.bodies[image.body].shape, thinned[static_cast<std::size_t>(&image - images.data())]);
        if (!unit.contains(key))
            unit.emplace(key, grain_mesh(packing.shapes[key.first], 0.9 * deviation * std::pow(0.9, key.second), key.second * contact_gap,
                                         key.second));
    }
    std::vector<std::vector<const GrainContact*>> of_image(images.size());
    for (const auto& contact : contacts) {
        of_image[contact.first].push_back(&contact);
        if (contact.gap >= contact_gap) of_image[contact.second].push_back(&contact);
    }
    std::vector<Mesh> meshes(images.size());
    parallel_for(images.size(), [&](std::size_t i) {
        const Body& body = packing.bodies[images[i].body];
        meshes[i] = moved_mesh(unit.at({body.shape, thinned[i]}), body.position_m + images[i].shift, body.orientation);
        for (const GrainContact* contact : of_image[i])
            if (contact->gap >= contact_gap)
                keep_apart(meshes[i], contact->first == i ? contact->first_capsule : contact->second_capsule, *contact, deviation,
                           thinned[i]);
        for (const GrainContact* contact : of_image[i])
            if (contact->gap < contact_gap && contact->gap > -4.0 * deviation) {
                Mesh box = bridge_mesh(*contact, contact_gap, deviation, thinned[contact->first] + thinned[contact->second]);
                unite_into(meshes[i], box);
            }
#pragma omp critical
        done(1.0 / threads_of(images.size()));
    });
    return meshes;
}

// Where two bodies meet, corners of one lie next to edges of the other. Edges shorter than `smallest` are collapsed, and triangles less
// high than it are flipped away: rounded, they would cross each other.
Mesh without_slivers(const Mesh& united, double smallest) {
    constexpr double flat = 160.0 / 180.0 * std::numbers::pi;  // largest angle of a triangle that may stay
    constexpr double long_to_short = 4.0;                      // edges of a triangle that may stay
    TriangleSurface surface;
    append(surface, united);
    auto mesh = mesh_of(in_order<double>(surface));  // what is collapsed first decides what is left
    if (!mesh) return united;                        // not manifold: the check of the surface says where
    pmp::experimental::remove_almost_degenerate_faces(*mesh, std::cos(flat), long_to_short, smallest,
                                                      CGAL::parameters::flip_triangle_height_threshold(smallest));
    mesh->collect_garbage();
    return std::move(*mesh);
}

// The union of the meshes of each cluster, and all clusters in one mesh.
TriangleSurface unite_clusters(std::vector<std::vector<std::size_t>>& clusters, const std::vector<Grains::Image>& images,
                               std::vector<Mesh> meshes, double smallest, const std::function<void(double cost)>& done) {
    TriangleSurface surface;
    for (auto& cluster : clusters) {
        std::sort(cluster.begin(), cluster.end(),
                  [&](std::size_t p, std::size_t q) { return images[p].bounds.low.z() < images[q].bounds.low.z(); });
        std::vector<Mesh> members;
        members.reserve(cluster.size());
        for (const std::size_t g : cluster) members.push_back(std::move(meshes[g]));
        append(surface, without_slivers(unite_cluster(std::move(members), done), smallest));
    }
    return surface;
}

// Grains whose surface is near one of the places.
std::set<std::size_t> grains_at(const std::vector<Vec3>& places, const std::vector<Grains::Image>& images, double reach) {
    std::set<std::size_t> bodies;
    for (const Vec3& place : places)
        for (const auto& image : images)
            if (signed_distance(image.capsules, place) < reach) bodies.insert(image.body);
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
    pmp::experimental::remove_self_intersections(near, *mesh, CGAL::parameters::preserve_genus(false));
    mesh->collect_garbage();
    TriangleSurface repaired;
    append(repaired, *mesh);
    repaired = round_to_single(repaired);
    SurfaceCheck again = check_surface(repaired);
    log_info("surface: local repair leaves {} of {} faults after rounding to single precision", again.fault_places.size(),
             check.fault_places.size());
    // A fault without a place could not be fixed by thinning the grains there.
    const bool fewer = !again.fault_places.empty() && again.fault_places.size() < check.fault_places.size();
    if (!again.fault.empty() && !fewer) return;
    surface = std::move(repaired);
    check = std::move(again);
}

void require_volume(const TriangleSurface& surface, const Grains& grains, const Container& container, double largest_error) {
    if (container.any_periodic()) return;
    const Section all{std::min(0.0, grains.bounds().low.z()), std::max(container.height(), grains.bounds().high.z())};
    const double exact = (1.0 - porosity(grains, container, all).value) * container.inner_area_m2() * all.length();
    const double error = measure_surface(surface).volume_m3 / exact - 1.0;
    if (std::abs(error) > largest_error)
        throw UserError(
            fmt::format("the volume of the surface differs from that of the grains by {:.2g} %", 100.0 * error),
            {.allowed = fmt::format("{:g} %", 100.0 * largest_error), .fix = "use a smaller surface_deviation_m or contact_gap_m"});
}

}  // namespace

SurfaceResult make_surface(const Packing& packing, const SurfaceOptions& options) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain");
    const double d = finest_diameter(packing);
    const double deviation = options.deviation_m > 0.0 ? options.deviation_m : 0.005 * d;
    SurfaceResult result;
    result.contact_gap_m = options.contact_gap_m > 0.0 ? options.contact_gap_m : 1e-4 * d;
    for (const auto& [key, value] : {std::pair("surface_deviation_m", deviation), std::pair("contact_gap_m", result.contact_gap_m)})
        if (value > largest_change * d)
            throw UserError(
                fmt::format("{:g} m would change the grains: their smallest capsule diameter is {:g} m", value, d),
                {.where = key, .allowed = fmt::format("at most {:g} m", largest_change * d), .fix = "use a smaller value, or auto"});
    const Grains grains(packing);
    const auto& images = grains.images();
    const auto contacts = find_contacts(images, std::max(4.0 * deviation, result.contact_gap_m));
    auto clusters = clusters_of(images.size(), contacts, result.contact_gap_m);
    for (const auto& cluster : clusters)
        if (cluster.size() > 1) result.joined_grains += static_cast<long>(cluster.size());
    for (const auto& contact : contacts) result.bridges += contact.gap < result.contact_gap_m ? 1 : 0;

    // Single precision moves corners by up to 1e-7 of their coordinates, which can make facets with small gaps cross. Crossings are
    // repaired in place where that is possible. Else the grains at such a place are thinned by the contact gap and get other facets, turned
    // and finer ones, and the union is made again.
    std::vector<int> thinned = thin_coaxial(images.size(), contacts);
    constexpr int maximum_rounds = 8;
    for (int round = 0; round < maximum_rounds; ++round) {
        Progress progress(round == 0 ? "surface (CGAL)" : fmt::format("surface (CGAL), repair {}", round));
        double all = 0.0, so_far = 0.0;
        for (const auto& cluster : clusters) all += cost_of_cluster(cluster.size());
        const auto done = [&](double cost) { progress.update((so_far += cost) / all); };
        auto meshes = image_meshes(packing, images, contacts, thinned, deviation, result.contact_gap_m, done);
        result.surface = round_to_single(unite_clusters(clusters, images, std::move(meshes), result.contact_gap_m, done));
        SurfaceCheck check = check_surface(result.surface);
        if (check.self_intersecting) repair_crossings(result.surface, check, 2.0 * deviation);
        result.shells = check.shells;
        if (check.fault.empty()) break;
        const auto& crossings = check.fault_places;
        if (round + 1 == maximum_rounds || crossings.empty())
            throw NumericalError(fmt::format("the surface still has faults at {} places after the grains there were thinned {} times: {}",
                                             crossings.size(), round, check.fault),
                                 {.fix = "raise contact_gap_m, or change surface_deviation_m slightly"});
        const std::set<std::size_t> faulty = grains_at(crossings, images, 2.0 * deviation);
        for (std::size_t i = 0; i < images.size(); ++i) thinned[i] += faulty.contains(images[i].body) ? 1 : 0;
        log_info("surface: {} faults after rounding to single precision; {} grains are thinned by {:.2g} m", crossings.size(),
                 faulty.size(), result.contact_gap_m);
    }
    std::set<std::size_t> shrunk;
    for (std::size_t i = 0; i < images.size(); ++i)
        if (thinned[i] > 0) shrunk.insert(images[i].body);
    result.shrunk_grains = static_cast<long>(shrunk.size());
    require_volume(result.surface, grains, packing.container, options.largest_volume_error);
    result.deviation_m = largest_deviation(result.surface, grains, d);
    return result;
}

}  // namespace porepack::converters
