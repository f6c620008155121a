// Contacts of grains with faces, with each other, with grains of capsules and with walls (piece_contact.hpp).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/error.hpp"
#include "geometry/triangle_wall.hpp"
#include "pouring/dem/capsule_state.hpp"
#include "pouring/dem/piece_rows.hpp"
#include "pouring/pour.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

namespace {

// In the shape's frame.
class ShapeSurface : public Surface {
public:
    ShapeSurface(const Shape& shape, bool convex) : Surface(convex), shape_(shape) {}
    double distance(const Vec3& point, Vec3& outward) const override {
        return shape_.body != nullptr ? shape_.body->distance(point, &outward) : signed_distance(shape_.capsules, point, outward);
    }
    void distances(const PointRow& points, DistanceRow& found) const override {
        shape_.body != nullptr ? shape_.body->distances(points, found) : Surface::distances(points, found);
    }

private:
    const Shape& shape_;
};

// Walls in the frame of a grain's shape.
class PlaneSurface : public Surface {
public:
    PlaneSurface(const Vec3& normal, double offset) : Surface(true), normal_(normal), offset_(offset) {}
    double distance(const Vec3& point, Vec3& outward) const override {
        outward = normal_;
        return offset_ + normal_.dot(point);
    }
    void distances(const PointRow& points, DistanceRow& found) const override { plane_distances(normal_, offset_, points, found); }

private:
    Vec3 normal_;
    double offset_;
};

class RoundSurface : public Surface {
public:
    RoundSurface(const Eigen::Matrix3d& turn, const Vec3& origin, const VesselWalls::Round& wall)
        : Surface(wall.inside), turn_(turn), origin_(origin), wall_(wall) {}
    double distance(const Vec3& point, Vec3& outward) const override {
        const Vec3 x = origin_ + turn_ * point;
        outward = turn_.transpose() * wall_.normal(x);
        return wall_.distance(x);
    }
    void distances(const PointRow& points, DistanceRow& found) const override { round_distances(turn_, origin_, wall_, points, found); }

private:
    const Eigen::Matrix3d& turn_;
    const Vec3& origin_;
    const VesselWalls::Round& wall_;
};

// `sides`: those within twice `reach` of the grain's middle. A point of the grain that is farther from the wall than `reach`, which is the
// radius of the grain's bounding sphere, has no contact: there the distance may be any larger one.
class MeshSurface : public Surface {
public:
    MeshSurface(const Eigen::Matrix3d& turn, const Vec3& origin, const TriangleWall& wall, const std::vector<std::uint32_t>& sides,
                double reach)
        : Surface(false), turn_(turn), origin_(origin), wall_(wall), sides_(sides), reach_(reach) {}
    double distance(const Vec3& point, Vec3& outward) const override {
        constexpr std::size_t few = 100;  // more are searched in the wall's tree
        Vec3 inward;
        const Vec3 x = origin_ + turn_ * point;
        const double away = sides_.size() <= few ? wall_.distance(x, sides_, &inward) : wall_.distance(x, &inward);
        outward = turn_.transpose() * inward;
        return away < -reach_ ? -away : away;
    }

private:
    const Eigen::Matrix3d& turn_;
    const Vec3& origin_;
    const TriangleWall& wall_;
    const std::vector<std::uint32_t>& sides_;
    double reach_;
};

}  // namespace

bool CapsuleDem::State::is_faced(std::size_t i, std::size_t other) const {
    return faced_ && (has_faces(bodies_[i]) || has_faces(bodies_[other]));
}

