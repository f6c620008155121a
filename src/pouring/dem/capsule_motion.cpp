// Time integration of the grains, and their sleep.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/log.hpp"
#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr std::int32_t quiet_steps = 50;

Eigen::Vector4d turn_rate(const Vec3& omega, const Quaternion& q) {
    return 0.5 * (Quaternion(0.0, omega.x(), omega.y(), omega.z()) * q).coeffs();
}

Quaternion unit(const Eigen::Vector4d& coefficients) {
    return Quaternion(coefficients).normalized();
}

}  // namespace

// One step of position and orientation, and (Verlet) half a step of velocity.
void CapsuleDem::State::advance(BodyState& body) {
    const double dt = options_.time_step_s;
    const Kind& kind = kinds_[body.kind];
    const Vec3 acceleration = body.force / kind.body.mass_kg + options_.gravity_m_per_s2;
    const Vec3 from = body.x;
    const bool multistep = options_.integrator == Integrator::adams_bashforth;
    const Vec3 omega = omega_of(body, body.q, body.momentum);
    Derivative now;
    if (multistep) now = {body.v, acceleration, body.torque, turn_rate(omega, body.q)};
    if (multistep && body.fresh == 0) {
        const auto mean = [&](const auto& here, const auto& before, const auto& before_that) {
            return ((dt / 12.0) * (23.0 * here - 16.0 * before + 5.0 * before_that)).eval();
        };
        const Derivative &b = body.before, &c = body.before_that;
        body.x += mean(now.v, b.v, c.v);
        body.v += mean(now.a, b.a, c.a);
        body.momentum += mean(now.torque, b.torque, c.torque);
        body.q = unit(body.q.coeffs() + mean(now.turn, b.turn, c.turn));
        body.v_contact = body.v;
        body.omega = omega_of(body, body.q, body.momentum);
    } else {
        body.v += 0.5 * dt * acceleration;
        body.x += dt * body.v;
        body.v_contact = body.v + 0.5 * dt * acceleration;
        body.momentum += 0.5 * dt * body.torque;
        // Richardson extrapolation from a whole step and two half steps, because the angular velocity rotates with the body.
        const Eigen::Vector4d rate = turn_rate(omega_of(body, body.q, body.momentum), body.q);
        const Quaternion whole = unit(body.q.coeffs() + dt * rate), half = unit(body.q.coeffs() + 0.5 * dt * rate);
        const Quaternion second = unit(half.coeffs() + 0.5 * dt * turn_rate(omega_of(body, half, body.momentum), half));
        body.q = unit(2.0 * second.coeffs() - whole.coeffs());
        body.omega = omega_of(body, body.q, body.momentum + 0.5 * dt * body.torque);
    }
    if (multistep) {
        body.before_that = body.before;
        body.before = now;
    }
    body.travelled += (body.x - from).norm() + 1.01 * dt * std::max(omega.norm(), body.omega.norm()) * kind.radius;
}

// Adds the loads of all slots, in their order.
void CapsuleDem::State::gather(BodyState& body, std::size_t i) const {
    body.force = loads_[0][i].force;
    body.torque = loads_[0][i].torque;
    for (std::size_t slot = 1; slot < load_slots; ++slot) {
        body.force += loads_[slot][i].force;
        body.torque += loads_[slot][i].torque;
    }
}

// The remaining part of the step, when the forces at its end are known.
void CapsuleDem::State::finish(BodyState& body) {
    const double dt = options_.time_step_s;
    const Kind& kind = kinds_[body.kind];
    if (options_.integrator == Integrator::verlet || body.fresh > 0) {
        body.v += 0.5 * dt * (body.force / kind.body.mass_kg + options_.gravity_m_per_s2);
        body.momentum += 0.5 * dt * body.torque;
        if (body.fresh > 0) --body.fresh;
    }
    if (!options_.sleep) return;
    const double g = options_.gravity_m_per_s2.norm();
    const double energy = 0.5 * body.v.squaredNorm() + 0.5 * body.momentum.dot(body.omega) / kind.body.mass_kg;
    const Vec3 net = body.force / kind.body.mass_kg + options_.gravity_m_per_s2;
    const bool quiet = energy < 1e-3 * g * kind.diameter && net.norm() < 0.3 * g;
    body.quiet = quiet ? body.quiet + 1 : 0;
}

