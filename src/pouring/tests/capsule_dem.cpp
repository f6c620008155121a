// The capsule engine against closed forms: closest points, contact law, friction, integrators, rotation, conservation.
#include "pouring/dem/capsule_dem.hpp"

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/machine.hpp"
#include "pouring/dem/thread_choice.hpp"
#include "shapes/segments.hpp"
#include "shapes/shape.hpp"
#include "support/helpers.hpp"
#include "vessels/config.hpp"

namespace porepack {
namespace {

constexpr double g = 9.81, pi = std::numbers::pi;

// The exact minimum by another method: of the four ends' distances to the other segment, and of the two lines' if within both.
double distance_otherwise(const Segment& p, const Segment& q) {
    const auto to_segment = [](const Vec3& x, const Segment& segment) {
        const double length2 = segment.along.squaredNorm();
        const double t = length2 > 0.0 ? std::clamp((x - segment.start).dot(segment.along) / length2, 0.0, 1.0) : 0.0;
        return (x - segment.start - t * segment.along).norm();
    };
    double least =
        std::min({to_segment(p.start, q), to_segment(p.start + p.along, q), to_segment(q.start, p), to_segment(q.start + q.along, p)});
    const Vec3 across = p.along.cross(q.along), between = q.start - p.start;
    if (const double size2 = across.squaredNorm(); size2 > 1e-20 * p.along.squaredNorm() * q.along.squaredNorm()) {
        const double s = between.cross(q.along).dot(across) / size2, t = between.cross(p.along).dot(across) / size2;
        if (s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0) least = std::min(least, std::abs(between.dot(across)) / std::sqrt(size2));
    }
    return least;
}

TEST(Segments, AMillionPairsAgainstAnotherFormula) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    double worst = 0.0;
    for (int i = 0; i < 1000000; ++i) {
        Segment p{vector(), vector()}, q{vector(), vector()};
        const int kind = i % 10;
        if (kind == 1) q.along = unit(random) * p.along;                                // parallel
        if (kind == 2) q.along = p.along + 1e-7 * vector();                             // nearly
        if (kind == 3) q = {p.start + unit(random) * p.along, unit(random) * p.along};  // on one line
        if (kind == 4) q.start = p.start + 0.5 * p.along - 0.5 * q.along;               // crossing
        if (kind == 5) p.along = Vec3::Zero();
        if (kind == 6) p.along = q.along = Vec3::Zero();
        if (kind == 7) q.along *= 1e-9;
        if (kind == 8) q.start = p.start;  // a common end
        const ClosestPoints found = closest_points(p, q);
        worst = std::max(worst, std::abs(found.distance - distance_otherwise(p, q)));
    }
    std::printf("  largest difference %.1e\n", worst);
    EXPECT_LT(worst, 5e-8);
}

TEST(Segments, TheContactPointOfNearlyParallelAxesDoesNotJump) {
    const Segment p{Vec3(-1, 0, 0), Vec3(2, 0, 0)};
    Vec3 before;
    for (int i = -4000; i <= 4000; ++i) {
        const double angle = 1e-4 * i;
        const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
        const Segment q{Vec3(0.3, 0, 0.99) - along, 2.0 * along};
        const ClosestPoints closest = closest_points(p, q);
        const Vec3 at = pressed_point(p, q, closest, 1.0 - closest.distance);
        if (i > -4000) {
            EXPECT_LT((at - before).norm(), 0.01) << angle;
        }
        before = at;
    }
    // Exactly parallel: the middle of the shared interval, from -0.7 to 1.
    const Segment q{Vec3(-0.7, 0, 0.99), Vec3(2, 0, 0)};
    EXPECT_NEAR(pressed_point(p, q, closest_points(p, q), 0.01).x(), 0.15, 1e-12);
}

CapsuleDem floor_with(const Shape& shape, const ContactLaw& law, const DemOptions& options) {
    return {parse_container("box:1,1,1"), {shape}, 1000.0, law, options};
}

const Shape sphere = make_preset(ShapeKind::sphere, 0.01, 0.0);
const double sphere_mass = grain_body(sphere, 1000.0).mass_kg;

TEST(CapsuleDem, CentralImpactsRestituteAsTheFormulaSays) {
    // Linear spring and dashpot: e = exp(-pi eta/sqrt(1 - eta^2)); without attraction the contact ends where the force vanishes.
    const double eta = 0.35, root = std::sqrt(1.0 - eta * eta);
    const double whole = std::exp(-pi * eta / root);
    for (const bool attraction : {true, false}) {
        ContactLaw law;
        law.attraction = attraction;
        CapsuleDem dem(parse_container("box:1,1,1"), {sphere}, 1000.0, law, {.time_step_s = 1e-6, .gravity_m_per_s2 = Vec3::Zero()});
        dem.add(0, Vec3(0.5, 0.5, 0.5), Quaternion::Identity(), Vec3(0.1, 0, 0));
        dem.add(0, Vec3(0.511, 0.5, 0.5), Quaternion::Identity(), Vec3(-0.1, 0, 0));
        dem.step(20000);
        const double e = (dem.velocity(1).x() - dem.velocity(0).x()) / 0.2;
        std::printf("  restitution %.4f (%s)\n", e, attraction ? "with attraction" : "without");
        EXPECT_NEAR(e, attraction ? 0.309 : 0.404, 1e-3);
        if (attraction) {
            EXPECT_NEAR(e, whole, 1e-3);
        }
    }
}

TEST(CapsuleDem, ARodRestsStandingAndLying) {
    const Shape rod = make_preset(ShapeKind::rod, 0.01, 0.02);
    const double mass = 1000.0 * measure(rod).volume_m3, kn = 0.5 * ContactLaw{}.normal_stiffness_N_per_m;
    const auto low = [](const Capsule& capsule) { return std::min(capsule.a.z(), capsule.b.z()) - capsule.radius; };
    for (const bool standing : {true, false}) {
        CapsuleDem dem = floor_with(rod, {}, {.time_step_s = 2e-5});
        // The preset lies along one axis of its frame: rotate it onto z or x.
        const Vec3 axis = (rod.capsules[0].b - rod.capsules[0].a).normalized();
        const Quaternion turn = Quaternion::FromTwoVectors(axis, standing ? Vec3(Vec3::UnitZ()) : Vec3(Vec3::UnitX()));
        dem.add(0, Vec3(0.5, 0.5, standing ? 0.0151 : 0.0051), turn);
        dem.step(50000);
        const Packing packing = dem.packing();
        const double overlap = -low(world_capsules(packing, packing.bodies[0])[0]);
        EXPECT_NEAR(overlap, mass * g / kn / (standing ? 1.0 : 2.0), 1e-3 * mass * g / kn) << standing;
        EXPECT_LT(dem.rest().largest_force_over_weight, 1e-6);
    }
}

TEST(CapsuleDem, FrictionStopsARodAndSetsASphereRolling) {
    const ContactLaw law{.wall_friction = 0.1};
    const DemOptions options{.time_step_s = 1e-5};
    const Shape rod = make_preset(ShapeKind::rod, 0.01, 0.02);
    const Vec3 axis = (rod.capsules[0].b - rod.capsules[0].a).normalized();
    CapsuleDem sliding = floor_with(rod, law, options);
    const double rod_mass = 1000.0 * measure(rod).volume_m3;
    sliding.add(0, Vec3(0.2, 0.5, 0.005 - rod_mass * g / 1e4), Quaternion::FromTwoVectors(axis, Vec3(Vec3::UnitX())), Vec3(0.5, 0, 0));
    sliding.step(20000);
    EXPECT_NEAR(sliding.velocity(0).x(), 0.5 - 0.1 * g * 0.2, 2e-3);
    sliding.step(60000);
    EXPECT_NEAR(sliding.centre_of_mass(0).x() - 0.2, 0.25 / (2.0 * 0.1 * g), 1e-3);

    CapsuleDem rolling = floor_with(sphere, law, options);
    rolling.add(0, Vec3(0.2, 0.5, 0.005 - sphere_mass * g / 5e3), Quaternion::Identity(), Vec3(0.5, 0, 0));
    rolling.step(40000);
    EXPECT_NEAR(rolling.velocity(0).x(), 5.0 / 7.0 * 0.5, 1e-3);
    EXPECT_NEAR(rolling.angular_velocity(0).y() * 0.005, 5.0 / 7.0 * 0.5, 2e-3);
}

TEST(CapsuleDem, BothIntegratorsHaveTheirOrder) {
    // A sphere on the floor, always in contact: a damped oscillator.
    const double kn = 5e3, omega0 = std::sqrt(kn / sphere_mass), eta = 0.35, root = std::sqrt(1.0 - eta * eta), time = 2e-3;
    const double depth = sphere_mass * g / kn, start = 0.3 * depth;
    const double exact =
        std::exp(-eta * omega0 * time) * (std::cos(root * omega0 * time) + eta / root * std::sin(root * omega0 * time)) * start;
    for (const Integrator integrator : {Integrator::verlet, Integrator::adams_bashforth}) {
        std::vector<double> errors;
        for (const int n : {100, 200, 400, 800}) {
            CapsuleDem dem = floor_with(sphere, {}, {.time_step_s = time / n, .integrator = integrator});
            dem.add(0, Vec3(0.5, 0.5, 0.005 - depth + start), Quaternion::Identity());
            dem.step(n);
            errors.push_back(std::abs(dem.centre_of_mass(0).z() - 0.005 + depth - exact) / start);
        }
        const double order = std::log2(errors[1] / errors[3]) / 2.0;
        std::printf("  %s: errors %.1e %.1e %.1e %.1e, order %.2f\n", integrator == Integrator::verlet ? "Verlet" : "Adams-Bashforth",
                    errors[0], errors[1], errors[2], errors[3], order);
        EXPECT_NEAR(order, integrator == Integrator::verlet ? 2.0 : 3.0, 0.25);
    }
}

// Euler's equations and the quaternion in the body frame, by the classical Runge-Kutta method with small steps.
Quaternion spun(const Vec3& inertia, Vec3 omega, double time, int steps) {
    Eigen::Vector4d q = Quaternion::Identity().coeffs();
    const double h = time / steps;
    const auto rate = [&](const Vec3& w, const Eigen::Vector4d& turn) {
        const Vec3 dw = (inertia.cwiseProduct(w)).cross(w).cwiseQuotient(inertia);
        const Eigen::Vector4d dq = 0.5 * (Quaternion(turn) * Quaternion(0, w.x(), w.y(), w.z())).coeffs();
        return std::pair(dw, dq);
    };
    for (int i = 0; i < steps; ++i) {
        const auto [a, qa] = rate(omega, q);
        const auto [b, qb] = rate(omega + 0.5 * h * a, q + 0.5 * h * qa);
        const auto [c, qc] = rate(omega + 0.5 * h * b, q + 0.5 * h * qb);
        const auto [d, qd] = rate(omega + h * c, q + h * qc);
        omega += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        q += h / 6.0 * (qa + 2.0 * qb + 2.0 * qc + qd);
    }
    return Quaternion(q).normalized();
}

TEST(CapsuleDem, AnAsymmetricBodyTurnsAsEulerSays) {
    Shape ell = make_preset(ShapeKind::rod, 0.01, 0.03);
    ell.capsules = {{Vec3(0, 0, 0), Vec3(0.03, 0, 0), 0.005}, {Vec3(0, 0, 0), Vec3(0, 0.018, 0), 0.005}};
    const double spin = 60.0, time = 100.0 * 2.0 * pi / spin;
    for (const Integrator integrator : {Integrator::verlet, Integrator::adams_bashforth}) {
        std::vector<double> errors;
        for (const double dt : {4e-5, 2e-5}) {
            CapsuleDem dem(parse_container("box:1,1,1"), {ell}, 1000.0, {},
                           {.time_step_s = dt, .gravity_m_per_s2 = Vec3::Zero(), .integrator = integrator});
            const GrainBody& grain = dem.grain(0);
            const Vec3 in_body = spin * Vec3(0.6, 0.5, 0.62).normalized();
            const Quaternion start(0.3, 0.5, -0.4, 0.7);
            dem.add(0, Vec3(0.5, 0.5, 0.5), start.normalized() * grain.turn.conjugate(), Vec3::Zero(), start.normalized() * in_body);
            const Vec3 momentum = dem.angular_momentum(0);
            dem.step(std::lround(time / dt));
            EXPECT_LT((dem.angular_momentum(0) - momentum).norm(), 1e-12 * momentum.norm());
            const Quaternion exact = start.normalized() * spun(grain.inertia_kg_m2, in_body, std::lround(time / dt) * dt, 400000);
            const Quaternion found = dem.pose(0).orientation * grain.turn;
            errors.push_back(exact.angularDistance(found));
        }
        std::printf("  after 100 turns %.1e and %.1e rad\n", errors[0], errors[1]);
        EXPECT_LT(errors[1], 0.02);
        EXPECT_GT(std::log2(errors[0] / errors[1]), 1.8);
    }
}

// A loose heap of tetrapods, dropped on a floor.
CapsuleDem heap(int grains, const DemOptions& options, const ContactLaw& law = {}, const char* container = "cylinder:0.06,0.4") {
    const Shape tetrapod = make_preset(ShapeKind::tetrapod, 0.004, 0.008);
    CapsuleDem dem(parse_container(container), {tetrapod}, 1000.0, law, options);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int i = 0; i < grains; ++i)
        dem.add(0, Vec3(0.021 * (i % 2) - 0.0105, 0.021 * (i / 2 % 2) - 0.0105, 0.011 + 0.021 * (i / 4)),
                Quaternion(unit(random), unit(random), unit(random), unit(random)).normalized(),
                Vec3(0.2 * unit(random), 0.2 * unit(random), 0.0));
    return dem;
}

