// Rigid unions of capsules that collide: the paper's own kind of DEM (2.1.2), with exact contacts of spherocylinders.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "packing/grain_body.hpp"
#include "packing/packing.hpp"
#include "shapes/segments.hpp"

namespace porepack {

/// Eq. 9 and 11: Fn = max(0, (s_n/2) overlap - eta_n sqrt(2 m s_n) v_n), |Ft| <= mu Fn with a spring s_t/2 and a dashpot eta_t sqrt(2 m
/// s_t); m is the pair's effective mass, and the grain's own at a wall. `elastic_limit` limits |Ft| by the elastic part of Fn alone, as the
/// paper does; `attraction` leaves the max(0, .) out.
struct ContactLaw {
    double normal_stiffness_N_per_m = 1e4, tangential_stiffness_N_per_m = 5e3;  ///< s_n, s_t
    double normal_damping = 0.35, tangential_damping = 0.3;                     ///< eta_n, eta_t
    double friction = 0.35, wall_friction = 0.1;
    bool elastic_limit = false, attraction = false;
};

/// Second order, symplectic without damping (velocity Verlet; quaternions after Omelyan); or the paper's third-order Adams-Bashforth.
enum class Integrator { verlet, adams_bashforth };

struct DemOptions {
    double time_step_s = 1e-5;
    Vec3 gravity_m_per_s2 = Vec3(0.0, 0.0, -9.81);
    Integrator integrator = Integrator::verlet;
    bool sleep = false;  ///< grains at rest are left out until the force on one of their contacts changes by `wake_fraction` of their
                         ///< weight; the pour wakes all at the end
    double wake_fraction = 0.5;
    double skin_m = 0.0;  ///< capsules nearer than this are watched; 0: a quarter of the smallest diameter
};

struct DemEnergy {
    double kinetic_J = 0.0, rotational_J = 0.0, potential_J = 0.0, elastic_J = 0.0;
    [[nodiscard]] double total() const { return kinetic_J + rotational_J + potential_J + elastic_J; }
};

/// What rest is measured by.
struct DemRest {
    double kinetic_energy_per_grain_J = 0.0;  ///< of translation, and of rotation unless all grains are spheres
    double largest_force_over_weight = 0.0;   ///< net force (contacts and gravity) on a grain / its weight
    double mean_force_over_weight = 0.0;
    double coordination_number = 0.0;                      ///< touching grains a grain, walls not counted
    double largest_overlap_m = 0.0, mean_overlap_m = 0.0;  ///< between grains
    double top_m = 0.0;                                    ///< highest point of the grains slower than 0.05 m/s; 0 when there is none
};

/// Deterministic: the same calls give the same bits, whatever the number of threads.
/// Every pair of capsules that overlap is a contact, as in the paper. Where several of them lie at one place, at a joint of arms, they
/// share the stiffness of one (smoothly, within half a radius), else a corner of a tetrahedron on another's would be nine times as stiff.
/// Walls meet the capsules' ends, each place once. Cost is linear in the grains: a body looks for neighbours again only when it has moved
/// by half the skin, and a pair is looked at again only when its bodies can have closed its gap.
class CapsuleDem {
public:
    /// Throws UserError for a periodic box that is narrower than two grains.
    CapsuleDem(const Container& container, const std::vector<Shape>& shapes, double density_kg_per_m3, const ContactLaw& law,
               const DemOptions& options);

    /// Adds a grain: pose of the shape's frame, velocity of its centre of mass, angular velocity.
    void add(std::size_t shape, const Vec3& position_m, const Quaternion& orientation, const Vec3& velocity = Vec3::Zero(),
             const Vec3& angular_velocity = Vec3::Zero());
    void step(long steps = 1);
    void wake_all();
    /// Without sleep all grains are awake.
    void set_sleep(bool sleep);

    [[nodiscard]] std::size_t size() const { return bodies_.size(); }
    [[nodiscard]] double time_s() const { return time_; }
    [[nodiscard]] long steps() const { return steps_; }
    [[nodiscard]] Body pose(std::size_t body) const;
    [[nodiscard]] const Vec3& centre_of_mass(std::size_t body) const { return bodies_[body].x; }
    [[nodiscard]] const Vec3& velocity(std::size_t body) const { return bodies_[body].v; }
    [[nodiscard]] Vec3 angular_velocity(std::size_t body) const;
    [[nodiscard]] const Vec3& angular_momentum(std::size_t body) const { return bodies_[body].momentum; }
    [[nodiscard]] const GrainBody& grain(std::size_t shape) const { return kinds_[shape].body; }
    [[nodiscard]] std::size_t sleeping() const;
    [[nodiscard]] DemEnergy energy() const;
    [[nodiscard]] DemRest rest() const;
    [[nodiscard]] Packing packing() const;
    /// Pairs of capsules that are watched, and those looked at in the last step.
    [[nodiscard]] std::size_t watched_pairs() const;
    [[nodiscard]] std::size_t looked_at() const { return looked_at_; }