// Adds the pieces of each body that are near the other one.
void CapsuleDem::State::add_piece_pairs(std::size_t i, std::size_t other, const Vec3& shift) {
    const std::size_t owner = std::min(i, other), second = std::max(i, other);
    const Vec3 to_second = owner == i ? shift : Vec3(-shift);
    auto& list = piece_pairs_[owner];
    const std::size_t before = list.size();
    for (const bool own : {true, false}) {
        const std::size_t of_piece = own ? owner : second, of_surface = own ? second : owner;
        const BodyState &piece_body = bodies_[of_piece], &surface_body = bodies_[of_surface];
        const Kind &piece_kind = kinds_[piece_body.kind], &surface_kind = kinds_[surface_body.kind];
        const Frame &frame = frames_[of_piece], &surface_frame = frames_[of_surface];
        const Vec3 away = own ? Vec3(-to_second) : to_second;  // of the image of the piece's body that is near the surface's
        std::vector<bool> known(piece_kind.pieces.size(), false);
        for (std::size_t n = 0; n < before; ++n)
            if (list[n].other == second && (list[n].own != 0) == own) known[list[n].piece] = true;
        const ShapeSurface surface(shapes_[surface_body.kind], surface_kind.convex);
        Vec3 outward;
        for (std::size_t p = 0; p < piece_kind.pieces.size(); ++p) {
            const ContactPiece& piece = piece_kind.pieces[p];
            const Vec3 middle = frame.origin + frame.turn * piece.at(0.5) + away;
            const double half = 0.5 * piece.speed(0.0) + piece.radius, far = surface_kind.radius + half + skin_;
            // Other bodies are in contact with a round side by corners and edges of their own.
            if (known[p] || (piece.kind == ContactPiece::Kind::axis && !surface_kind.round) ||
                (middle - surface_body.x).squaredNorm() > far * far)
                continue;
            const double gap = surface.distance(surface_frame.turn.transpose() * (middle - surface_frame.origin), outward) - half;
            if (gap > skin_) continue;
            list.push_back({.other = static_cast<std::uint32_t>(second),
                            .piece = static_cast<std::uint16_t>(p),
                            .own = static_cast<std::uint16_t>(own),
                            .out_of_reach = bodies_[owner].travelled + bodies_[second].travelled + gap,
                            .tangential_displacement = Vec3::Zero(),
                            .base_force = Vec3::Zero()});
        }
    }
    if (list.size() > before) list_neighbours(owner);
}

bool CapsuleDem::State::piece_contact_of(std::size_t i, std::size_t n, Contact& contact, PieceContact& part, double& gap) const {
    const PiecePair& pair = piece_pairs_[i][n];
    contact.pair = n;
    contact.shift = image_shift(bodies_[pair.other].x - bodies_[i].x);
    const bool own = pair.own != 0;
    const std::size_t of_piece = own ? i : pair.other, of_surface = own ? pair.other : i;
    const std::uint32_t surface_kind = bodies_[of_surface].kind;
    const Frame &frame = frames_[of_piece], &surface = frames_[of_surface];
    const Vec3 away = own ? Vec3(-contact.shift) : contact.shift;
    const Eigen::Matrix3d turn = surface.turn.transpose() * frame.turn;
    const ContactPiece piece =
        kinds_[bodies_[of_piece].kind].pieces[pair.piece].moved(turn, surface.turn.transpose() * (frame.origin + away - surface.origin));
    if (!dem::contact_of(piece, ShapeSurface(shapes_[surface_kind], kinds_[surface_kind].convex), part, gap)) return false;
    // Out of the surface means towards the piece's body.
    contact.normal = surface.turn * (own ? Vec3(-part.normal) : part.normal);
    contact.at = surface.origin + surface.turn * part.at + (own ? contact.shift : Vec3(Vec3::Zero()));
    contact.overlap = part.overlap;
    contact.twist = part.twist;
    return true;
}

// All contacts of two bodies share one potential.
void CapsuleDem::State::share_potential(std::size_t i, const std::vector<PieceContact>& parts, std::vector<Contact>& contacts) const {
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const std::uint32_t other = piece_pairs_[i][contacts[c].pair].other;
        double sum = 0.0;
        for (std::size_t d = 0; d < contacts.size(); ++d)
            if (piece_pairs_[i][contacts[d].pair].other == other) sum += parts[d].potential;
        contacts[c].share = share_of(parts[c], sum);
        contacts[c].square = square_of(parts[c], sum);
    }
}

void CapsuleDem::State::check_piece_pairs(std::size_t i, std::vector<Contact>& contacts, std::size_t& looked_at) {
    thread_local std::vector<PieceContact> parts;
    contacts.clear();
    parts.clear();
    look_at(
        i, piece_pairs_[i], looked_at,
        [&](std::size_t n, double& gap) {
            Contact contact;
            PieceContact part;
            if (!piece_contact_of(i, n, contact, part, gap)) return false;
            contacts.push_back(contact);
            parts.push_back(part);
            const std::size_t other = piece_pairs_[i][n].other;
            const double thickness = std::min(kinds_[bodies_[i].kind].diameter, kinds_[bodies_[other].kind].diameter);
            if (part.overlap > deepest_overlap * thickness) too_deep_[i / block % load_slots] = {1, i, other};
            return true;
        },
        [](const PiecePair&) {});
    share_potential(i, parts, contacts);
}

