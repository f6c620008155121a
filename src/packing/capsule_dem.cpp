#include "packing/capsule_dem.hpp"

#include <fmt/format.h>

#include <istream>
#include <ostream>
#include <set>

#include "core/error.hpp"

namespace porepack {
namespace {

// Bodies are dealt to lanes in blocks; each lane adds up its own loads, and the lanes are added in their order: so the sums do not
// depend on the number of threads.
constexpr std::size_t lanes = 4, block = 16;
constexpr std::int32_t quiet_steps = 50;

Eigen::Vector4d turn_rate(const Vec3& omega, const Quaternion& q) {
    return 0.5 * (Quaternion(0.0, omega.x(), omega.y(), omega.z()) * q).coeffs();
}

Quaternion unit(const Eigen::Vector4d& coefficients) {
    return Quaternion(coefficients).normalized();
}

template <typename Value>
void put(std::ostream& out, const Value& value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename Value>
void get(std::istream& in, Value& value) {
    in.read(reinterpret_cast<char*>(&value), sizeof value);
}

}  // namespace

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

// One step of position and orientation, and (Verlet) half a step of velocity.
void CapsuleDem::advance(Moving& body) {
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
        // From a whole step and two half steps (Richardson), as the angular velocity turns with the body.
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
    place_arms(body);
}

// The rest of the step, once the forces at its end are known.
void CapsuleDem::finish(Moving& body) {
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

long CapsuleDem::cell_of(const Vec3& place) const {
    std::array<long, 3> at{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        double x = place[axis] - cell_low_[axis];
        const double extent = container_.periodic[a] ? container_.size_m[axis] : 0.0;
        if (extent > 0.0) x -= extent * std::floor(x / extent);
        const double width = extent > 0.0 ? extent / static_cast<double>(cell_count_[a]) : cell_size_;
        at[a] = std::clamp(static_cast<long>(std::clamp(x / width, 0.0, 1e6)), 0L, cell_count_[a] - 1);
    }
    return at[0] + cell_count_[0] * (at[1] + cell_count_[1] * at[2]);
}

// Neighbours of those bodies that may have come near new ones.
void CapsuleDem::search() {
    for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (bodies_[i].travelled - bodies_[i].searched_at > 0.5 * skin_) search_one(i);
}

void CapsuleDem::search_one(std::size_t i) {
    Moving& body = bodies_[i];
    const long cell = cell_of(body.x);
    if (cell != cell_of_body_[i]) {
        if (cell_of_body_[i] >= 0) std::erase(cells_[static_cast<std::size_t>(cell_of_body_[i])], static_cast<std::uint32_t>(i));
        cells_[static_cast<std::size_t>(cell)].push_back(static_cast<std::uint32_t>(i));
        cell_of_body_[i] = cell;
    }
    body.searched_at = body.travelled;
    const Kind& kind = kinds_[body.kind];
    const std::array<long, 3> at = {cell % cell_count_[0], cell / cell_count_[0] % cell_count_[1],
                                    cell / (cell_count_[0] * cell_count_[1])};
    std::array<std::set<long>, 3> around;  // a narrow periodic box has fewer than three cells
    for (std::size_t a = 0; a < 3; ++a)
        for (const long step : {-1L, 0L, 1L}) {
            long c = at[a] + step;
            if (container_.periodic[a]) c = (c + cell_count_[a]) % cell_count_[a];
            if (c >= 0 && c < cell_count_[a]) around[a].insert(c);
        }
    for (const long z : around[2])
        for (const long y : around[1])
            for (const long x : around[0])
                for (const std::uint32_t other : cells_[static_cast<std::size_t>(x + cell_count_[0] * (y + cell_count_[1] * z))]) {
                    if (other == i) continue;
                    const Moving& neighbour = bodies_[other];
                    const Kind& other_kind = kinds_[neighbour.kind];
                    const Vec3 shift = image_shift(neighbour.x - body.x);
                    const double reach = kind.radius + other_kind.radius + skin_;
                    if ((neighbour.x + shift - body.x).squaredNorm() > reach * reach) continue;
                    const std::size_t owner = std::min<std::size_t>(i, other), second = std::max<std::size_t>(i, other);
                    auto& list = pairs_[owner];
                    for (std::size_t p = 0; p < kind.arms.size(); ++p)
                        for (std::size_t q = 0; q < other_kind.arms.size(); ++q) {
                            const WorldArm &one = arms_[body.first_arm + p], &two = arms_[neighbour.first_arm + q];
                            const Vec3 between = two.start + 0.5 * two.along + shift - one.start - 0.5 * one.along;
                            const double radii = kind.arms[p].radius + other_kind.arms[q].radius;
                            const double far = 0.5 * (one.along.norm() + two.along.norm()) + radii + skin_;
                            if (between.squaredNorm() > far * far) continue;
                            const double gap = closest_points({one.start, one.along}, {two.start + shift, two.along}).distance - radii;
                            if (gap > skin_) continue;
                            const auto arm = static_cast<std::uint16_t>(owner == i ? p : q),
                                       other_arm = static_cast<std::uint16_t>(owner == i ? q : p);
                            const auto known = [&](const Pair& pair) {
                                return pair.other == second && pair.arm == arm && pair.other_arm == other_arm;
                            };
                            if (std::any_of(list.begin(), list.end(), known)) continue;
                            list.push_back({.other = static_cast<std::uint32_t>(second),
                                            .arm = arm,
                                            .other_arm = other_arm,
                                            .out_of_reach = body.travelled + neighbour.travelled + gap,
                                            .spring = Vec3::Zero(),
                                            .base_force = Vec3::Zero()});
                        }
                }
}

// The force on the second of two bodies; `normal` points to it, `velocity` is that of the first relative to it. The spring is kept in the
// tangent plane.
Vec3 CapsuleDem::contact(const Vec3& normal, double overlap, const Vec3& velocity, double mass, double friction, double share, Vec3& spring,
                         bool first) const {
    const double approach = velocity.dot(normal);
    const double elastic = share * 0.5 * law_.normal_stiffness_N_per_m * overlap;
    double force = elastic + share * law_.normal_damping * std::sqrt(2.0 * mass * law_.normal_stiffness_N_per_m) * approach;
    if (!law_.attraction) force = std::max(0.0, force);
    const double kt = share * 0.5 * law_.tangential_stiffness_N_per_m;
    const double ct = share * law_.tangential_damping * std::sqrt(2.0 * mass * law_.tangential_stiffness_N_per_m);
    const Vec3 sliding = velocity - approach * normal;
    if (first) {
        spring.setZero();
    } else {
        const double length = spring.norm();
        spring -= spring.dot(normal) * normal;
        const double now = spring.norm();
        if (now > 0.0) spring *= length / now;
    }
    spring += options_.time_step_s * sliding;
    // The spring alone, then spring and dashpot are cut to the friction's limit: a spring that the dashpot pulled would give back more than
    // was put in.
    const double most = friction * (law_.elastic_limit ? elastic : std::max(0.0, force));
    if (const double size = kt * spring.norm(); size > most) spring *= most / size;
    Vec3 tangential = kt * spring + ct * sliding;
    if (const double size = tangential.norm(); size > most) tangential *= most / size;
    return force * normal + tangential;
}

// The contact of one watched pair; false, and the gap, where there is none.
bool CapsuleDem::touch_of(std::size_t i, std::size_t n, Touch& touch, double& gap) const {
    const Pair& pair = pairs_[i][n];
    const Moving &body = bodies_[i], &other = bodies_[pair.other];
    const WorldArm &one = arms_[body.first_arm + pair.arm], &two = arms_[other.first_arm + pair.other_arm];
    const double r = kinds_[body.kind].arms[pair.arm].radius, other_r = kinds_[other.kind].arms[pair.other_arm].radius;
    touch.pair = n;
    touch.shift = image_shift(other.x - body.x);
    const Segment p{one.start, one.along}, q{two.start + touch.shift, two.along};
    const ClosestPoints closest = closest_points(p, q);
    gap = closest.distance - r - other_r;
    if (gap >= 0.0) return false;
    touch.overlap = -gap;
    touch.normal = closest.distance > 0.0 ? Vec3((closest.on_second - closest.on_first) / closest.distance)
                                          : (other.x + touch.shift - body.x).normalized();
    touch.at = pressed_point(p, q, closest, touch.overlap) + (r - 0.5 * touch.overlap) * touch.normal;
    touch.share = 1.0;
    return true;
}

// Contacts of the same two bodies at one place share the stiffness of one.
void CapsuleDem::share_places(const std::vector<Pair>& pairs, std::vector<Touch>& touches, double reach) {
    for (Touch& touch : touches) {
        double together = 0.0;
        for (const Touch& other : touches) {
            if (pairs[other.pair].other != pairs[touch.pair].other) continue;
            const double near = std::max(0.0, 1.0 - (other.at - touch.at).squaredNorm() / (reach * reach));
            together += near * near;
        }
        touch.share = 1.0 / together;
    }
}

// What of a body's watched pairs touches; pairs that have parted are no longer watched.
void CapsuleDem::look_at_pairs(std::size_t i, std::vector<Touch>& touches, std::size_t& looked_at) {
    const Moving& body = bodies_[i];
    auto& list = pairs_[i];
    touches.clear();
    for (std::size_t n = 0; n < list.size();) {
        Pair& pair = list[n];
        const Moving& other = bodies_[pair.other];
        if (body.travelled + other.travelled < pair.out_of_reach || (body.asleep != 0 && other.asleep != 0)) {
            ++n;
            continue;
        }
        ++looked_at;
        Touch touch;
        double gap = 0.0;
        if (touch_of(i, n, touch, gap)) {
            touches.push_back(touch);
        } else if (gap > 2.0 * skin_) {
            pair = list.back();
            list.pop_back();
            continue;
        } else {
            pair.out_of_reach = body.travelled + other.travelled + gap;
            if (body.asleep != 0 || other.asleep != 0) watch_sleeper(i, pair, Vec3::Zero());
        }
        ++n;
    }
    if (touches.size() > 1) share_places(list, touches, 0.25 * kinds_[body.kind].diameter);
}

// A contact that was not there in the last step, unless both slept since: then it was there, but not looked at, and its spring holds.
bool CapsuleDem::is_new(std::int64_t touched, const Moving& body, const Moving& other) const {
    if (touched >= steps_ - 1) return false;
    const auto slept_since = [&](const Moving& one) {
        return one.slept_at >= 0 && one.slept_at <= touched + 1 && (one.asleep != 0 || one.woke_at >= steps_ - 1);
    };
    return !slept_since(body) || !slept_since(other);
}

void CapsuleDem::watch_sleeper(std::size_t i, Pair& pair, const Vec3& force) {
    const Moving& sleeper = bodies_[i].asleep != 0 ? bodies_[i] : bodies_[pair.other];
    if (sleeper.slept_at == steps_ - 1) pair.base_force = force;
    const double weight = kinds_[sleeper.kind].body.mass_kg * options_.gravity_m_per_s2.norm();
    if ((force - pair.base_force).norm() > options_.wake_fraction * weight)
        woken_[i / block % lanes].push_back(bodies_[i].asleep != 0 ? static_cast<std::uint32_t>(i) : pair.other);
}

void CapsuleDem::pair_forces(std::size_t i, std::vector<Load>& loads, std::size_t& looked_at, std::vector<Touch>& touches) {
    look_at_pairs(i, touches, looked_at);
    const Moving& body = bodies_[i];
    const double own_mass = kinds_[body.kind].body.mass_kg;
    for (const Touch& touch : touches) {
        Pair& pair = pairs_[i][touch.pair];
        const Moving& other = bodies_[pair.other];
        const Vec3 lever = touch.at - body.x, other_lever = touch.at - other.x - touch.shift;
        const Vec3 velocity = body.v_contact + body.omega.cross(lever) - other.v_contact - other.omega.cross(other_lever);
        const double other_mass = kinds_[other.kind].body.mass_kg, mass = own_mass * other_mass / (own_mass + other_mass);
        const Vec3 force = contact(touch.normal, touch.overlap, velocity, mass, law_.friction, touch.share, pair.spring,
                                   is_new(pair.touched, body, other));
        pair.touched = steps_;
        loads[i].force -= force;
        loads[i].torque -= lever.cross(force);
        loads[pair.other].force += force;
        loads[pair.other].torque += other_lever.cross(force);
        if (body.asleep != 0 || other.asleep != 0)
            watch_sleeper(i, pair, force);
        else if (options_.sleep)
            pair.base_force.setZero();
    }
}

void CapsuleDem::wall_forces(std::size_t i, std::vector<Load>& loads) {
    const Moving& body = bodies_[i];
    const Kind& kind = kinds_[body.kind];
    const std::size_t walls = planes_.size() + 1;
    const auto touch = [&](std::size_t node, std::size_t wall, const Vec3& place, const Vec3& outward, double overlap) {
        const Vec3 lever = place + (kind.nodes[node].radius - overlap) * outward - body.x;
        WallSpring& spring = walls_[body.first_wall + node * walls + wall];
        const Vec3 velocity = body.v_contact + body.omega.cross(lever);
        const Vec3 force = contact(outward, overlap, velocity, kind.body.mass_kg, law_.wall_friction, 1.0, spring.spring,
                                   is_new(spring.touched, body, body));
        spring.touched = steps_;
        loads[i].force -= force;
        loads[i].torque -= lever.cross(force);
    };
    const auto for_nodes = [&](const auto& visit) {
        const Eigen::Matrix3d turn = body.q.toRotationMatrix();
        for (std::size_t node = 0; node < kind.nodes.size(); ++node) visit(node, Vec3(body.x + turn * kind.nodes[node].place));
    };
    for (std::size_t w = 0; w < planes_.size(); ++w) {
        const Plane& plane = planes_[w];
        if (plane.normal.dot(body.x) - plane.offset > kind.radius) continue;
        for_nodes([&](std::size_t node, const Vec3& place) {
            const double overlap = kind.nodes[node].radius - (plane.normal.dot(place) - plane.offset);
            if (overlap > 0.0) touch(node, w, place, -plane.normal, overlap);
        });
    }
    if (cylinder_radius_ > 0.0 && body.x.head<2>().norm() + kind.radius > cylinder_radius_)
        for_nodes([&](std::size_t node, const Vec3& place) {
            const double away = place.head<2>().norm(), overlap = away + kind.nodes[node].radius - cylinder_radius_;
            if (overlap > 0.0) touch(node, walls - 1, place, Vec3(place.x() / away, place.y() / away, 0.0), overlap);
        });
}

void CapsuleDem::forces() {
    const std::size_t n = bodies_.size();
    std::array<std::size_t, lanes> looked_at{};
#pragma omp parallel for schedule(dynamic, 1) if (parallel_)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
        auto& loads = loads_[lane];
        std::vector<Touch> touches;
        loads.assign(n, {Vec3::Zero(), Vec3::Zero()});
        for (std::size_t first = lane * block; first < n; first += lanes * block)
            for (std::size_t i = first; i < std::min(n, first + block); ++i) {
                pair_forces(i, loads, looked_at[lane], touches);
                if (bodies_[i].asleep == 0) wall_forces(i, loads);
            }
    }
    looked_at_ = 0;
    for (const std::size_t count : looked_at) looked_at_ += count;
    // Steps of less than about a millisecond are left to one thread: where another program takes a core, threads that meet thrice a step
    // wait a hundred times longer than they work.
    parallel_ = looked_at_ + 3 * (n - sleepers_) > 20000;
}

void CapsuleDem::fall_asleep_or_wake() {
    for (auto& list : woken_) {
        for (const std::uint32_t i : list) {
            Moving& body = bodies_[i];
            if (body.asleep == 0) continue;
            body.asleep = 0;
            body.woke_at = steps_;
            body.quiet = 0;
            body.fresh = 2;
            // Its contacts with other sleepers were not looked at in this step: it starts from balance.
            body.force = -kinds_[body.kind].body.mass_kg * options_.gravity_m_per_s2;
            body.torque.setZero();
        }
        list.clear();
    }
    sleepers_ = 0;
    for (Moving& body : bodies_) {
        if (body.asleep == 0 && body.quiet >= quiet_steps) {
            body.asleep = 1;
            body.slept_at = steps_;
            body.v = body.v_contact = body.momentum = body.omega = Vec3::Zero();
        }
        sleepers_ += body.asleep;
    }
}

void CapsuleDem::wake_all() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) woken_[0].push_back(static_cast<std::uint32_t>(i));
    fall_asleep_or_wake();
    primed_ = false;
}

