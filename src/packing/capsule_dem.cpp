#include "packing/capsule_dem.hpp"

#include <fmt/format.h>

#include <set>

#include "core/error.hpp"

namespace porepack {

CapsuleDem::CapsuleDem(const Container& container, const std::vector<Shape>& shapes, double density_kg_per_m3, const ContactLaw& law,
                       const DemOptions& options)
    : container_(container), shapes_(shapes), law_(law), options_(options), loads_(lanes) {
    double widest = 0.0, finest = 1e300;
    for (const Shape& shape : shapes) {
        Kind kind{.body = grain_body(shape, density_kg_per_m3), .arms = {}, .nodes = {}};
        kind.diameter = smallest_diameter(shape);
        const Vec3& inertia = kind.body.inertia_kg_m2;
        kind.isotropic = inertia.maxCoeff() - inertia.minCoeff() < 1e-6 * inertia.maxCoeff();
        if (kind.isotropic) kind.body.inertia_kg_m2.setConstant(inertia.mean());
        for (const Capsule& capsule : shape.capsules) {
            const Vec3 a = kind.body.turn.conjugate() * (capsule.a - kind.body.centre_m),
                       b = kind.body.turn.conjugate() * (capsule.b - kind.body.centre_m);
            kind.arms.push_back({.start = a, .along = b - a, .radius = capsule.radius});
            kind.radius = std::max(kind.radius, std::max(a.norm(), b.norm()) + capsule.radius);
        }
        for (std::size_t i = 0; i < kind.arms.size(); ++i)
            for (const std::size_t end : {0U, 1U}) {
                const Arm& arm = kind.arms[i];
                const Vec3 place = arm.start + static_cast<double>(end) * arm.along;
                bool inside = false;
                for (std::size_t j = 0; j < kind.arms.size(); ++j) {
                    const Arm& other = kind.arms[j];
                    const double length = other.along.norm(), slack = 1e-6 * kind.diameter;
                    if (i == j || !(length > 0.0)) continue;
                    const double t = (place - other.start).dot(other.along) / length;
                    const bool on_axis = (place - other.start - t / length * other.along).norm() < slack;
                    inside = inside || (on_axis && t > slack && t < length - slack);
                }
                const auto same = [&](const Node& node) { return (node.place - place).norm() < 1e-6 * kind.diameter; };
                if (!inside && std::none_of(kind.nodes.begin(), kind.nodes.end(), same)) kind.nodes.push_back({place, arm.radius});
            }
        widest = std::max(widest, kind.radius);
        finest = std::min(finest, kind.diameter);
        kinds_.push_back(std::move(kind));
    }
    skin_ = options.skin_m > 0.0 ? options.skin_m : 0.25 * finest;
    cell_size_ = 2.0 * widest + 2.0 * skin_;
    const Vec3 low = container.low(), high = container.high();
    cell_low_ = low;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double extent = high[axis] - low[axis];
        if (container.periodic[a] && extent < 4.0 * widest + 2.0 * skin_)
            throw UserError(
                fmt::format("the periodic box is {:g} m wide along axis {}, too narrow for grains of radius {:g} m", extent, axis, widest),
                {.allowed = fmt::format("{:g} m or more, so that no grain meets another one twice", 4.0 * widest + 2.0 * skin_)});
        cell_count_[a] = std::clamp(static_cast<long>(extent / cell_size_), 1L, 400L);
    }
    cells_.resize(static_cast<std::size_t>(cell_count_[0] * cell_count_[1] * cell_count_[2]));
    if (!container.periodic[2]) planes_.push_back({Vec3::UnitZ(), 0.0});
    if (container.kind == Container::Kind::cylinder) {
        cylinder_radius_ = container.diameter_m / 2.0;
    } else {
        for (int axis = 0; axis < 2; ++axis) {
            if (container.periodic[static_cast<std::size_t>(axis)]) continue;
            planes_.push_back({Vec3::Unit(axis), 0.0});
            planes_.push_back({-Vec3::Unit(axis), -container.size_m[axis]});
        }
    }
}

