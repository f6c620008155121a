// Contact detection and contact forces.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

// The contact law: the force on the second of two bodies, Eq. (T3) along the normal, and the paper's Eq. 11 across it (docs/theory.md:
// corrections). The tangential displacement is kept in the tangent plane.
Vec3 CapsuleDem::State::contact_force(const Approach& at, Vec3& displacement, bool first) const {
    const double approach = at.velocity.dot(at.normal);
    const double elastic = elastic_force(at.overlap, at.share);
    double force = elastic + at.share * law_.normal_damping * std::sqrt(2.0 * at.mass * law_.normal_stiffness_N_per_m) * approach;
    if (!law_.attraction) force = std::max(0.0, force);
    const double kt = at.share * 0.5 * law_.tangential_stiffness_N_per_m;
    const double ct = at.share * law_.tangential_damping * std::sqrt(2.0 * at.mass * law_.tangential_stiffness_N_per_m);
    const Vec3 sliding = at.velocity - approach * at.normal;
    if (first) {
        displacement.setZero();
    } else {
        const double length = displacement.norm();
        displacement -= displacement.dot(at.normal) * at.normal;
        const double now = displacement.norm();
        if (now > 0.0) displacement *= length / now;
    }
    displacement += displacement_time_ * sliding;
    // First the elastic force alone, then elastic and dashpot force together are limited by friction: a displacement that includes a
    // dashpot part would return more energy than was put in.
    const double limit = at.friction * (law_.elastic_limit ? elastic : std::max(0.0, force));
    if (const double size = kt * displacement.norm(); size > limit) displacement *= limit / size;
    Vec3 tangential = kt * displacement + ct * sliding;
    if (const double size = tangential.norm(); size > limit) tangential *= limit / size;
    return force * at.normal + tangential;
}

// The contact of one pair of a Verlet list; returns false and the gap where there is none.
bool CapsuleDem::State::contact_of(std::size_t i, std::size_t n, Contact& contact, double& gap) const {
    const VerletPair& pair = verlet_lists_[i][n];
    const BodyState &body = bodies_[i], &other = bodies_[pair.other];
    const WorldArm &one = arms_[body.first_arm + pair.arm], &two = arms_[other.first_arm + pair.other_arm];
    const double r = kinds_[body.kind].arms[pair.arm].radius, other_r = kinds_[other.kind].arms[pair.other_arm].radius;
    contact.pair = n;
    contact.shift = image_shift(other.x - body.x);
    const Segment p{one.start, one.along}, q{two.start + contact.shift, two.along};
    const ClosestPoints closest = closest_points(p, q);
    gap = closest.distance - r - other_r;
    if (gap >= 0.0) return false;
    contact.overlap = -gap;
    contact.normal = closest.distance > 0.0 ? Vec3((closest.on_second - closest.on_first) / closest.distance)
                                            : (other.x + contact.shift - body.x).normalized();
    contact.at = pressed_point(p, q, closest, contact.overlap) + (r - 0.5 * contact.overlap) * contact.normal;
    contact.share = 1.0;
    return true;
}

namespace {

// 1 at the same place, 0 beyond `reach`.
double nearness(const Vec3& a, const Vec3& b, double reach) {
    const double near = std::max(0.0, 1.0 - (a - b).squaredNorm() / (reach * reach));
    return near * near;
}

}  // namespace

// Several contacts of the same two bodies at one place share the stiffness of a single contact.
void CapsuleDem::State::share_stiffness(const std::vector<VerletPair>& pairs, std::vector<Contact>& contacts, double reach) {
    for (Contact& contact : contacts) {
        double together = 0.0;
        for (const Contact& other : contacts) {
            if (pairs[other.pair].other != pairs[contact.pair].other) continue;
            together += nearness(other.at, contact.at, reach);
        }
        contact.share = 1.0 / together;
    }
}

// Most grains of a bed that is being poured. Their lists, which are long, need not be read.
bool CapsuleDem::State::rests_among_sleepers(std::size_t i) const {
    return bodies_[i].asleep != 0 &&
           std::all_of(neighbours_[i].begin(), neighbours_[i].end(), [&](std::uint32_t other) { return bodies_[other].asleep != 0; });
}

