#include "converters/grain_from_mesh.hpp"

#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <fmt/format.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "converters/cgal_mesh.hpp"
#include "converters/grain_mesh.hpp"
#include "converters/single_precision.hpp"
#include "converters/surface.hpp"
#include "converters/uses.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/machine.hpp"
#include "shapes/shape.hpp"
#include "shapes/triangle_core.hpp"

namespace porepack::converters {
namespace sms = CGAL::Surface_mesh_simplification;
namespace {

constexpr long fewest_faces = 4, max_faces = 2000;
constexpr double largest_share = 0.1;  // of the deviation in the diameter of the sphere of the same volume

struct Corners {
    std::vector<Vec3> points;
    std::vector<std::array<int, 3>> triangles;
};

Corners corners_of(const Mesh& mesh) {
    Corners corners;
    std::vector<int> place(mesh.num_vertices() + mesh.number_of_removed_vertices());
    for (const auto v : mesh.vertices()) {
        place[v.idx()] = static_cast<int>(corners.points.size());
        corners.points.push_back(to_vector(mesh.point(v)));
    }
    for (const auto face : mesh.faces()) {
        std::array<int, 3> triangle{};
        std::size_t i = 0;
        for (const auto v : vertices_around_face(mesh.halfedge(face), mesh)) triangle[i++] = place[v.idx()];
        corners.triangles.push_back(triangle);
    }
    return corners;
}

Corners simplified(Mesh mesh, long faces) {
    // A closed surface has three edges for two triangles.
    const sms::Count_stop_predicate<Mesh> stop(static_cast<std::size_t>(3 * faces / 2 + 1));
    sms::edge_collapse(mesh, stop, CGAL::parameters::filter(sms::Bounded_normal_change_filter<>()));
    return corners_of(mesh);
}

// Points of the surface, evenly by area: in each triangle, those of a sequence that fills it evenly (R2, Roberts 2018).
std::vector<Vec3> points_on(const TriangleSurface& surface, double area, std::size_t wanted) {
    std::vector<Vec3> points;
    points.reserve(wanted + surface.triangles.size());
    constexpr double a1 = 0.7548776662466927, a2 = 0.5698402909980532;
    double owed = 0.0;
    std::size_t n = 0;
    for (const auto& triangle : surface.triangles) {
        Vec3 x[3];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto& p = surface.points[static_cast<std::size_t>(triangle[i])];
            x[i] = Vec3(p[0], p[1], p[2]);
        }
        for (owed += 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm() / area * static_cast<double>(wanted); owed >= 1.0; owed -= 1.0) {
            ++n;
            double u = std::fmod(a1 * static_cast<double>(n), 1.0), v = std::fmod(a2 * static_cast<double>(n), 1.0);
            if (u + v > 1.0) {
                u = 1.0 - u;
                v = 1.0 - v;
            }
            points.push_back(x[0] + u * (x[1] - x[0]) + v * (x[2] - x[0]));
        }
    }
    return points;
}

// One step of Gauss and Newton: corners of the core for which the points lie at the distance `rounding` from it, in the least squares, with
// the distance of a point linear in the corners of its nearest triangle.
std::vector<Vec3> fitted(const Corners& corners, const TriangleCore& core, const std::vector<Vec3>& points, double rounding) {
    const auto size = static_cast<Eigen::Index>(3 * corners.points.size());
    // Of each triangle's corners.
    std::vector<Eigen::Matrix<double, 9, 9>> own(corners.triangles.size(), Eigen::Matrix<double, 9, 9>::Zero());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    for (const Vec3& point : points) {
        Vec3 outward;
        std::size_t t = 0;
        const double away = core.distance(point, &outward, &t);
        const auto& triangle = corners.triangles[t];
        const Vec3 foot = point - away * outward;
        const Vec3 &a = corners.points[static_cast<std::size_t>(triangle[0])], &b = corners.points[static_cast<std::size_t>(triangle[1])],
                   &c = corners.points[static_cast<std::size_t>(triangle[2])];
        const Vec3 normal = (b - a).cross(c - a);
        const double per = 1.0 / normal.squaredNorm();
        const double share[3] = {(c - b).cross(foot - b).dot(normal) * per, (a - c).cross(foot - c).dot(normal) * per,
                                 (b - a).cross(foot - a).dot(normal) * per};
        Eigen::Matrix<double, 9, 1> slope;  // of the distance, by the corners
        slope << share[0] * outward, share[1] * outward, share[2] * outward;
        own[t] += slope * slope.transpose();
        for (int i = 0; i < 3; ++i)
            right.segment<3>(3 * triangle[static_cast<std::size_t>(i)]) += (away - rounding) * slope.segment<3>(3 * i);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t t = 0; t < own.size(); ++t)
        for (int i = 0; i < 9; ++i)
            for (int j = 0; j < 9; ++j)
                entries.emplace_back(3 * corners.triangles[t][static_cast<std::size_t>(i / 3)] + i % 3,
                                     3 * corners.triangles[t][static_cast<std::size_t>(j / 3)] + j % 3, own[t](i, j));
    // What the points do not determine, as shifts within a flat face, stays.
    const double hold = 1e-2 * static_cast<double>(points.size()) / static_cast<double>(corners.points.size());
    for (Eigen::Index i = 0; i < size; ++i) entries.emplace_back(i, i, hold);
    Eigen::SparseMatrix<double> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd shift = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
    std::vector<Vec3> moved = corners.points;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += shift.segment<3>(static_cast<Eigen::Index>(3 * i));
    return moved;
}

std::shared_ptr<const RoundedBody> body_of(const Corners& corners, double rounding) {
    PolyhedronSize size{.corners_m = corners.points, .faces = {}, .rounding_m = rounding};
    for (const auto& triangle : corners.triangles) size.faces.emplace_back(triangle.begin(), triangle.end());
    return make_polyhedron(size);
}

std::string first_line(const std::string& text) {
    return text.substr(0, text.find('\n'));
}

class Simplification {
public:
    Simplification(const TriangleSurface& surface, double rounding, const std::string& where) : where_(where), rounding_(rounding) {
        constexpr double bytes_per_triangle = 700.0;  // 580 were measured between 80,000 and 330,000 triangles
        require_memory(bytes_per_triangle * static_cast<double>(surface.triangles.size()),
                       fmt::format("the simplification of {} triangles", surface.triangles.size()),
                       "reduce the file to less than a million triangles first, for example with MeshLab");
        const SurfaceCheck check = check_surface(surface);
        require_sound(check, where);
        if (check.shells > 1)
            throw UserError(fmt::format("the surface has {} parts", check.shells),
                            {.where = where, .allowed = "one closed part", .fix = "one file per grain; a whole bed is kind = \"surface\""});
        before_ = measure_surface(surface);
        const Vec3 centre = before_.centre_of_mass_m;
        for (auto& p : (surface_ = surface).points)
            for (std::size_t axis = 0; axis < 3; ++axis) p[axis] -= centre[static_cast<Eigen::Index>(axis)];
        diameter_ = std::cbrt(6.0 * before_.volume_m3 / std::numbers::pi);
        // A level set may have edges of any shortness, whose triangles' normals say nothing: no edge would be collapsed over them.
        mesh_ = without_slivers(mesh_of(surface_).value(), 1e-5 * diameter_);
        if (rounding_ == 0.0) rounding_ = default_share * diameter_;
        points_ = points_on(surface_, before_.area_m2, 20000);
        tree_.insert(faces(mesh_).first, faces(mesh_).second, mesh_);
    }

