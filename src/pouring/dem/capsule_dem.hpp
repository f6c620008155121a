// DEM of rigid unions of capsules, as in the paper (2.1.2), with exact contacts of spherocylinders.
#pragma once

#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "packing/packing.hpp"
#include "pouring/config.hpp"
#include "pouring/grain_body.hpp"

namespace porepack::pouring::dem {

using packing::Packing;

/// Eq. 9 and 11: Fn = max(0, (s_n/2) overlap - eta_n sqrt(2 m s_n) v_n), |Ft| <= mu Fn with a spring s_t/2 and a dashpot eta_t sqrt(2 m
/// s_t); m is the pair's effective mass, and the grain's own at a wall.
struct ContactLaw {
    /// s_n in N/m. The overlap of a grain at rest is about 2 weight / s_n; the contact time, of which the time step is a fraction, scales
    /// with 1/sqrt(s_n): raise it where overlaps are too large, at the cost of more steps.
    double normal_stiffness_N_per_m = 1e4;
    /// s_t in N/m; usually between s_n/2 and s_n.
    double tangential_stiffness_N_per_m = 5e3;
    /// eta_n, dimensionless, below 1 (critical). With `attraction` a central impact has the restitution exp(-pi eta_n / sqrt(1 - eta_n^2)),
    /// without it a slightly larger one.
    double normal_damping = 0.35;
    /// eta_t, dimensionless, below 1.
    double tangential_damping = 0.3;
    /// Coulomb coefficient mu between grains. Larger values make looser packings.
    double friction = 0.35;
    /// Coulomb coefficient at the walls.
    double wall_friction = 0.1;
    /// true: limits |Ft| by the elastic part of Fn alone, as the paper does; false: by all of Fn. For comparisons with the paper.
    bool elastic_limit = false;
    /// Omits the max(0, .), so that the dashpot may attract separating grains. For tests against the linear oscillator.
    bool attraction = false;
};

struct DemOptions {
    /// Time step in seconds. About 45 steps per contact time pi / sqrt((s_n/2)/m) are usual (plan_pour computes it); shorten it when energy
    /// grows or grains are lost.
    double time_step_s = 1e-5;
    /// Gravity in m/s^2. Without gravity grains never sleep.
    shapes::Vec3 gravity_m_per_s2 = shapes::Vec3(0.0, 0.0, -9.81);
    /// Adams-Bashforth only to reproduce the paper.
    Integrator integrator = Integrator::verlet;
    /// Grains at rest are skipped until the force on one of their contacts changes by `wake_fraction` of their weight; the pour wakes all
    /// at the end. Saves time in beds that fill up; switch it off where the motion of every grain matters.
    bool sleep = false;
    /// Dimensionless. Smaller values wake more grains.
    double wake_fraction = 0.5;
    /// Capsules with a gap below this, in metres, are kept in the Verlet lists; 0: a quarter of the smallest diameter. It changes the cost,
    /// not the physics: larger for fast grains (fewer searches), smaller for slow ones (shorter lists).
    double skin_m = 0.0;
};

struct DemEnergy {
    double kinetic_J = 0.0, rotational_J = 0.0, potential_J = 0.0, elastic_J = 0.0;
    [[nodiscard]] double total() const { return kinetic_J + rotational_J + potential_J + elastic_J; }
};

/// Quantities that define rest, of the grains that are not held.
struct DemRest {
    double kinetic_energy_per_grain_J = 0.0;  ///< of translation, and of rotation unless all grains are spheres
    double translation_energy_per_grain_J = 0.0;
    double largest_force_over_weight = 0.0;  ///< net force (contacts and gravity) on a grain / its weight
    double mean_force_over_weight = 0.0;
    double mean_net_force_N = 0.0;
    double coordination_number = 0.0;                      ///< grains in contact per grain, held ones too, walls not counted
    double largest_overlap_m = 0.0, mean_overlap_m = 0.0;  ///< between grains
    double top_m = 0.0;                                    ///< highest point of the grains slower than 0.05 m/s; 0 if there is none
    long rattlers = 0;                                     ///< grains with fewer than four contacts, removed until none is left
    double coordination_without_rattlers = 0.0;
};

/// A horizontal plate above the grains, which closes the vessel and slides along its sides without friction.
struct Lid {
    double height_m = 0.0;
    double velocity_m_per_s = 0.0;
    double mass_kg = 0.0;  ///< 0: it keeps its velocity, whatever presses on it
    double force_N = 0.0;  ///< of the grains on it, upwards; set by each step
};

/// Forces of the grains on the walls in the last step, along z; of grains that are awake.
struct WallLoads {
    double floor_N = 0.0, sides_N = 0.0, lid_N = 0.0;
};

/// Deterministic: the same calls give the same bits for any number of threads.
/// Every pair of overlapping capsules is a contact, as in the paper. Where several of them lie at one place, at a joint of arms, they
/// share the stiffness of one (smoothly, within half a radius); otherwise two tetrahedra corner to corner would be nine times as stiff.
/// Walls are in contact with the capsules' ends, once per place; a wall that grains lie around is so with their axes. Cost is linear in the
/// number of grains: a body searches neighbours again only when it has moved by half the skin, and a pair is checked again only when its
/// gap can have closed.
class CapsuleDem {
public:
    /// Throws UserError for a periodic box narrower than two grains.
    CapsuleDem(const vessels::Container& container, const std::vector<shapes::Shape>& shapes, double density_kg_per_m3,
               const ContactLaw& law, const DemOptions& options);
    ~CapsuleDem();
    CapsuleDem(CapsuleDem&&) noexcept;
    CapsuleDem& operator=(CapsuleDem&&) noexcept;