TEST(CapsuleDem, EnergyNeverGrows) {
    CapsuleDem dem = heap(32, {.time_step_s = 1e-5});
    double before = dem.energy().total();
    const double at_first = before;
    for (int i = 0; i < 400; ++i) {
        dem.step(200);
        const double now = dem.energy().total();
        ASSERT_LT(now, before + 1e-7 * at_first) << i;
        before = now;
    }
    EXPECT_LT(before, 0.7 * at_first);
}

TEST(CapsuleDem, AFreeClusterKeepsItsMomentum) {
    const Shape tetrapod = make_preset(ShapeKind::tetrapod, 0.004, 0.008);
    CapsuleDem dem(parse_container("box:1,1,1"), {tetrapod}, 1000.0, {}, {.time_step_s = 1e-5, .gravity_m_per_s2 = Vec3::Zero()});
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto sums = [&] {
        Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
        const Vec3 middle(0.5, 0.5, 0.5);
        for (std::size_t i = 0; i < dem.size(); ++i) {
            momentum += dem.grain(0).mass_kg * dem.velocity(i);
            angular += dem.angular_momentum(i) + dem.grain(0).mass_kg * (dem.centre_of_mass(i) - middle).cross(dem.velocity(i));
        }
        return std::pair(momentum, angular);
    };
    for (int i = 0; i < 27; ++i) {
        const Vec3 place = 0.015 * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        dem.add(0, Vec3(0.5, 0.5, 0.5) + place, Quaternion(unit(random), unit(random), unit(random), unit(random)).normalized(),
                -5.0 * place + 0.1 * Vec3(unit(random), unit(random), unit(random)), 30.0 * Vec3(unit(random), unit(random), unit(random)));
    }
    const auto [momentum, angular] = sums();
    double hits = 0.0;
    for (int i = 0; i < 50; ++i) {
        dem.step(100);
        hits += dem.rest().coordination_number;
    }
    EXPECT_GT(hits, 1.0);
    const auto [after, angular_after] = sums();
    const double scale = 27.0 * dem.grain(0).mass_kg * 0.1;
    EXPECT_LT((after - momentum).norm(), 1e-12 * scale);
    EXPECT_LT((angular_after - angular).norm(), 1e-11 * scale * 0.03);
}