void CapsuleDem::set_sleep(bool sleep) {
    options_.sleep = sleep;
    if (!sleep) wake_all();
}

void CapsuleDem::step(long steps) {
    const std::size_t n = bodies_.size();
    const auto gather = [&](std::size_t i) {
        Moving& body = bodies_[i];
        body.force = loads_[0][i].force;
        body.torque = loads_[0][i].torque;
        for (std::size_t lane = 1; lane < lanes; ++lane) {
            body.force += loads_[lane][i].force;
            body.torque += loads_[lane][i].torque;
        }
    };
    for (long s = 0; s < steps; ++s) {
        if (!primed_) {
            search();
            forces();
            for (std::size_t i = 0; i < n; ++i)
                if (bodies_[i].asleep == 0) gather(i);
            primed_ = true;
        }
        ++steps_;
        time_ += options_.time_step_s;
#pragma omp parallel for schedule(static, block) if (parallel_)
        for (std::size_t i = 0; i < n; ++i)
            if (bodies_[i].asleep == 0) advance(bodies_[i]);
        search();
        forces();
#pragma omp parallel for schedule(static, block) if (parallel_)
        for (std::size_t i = 0; i < n; ++i)
            if (bodies_[i].asleep == 0) {
                gather(i);
                finish(bodies_[i]);
            }
        if (options_.sleep) fall_asleep_or_wake();
    }
}