    [[nodiscard]] MeshGrain with(long faces) const {
        Corners corners = simplified(mesh_, faces);
        std::shared_ptr<const RoundedBody> body;
        try {
            fit(corners);
            body = body_of(corners, rounding_);
        } catch (const UserError& fault) {
            throw UserError(fmt::format("with {} faces, {}", corners.triangles.size(), first_line(fault.what())),
                            {.where = where_, .fix = "a slightly different number of faces"});
        }
        MeshGrain grain{.faces_before = static_cast<long>(surface_.triangles.size()),
                        .faces = static_cast<long>(corners.triangles.size()),
                        .volume_m3 = before_.volume_m3,
                        .area_before_m2 = before_.area_m2};
        for (int round = 0; round < 2; ++round) {
            const ShapeMeasures own = measure({.id = "mesh", .body = body}, 1e-8, Effort::once);
            const double factor = std::cbrt(before_.volume_m3 / own.volume_m3);
            grain.scale *= factor;
            for (Vec3& x : corners.points) x = factor * (x - own.centre_of_mass_m);
            body = body_of(corners, grain.scale * rounding_);
        }
        if (std::abs(grain.scale - 1.0) > 0.1)
            throw UserError(fmt::format("a rounding of {:.3g} m leaves no core of {} faces", rounding_, grain.faces),
                            {.where = where_, .fix = "a smaller rounding_m"});
        grain.body = body;
        grain.surface = surface_;
        measure_deviation(grain);
        return grain;
    }

    [[nodiscard]] double diameter_m() const { return diameter_; }
    [[nodiscard]] const std::string& where() const { return where_; }
    [[nodiscard]] double rounding_m() const { return rounding_; }

private:
    static constexpr double default_share = 0.02;