TEST(CapsuleDem, ASnapshotGoesOnWithTheSameBits) {
    CapsuleDem whole = heap(24, {.time_step_s = 2e-5, .sleep = true}), first = heap(24, {.time_step_s = 2e-5, .sleep = true});
    whole.step(9000);
    std::stringstream file;
    whole.save(file);
    first.load(file, "a snapshot");
    whole.step(4000);
    first.step(4000);
    for (std::size_t i = 0; i < whole.size(); ++i) {
        EXPECT_EQ(whole.centre_of_mass(i), first.centre_of_mass(i));
        EXPECT_EQ(whole.pose(i).orientation.coeffs(), first.pose(i).orientation.coeffs());
    }
    std::stringstream cut(file.str().substr(0, 900));
    EXPECT_TRUE(test::has(test::message_of<UserError>([&] { first.load(cut, "a snapshot"); }), "cut short"));
}

TEST(CapsuleDem, ADamagedSnapshotIsReadOrRefused) {
    CapsuleDem whole = heap(12, {.time_step_s = 2e-5}), damaged = heap(12, {.time_step_s = 2e-5});
    whole.step(3000);
    std::stringstream file;
    whole.save(file);
    const std::string bytes = file.str();
    int refused = 0;
    for (std::size_t i = 0; i + 4 < bytes.size(); i += 29) {
        std::string changed = bytes;
        for (std::size_t k = 0; k < 4; ++k) changed[i + k] = '\x7f';  // of an index: far beyond the last body, arm and kind
        std::stringstream in(changed);
        try {
            damaged.load(in, "a snapshot");
        } catch (const UserError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 12);  // each body has pairs, a kind and numbers of pairs
}

TEST(CapsuleDem, NoPairIsMissed) {
    // A skin that includes all pairs must give the same motion: the skin decides only which pairs are checked.
    CapsuleDem narrow = heap(24, {.time_step_s = 2e-5, .skin_m = 0.0004}), wide = heap(24, {.time_step_s = 2e-5, .skin_m = 0.1});
    for (int i = 0; i < 20; ++i) {
        narrow.step(150);
        wide.step(150);
        // Sums in another order differ in their last bits, and collisions amplify the difference.
        for (std::size_t b = 0; b < narrow.size(); ++b)
            ASSERT_LT((narrow.centre_of_mass(b) - wide.centre_of_mass(b)).norm(), i < 8 ? 1e-10 : 1e-4) << i << " " << b;
    }
    EXPECT_LT(narrow.looked_at(), wide.looked_at());
}

// Seconds of a step, with one thread and with all.
TEST(CapsuleDem, UsesThreadsWhereTheyAreFaster) {
    const auto parallel_share = [](double one, double all, int steps) {
        ThreadChoice choice;
        int parallel = 0;
        for (int step = 0; step < steps; ++step) {
            parallel += choice.parallel() ? 1 : 0;
            choice.add(choice.parallel() ? all : one);
        }
        return static_cast<double>(parallel) / steps;
    };
    set_thread_count(2);
    EXPECT_GT(parallel_share(1e-3, 0.6e-3, 10000), 0.95);
    EXPECT_LT(parallel_share(1e-3, 1.1e-3, 100000), 0.01) << "a trial only";
    EXPECT_LT(parallel_share(1e-3, 0.1, 100000), 1e-4) << "a trial ends when its time is over";
    EXPECT_EQ(parallel_share(5e-5, 1e-5, 10000), 0.0) << "such short steps are not worth it";
    set_thread_count(1);
    EXPECT_EQ(parallel_share(1e-3, 0.6e-3, 10000), 0.0);
    set_thread_count(2);
    ThreadChoice choice;  // another program begins to use a core
    for (int step = 0; step < 1000; ++step) choice.add(choice.parallel() ? 0.6e-3 : 1e-3);
    ASSERT_TRUE(choice.parallel());
    int slow = 0;
    for (; choice.parallel(); ++slow) choice.add(1e-2);
    EXPECT_LE(slow, 20);
    set_thread_count(usable_cores());
}

TEST(CapsuleDem, TenThousandSpheresOnAnyThreads) {
    const Shape small = make_preset(ShapeKind::sphere, 0.002, 0.0);
    std::vector<double> top;
    std::vector<Vec3> last;
    for (const int threads : {1, 2}) {
        omp_set_num_threads(threads);
        CapsuleDem dem(parse_container("box:0.05,0.05,0.2"), {small}, 1000.0,
                       {.normal_stiffness_N_per_m = 1000, .tangential_stiffness_N_per_m = 500}, {.time_step_s = 4e-6});
        std::mt19937_64 random(1);
        std::uniform_real_distribution<double> unit(-1.0, 1.0);
        for (int i = 0; i < 10000; ++i)
            dem.add(0, Vec3(0.0013 + 0.0021 * (i % 23), 0.0013 + 0.0021 * (i / 23 % 23), 0.0012 + 0.0021 * (i / 529)),
                    Quaternion::Identity(), Vec3(unit(random), unit(random), unit(random) - 1.0));
        dem.step(60);
        EXPECT_GT(dem.rest().coordination_number, 0.01);
        EXPECT_LT(dem.watched_pairs(), 100000U);
        last.push_back(dem.centre_of_mass(1234));
        top.push_back(dem.energy().total());
    }
    omp_set_num_threads(omp_get_num_procs());
    EXPECT_EQ(top[0], top[1]);
    EXPECT_EQ(last[0], last[1]);
}

TEST(CapsuleDem, EndsTouchWallsOnce) {
    // The ends of a tetrapod are five, of a dolos (whose middle arm ends within the others) four.
    const double overlap = 1e-5, one = 0.5 * 5e3 * overlap * overlap;
    const Shape tetrapod = make_preset(ShapeKind::tetrapod, 0.004, 0.008), dolos = make_preset(ShapeKind::dolos, 0.004, 0.012);
    const auto on_floor = [&](const Shape& shape, const Quaternion& turn) {
        CapsuleDem dem(parse_container("box:1,1,1"), {shape}, 1000.0, {}, {.time_step_s = 1e-9, .gravity_m_per_s2 = Vec3::Zero()});
        double low = 1.0;
        for (const Capsule& capsule : shape.capsules)
            for (const Vec3& end : {capsule.a, capsule.b}) low = std::min(low, (turn * end).z() - capsule.radius);
        dem.add(0, Vec3(0.5, 0.5, -low - overlap), turn);
        dem.step(1);
        return dem.energy().elastic_J / one;
    };
    const Vec3 arm = (tetrapod.capsules[0].b - tetrapod.capsules[0].a).normalized();
    EXPECT_NEAR(on_floor(tetrapod, Quaternion::FromTwoVectors(arm, Vec3(Vec3::UnitZ()))), 3.0, 1e-3);
    EXPECT_NEAR(on_floor(tetrapod, Quaternion::FromTwoVectors(arm, Vec3(-Vec3::UnitZ()))), 1.0, 1e-3);
    EXPECT_LE(on_floor(dolos, Quaternion::Identity()), 3.001);
}

}  // namespace
}  // namespace porepack