void CapsuleDem::add(std::size_t shape, const Vec3& position_m, const Quaternion& orientation, const Vec3& velocity,
                     const Vec3& angular_velocity) {
    const Kind& kind = kinds_[shape];
    Moving body;
    body.kind = static_cast<std::uint32_t>(shape);
    body.q = (orientation * kind.body.turn).normalized();
    body.x = position_m + orientation * kind.body.centre_m;
    body.v = body.v_contact = velocity;
    body.omega = angular_velocity;
    body.momentum = body.q * (kind.body.inertia_kg_m2.cwiseProduct(body.q.conjugate() * angular_velocity));
    body.force = Vec3::Zero();
    body.first_arm = static_cast<std::uint32_t>(arms_.size());
    body.first_wall = static_cast<std::uint32_t>(walls_.size());
    arms_.resize(arms_.size() + kind.arms.size());
    walls_.resize(walls_.size() + kind.nodes.size() * (planes_.size() + 1));
    bodies_.push_back(body);
    pairs_.emplace_back();
    cell_of_body_.push_back(-1);
    place_arms(body);
    primed_ = false;
}

Vec3 CapsuleDem::omega_of(const Moving& body, const Quaternion& q, const Vec3& momentum) const {
    const Kind& kind = kinds_[body.kind];
    if (kind.isotropic) return momentum / kind.body.inertia_kg_m2.x();
    return q * (q.conjugate() * momentum).cwiseQuotient(kind.body.inertia_kg_m2);
}

Vec3 CapsuleDem::angular_velocity(std::size_t body) const {
    return omega_of(bodies_[body], bodies_[body].q, bodies_[body].momentum);
}

Body CapsuleDem::pose(std::size_t body) const {
    const Moving& moving = bodies_[body];
    const GrainBody& grain = kinds_[moving.kind].body;
    Body pose{.shape = moving.kind};
    pose.orientation = (moving.q * grain.turn.conjugate()).normalized();
    pose.position_m = moving.x - pose.orientation * grain.centre_m;
    for (int axis = 0; axis < 3; ++axis)
        if (container_.periodic[static_cast<std::size_t>(axis)])
            pose.position_m[axis] -= container_.size_m[axis] * std::floor(pose.position_m[axis] / container_.size_m[axis]);
    return pose;
}

Packing CapsuleDem::packing() const {
    Packing packing{.container = container_, .shapes = shapes_, .bodies = {}};
    for (std::size_t i = 0; i < bodies_.size(); ++i) packing.bodies.push_back(pose(i));
    return packing;
}

Vec3 CapsuleDem::image_shift(const Vec3& between) const {
    Vec3 shift = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis)
        if (container_.periodic[static_cast<std::size_t>(axis)])
            shift[axis] = -container_.size_m[axis] * std::round(between[axis] / container_.size_m[axis]);
    return shift;
}

void CapsuleDem::place_arms(const Moving& body) {
    const Eigen::Matrix3d turn = body.q.toRotationMatrix();
    const Kind& kind = kinds_[body.kind];
    for (std::size_t a = 0; a < kind.arms.size(); ++a)
        arms_[body.first_arm + a] = {body.x + turn * kind.arms[a].start, turn * kind.arms[a].along};
}

std::size_t CapsuleDem::sleeping() const {
    return static_cast<std::size_t>(std::count_if(bodies_.begin(), bodies_.end(), [](const Moving& body) { return body.asleep != 0; }));
}

std::size_t CapsuleDem::watched_pairs() const {
    std::size_t count = 0;
    for (const auto& list : pairs_) count += list.size();
    return count;
}

// visit(first body, pair, touch) for every contact of grains.
template <typename Visit>
void CapsuleDem::for_contacts(const Visit& visit) const {
    std::vector<Touch> touches;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        find_touches(i, touches);
        for (const Touch& touch : touches) visit(i, pairs_[i][touch.pair], touch);
    }
}