    // The first step moves all corners inward by the rounding. Steps after which the surface would cross itself are made shorter.
    void fit(Corners& corners) const {
        auto core = std::make_unique<const TriangleCore>(corners.points, corners.triangles);
        for (int step = 0; step < 6; ++step) {
            const std::vector<Vec3> whole = fitted(corners, *core, points_, rounding_);
            bool moved = false;
            for (double share = 1.0; !moved && share > 0.1; share *= 0.5) {
                std::vector<Vec3> trial = corners.points;
                for (std::size_t i = 0; i < trial.size(); ++i) trial[i] += share * (whole[i] - trial[i]);
                try {
                    core = std::make_unique<const TriangleCore>(trial, corners.triangles);
                    corners.points = std::move(trial);
                    moved = true;
                } catch (const UserError&) {  // it crosses itself
                }
            }
            if (!moved) return;
        }
    }
    using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_face_graph_triangle_primitive<Mesh>>>;

    // From the surface's points to the body, and from points of the body to the surface.
    void measure_deviation(MeshGrain& grain) const {
        double squares = 0.0, area = 0.0, owed = 0.0;
        for (const Vec3& point : points_) {
            const double away = std::abs(grain.body->distance(point));
            grain.largest_deviation_m = std::max(grain.largest_deviation_m, away);
            squares += away * away;
        }
        grain.rms_deviation_m = std::sqrt(squares / static_cast<double>(points_.size()));
        grain.body->for_surface([&](const Vec3& x, const Vec3&, double own) {
            area += own;
            owed += own * 20000.0 / before_.area_m2;
            if (owed < 1.0) return;
            owed -= std::floor(owed);
            grain.largest_deviation_m = std::max(grain.largest_deviation_m, std::sqrt(tree_.squared_distance(to_point(x))));
        });
    }

    std::string where_;
    double rounding_, diameter_ = 0.0;
    TriangleSurface surface_;
    SurfaceMeasures before_;
    Mesh mesh_;
    std::vector<Vec3> points_;
    Tree tree_;
};

// Through a closed surface in one part, by Euler's formula.
long holes_through(std::size_t corners, std::size_t triangles) {
    return 1 - (static_cast<long>(corners) - static_cast<long>(triangles) / 2) / 2;
}

}  // namespace

void require_same_holes(const MeshGrain& grain, const std::string& where) {
    const long before = holes_through(grain.surface.points.size(), grain.surface.triangles.size());
    if (before == 0) return;
    const double diameter = std::cbrt(6.0 * grain.volume_m3 / std::numbers::pi);
    const Mesh after = grain_mesh({.id = "mesh", .body = grain.body}, 0.005 * diameter, 0.0, 0);
    if (const long left = holes_through(after.number_of_vertices(), after.number_of_faces()); left != before)
        throw UserError(fmt::format("the surface has {} hole{} through it, the grain of {} faces with a rounding of {:.3g} m has {}",
                                    before, before == 1 ? "" : "s", grain.faces, grain.body->rounding(), left),
                        {.where = where, .fix = "more faces, or a smaller rounding_m; or close the hole in the file"});
}

MeshGrain grain_from_mesh(const TriangleSurface& surface, const MeshGrainOptions& options, const std::string& where) {
    const Simplification simplification(surface, options.rounding_m, where);
    MeshGrain grain;
    if (options.deviation_m > 0.0) {
        const double most = std::min(static_cast<double>(max_faces), static_cast<double>(surface.triangles.size()));
        for (double faces = std::min(20.0, most);; faces = std::min(1.26 * faces, most)) {
            check_interrupt();
            try {
                grain = simplification.with(std::lround(faces));
                if (grain.largest_deviation_m <= options.deviation_m) {
                    require_same_holes(grain, where);
                    return grain;
                }
            } catch (const UserError&) {  // so few faces would cross
                if (faces == most) throw;
            }
            if (faces == most)
                throw UserError(fmt::format("{} faces deviate by {:.3g} m", grain.faces, grain.largest_deviation_m),
                                {.where = where,
                                 .allowed = fmt::format("a deviation_m that at most {} faces keep", std::lround(most)),
                                 .fix = "a larger deviation_m, or a smaller rounding_m"});
        }
    }
    if (options.faces < fewest_faces || options.faces > max_faces)
        throw UserError(fmt::format("{} faces", options.faces),
                        {.where = where, .allowed = fmt::format("{} to {}", fewest_faces, max_faces)});
    grain = simplification.with(options.faces);
    if (grain.largest_deviation_m > largest_share * simplification.diameter_m())
        throw UserError(fmt::format("a grain of {} faces with a rounding of {:.3g} m deviates from the surface by {:.3g} m", grain.faces,
                                    simplification.rounding_m(), grain.largest_deviation_m),
                        {.where = where,
                         .allowed = fmt::format("{:g} of the diameter of the sphere of the same volume", largest_share),
                         .fix = "more faces, or a smaller rounding_m"});
    require_same_holes(grain, where);
    return grain;
}

}  // namespace porepack::converters
