#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <set>

#include "converters/cgal_mesh.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"

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
    for (int n = 8; n <= 512; n += 4) {
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

Mesh grain_mesh(const Shape& shape, double deviation, double thinner) {
    Mesh mesh;
    for (std::size_t i = 0; i < shape.capsules.size(); ++i) {
        Capsule capsule = shape.capsules[i];
        capsule.radius -= thinner;
        Mesh part = capsule_mesh(capsule, deviation, 0.37 + 1.117 * static_cast<double>(i));
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

// Groups of images that touch or nearly touch: only those need Booleans.
std::vector<std::vector<std::size_t>> clusters_of(const std::vector<Grains::Image>& images, double reach) {
    std::vector<std::size_t> parent(images.size());
    for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = i;
    const auto root = [&](std::size_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    };
    for (std::size_t i = 0; i < images.size(); ++i)
        for (std::size_t j = i + 1; j < images.size(); ++j) {
            if (root(i) == root(j)) continue;
            if (((images[i].bounds.high - images[j].bounds.low).array() < -reach).any() ||
                ((images[j].bounds.high - images[i].bounds.low).array() < -reach).any())
                continue;
            bool near = false;
            for (const auto& p : images[i].capsules)
                for (const auto& q : images[j].capsules) near = near || gap(p, q) < reach;
            if (near) parent[root(i)] = root(j);
        }
    std::map<std::size_t, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < images.size(); ++i) groups[root(i)].push_back(i);
    std::vector<std::vector<std::size_t>> clusters;
    for (auto& [r, members] : groups) clusters.push_back(std::move(members));
    return clusters;
}

// Unions pairwise as a tree, neighbours in z first.
Mesh unite_cluster(std::vector<Mesh> meshes, const std::function<void()>& one_done) {
    while (meshes.size() > 1) {
        check_interrupt();
        const std::size_t pairs = meshes.size() / 2;
        std::exception_ptr fault;
#pragma omp parallel for schedule(dynamic, 1)
        for (std::size_t p = 0; p < pairs; ++p) {
            try {
                unite_into(meshes[2 * p], meshes[2 * p + 1]);
#pragma omp critical
                one_done();
            } catch (...) {
#pragma omp critical
                fault = std::current_exception();
            }
        }
        if (fault) std::rethrow_exception(fault);
        std::vector<Mesh> next;
        for (std::size_t p = 0; p < meshes.size(); p += 2) next.push_back(std::move(meshes[p]));
        meshes = std::move(next);
    }
    return std::move(meshes.front());
}

// Rounds to single precision, as the STL file does, and welds.
void append(TriangleSurface& surface, const Mesh& mesh) {
    const auto offset = static_cast<int>(surface.points.size());
    std::vector<int> index(mesh.num_vertices());
    int next = offset;
    for (const auto v : mesh.vertices()) {
        index[v.idx()] = next++;
        const Point& p = mesh.point(v);
        surface.points.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto face : mesh.faces()) {
        std::array<int, 3> triangle{};
        std::size_t c = 0;
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) triangle[c++] = index[v.idx()];
        surface.triangles.push_back(triangle);
    }
}

TriangleSurface round_to_single(const TriangleSurface& surface) {
    std::map<std::array<float, 3>, int> seen;
    TriangleSurface rounded;
    std::vector<int> index;
    for (const auto& p : surface.points) {
        const std::array<float, 3> q = {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
        const auto [entry, fresh] = seen.try_emplace(q, static_cast<int>(rounded.points.size()));
        if (fresh) rounded.points.push_back({q[0], q[1], q[2]});
        index.push_back(entry->second);
    }
    for (const auto& t : surface.triangles) {
        const std::array<int, 3> r = {index[static_cast<std::size_t>(t[0])], index[static_cast<std::size_t>(t[1])],
                                      index[static_cast<std::size_t>(t[2])]};
        if (r[0] != r[1] && r[1] != r[2] && r[2] != r[0]) rounded.triangles.push_back(r);
    }
    return rounded;
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

SurfaceResult make_surface(const Packing& packing, const SurfaceOptions& options) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain");
    double d = 1e300;
    for (const auto& shape : packing.shapes) d = std::min(d, smallest_diameter(shape));
    const double deviation = options.deviation_m > 0.0 ? options.deviation_m : 0.02 * d;
    SurfaceResult result;
    result.contact_gap_m = options.contact_gap_m > 0.0 ? options.contact_gap_m : 1e-4 * d;
    const Grains grains(packing);
    const auto& images = grains.images();
    auto clusters = clusters_of(images, 2.0 * deviation);
    for (const auto& cluster : clusters)
        if (cluster.size() > 1) result.joined_grains += static_cast<long>(cluster.size());

    std::vector<int> thinned(packing.bodies.size(), 0);
    constexpr int most_rounds = 6;
    for (int round = 0; round < most_rounds; ++round) {
        std::map<std::pair<std::size_t, int>, Mesh> unit;  // grain's mesh by shape and thinning
        for (const auto& image : images) {
            const auto key = std::pair(packing.bodies[image.body].shape, thinned[image.body]);
            if (!unit.contains(key))
                unit.emplace(key, grain_mesh(packing.shapes[key.first], 0.9 * deviation, key.second * result.contact_gap_m));
        }
        TriangleSurface surface;
        Progress progress("surface (CGAL)");
        std::size_t done = 0;
        for (auto& cluster : clusters) {
            std::sort(cluster.begin(), cluster.end(),
                      [&](std::size_t p, std::size_t q) { return images[p].bounds.low.z() < images[q].bounds.low.z(); });
            std::vector<Mesh> meshes;
            for (const std::size_t g : cluster) {
                const Body& body = packing.bodies[images[g].body];
                meshes.push_back(
                    moved_mesh(unit.at({body.shape, thinned[images[g].body]}), body.position_m + images[g].shift, body.orientation));
            }
            append(surface, unite_cluster(std::move(meshes),
                                          [&] { progress.update(static_cast<double>(++done) / static_cast<double>(images.size())); }));
        }
        result.surface = round_to_single(surface);
        const SurfaceCheck check = check_surface(result.surface);
        if (check.fault.empty()) break;
        const auto& crossings = check.fault_places;
        if (round + 1 == most_rounds)
            throw NumericalError(fmt::format("the surface still has faults at {} places after the grains there were thinned {} times: {}",
                                             crossings.size(), round, check.fault),
                                 {.mend = "raise contact_gap_m, or change surface_deviation_m a little"});
        std::set<std::size_t> guilty;
        for (const Vec3& place : crossings)
            for (const auto& image : images)
                if (signed_distance(image.capsules, place) < 2.0 * deviation) guilty.insert(image.body);
        for (const std::size_t body : guilty) ++thinned[body];
        log_info("surface: {} faults after rounding to single precision; {} grains are thinned by {:.2g} m", crossings.size(),
                 guilty.size(), result.contact_gap_m);
    }
    for (const int steps : thinned) result.shrunk_grains += steps > 0 ? 1 : 0;
    result.deviation_m = largest_deviation(result.surface, grains, d);
    return result;
}

}  // namespace porepack