std::size_t CapsuleDem::sleeping() const {
    return static_cast<std::size_t>(std::count_if(bodies_.begin(), bodies_.end(), [](const Moving& body) { return body.asleep != 0; }));
}

std::size_t CapsuleDem::watched_pairs() const {
    std::size_t count = 0;
    for (const auto& list : pairs_) count += list.size();
    return count;
}

void CapsuleDem::find_touches(std::size_t i, std::vector<Touch>& touches) const {
    touches.clear();
    for (std::size_t n = 0; n < pairs_[i].size(); ++n) {
        Touch touch;
        double gap = 0.0;
        if (touch_of(i, n, touch, gap)) touches.push_back(touch);
    }
    share_places(pairs_[i], touches, 0.25 * kinds_[bodies_[i].kind].diameter);
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

namespace {
constexpr std::uint64_t state_mark = 0x31307374'61746570ULL;
}

void CapsuleDem::save(std::ostream& out) const {
    put(out, state_mark);
    put(out, sizeof(Moving) + sizeof(Pair));
    put(out, options_.time_step_s);
    put(out, kinds_.size());
    put(out, bodies_.size());
    put(out, time_);
    put(out, steps_);
    put(out, primed_);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        put(out, bodies_[i]);
        put(out, pairs_[i].size());
        for (const Pair& pair : pairs_[i]) put(out, pair);
    }
    for (const WallSpring& spring : walls_) put(out, spring);
    for (const auto& cell : cells_) {  // their order decides that of the pairs
        put(out, cell.size());
        for (const std::uint32_t body : cell) put(out, body);
    }
    put(out, state_mark);
}