DemEnergy CapsuleDem::energy() const {
    DemEnergy energy;
    const double kn = 0.5 * law_.normal_stiffness_N_per_m, kt = 0.5 * law_.tangential_stiffness_N_per_m;
    const std::size_t walls = planes_.size() + 1;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Moving& body = bodies_[i];
        const Kind& kind = kinds_[body.kind];
        energy.kinetic_J += 0.5 * kind.body.mass_kg * body.v.squaredNorm();
        energy.rotational_J += 0.5 * body.momentum.dot(omega_of(body, body.q, body.momentum));
        energy.potential_J -= kind.body.mass_kg * options_.gravity_m_per_s2.dot(body.x);
        for (std::size_t node = 0; node < kind.nodes.size(); ++node) {
            const Vec3 place = body.x + body.q * kind.nodes[node].place;
            for (std::size_t w = 0; w < walls; ++w) {
                const double overlap = w < planes_.size()       ? kind.nodes[node].radius - planes_[w].normal.dot(place) + planes_[w].offset
                                       : cylinder_radius_ > 0.0 ? place.head<2>().norm() + kind.nodes[node].radius - cylinder_radius_
                                                                : 0.0;
                if (overlap > 0.0)
                    energy.elastic_J +=
                        0.5 * kn * overlap * overlap + 0.5 * kt * walls_[body.first_wall + node * walls + w].spring.squaredNorm();
            }
        }
    }
    for_contacts([&](std::size_t, const Pair& pair, const Touch& touch) {
        energy.elastic_J += 0.5 * touch.share * (kn * touch.overlap * touch.overlap + kt * pair.spring.squaredNorm());
    });
    return energy;
}

DemRest CapsuleDem::rest() const {
    DemRest rest;
    const bool spheres = std::all_of(kinds_.begin(), kinds_.end(), [](const Kind& kind) { return kind.nodes.size() == 1; });
    const double g = options_.gravity_m_per_s2.norm();
    for (const Moving& body : bodies_) {
        const Kind& kind = kinds_[body.kind];
        // A sphere may spin in place for ever, which moves nothing.
        const double rotation = spheres ? 0.0 : 0.5 * body.momentum.dot(omega_of(body, body.q, body.momentum));
        rest.kinetic_energy_per_grain_J += 0.5 * kind.body.mass_kg * body.v.squaredNorm() + rotation;
        const double net = g > 0.0 ? (body.force / kind.body.mass_kg + options_.gravity_m_per_s2).norm() / g : 0.0;
        rest.largest_force_over_weight = std::max(rest.largest_force_over_weight, net);
        rest.mean_force_over_weight += net;
        if (body.v.norm() < 0.05)
            for (std::size_t a = 0; a < kind.arms.size(); ++a) {
                const WorldArm& arm = arms_[body.first_arm + a];
                rest.top_m = std::max(rest.top_m, std::max(arm.start.z(), arm.start.z() + arm.along.z()) + kind.arms[a].radius);
            }
    }
    std::set<std::pair<std::size_t, std::size_t>> touching;
    long contacts = 0;
    for_contacts([&](std::size_t i, const Pair& pair, const Touch& touch) {
        touching.insert({i, pair.other});
        ++contacts;
        rest.mean_overlap_m += touch.overlap;
        rest.largest_overlap_m = std::max(rest.largest_overlap_m, touch.overlap);
    });
    const auto n = static_cast<double>(std::max<std::size_t>(1, bodies_.size()));
    rest.kinetic_energy_per_grain_J /= n;
    rest.mean_force_over_weight /= n;
    rest.coordination_number = 2.0 * static_cast<double>(touching.size()) / n;
    rest.mean_overlap_m /= static_cast<double>(std::max(1L, contacts));
    return rest;
}

}  // namespace porepack