    /// Adds a grain: pose of the shape's frame, velocity of its centre of mass, angular velocity.
    void add(std::size_t shape, const shapes::Vec3& position_m, const shapes::Quaternion& orientation,
             const shapes::Vec3& velocity = shapes::Vec3::Zero(), const shapes::Vec3& angular_velocity = shapes::Vec3::Zero());
    /// The grain stays where it is, whatever presses on it.
    void hold(std::size_t body);
    /// Takes all velocities away.
    void stop();
    void step(long steps = 1);
    void wake_all();
    /// Without sleep all grains are awake.
    void set_sleep(bool sleep);
    /// From the next step on. A vessel that moves is described in its own frame: gravity less the vessel's acceleration.
    void set_gravity(const shapes::Vec3& gravity_m_per_s2);
    /// Wakes all grains and adds a velocity to each, and to a lid that has a mass.
    void push(const shapes::Vec3& velocity_m_per_s);
    /// Between grains, from the next step on.
    void set_friction(double friction);
    /// Without a value, the lid is taken away. Under a lid grains do not sleep: switch sleep off. Not along a periodic axis z.
    void set_lid(const std::optional<Lid>& lid);
    [[nodiscard]] const std::optional<Lid>& lid() const;
    /// Moves all grains with a box that is periodic along x, y and z to a new size, one part in 1000 smaller or larger at most. Grains keep
    /// their size. Throws UserError where the box becomes narrower than two grains.
    void resize(const shapes::Vec3& size_m);
    /// Of contacts between grains over the container's volume, from the last step: trace of the stress / 3.
    [[nodiscard]] double pressure_Pa() const;
    [[nodiscard]] WallLoads wall_loads() const;

    [[nodiscard]] std::size_t size() const;
    [[nodiscard]] double time_s() const;
    [[nodiscard]] long steps() const;
    [[nodiscard]] packing::Body pose(std::size_t body) const;
    [[nodiscard]] const shapes::Vec3& centre_of_mass(std::size_t body) const;
    [[nodiscard]] const shapes::Vec3& velocity(std::size_t body) const;
    [[nodiscard]] shapes::Vec3 angular_velocity(std::size_t body) const;
    [[nodiscard]] const shapes::Vec3& angular_momentum(std::size_t body) const;
    [[nodiscard]] const GrainBody& grain(std::size_t shape) const;
    [[nodiscard]] std::size_t sleeping() const;
    [[nodiscard]] DemEnergy energy() const;
    [[nodiscard]] DemRest rest() const;
    [[nodiscard]] Packing packing() const;
    [[nodiscard]] const vessels::Container& container() const;
    /// Pairs of capsules in the Verlet lists, and those checked in the last step.
    [[nodiscard]] std::size_t watched_pairs() const;
    [[nodiscard]] std::size_t looked_at() const;

    /// The whole state: a run that loads it continues with the same bits. load() throws UserError on a file of another set-up.
    void save(std::ostream& out) const;
    void load(std::istream& in, const std::string& where);

private:
    class State;  // capsule_state.hpp
    std::unique_ptr<State> state_;
};

}  // namespace porepack::pouring::dem