// The contacts of a body's Verlet list; pairs that have separated are removed from it.
void CapsuleDem::State::check_pairs(std::size_t i, std::vector<Contact>& contacts, std::size_t& looked_at) {
    contacts.clear();
    auto& list = verlet_lists_[i];
    look_at(
        i, list, looked_at,
        [&](std::size_t n, double& gap) {
            Contact contact;
            if (!contact_of(i, n, contact, gap)) return false;
            contacts.push_back(contact);
            return true;
        },
        [&](VerletPair& pair) {
            if (bodies_[i].asleep != 0 || bodies_[pair.other].asleep != 0) watch_sleeper(i, pair.other, pair.base_force, Vec3::Zero());
        });
    if (contacts.size() > 1) share_stiffness(list, contacts, 0.25 * kinds_[bodies_[i].kind].diameter);
}

void CapsuleDem::State::find_contacts(std::size_t i, std::vector<Contact>& contacts) const {
    contacts.clear();
    for (std::size_t n = 0; n < verlet_lists_[i].size(); ++n) {
        Contact contact;
        double gap = 0.0;
        if (contact_of(i, n, contact, gap)) contacts.push_back(contact);
    }
    share_stiffness(verlet_lists_[i], contacts, 0.25 * kinds_[bodies_[i].kind].diameter);
    for (Contact& contact : contacts) contact.square = contact.share * contact.overlap * contact.overlap;
}

// A contact that did not exist in the last step, unless both bodies slept: then it existed unchecked, and its
// tangential displacement remains valid.
bool CapsuleDem::State::is_new(std::int64_t last_contact, const BodyState& body, const BodyState& other) const {
    if (last_contact >= steps_ - 1) return false;
    const auto slept_since = [&](const BodyState& one) {
        return one.slept_at >= 0 && one.slept_at <= last_contact + 1 && (one.asleep != 0 || one.woke_at >= steps_ - 1);
    };
    return !slept_since(body) || !slept_since(other);
}

void CapsuleDem::State::watch_sleeper(std::size_t i, std::uint32_t other, Vec3& base_force, const Vec3& force) {
    const BodyState& sleeper = bodies_[i].asleep != 0 ? bodies_[i] : bodies_[other];
    if (sleeper.slept_at == steps_ - 1) base_force = force;
    const double weight = kinds_[sleeper.kind].body.mass_kg * options_.gravity_m_per_s2.norm();
    if ((force - base_force).norm() > options_.wake_fraction * weight)
        woken_[i / block % load_slots].push_back(bodies_[i].asleep != 0 ? static_cast<std::uint32_t>(i) : other);
}

template <typename Pair>
Vec3 CapsuleDem::State::press(std::size_t i, Pair& pair, const Contact& contact, std::vector<Load>& loads) {
    const BodyState& body = bodies_[i];
    const double own_mass = kinds_[body.kind].body.mass_kg;
    const BodyState& other = bodies_[pair.other];
    const Vec3 lever = contact.at - body.x, other_lever = contact.at - other.x - contact.shift;
    const Vec3 velocity = body.v_contact + body.omega.cross(lever) - other.v_contact - other.omega.cross(other_lever);
    const double other_mass = kinds_[other.kind].body.mass_kg;
    const double mass = other.held != 0 ? own_mass : body.held != 0 ? other_mass : own_mass * other_mass / (own_mass + other_mass);
    const Vec3 force = contact_force({.normal = contact.normal,
                                      .overlap = contact.overlap,
                                      .velocity = velocity,
                                      .mass = mass,
                                      .friction = law_.friction,
                                      .share = contact.share},
                                     pair.tangential_displacement, is_new(pair.last_contact, body, other));
    pair.last_contact = steps_;
    loads[i].force -= force;
    loads[i].torque -= lever.cross(force);
    loads[pair.other].force += force;
    virial_[i / block % load_slots] += force.dot(other.x + contact.shift - body.x);
    loads[pair.other].torque += other_lever.cross(force);
    if (contact.twist != 0.0) {
        const Vec3 torque = elastic_force(contact.overlap, contact.share) * contact.twist * contact.normal;
        loads[i].torque -= torque;
        loads[pair.other].torque += torque;
    }
    return force;
}