void CapsuleDem::load(std::istream& in, const std::string& where) {
    const auto refuse = [&] {
        throw UserError("this snapshot is cut short or of another run", {.where = where, .mend = "remove it to start anew"});
    };
    std::uint64_t mark = 0;
    std::size_t layout = 0, kinds = 0, count = 0;
    double step = 0.0;
    get(in, mark);
    get(in, layout);
    get(in, step);
    get(in, kinds);
    get(in, count);
    if (!in || mark != state_mark || layout != sizeof(Moving) + sizeof(Pair) || step != options_.time_step_s || kinds != kinds_.size() ||
        count > 100000000)
        refuse();
    get(in, time_);
    get(in, steps_);
    get(in, primed_);
    bodies_.assign(count, {});
    pairs_.assign(count, {});
    cell_of_body_.assign(count, -1);
    std::size_t arms = 0, walls = 0;
    for (std::size_t i = 0; i < count; ++i) {
        get(in, bodies_[i]);
        std::size_t pairs = 0;
        get(in, pairs);
        if (!in || bodies_[i].kind >= kinds_.size() || pairs > 1000000) refuse();
        pairs_[i].resize(pairs);
        for (Pair& pair : pairs_[i]) get(in, pair);
        arms += kinds_[bodies_[i].kind].arms.size();
        walls += kinds_[bodies_[i].kind].nodes.size() * (planes_.size() + 1);
    }
    walls_.assign(walls, {});
    for (WallSpring& spring : walls_) get(in, spring);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        std::size_t size = 0;
        get(in, size);
        if (!in || size > count) refuse();
        cells_[c].resize(size);
        for (std::uint32_t& body : cells_[c]) {
            get(in, body);
            if (body >= count) refuse();
            cell_of_body_[body] = static_cast<long>(c);
        }
    }
    mark = 0;
    get(in, mark);
    if (!in || mark != state_mark) refuse();
    arms_.assign(arms, {});
    for (const Moving& body : bodies_) place_arms(body);
}

}  // namespace porepack