void CapsuleDem::State::fall_asleep_or_wake() {
    for (auto& list : woken_) {
        for (const std::uint32_t i : list) {
            BodyState& body = bodies_[i];
            if (body.asleep == 0) continue;
            body.asleep = 0;
            body.woke_at = steps_;
            body.quiet = 0;
            body.fresh = 2;
            // Its contacts with other sleeping bodies were not checked in this step: it starts from equilibrium.
            body.force = -kinds_[body.kind].body.mass_kg * options_.gravity_m_per_s2;
            body.torque.setZero();
        }
        list.clear();
    }
    sleepers_ = 0;
    for (BodyState& body : bodies_) {
        if (body.asleep == 0 && body.quiet >= quiet_steps) {
            body.asleep = 1;
            body.slept_at = steps_;
            body.v = body.v_contact = body.momentum = body.omega = Vec3::Zero();
        }
        sleepers_ += body.asleep;
    }
}

void CapsuleDem::State::wake_all() {
    if (sleeping() == 0) return;  // the forces stay valid: a resumed run has the same bits
    for (std::size_t i = 0; i < bodies_.size(); ++i) woken_[0].push_back(static_cast<std::uint32_t>(i));
    fall_asleep_or_wake();
    primed_ = false;
}

void CapsuleDem::State::set_sleep(bool sleep) {
    if (sleep && !options_.sleep)
        for (BodyState& body : bodies_) body.quiet = 0;
    options_.sleep = sleep;
    if (!sleep) wake_all();
}

void CapsuleDem::State::hold(std::size_t body) {
    bodies_[body].held = 1;
    bodies_[body].v = bodies_[body].v_contact = bodies_[body].momentum = bodies_[body].omega = Vec3::Zero();
}

void CapsuleDem::State::push(const Vec3& velocity_m_per_s) {
    wake_all();
    for (BodyState& body : bodies_) {
        if (body.held != 0) continue;
        body.v += velocity_m_per_s;
        body.v_contact = body.v;
        body.fresh = 3;
    }
    if (lid_ && lid_->mass_kg > 0.0) lid_->velocity_m_per_s += velocity_m_per_s.z();
}

void CapsuleDem::State::set_lid(const std::optional<Lid>& lid) {
    lid_ = lid;
    primed_ = false;
}

// Velocity Verlet, as of the grains.
void CapsuleDem::State::move_lid(bool first_half) {
    const double dt = options_.time_step_s;
    if (lid_->mass_kg > 0.0) lid_->velocity_m_per_s += 0.5 * dt * (lid_->force_N / lid_->mass_kg + options_.gravity_m_per_s2.z());
    if (first_half) lid_->height_m += dt * lid_->velocity_m_per_s;
}

// Two grains in contact, or nearly so, are as far apart as a cell is wide at most: so much their distance changes.
void CapsuleDem::State::resize(const Vec3& size_m) {
    const Vec3 ratio = size_m.cwiseQuotient(container_.size());
    const double change = (ratio - Vec3::Ones()).cwiseAbs().maxCoeff();
    container_ = container_.resized(size_m);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        bodies_[i].x = bodies_[i].x.cwiseProduct(ratio);
        bodies_[i].travelled += 0.51 * change * cell_size_;
        place_arms(i);
    }
    for (int axis = 0; axis < 3; ++axis)
        if (size_m[axis] < cell_size_ * static_cast<double>(cell_count_[static_cast<std::size_t>(axis)])) {
            make_cells();
            sort_into_cells();
            break;
        }
}

void CapsuleDem::State::stop() {
    for (BodyState& body : bodies_) body.v = body.v_contact = body.momentum = body.omega = Vec3::Zero();
}

void CapsuleDem::State::step(long steps) {
    const std::size_t n = bodies_.size();
    for (long s = 0; s < steps; ++s) {
        if (!primed_) {
            search();
            forces(0.0);
            for (std::size_t i = 0; i < n; ++i)
                if (bodies_[i].moves()) gather(bodies_[i], i);
            primed_ = true;
        }
        const core::Stopwatch watch;
        ++steps_;
        time_ += options_.time_step_s;
        if (lid_) move_lid(true);
#pragma omp parallel for schedule(static, block) if (threads_.parallel())
        for (std::size_t i = 0; i < n; ++i)
            if (bodies_[i].moves()) {
                advance(bodies_[i]);
                place_arms(i);
            }
        search();
        forces(options_.time_step_s);
        if (faced_) require_no_crossing();
        if (lid_) move_lid(false);
#pragma omp parallel for schedule(static, block) if (threads_.parallel())
        for (std::size_t i = 0; i < n; ++i)
            if (bodies_[i].moves()) {
                gather(bodies_[i], i);
                finish(bodies_[i]);
            }
        if (options_.sleep) fall_asleep_or_wake();
        threads_.add(watch.seconds());
    }
}

}  // namespace porepack::pouring::dem
