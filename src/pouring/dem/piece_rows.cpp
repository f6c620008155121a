#include "pouring/dem/piece_rows.hpp"

#include <cmath>

#include "core/vectorised.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr int size = PointRow::most;

struct Pointers {
    double *x, *y, *z;
    explicit Pointers(PointRow& row) : x(row.x.data()), y(row.y.data()), z(row.z.data()) {}
};

POREPACK_VECTORISED void place_on_line(const Vec3& start, const Vec3& along, double length, PlaceRow& row) {
    const double *const s = row.s.data(), x = start.x(), y = start.y(), z = start.z(), dx = along.x(), dy = along.y(), dz = along.z();
    const Pointers at(row.points), tangent(row.tangents);
    double* const speed = row.speed.data();
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) {
        at.x[i] = x + s[i] * dx;
        at.y[i] = y + s[i] * dy;
        at.z[i] = z + s[i] * dz;
        tangent.x[i] = dx / length;
        tangent.y[i] = dy / length;
        tangent.z[i] = dz / length;
        speed[i] = length;
    }
}

POREPACK_VECTORISED void place_on_arc(const ContactPiece& piece, PlaceRow& row) {
    const double *const s = row.s.data(), half = piece.half_tangent, radius = piece.rim_radius;
    const double x = piece.start.x(), y = piece.start.y(), z = piece.start.z();
    const double ux = piece.u.x(), uy = piece.u.y(), uz = piece.u.z(), vx = piece.v.x(), vy = piece.v.y(), vz = piece.v.z();
    const Pointers at(row.points), tangent(row.tangents);
    double* const speed = row.speed.data();
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) {
        const double t = s[i] * half, per = 1.0 / (1.0 + t * t), c = (1.0 - t * t) * per, sine = 2.0 * t * per;
        at.x[i] = x + c * ux + sine * vx;
        at.y[i] = y + c * uy + sine * vy;
        at.z[i] = z + c * uz + sine * vz;
        tangent.x[i] = (c * vx - sine * ux) / radius;
        tangent.y[i] = (c * vy - sine * uy) / radius;
        tangent.z[i] = (c * vz - sine * uz) / radius;
        speed[i] = 2.0 * radius * half * per;
    }
}

// The order of the additions does not depend on the instruction set.
enum Quantity { potential, weight, push_x, push_y, push_z, moment_x, moment_y, moment_z, at_x, at_y, at_z, quantities };
POREPACK_VECTORISED void sum_row(const PlaceRow& row, const DistanceRow& found, const Row& weights, double radius, const Vec3& about,
                                 double (&sums)[quantities]) {
    alignas(64) double part_of[quantities][size];
    const double *const px = row.points.x.data(), *const py = row.points.y.data(), *const pz = row.points.z.data();
    const double *const nx = found.outward.x.data(), *const ny = found.outward.y.data(), *const nz = found.outward.z.data();
    const double *const distance = found.distance.data(), *const weight_of = weights.data();
    const double x0 = about.x(), y0 = about.y(), z0 = about.z();
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) {
        const double depth = radius - distance[i], overlap = depth > 0.0 ? depth : 0.0, o2 = overlap * overlap;
        const double part = weight_of[i] * (o2 * o2 * o2 * overlap);
        const double x = px[i] - x0, y = py[i] - y0, z = pz[i] - z0, inward = radius - 0.5 * overlap;
        const double fx = part * nx[i], fy = part * ny[i], fz = part * nz[i];
        part_of[potential][i] = part * overlap;
        part_of[weight][i] = part;
        part_of[push_x][i] = fx;
        part_of[push_y][i] = fy;
        part_of[push_z][i] = fz;
        part_of[moment_x][i] = y * fz - z * fy;
        part_of[moment_y][i] = z * fx - x * fz;
        part_of[moment_z][i] = x * fy - y * fx;
        part_of[at_x][i] = part * x - inward * fx;
        part_of[at_y][i] = part * y - inward * fy;
        part_of[at_z][i] = part * z - inward * fz;
    }
    for (int q = 0; q < quantities; ++q) {
        double* const part = part_of[q];
        for (int i = 0; i < 8; ++i) part[i] += part[i + 8];
        for (int i = 0; i < 4; ++i) part[i] += part[i + 4];
        sums[q] = (part[0] + part[2]) + (part[1] + part[3]);
    }
}

}  // namespace

