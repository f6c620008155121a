#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

#include "converters/cgal_mesh.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "core/parallel.hpp"
#include "shapes/segments.hpp"

namespace porepack {
namespace pmp = CGAL::Polygon_mesh_processing;
namespace {

Point to_point(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

// A capsule, ring by ring from pole to pole, its corners at distance `r` from the axis. `turn` differs from arm to arm so
// that no facets are coplanar.
Mesh ring_mesh(const Capsule& capsule, double r, int n, double turn) {
    const double length = (capsule.b - capsule.a).norm();
    const Vec3 axis = length > 0.0 ? Vec3((capsule.b - capsule.a) / length) : Vec3(Vec3::UnitZ());
    const Vec3 e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    Mesh mesh;
    std::vector<std::vector<Mesh::Vertex_index>> rings;
    const auto add_ring = [&](const Vec3& centre, double radius) {
        rings.emplace_back();
        const double phase = turn + std::numbers::pi / n * static_cast<double>(rings.size());
        for (int i = 0; i < n; ++i) {
            const double phi = phase + 2.0 * std::numbers::pi * i / n;
            rings.back().push_back(mesh.add_vertex(to_point(centre + radius * (std::cos(phi) * e1 + std::sin(phi) * e2))));
        }
    };
    const int bands = n / 4;
    const auto bottom = mesh.add_vertex(to_point(capsule.a - r * axis));
    for (int k = 1; k <= bands; ++k) {
        const double theta = 0.5 * std::numbers::pi * k / bands;
        add_ring(capsule.a - r * std::cos(theta) * axis, r * std::sin(theta));
    }
    // A straight side needs no rings in between, but very long triangles make slow and poor cuts.
    const int pieces = static_cast<int>(std::ceil(length / (3.0 * capsule.radius)));
    for (int k = 1; k < pieces; ++k) add_ring(capsule.a + (capsule.b - capsule.a) * (static_cast<double>(k) / pieces), r);
    for (int k = bands; k >= 1; --k) {
        if (k == bands && length == 0.0) continue;
        const double theta = 0.5 * std::numbers::pi * k / bands;
        add_ring(capsule.b + r * std::cos(theta) * axis, r * std::sin(theta));
    }
    const auto top = mesh.add_vertex(to_point(capsule.b + r * axis));
    const auto corner = [&](std::size_t ring, int i) { return rings[ring][static_cast<std::size_t>(i % n)]; };
    for (int i = 0; i < n; ++i) {
        mesh.add_face(bottom, corner(0, i + 1), corner(0, i));
        for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring) {
            mesh.add_face(corner(ring, i), corner(ring, i + 1), corner(ring + 1, i));
            mesh.add_face(corner(ring, i + 1), corner(ring + 1, i + 1), corner(ring + 1, i));
        }
        mesh.add_face(top, corner(rings.size() - 1, i), corner(rings.size() - 1, i + 1));
    }
    return mesh;
}

// Largest distance of a facet's middle or corner from the capsule's surface.
double mesh_deviation(const Mesh& mesh, const Capsule& capsule) {
    double worst = 0.0;
    for (const auto face : mesh.faces()) {
        Vec3 middle = Vec3::Zero();
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) {
            const Vec3 corner(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
            worst = std::max(worst, std::abs(signed_distance(capsule, corner)));
            middle += corner / 3.0;
        }
        worst = std::max(worst, std::abs(signed_distance(capsule, middle)));
    }
    return worst;
}

// The coarsest mesh of a capsule within the deviation. Its corners lie outside, its facets inside, so that it has the
// capsule's volume.
Mesh capsule_mesh(const Capsule& capsule, double deviation, double turn) {
    const double r = capsule.radius;
    const double volume = std::numbers::pi * r * r * ((capsule.b - capsule.a).norm() + 4.0 / 3.0 * r);
    // Facets of n corners stray by r (1 - cos(pi/n)); half of it lies outside.
    const double least = 0.6 * std::numbers::pi / std::acos(1.0 - std::min(1.0, deviation / r));
    for (int n = std::max(8, 4 * static_cast<int>(std::min(least, 512.0) / 4.0)); n <= 512; n += 4) {
        check_interrupt();
        double radius = r;
        Mesh mesh;
        for (int round = 0; round < 4; ++round) {
            mesh = ring_mesh(capsule, radius, n, turn);
            // dV/dr is the surface, up to the small error of the facets.
            const double surface = 2.0 * std::numbers::pi * r * ((capsule.b - capsule.a).norm() + 2.0 * r);
            radius += (volume - pmp::volume(mesh)) / surface;
        }
        if (mesh_deviation(mesh, capsule) <= deviation) return mesh;
    }
    throw UserError(fmt::format("a surface deviation of {:g} m needs more than 512 corners round a capsule", deviation),
                    {.mend = "take a larger surface_deviation_m"});
}

void unite_into(Mesh& all, Mesh& part) {
    Mesh result;
    if (!pmp::corefine_and_compute_union(all, part, result))
        throw NumericalError("CGAL cannot unite two bodies", {.mend = "change surface_deviation_m a little"});
    result.collect_garbage();
    all = std::move(result);
}

// Inner shells (enclosed voids) have negative volume.
void drop_cavities(Mesh& mesh) {
    auto shell = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:shell").first;
    const std::size_t count = pmp::connected_components(mesh, shell);
    std::vector<std::size_t> keep;
    for (std::size_t s = 0; s < count; ++s) {
        double volume = 0.0;
        for (const auto face : mesh.faces()) {
            if (shell[face] != s) continue;
            auto h = mesh.halfedge(face);
            volume +=
                CGAL::volume(Point(0, 0, 0), mesh.point(mesh.source(h)), mesh.point(mesh.target(h)), mesh.point(mesh.target(mesh.next(h))));
        }
        if (volume > 0.0) keep.push_back(s);
    }
    if (keep.size() < count) pmp::keep_connected_components(mesh, keep, shell);
    mesh.collect_garbage();
    mesh.remove_property_map(shell);
}

// `variant` counts the attempts: each has its corners elsewhere.
Mesh grain_mesh(const Shape& shape, double deviation, double thinner, int variant) {
    Mesh mesh;
    for (std::size_t i = 0; i < shape.capsules.size(); ++i) {
        Capsule capsule = shape.capsules[i];
        capsule.radius -= thinner;
        Mesh part = capsule_mesh(capsule, deviation, 0.37 + 1.117 * static_cast<double>(i) + 0.291 * variant);
        if (i == 0)
            mesh = std::move(part);
        else
            unite_into(mesh, part);
    }
    if (shape.cavity == Cavity::filled && !shape.cavity_points.empty()) drop_cavities(mesh);
    return mesh;
}

Mesh moved_mesh(const Mesh& mesh, const Vec3& position, const Quaternion& orientation) {
    Mesh copy = mesh;
    for (const auto v : copy.vertices()) {
        const Point& p = copy.point(v);
        copy.point(v) = to_point(position + orientation * Vec3(p.x(), p.y(), p.z()));
    }
    return copy;
}

// Two capsules of different grains that touch or nearly touch: the stretch of the first one's axis that is nearest to the
// second (a point unless they are parallel), and the direction towards it.
struct Contact {
    std::size_t first, second;  // images
    Capsule first_capsule, second_capsule;
    Vec3 from, to, normal;
    double gap;
};

// The stretch of `p`'s axis that lies beside `q`'s, for parallel axes; else the nearest point twice.
std::pair<Vec3, Vec3> nearest_stretch(const Capsule& p, const Capsule& q) {
    const Vec3 along = p.b - p.a;
    const double length = along.norm();
    if (length > 0.0 && along.cross(q.b - q.a).norm() < 1e-3 * length * (q.b - q.a).norm()) {
        const Vec3 unit = along / length;
        const double at_a = (q.a - p.a).dot(unit), at_b = (q.b - p.a).dot(unit);
        const double low = std::clamp(std::min(at_a, at_b), 0.0, length), high = std::clamp(std::max(at_a, at_b), 0.0, length);
        return {p.a + low * unit, p.a + high * unit};
    }
    const Vec3 nearest = closest_points({p.a, along}, {q.a, q.b - q.a}).on_first;
    return {nearest, nearest};
}

std::vector<Contact> find_contacts(const std::vector<Grains::Image>& images, double reach) {
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = i + 1; j < images.size(); ++j) {
            if (((images[i].bounds.high - images[j].bounds.low).array() < -reach).any() ||
                ((images[j].bounds.high - images[i].bounds.low).array() < -reach).any())
                continue;
            for (const auto& p : images[i].capsules)
                for (const auto& q : images[j].capsules) {
                    const double between = gap(p, q);
                    if (between >= reach) continue;
                    Contact contact{.first = i,
                                    .second = j,
                                    .first_capsule = p,
                                    .second_capsule = q,
                                    .from = {},
                                    .to = {},
                                    .normal = {},
                                    .gap = between};
                    std::tie(contact.from, contact.to) = nearest_stretch(p, q);
                    const Vec3 across = closest_on_axis(q, contact.from) - contact.from;
                    contact.normal = across.norm() > 0.0 ? Vec3(across.normalized()) : Vec3(Vec3::UnitZ());
                    // Arms share their end spheres: the same contact is met several times.
                    const auto same = [&](const Contact& other) {
                        const double slack = 1e-6 * p.radius;
                        return other.first == i && other.second == j && (other.from - contact.from).norm() < slack &&
                               (other.to - contact.to).norm() < slack && (other.normal - contact.normal).norm() < 1e-6;
                    };
                    const auto recent = contacts.end() - static_cast<std::ptrdiff_t>(std::min<std::size_t>(contacts.size(), 64));
                    if (std::none_of(recent, contacts.end(), same)) contacts.push_back(contact);
                }
        }
    return contacts;
}

// A box that joins two grains at their contact, wide enough to hold the lens in which they overlap. After a fault (`variant` > 0) it is
// wider: where facets cross at a grazing angle within the lens of their strays too.
Mesh bridge(const Contact& contact, double contact_gap, double deviation, int variant) {
    const double r = std::min(contact.first_capsule.radius, contact.second_capsule.radius);
    const double lens = std::max(contact_gap, -contact.gap) + std::min(variant, 2) * deviation;
    const double half_width = std::min(0.4 * r, (1.0 + 0.1 * variant) * std::sqrt(r * lens));
    const double depth = std::min(0.8 * r, 3.0 * deviation + half_width);
    const Vec3 along = contact.to - contact.from;
    // Turned a little: no face lies in a plane of the grains' meshes.
    const Vec3 across = along.norm() > 0.0 ? Vec3(along.normalized()) : contact.normal.unitOrthogonal();
    const Eigen::AngleAxisd turn(0.0137 + 0.083 * variant, contact.normal);
    const Vec3 t = turn * across, w = contact.normal.cross(t);
    const double half_length = 0.5 * along.norm() + half_width;
    const Vec3 middle = 0.5 * (contact.from + contact.to);
    const double bottom = contact.first_capsule.radius - depth;
    const double top = contact.first_capsule.radius + contact.gap + depth;
    Mesh mesh;
    std::array<Mesh::Vertex_index, 8> corner;
    for (std::size_t c = 0; c < 8; ++c)
        corner[c] =
            mesh.add_vertex(to_point(middle + ((c & 1U) != 0 ? half_length : -half_length) * t +
                                     ((c & 2U) != 0 ? half_width : -half_width) * w + ((c & 4U) != 0 ? top : bottom) * contact.normal));
    constexpr std::array<std::array<std::size_t, 4>, 6> quads = {
        {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
    for (const auto& q : quads) {
        mesh.add_face(corner[q[0]], corner[q[1]], corner[q[2]]);
        mesh.add_face(corner[q[0]], corner[q[2]], corner[q[3]]);
    }
    return mesh;
}

// Near a grain that it does not touch, a grain's corners go back onto its exact surface: the facets between them then lie
// inside, so that what is apart stays apart.
void keep_apart(Mesh& mesh, const Capsule& own, const Contact& contact, double deviation) {
    // Beyond this distance from the contact the exact surfaces are farther apart than any facet strays.
    const double reach = 2.0 * std::sqrt(8.0 * own.radius * deviation);
    const Vec3 to_contact = contact.first_capsule.radius * contact.normal;
    const Capsule zone{contact.from + to_contact, contact.to + to_contact, 0.0};
    for (const auto v : mesh.vertices()) {
        const Vec3 x(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
        if (signed_distance(zone, x) > reach) continue;
        const Vec3 foot = closest_on_axis(own, x);
        const double distance = (x - foot).norm();
        if (distance > own.radius && distance < own.radius + 2.0 * deviation)
            mesh.point(v) = to_point(foot + own.radius / distance * (x - foot));
    }
}

bool on_one_line(const Capsule& p, const Capsule& q) {
    const Vec3 along = p.b - p.a;
    const double slack = 1e-6 * p.radius * along.norm();
    return along.norm() > 0.0 && along.cross(q.a - p.a).norm() < slack && along.cross(q.b - p.a).norm() < slack;
}

// How often each image is thinned to begin with: of capsules on one line that overlap (a rod through a periodic face and its image)
// one is thinner, else their facets would lie in each other and CGAL would crash.
std::vector<int> thin_coaxial(std::size_t images, const std::vector<Contact>& contacts) {
    std::vector<int> thinned(images, 0);
    for (const auto& contact : contacts)
        if (on_one_line(contact.first_capsule, contact.second_capsule))
            thinned[contact.second] = std::max(thinned[contact.second], thinned[contact.first] + 1);
    return thinned;
}

// Groups of images that contacts join: only those need Booleans.
std::vector<std::vector<std::size_t>> clusters_of(std::size_t images, const std::vector<Contact>& contacts, double contact_gap) {
    std::vector<std::size_t> parent(images);
    std::iota(parent.begin(), parent.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    for (const auto& contact : contacts)
        if (contact.gap < contact_gap) parent[root(contact.first)] = root(contact.second);
    std::map<std::size_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < images; ++i) groups[root(i)].push_back(i);
    std::vector<std::vector<std::size_t>> clusters;
    clusters.reserve(groups.size());
    for (auto& [r, members] : groups) clusters.push_back(std::move(members));
    return clusters;
}

// Unions pairwise as a tree, neighbours in z first.
Mesh unite_cluster(std::vector<Mesh> meshes, const std::function<void()>& one_done) {
    while (meshes.size() > 1) {
        const std::size_t pairs = meshes.size() / 2;
        parallel_for(pairs, [&](std::size_t p) {
            unite_into(meshes[2 * p], meshes[2 * p + 1]);
#pragma omp critical
            one_done();
        });
        std::vector<Mesh> next;
        for (std::size_t p = 0; p < meshes.size(); p += 2) next.push_back(std::move(meshes[p]));
        meshes = std::move(next);
    }
    return std::move(meshes.front());
}

// As the STL file does; welds, and brings points and triangles into one order, which CGAL's depends on the threads.
TriangleSurface round_to_single(const TriangleSurface& surface) {
    const auto rounded = [](const std::array<double, 3>& p) {
        return std::array<float, 3>{static_cast<float>(p[0]) + 0.0F, static_cast<float>(p[1]) + 0.0F, static_cast<float>(p[2]) + 0.0F};
    };
    std::map<std::array<float, 3>, int> number;
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

}  // namespace

namespace {

// Every image's own mesh: the grain's, moved, kept apart from what it does not touch, with a bridge to every later grain that
// it touches.
std::vector<Mesh> image_meshes(const Packing& packing, const std::vector<Grains::Image>& images, const std::vector<Contact>& contacts,
                               const std::vector<int>& thinned, double deviation, double contact_gap,
                               const std::function<void()>& one_done) {
    std::map<std::pair<std::size_t, int>, Mesh> unit;  // by shape and thinning
    for (const auto& image : images) {
        const auto key = std::pair(packing.bodies[image.body].shape, thinned[static_cast<std::size_t>(&image - images.data())]);
        if (!unit.contains(key))
            unit.emplace(key, grain_mesh(packing.shapes[key.first], 0.9 * deviation, key.second * contact_gap, key.second));
    }
    std::vector<std::vector<const Contact*>> of_image(images.size());
    for (const auto& contact : contacts) {
        of_image[contact.first].push_back(&contact);
        if (contact.gap >= contact_gap) of_image[contact.second].push_back(&contact);
    }
    std::vector<Mesh> meshes(images.size());
    parallel_for(images.size(), [&](std::size_t i) {
        const Body& body = packing.bodies[images[i].body];
        meshes[i] = moved_mesh(unit.at({body.shape, thinned[i]}), body.position_m + images[i].shift, body.orientation);
        for (const Contact* contact : of_image[i])
            if (contact->gap >= contact_gap)
                keep_apart(meshes[i], contact->first == i ? contact->first_capsule : contact->second_capsule, *contact, deviation);
        for (const Contact* contact : of_image[i])
            if (contact->gap < contact_gap && contact->gap > -4.0 * deviation) {
                Mesh box = bridge(*contact, contact_gap, deviation, thinned[contact->first] + thinned[contact->second]);
                unite_into(meshes[i], box);
            }
#pragma omp critical
        one_done();
    });
    return meshes;
}

}  // namespace

SurfaceResult make_surface(const Packing& packing, const SurfaceOptions& options) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain");
    const double d = finest_diameter(packing);
    const double deviation = options.deviation_m > 0.0 ? options.deviation_m : 0.005 * d;
    SurfaceResult result;
    result.contact_gap_m = options.contact_gap_m > 0.0 ? options.contact_gap_m : 1e-4 * d;
    const Grains grains(packing);
    const auto& images = grains.images();
    const auto contacts = find_contacts(images, std::max(4.0 * deviation, result.contact_gap_m));
    auto clusters = clusters_of(images.size(), contacts, result.contact_gap_m);
    for (const auto& cluster : clusters)
        if (cluster.size() > 1) result.joined_grains += static_cast<long>(cluster.size());
    for (const auto& contact : contacts) result.bridges += contact.gap < result.contact_gap_m ? 1 : 0;

    std::vector<int> thinned = thin_coaxial(images.size(), contacts);
    constexpr int most_rounds = 8;
    for (int round = 0; round < most_rounds; ++round) {
        Progress progress("surface (CGAL)");
        const double steps = 2.0 * static_cast<double>(images.size());
        std::size_t done = 0;
        const auto one_done = [&] { progress.update(static_cast<double>(++done) / steps); };
        auto meshes = image_meshes(packing, images, contacts, thinned, deviation, result.contact_gap_m, one_done);
        TriangleSurface surface;
        for (auto& cluster : clusters) {
            std::sort(cluster.begin(), cluster.end(),
                      [&](std::size_t p, std::size_t q) { return images[p].bounds.low.z() < images[q].bounds.low.z(); });
            std::vector<Mesh> members;
            members.reserve(cluster.size());
            for (const std::size_t g : cluster) members.push_back(std::move(meshes[g]));
            append(surface, unite_cluster(std::move(members), one_done));
        }
        result.surface = round_to_single(surface);
        const SurfaceCheck check = check_surface(result.surface);
        result.shells = check.shells;
        if (check.fault.empty()) break;
        const auto& crossings = check.fault_places;
        if (round + 1 == most_rounds || crossings.empty())
            throw NumericalError(fmt::format("the surface still has faults at {} places after the grains there were thinned {} times: {}",
                                             crossings.size(), round, check.fault),
                                 {.mend = "raise contact_gap_m, or change surface_deviation_m a little"});
        std::set<std::size_t> guilty;
        for (const Vec3& place : crossings)
            for (const auto& image : images)
                if (signed_distance(image.capsules, place) < 2.0 * deviation) guilty.insert(image.body);
        for (std::size_t i = 0; i < images.size(); ++i) thinned[i] += guilty.contains(images[i].body) ? 1 : 0;
        log_info("surface: {} faults after rounding to single precision; {} grains are thinned by {:.2g} m", crossings.size(),
                 guilty.size(), result.contact_gap_m);
    }
    std::set<std::size_t> shrunk;
    for (std::size_t i = 0; i < images.size(); ++i)
        if (thinned[i] > 0) shrunk.insert(images[i].body);
    result.shrunk_grains = static_cast<long>(shrunk.size());
    result.deviation_m = largest_deviation(result.surface, grains, d);
    return result;
}

}  // namespace porepack