void CapsuleDem::State::grain_forces(std::size_t i, std::vector<Load>& loads, std::size_t& looked_at, std::vector<Contact>& contacts) {
    if (rests_among_sleepers(i)) return;
    check_pairs(i, contacts, looked_at);
    for (const Contact& contact : contacts) {
        VerletPair& pair = verlet_lists_[i][contact.pair];
        const Vec3 force = press(i, pair, contact, loads);
        if (bodies_[i].asleep != 0 || bodies_[pair.other].asleep != 0)
            watch_sleeper(i, pair.other, pair.base_force, force);
        else if (options_.sleep)
            pair.base_force.setZero();
    }
    if (!faced_) return;
    check_piece_pairs(i, contacts, looked_at);
    std::vector<Vec3>& forces = piece_forces_[i / block % load_slots];
    forces.clear();
    for (const Contact& contact : contacts) forces.push_back(press(i, piece_pairs_[i][contact.pair], contact, loads));
    if (options_.sleep) watch_sleeping_neighbours(i, contacts, forces);
}

// Between walls that enclose a convex space, the ends of the capsules are nearest to each wall.
void CapsuleDem::State::find_wall_contacts(std::size_t i, std::vector<WallContactPoint>& found) const {
    const BodyState& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const std::size_t walls = wall_count(), planes = vessel_walls_.planes.size();
    found.clear();
    const auto for_nodes = [&](const auto& visit) {
        const Eigen::Matrix3d turn = body.q.toRotationMatrix();
        for (std::size_t node = 0; node < kind.nodes.size(); ++node)
            visit(node, kind.nodes[node].radius, Vec3(body.x + turn * kind.nodes[node].place));
    };
    const auto add = [&](std::size_t history, const Vec3& place, double radius, const Vec3& outward, double overlap) {
        found.push_back({history, place + (radius - overlap) * outward, outward, overlap, 1.0, overlap * overlap});
    };
    const auto add_plane = [&](std::size_t w, const VesselWalls::Plane& plane) {
        if (plane.distance(body.x) > kind.radius) return;
        for_nodes([&](std::size_t node, double radius, const Vec3& place) {
            const double overlap = radius - plane.distance(place);
            if (overlap > 0.0) add(node * walls + w, place, radius, -plane.normal, overlap);
        });
    };
    for (std::size_t w = 0; w < planes; ++w) add_plane(w, vessel_walls_.planes[w]);
    for (std::size_t w = 0; w < vessel_walls_.round.size(); ++w) {
        const auto& wall = vessel_walls_.round[w];
        if (!(wall.overlap(body.x, kind.radius) > 0.0)) continue;
        if (wall.inside)
            find_arm_wall_contacts(i, w, found);
        else
            for_nodes([&](std::size_t node, double radius, const Vec3& place) {
                const double overlap = wall.overlap(place, radius);
                if (overlap > 0.0) add(node * walls + planes + w, place, radius, -wall.normal(place), overlap);
            });
    }
    if (lid_) add_plane(lid_wall(), lid_plane());
    if (has_faces(body) || vessel_walls_.mesh != nullptr) find_piece_wall_contacts(i, found);
}

