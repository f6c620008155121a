// Contacts of grains with faces, with each other, with grains of capsules and with walls (contact_pieces.hpp).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

bool CapsuleDem::State::is_faced(std::size_t i, std::size_t other) const {
    return faced_ && (kinds_[bodies_[i].kind].shape.body != nullptr || kinds_[bodies_[other].kind].shape.body != nullptr);
}

Surface CapsuleDem::State::surface_of(const Kind& kind) {
    if (const RoundedBody* const body = kind.shape.body.get())
        return {[body](const Vec3& point, Vec3& outward) { return body->distance(point, &outward); }, kind.convex};
    return {[&capsules = kind.shape.capsules](const Vec3& point, Vec3& outward) { return signed_distance(capsules, point, outward); },
            kind.convex};
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
        // Other bodies touch a round side with corners and edges of their own.
        const bool round = std::any_of(surface_kind.pieces.begin(), surface_kind.pieces.end(),
                                       [](const ContactPiece& piece) { return piece.kind == ContactPiece::Kind::axis; });
        std::vector<bool> known(piece_kind.pieces.size(), false);
        for (std::size_t n = 0; n < before; ++n)
            if (list[n].other == second && (list[n].own != 0) == own) known[list[n].piece] = true;
        const Surface surface = surface_of(surface_kind);
        Vec3 outward;
        for (std::size_t p = 0; p < piece_kind.pieces.size(); ++p) {
            const ContactPiece& piece = piece_kind.pieces[p];
            const Vec3 middle = frame.origin + frame.turn * piece.at(0.5) + away;
            const double half = 0.5 * piece.speed(0.0) + piece.radius, far = surface_kind.radius + half + skin_;
            if (known[p] || (piece.kind == ContactPiece::Kind::axis && !round) || (middle - surface_body.x).squaredNorm() > far * far)
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
    const Kind& surface_kind = kinds_[bodies_[of_surface].kind];
    const Frame &frame = frames_[of_piece], &surface = frames_[of_surface];
    const Vec3 away = own ? Vec3(-contact.shift) : contact.shift;
    const Eigen::Matrix3d turn = surface.turn.transpose() * frame.turn;
    const ContactPiece piece =
        kinds_[bodies_[of_piece].kind].pieces[pair.piece].moved(turn, surface.turn.transpose() * (frame.origin + away - surface.origin));
    if (!touch(piece, surface_of(surface_kind), part, gap)) return false;
    // Out of the surface means towards the piece's body.
    contact.normal = surface.turn * (own ? Vec3(-part.normal) : part.normal);
    contact.at = surface.origin + surface.turn * part.at + (own ? contact.shift : Vec3(Vec3::Zero()));
    contact.overlap = part.overlap;
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
    }
}

void CapsuleDem::State::check_piece_pairs(std::size_t i, std::vector<Contact>& contacts, std::size_t& looked_at) {
    const BodyState& body = bodies_[i];
    auto& list = piece_pairs_[i];
    thread_local std::vector<PieceContact> parts;
    contacts.clear();
    parts.clear();
    const std::size_t before = list.size();
    for (std::size_t n = 0; n < list.size();) {
        PiecePair& pair = list[n];
        const BodyState& other = bodies_[pair.other];
        if (body.travelled + other.travelled < pair.out_of_reach || (body.asleep != 0 && other.asleep != 0)) {
            ++n;
            continue;
        }
        ++looked_at;
        Contact contact;
        PieceContact part;
        double gap = 0.0;
        if (piece_contact_of(i, n, contact, part, gap)) {
            contacts.push_back(contact);
            parts.push_back(part);
            if (part.overlap > deepest_overlap * std::min(kinds_[body.kind].diameter, kinds_[other.kind].diameter))
                too_deep_[i / block % load_slots] = {1, i, pair.other};
        } else if (gap > 2.0 * skin_) {
            pair = list.back();
            list.pop_back();
            continue;
        } else {
            pair.out_of_reach = body.travelled + other.travelled + gap;
        }
        ++n;
    }
    if (list.size() < before) list_neighbours(i);
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

// In the frame of the body's shape, where the pieces need not be moved; planes first, then the tube.
void CapsuleDem::State::for_piece_wall_contacts(std::size_t i, const VisitWall& visit) const {
    const BodyState& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const Frame& frame = frames_[i];
    std::vector<std::pair<std::size_t, PieceContact>> found;
    const auto for_wall = [&](std::size_t wall, const Surface& surface) {
        found.clear();
        double sum = 0.0;
        for (std::size_t p = 0; p < kind.pieces.size(); ++p) {
            PieceContact part;
            double gap = 0.0;
            if (kind.pieces[p].kind == ContactPiece::Kind::axis || !touch(kind.pieces[p], surface, part, gap)) continue;
            sum += part.potential;
            found.emplace_back(p, part);
        }
        for (auto& [piece, part] : found) {
            const double share = share_of(part, sum);
            part.normal = frame.turn * part.normal;
            part.at = frame.origin + frame.turn * part.at;
            visit(piece, wall, part, share);
        }
    };
    for (std::size_t w = 0; w < planes_.size(); ++w) {
        if (planes_[w].distance(body.x) > kind.radius) continue;
        const Vec3 normal = frame.turn.transpose() * planes_[w].normal;
        const double offset = planes_[w].distance(frame.origin);
        for_wall(w, {[&](const Vec3& point, Vec3& outward) {
                         outward = normal;
                         return offset + normal.dot(point);
                     },
                     true});
    }
    if (cylinder_radius_ == 0.0 || body.x.head<2>().norm() + kind.radius <= cylinder_radius_) return;
    for_wall(planes_.size(), {[&](const Vec3& point, Vec3& outward) {
                                  const Vec3 x = frame.origin + frame.turn * point;
                                  const double away = x.head<2>().norm();
                                  outward = away > 0.0 ? Vec3(frame.turn.transpose() * Vec3(-x.x() / away, -x.y() / away, 0.0))
                                                       : Vec3(Vec3::UnitX());
                                  return cylinder_radius_ - away;
                              },
                              false});
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
