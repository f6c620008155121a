// Energy, and the quantities that define rest.
#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

// Calls visit(first body, pair, contact) for every contact between grains.
template <typename Visit>
void CapsuleDem::State::for_contacts(const Visit& visit) const {
    std::vector<Contact> contacts;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        find_contacts(i, contacts);
        for (const Contact& contact : contacts) visit(i, verlet_lists_[i][contact.pair], contact);
        if (!faced_) continue;
        find_piece_contacts(i, contacts);
        for (const Contact& contact : contacts) visit(i, piece_pairs_[i][contact.pair], contact);
    }
}

// Returns `elastic_J` plus the energy of a body's contacts with walls.
double CapsuleDem::State::wall_energy(std::size_t index, double elastic_J) const {
    const BodyState& body = bodies_[index];
    const double kn = 0.5 * law_.normal_stiffness_N_per_m, kt = 0.5 * law_.tangential_stiffness_N_per_m;
    std::vector<WallContactPoint> found;
    find_wall_contacts(index, found);
    for (const WallContactPoint& touch : found)
        elastic_J +=
            0.5 * (kn * touch.square + kt * touch.share * walls_[body.first_wall + touch.history].tangential_displacement.squaredNorm());
    return elastic_J;
}

DemEnergy CapsuleDem::State::energy() const {
    DemEnergy energy;
    const double kn = 0.5 * law_.normal_stiffness_N_per_m, kt = 0.5 * law_.tangential_stiffness_N_per_m;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const BodyState& body = bodies_[i];
        const Kind& kind = kinds_[body.kind];
        energy.kinetic_J += 0.5 * kind.body.mass_kg * body.v.squaredNorm();
        energy.rotational_J += 0.5 * body.momentum.dot(omega_of(body, body.q, body.momentum));
        energy.potential_J -= kind.body.mass_kg * options_.gravity_m_per_s2.dot(body.x);
        energy.elastic_J = wall_energy(i, energy.elastic_J);
    }
    if (lid_) {
        energy.kinetic_J += 0.5 * lid_->mass_kg * lid_->velocity_m_per_s * lid_->velocity_m_per_s;
        energy.potential_J -= lid_->mass_kg * options_.gravity_m_per_s2.z() * lid_->height_m;
    }
    for_contacts([&](std::size_t, const auto& pair, const Contact& contact) {
        energy.elastic_J += 0.5 * (kn * contact.square + kt * contact.share * pair.tangential_displacement.squaredNorm());
    });
    return energy;
}

namespace {

// Grains that fewer than four others touch are removed, until none is left.
void remove_rattlers(const std::set<std::pair<std::size_t, std::size_t>>& touching, std::size_t grains, DemRest& rest) {
    std::vector<std::vector<std::size_t>> others(grains);
    for (const auto& [i, j] : touching) {
        others[i].push_back(j);
        others[j].push_back(i);
    }
    std::vector<std::size_t> count(grains), loose;
    std::vector<bool> removed(grains, false);
    const auto check = [&](std::size_t i) {
        if (removed[i] || count[i] >= 4) return;
        removed[i] = true;
        loose.push_back(i);
    };
    for (std::size_t i = 0; i < grains; ++i) count[i] = others[i].size();
    for (std::size_t i = 0; i < grains; ++i) check(i);
    while (!loose.empty()) {
        const std::size_t i = loose.back();
        loose.pop_back();
        for (const std::size_t j : others[i]) {
            --count[j];
            check(j);
        }
    }
    std::size_t neighbours = 0;
    for (std::size_t i = 0; i < grains; ++i) removed[i] ? static_cast<void>(++rest.rattlers) : static_cast<void>(neighbours += count[i]);
    const auto left = static_cast<double>(grains) - static_cast<double>(rest.rattlers);
    rest.coordination_without_rattlers = left > 0.0 ? static_cast<double>(neighbours) / left : 0.0;
}

}  // namespace

DemRest CapsuleDem::State::rest() const {
    DemRest rest;
    const bool spheres = !faced_ && std::all_of(kinds_.begin(), kinds_.end(), [](const Kind& kind) { return kind.nodes.size() == 1; });
    const double g = options_.gravity_m_per_s2.norm();
    std::size_t free = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const BodyState& body = bodies_[i];
        if (body.held != 0) continue;
        ++free;
        const Kind& kind = kinds_[body.kind];
        // A sphere may spin in place without end and move no other grain.
        const double rotation = spheres ? 0.0 : 0.5 * body.momentum.dot(omega_of(body, body.q, body.momentum));
        const double translation = 0.5 * kind.body.mass_kg * body.v.squaredNorm();
        rest.translation_energy_per_grain_J += translation;
        rest.kinetic_energy_per_grain_J += translation + rotation;
        const double acceleration = (body.force / kind.body.mass_kg + options_.gravity_m_per_s2).norm(),
                     net = g > 0.0 ? acceleration / g : 0.0;
        rest.mean_net_force_N += kind.body.mass_kg * acceleration;
        rest.largest_force_over_weight = std::max(rest.largest_force_over_weight, net);
        rest.mean_force_over_weight += net;
        if (body.v.norm() < 0.05) {
            if (has_faces(body)) {
                const Frame& frame = frames_[i];
                const double above = shapes_[body.kind].body->support(frame.turn.transpose() * Vec3::UnitZ());
                rest.top_m = std::max(rest.top_m, frame.origin.z() + above);
            }
            for (std::size_t a = 0; a < kind.arms.size(); ++a) {
                const WorldArm& arm = arms_[body.first_arm + a];
                rest.top_m = std::max(rest.top_m, std::max(arm.start.z(), arm.start.z() + arm.along.z()) + kind.arms[a].radius);
            }
        }
    }
    std::set<std::pair<std::size_t, std::size_t>> touching;
    long contacts = 0;
    std::size_t neighbours = 0;
    for_contacts([&](std::size_t i, const auto& pair, const Contact& contact) {
        if (touching.insert({i, pair.other}).second)
            neighbours += static_cast<std::size_t>(bodies_[i].held == 0) + static_cast<std::size_t>(bodies_[pair.other].held == 0);
        ++contacts;
        rest.mean_overlap_m += contact.overlap;
        rest.largest_overlap_m = std::max(rest.largest_overlap_m, contact.overlap);
    });
    remove_rattlers(touching, bodies_.size(), rest);
    const auto n = static_cast<double>(std::max<std::size_t>(1, free));
    rest.kinetic_energy_per_grain_J /= n;
    rest.translation_energy_per_grain_J /= n;
    rest.mean_force_over_weight /= n;
    rest.mean_net_force_N /= n;
    rest.coordination_number = static_cast<double>(neighbours) / n;
    rest.mean_overlap_m /= static_cast<double>(std::max(1L, contacts));
    return rest;
}

}  // namespace porepack::pouring::dem
