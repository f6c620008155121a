// Who touches whom, and with which force.
#include <set>

#include "packing/capsule_dem.hpp"

namespace porepack {

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
    spring += spring_time_ * sliding;
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

void CapsuleDem::find_touches(std::size_t i, std::vector<Touch>& touches) const {
    touches.clear();
    for (std::size_t n = 0; n < pairs_[i].size(); ++n) {
        Touch touch;
        double gap = 0.0;
        if (touch_of(i, n, touch, gap)) touches.push_back(touch);
    }
    share_places(pairs_[i], touches, 0.25 * kinds_[bodies_[i].kind].diameter);
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

// Over `spring_time` the friction springs stretch: a step, or nothing where the forces of a changed scene are found once more.
void CapsuleDem::forces(double spring_time) {
    spring_time_ = spring_time;
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

}  // namespace porepack