// Capsules lie around such a wall. Those that meet at one place of it share the stiffness of a single contact.
void CapsuleDem::State::find_arm_wall_contacts(std::size_t i, std::size_t w, std::vector<WallContactPoint>& found) const {
    const BodyState& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const auto& wall = vessel_walls_.round[w];
    const double far = container_.size().norm();
    const Segment axis{Vec3(0.0, 0.0, body.x.z() - far), Vec3(0.0, 0.0, 2.0 * far)};
    const std::size_t first = found.size(),
                      before = (kind.nodes.size() + kind.pieces.size()) * wall_count() + vessel_walls_.planes.size() + w;
    for (std::size_t a = 0; a < kind.arms.size(); ++a) {
        const WorldArm& arm = arms_[body.first_arm + a];
        const double radius = kind.arms[a].radius;
        const Segment segment{arm.start, arm.along};
        const ClosestPoints closest = closest_points(segment, axis);
        const double overlap = wall.radius_m + radius - closest.distance;
        if (!(overlap > 0.0)) continue;
        const Vec3 place = pressed_point(segment, axis, closest, overlap), outward = -wall.normal(place);
        found.push_back({before + a * wall_count(), place + (radius - overlap) * outward, outward, overlap, 1.0, 0.0});
    }
    for (std::size_t n = first; n < found.size(); ++n) {
        double together = 0.0;
        for (std::size_t m = first; m < found.size(); ++m) together += nearness(found[m].at, found[n].at, 0.25 * kind.diameter);
        found[n].share = 1.0 / together;
        found[n].square = found[n].share * found[n].overlap * found[n].overlap;
    }
}

void CapsuleDem::State::wall_forces(std::size_t i, std::vector<Load>& loads, WallLoads& sums) {
    const BodyState& body = bodies_[i];
    const double own_mass = kinds_[body.kind].body.mass_kg;
    thread_local std::vector<WallContactPoint> found;
    find_wall_contacts(i, found);
    for (const WallContactPoint& touch : found) {
        const Vec3 lever = touch.at - body.x;
        WallContact& contact = wall_contact(i, touch);
        Vec3 velocity = body.v_contact + body.omega.cross(lever);
        const std::size_t wall = touch.history % wall_count();
        double mass = own_mass;
        if (wall == lid_wall()) {
            velocity.z() -= lid_->velocity_m_per_s;
            if (lid_->mass_kg > 0.0) mass = own_mass * lid_->mass_kg / (own_mass + lid_->mass_kg);
        }
        const Vec3 force = contact_force({.normal = touch.outward,
                                          .overlap = touch.overlap,
                                          .velocity = velocity,
                                          .mass = mass,
                                          .friction = law_.wall_friction,
                                          .share = touch.share},
                                         contact.tangential_displacement, is_new(contact.last_contact, body, body));
        contact.last_contact = steps_;
        (wall == lid_wall() ? sums.lid_N : wall == 0 && has_floor_ ? sums.floor_N : sums.sides_N) += force.z();
        loads[i].force -= force;
        loads[i].torque -= lever.cross(force);
        if (touch.twist != 0.0) loads[i].torque -= elastic_force(touch.overlap, touch.share) * touch.twist * touch.outward;
    }
}

// `displacement_time` is the time over which tangential displacements grow: a step, or 0 where the forces of a changed state are computed
// again.
void CapsuleDem::State::forces(double displacement_time) {
    displacement_time_ = displacement_time;
    const std::size_t n = bodies_.size();
    std::array<std::size_t, load_slots> looked_at{};
#pragma omp parallel for schedule(dynamic, 1) if (threads_.parallel())
    for (std::size_t slot = 0; slot < load_slots; ++slot) {
        auto& loads = loads_[slot];
        std::vector<Contact> contacts;
        loads.assign(n, {Vec3::Zero(), Vec3::Zero()});
        wall_sums_[slot] = {};
        virial_[slot] = 0.0;
        for (std::size_t first = slot * block; first < n; first += load_slots * block)
            for (std::size_t i = first; i < std::min(n, first + block); ++i) {
                grain_forces(i, loads, looked_at[slot], contacts);
                if (bodies_[i].asleep == 0) wall_forces(i, loads, wall_sums_[slot]);
            }
    }
    looked_at_ = 0;
    for (const std::size_t count : looked_at) looked_at_ += count;
    if (lid_) lid_->force_N = wall_loads().lid_N;
}

WallLoads CapsuleDem::State::wall_loads() const {
    WallLoads sum;
    for (const WallLoads& one : wall_sums_) {
        sum.floor_N += one.floor_N;
        sum.sides_N += one.sides_N;
        sum.lid_N += one.lid_N;
    }
    return sum;
}

double CapsuleDem::State::pressure() const {
    double sum = 0.0;
    for (const double one : virial_) sum += one;
    return sum / (3.0 * container_.size().prod());
}

}  // namespace porepack::pouring::dem