// A sleeper wakes when the force between the two bodies changes, not that of one contact of many.
void CapsuleDem::State::watch_sleeping_neighbours(std::size_t i, const std::vector<Contact>& contacts, const std::vector<Vec3>& forces) {
    auto& list = piece_pairs_[i];
    for (const std::uint32_t other : neighbours_[i]) {
        const BodyState &body = bodies_[i], &second = bodies_[other];
        if (body.asleep != 0 && second.asleep != 0) continue;
        const bool watched = body.asleep != 0 || second.asleep != 0;
        const BodyState& sleeper = body.asleep != 0 ? body : second;
        const bool fresh = !watched || sleeper.slept_at == steps_ - 1;
        Vec3 change = Vec3::Zero();
        for (PiecePair& pair : list) {
            if (pair.other != other) continue;
            if (fresh) pair.base_force.setZero();
            change -= pair.base_force;
        }
        for (std::size_t c = 0; c < contacts.size(); ++c) {
            PiecePair& pair = list[contacts[c].pair];
            if (pair.other != other) continue;
            if (fresh && watched) pair.base_force = forces[c];
            if (!fresh) change += forces[c];
        }
        if (fresh) continue;
        const double weight = kinds_[sleeper.kind].body.mass_kg * options_.gravity_m_per_s2.norm();
        if (change.norm() > options_.wake_fraction * weight)
            woken_[i / block % load_slots].push_back(body.asleep != 0 ? static_cast<std::uint32_t>(i) : other);
    }
}

void CapsuleDem::State::find_piece_contacts(std::size_t i, std::vector<Contact>& contacts) const {
    std::vector<PieceContact> parts;
    contacts.clear();
    for (std::size_t n = 0; n < piece_pairs_[i].size(); ++n) {
        Contact contact;
        PieceContact part;
        double gap = 0.0;
        if (!piece_contact_of(i, n, contact, part, gap)) continue;
        contacts.push_back(contact);
        parts.push_back(part);
    }
    share_potential(i, parts, contacts);
}

bool CapsuleDem::State::is_near_mesh(std::size_t i) const {
    const BodyState& body = bodies_[i];
    NearMesh& near = near_mesh_[i];
    if (body.travelled < near.until) return near.touches;
    const double reach = kinds_[body.kind].radius, gap = vessel_walls_.mesh->distance(body.x) - reach;
    near.touches = gap <= skin_;
    near.until = body.travelled + std::max(skin_, gap);
    near.sides.clear();
    if (near.touches) vessel_walls_.mesh->sides_near(body.x, 2.0 * reach + skin_, near.sides);
    return near.touches;
}