    /// The whole state: a run that loads it goes on with the same bits. load() throws UserError on a file of another scene.
    void save(std::ostream& out) const;
    void load(std::istream& in, const std::string& where);

private:
    // Bodies are dealt to lanes in blocks; each lane adds up its own loads, and the lanes are added in their order: so the sums do not
    // depend on the number of threads.
    static constexpr std::size_t lanes = 4, block = 16;

    struct Arm {
        Vec3 start, along;  // in the body frame
        double radius;
    };
    struct Node {  // an end of capsules, once
        Vec3 place;
        double radius;
    };
    struct Kind {
        GrainBody body;
        std::vector<Arm> arms;
        std::vector<Node> nodes;
        double radius = 0.0;    // of the bounding sphere about the centre of mass
        double diameter = 0.0;  // smallest
        bool isotropic = false;
    };
    struct Derivative {
        Vec3 v = Vec3::Zero(), a = Vec3::Zero(), torque = Vec3::Zero();
        Eigen::Vector4d turn = Eigen::Vector4d::Zero();
    };
    struct Moving {
        Vec3 x, v, momentum;
        Quaternion q;
        Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
        Vec3 omega = Vec3::Zero();  // for the contacts' velocities
        Vec3 v_contact = Vec3::Zero();
        double travelled = 0.0, searched_at = -1e300;  // bounds of how far any of its points has moved
        std::uint32_t kind = 0, first_arm = 0, first_wall = 0;
        std::int32_t quiet = 0;              // steps at rest
        std::uint8_t asleep = 0, fresh = 3;  // fresh: steps without a history
        std::int64_t slept_at = -1, woke_at = -3;
        Derivative before, before_that;
    };
    struct Pair {
        std::uint32_t other;
        std::uint16_t arm, other_arm;
        double out_of_reach;  // no contact while the two bodies' travels sum to less
        Vec3 spring;
        Vec3 base_force;            // when one of the two fell asleep
        std::int64_t touched = -2;  // last step in contact
    };
    struct Touch {
        std::size_t pair;  // in the body's list
        Vec3 shift, normal, at;
        double overlap, share;
    };
    struct WallSpring {
        Vec3 spring = Vec3::Zero();
        std::int64_t touched = -2;
    };
    struct WorldArm {
        Vec3 start, along;
    };
    struct Load {
        Vec3 force, torque;
    };
    [[nodiscard]] Vec3 omega_of(const Moving& body, const Quaternion& q, const Vec3& momentum) const;
    [[nodiscard]] Vec3 image_shift(const Vec3& between) const;
    void place_arms(const Moving& body);
    void advance(Moving& body);
    void finish(Moving& body);
    void search();
    void search_one(std::size_t body);
    void forces(double spring_time);
    void find_touches(std::size_t body, std::vector<Touch>& touches) const;
    void look_at_pairs(std::size_t body, std::vector<Touch>& touches, std::size_t& looked_at);
    [[nodiscard]] bool touch_of(std::size_t body, std::size_t pair, Touch& touch, double& gap) const;
    static void share_places(const std::vector<Pair>& pairs, std::vector<Touch>& touches, double reach);
    void pair_forces(std::size_t body, std::vector<Load>& loads, std::size_t& looked_at, std::vector<Touch>& touches);
    [[nodiscard]] bool is_new(std::int64_t touched, const Moving& body, const Moving& other) const;
    void watch_sleeper(std::size_t body, Pair& pair, const Vec3& force);
    void wall_forces(std::size_t body, std::vector<Load>& loads);
    [[nodiscard]] Vec3 contact(const Vec3& normal, double overlap, const Vec3& velocity, double mass, double friction, double share,
                               Vec3& spring, bool first) const;
    void fall_asleep_or_wake();
    template <typename Visit>
    void for_contacts(const Visit& visit) const;
    [[nodiscard]] long cell_of(const Vec3& place) const;

    Container container_;
    std::vector<Shape> shapes_;
    ContactLaw law_;
    DemOptions options_;
    std::vector<Kind> kinds_;
    std::vector<Moving> bodies_;
    std::vector<WorldArm> arms_;
    std::vector<std::vector<Pair>> pairs_;  // by the body of lower number
    std::vector<WallSpring> walls_;
    std::vector<std::vector<Load>> loads_;  // by lane
    std::vector<std::vector<std::uint32_t>> cells_;
    std::vector<long> cell_of_body_;
    std::array<long, 3> cell_count_{};
    Vec3 cell_low_ = Vec3::Zero();
    double cell_size_ = 1.0, skin_ = 0.0;
    struct Plane {
        Vec3 normal;  // inward
        double offset;
    };
    std::vector<Plane> planes_;
    double cylinder_radius_ = 0.0;                         // 0: none
    std::array<std::vector<std::uint32_t>, lanes> woken_;  // by lane
    double time_ = 0.0, spring_time_ = 0.0;
    long steps_ = 0;
    std::size_t looked_at_ = 0, sleepers_ = 0;
    bool parallel_ = false;
    bool primed_ = false;  // forces of the present state are known
};

}  // namespace porepack