void place(const ContactPiece& piece, PlaceRow& row) {
    if (piece.kind == ContactPiece::Kind::arc)
        place_on_arc(piece, row);
    else
        place_on_line(piece.start, piece.along, piece.length, row);
}

POREPACK_VECTORISED void plane_distances(const Vec3& normal, double offset, const PointRow& points, DistanceRow& found) {
    const double *const px = points.x.data(), *const py = points.y.data(), *const pz = points.z.data();
    const double nx = normal.x(), ny = normal.y(), nz = normal.z();
    double* const distance = found.distance.data();
    const Pointers outward(found.outward);
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) {
        distance[i] = offset + (nx * px[i] + ny * py[i] + nz * pz[i]);
        outward.x[i] = nx;
        outward.y[i] = ny;
        outward.z[i] = nz;
    }
}

POREPACK_VECTORISED void round_distances(const Eigen::Matrix3d& turn, const Vec3& origin, const VesselWalls::Round& wall,
                                         const PointRow& points, DistanceRow& found) {
    const double *const px = points.x.data(), *const py = points.y.data(), *const pz = points.z.data();
    const double xx = turn(0, 0), xy = turn(0, 1), xz = turn(0, 2), yx = turn(1, 0), yy = turn(1, 1), yz = turn(1, 2), zx = turn(2, 0),
                 zy = turn(2, 1), zz = turn(2, 2);
    const double x0 = origin.x(), y0 = origin.y(), z0 = origin.z();
    const double radius = wall.radius_m, slope = wall.slope, level = 1.0 / std::sqrt(1.0 + slope * slope), up = slope * level,
                 inward = wall.inside ? -level : level;
    double* const distance = found.distance.data();
    const Pointers outward(found.outward);
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) {
        const double x = x0 + (xx * px[i] + xy * py[i] + xz * pz[i]), y = y0 + (yx * px[i] + yy * py[i] + yz * pz[i]),
                     z = z0 + (zx * px[i] + zy * py[i] + zz * pz[i]);
        const double away = std::sqrt(x * x + y * y), per = -inward / (away > 0.0 ? away : 1.0);
        distance[i] = inward * (radius + slope * z - away);
        outward.x[i] = per * (xx * x + yx * y) + up * zx;
        outward.y[i] = per * (xy * x + yy * y) + up * zy;
        outward.z[i] = per * (xz * x + yz * y) + up * zz;
    }
}

// The speed falls from the beginning of an arc.
POREPACK_VECTORISED double bound_between(const PlaceRow& row, const Row& distance) {
    const double *const d = distance.data(), *const s = row.s.data(), *const speed = row.speed.data();
    alignas(64) double bound[size];
#pragma GCC ivdep
    for (int i = 0; i < size - 1; ++i) {
        const double lower = d[i] < d[i + 1] ? d[i] : d[i + 1], between = 0.5 * (d[i] + d[i + 1] - (s[i + 1] - s[i]) * speed[i]);
        bound[i] = lower < between ? lower : between;
    }
    double least = bound[0];
    for (int i = 1; i < size - 1; ++i) least = bound[i] < least ? bound[i] : least;
    return least;
}

POREPACK_VECTORISED void find_slopes(const PlaceRow& row, const DistanceRow& found, Row& slopes) {
    const double *const tx = row.tangents.x.data(), *const ty = row.tangents.y.data(), *const tz = row.tangents.z.data();
    const double *const nx = found.outward.x.data(), *const ny = found.outward.y.data(), *const nz = found.outward.z.data();
    double* const slope = slopes.data();
#pragma GCC ivdep
    for (int i = 0; i < size; ++i) slope[i] = tx[i] * nx[i] + ty[i] * ny[i] + tz[i] * nz[i];
}

void add_row(const PlaceRow& row, const DistanceRow& found, const Row& weights, double radius, ContactSum& sum) {
    double sums[quantities];
    sum_row(row, found, weights, radius, sum.about, sums);
    sum.potential += sums[potential];
    sum.weight += sums[weight];
    sum.push += Vec3(sums[push_x], sums[push_y], sums[push_z]);
    sum.moment += Vec3(sums[moment_x], sums[moment_y], sums[moment_z]);
    sum.at += Vec3(sums[at_x], sums[at_y], sums[at_z]);
}

}  // namespace porepack::pouring::dem