// In the frame of the body's shape, where the pieces need not be moved.
void CapsuleDem::State::find_piece_wall_contacts(std::size_t i, std::vector<WallContactPoint>& found) const {
    const BodyState& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const Frame& frame = frames_[i];
    struct Part {
        std::size_t history;
        std::uint64_t rim;
        double to_wall;  // along the normal of the contact: -1, or 1 where the piece is the wall's
        PieceContact contact;
    };
    thread_local std::vector<Part> parts;
    const auto find = [&](std::size_t wall, const Surface& surface, bool with_axes) {
        for (std::size_t p = 0; p < kind.pieces.size(); ++p) {
            PieceContact contact;
            double gap = 0.0;
            if ((kind.pieces[p].kind == ContactPiece::Kind::axis && !with_axes) || !dem::contact_of(kind.pieces[p], surface, contact, gap))
                continue;
            parts.push_back({(kind.nodes.size() + p) * wall_count() + wall, 0, -1.0, contact});
        }
    };
    // All that were found share one potential.
    const auto add = [&] {
        double sum = 0.0;
        for (const Part& part : parts) sum += part.contact.potential;
        for (const auto& [history, rim, to_wall, contact] : parts)
            found.push_back({.history = history,
                             .at = frame.origin + frame.turn * contact.at,
                             .outward = to_wall * (frame.turn * contact.normal),
                             .overlap = contact.overlap,
                             .share = share_of(contact, sum),
                             .square = square_of(contact, sum),
                             .twist = contact.twist,
                             .rim = rim});
        parts.clear();
    };
    const std::size_t planes = vessel_walls_.planes.size();
    if (has_faces(body)) {
        // Round sides meet convex walls away from their rims.
        for (std::size_t w = 0; w < planes; ++w)
            if (const auto& plane = vessel_walls_.planes[w]; plane.distance(body.x) <= kind.radius) {
                find(w, PlaneSurface(frame.turn.transpose() * plane.normal, plane.distance(frame.origin)), false);
                add();
            }
        for (std::size_t w = 0; w < vessel_walls_.round.size(); ++w)
            if (const auto& wall = vessel_walls_.round[w]; wall.overlap(body.x, kind.radius) > 0.0) {
                find(planes + w, RoundSurface(frame.turn, frame.origin, wall), wall.inside);
                add();
            }
        if (lid_)
            if (const VesselWalls::Plane plane = lid_plane(); plane.distance(body.x) <= kind.radius) {
                find(lid_wall(), PlaneSurface(frame.turn.transpose() * plane.normal, plane.distance(frame.origin)), false);
                add();
            }
    }
    if (vessel_walls_.mesh == nullptr || !is_near_mesh(i)) return;
    const TriangleWall& mesh = *vessel_walls_.mesh;
    find(mesh_wall(), MeshSurface(frame.turn, frame.origin, mesh, near_mesh_[i].sides, kind.radius), true);
    // Capsules meet the wall's rims by their axes; faces do not.
    if (has_faces(body)) {
        const double longest = std::min(0.5 * kind.radius, kind.convex ? 1e300 : 6.0 * kind.diameter);
        const ShapeSurface surface(shapes_[body.kind], kind.convex);
        mesh.for_rims_near(body.x, kind.radius, [&](std::size_t n, double from, double to) {
            const auto& rim = mesh.rim(n);
            const double length = (rim.b - rim.a).norm();
            for (auto k = static_cast<std::uint64_t>(from / longest); static_cast<double>(k) * longest < to; ++k) {
                const double start = static_cast<double>(k) * longest, end = std::min(length, start + longest);
                if (!(end > start)) break;
                const ContactPiece piece{.kind = ContactPiece::Kind::segment,
                                         .start = rim.a + start / length * (rim.b - rim.a),
                                         .along = (end - start) / length * (rim.b - rim.a),
                                         .length = end - start,
                                         .per_length = 0.1 * kind.diameter};
                PieceContact contact;
                double gap = 0.0;
                const Eigen::Matrix3d back = frame.turn.transpose();
                if (dem::contact_of(piece.moved(back, -(back * frame.origin)), surface, contact, gap))
                    parts.push_back({mesh_wall(), (static_cast<std::uint64_t>(n) << 32U) + k + 1, 1.0, contact});
            }
        });
    }
    add();
}

CapsuleDem::State::WallContact& CapsuleDem::State::wall_contact(std::size_t i, const WallContactPoint& touch) {
    if (touch.rim == 0) return walls_[bodies_[i].first_wall + touch.history];
    auto& list = rim_contacts_[i];
    const auto found = std::find_if(list.begin(), list.end(), [&](const RimContact& one) { return one.rim == touch.rim; });
    if (found != list.end()) return found->contact;
    if (bodies_[i].asleep == 0) std::erase_if(list, [&](const RimContact& one) { return one.contact.last_contact < steps_ - 1; });
    list.push_back({.rim = touch.rim, .contact = {}});
    return list.back().contact;
}

void CapsuleDem::State::require_no_crossing() {
    for (const auto& [found, body, other] : too_deep_)
        if (found != 0)
            throw NumericalError(
                fmt::format(
                    "grains {} and {} overlap by more than {:g} of the thickness of the thinner one: they would pass through each other",
                    body, other, deepest_overlap),
                {.fix = "raise normal_stiffness_N_per_m (and tangential_stiffness_N_per_m), or lower drop_height_m"});
}

}  // namespace porepack::pouring::dem
