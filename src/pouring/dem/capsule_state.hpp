// State and private functions of CapsuleDem; only for the sources of this folder.
//
// A step: every body moves (capsule_motion.cpp), bodies that moved far search new neighbours (capsule_neighbours.cpp), the pairs of the
// Verlet lists that can be in contact are checked and give forces (capsule_contacts.cpp), the velocities are completed, and grains sleep or
// wake. Nothing here depends on the number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/vessel.hpp"
#include "pouring/dem/capsule_dem.hpp"
#include "pouring/dem/piece_contact.hpp"
#include "pouring/dem/thread_choice.hpp"
#include "shapes/segments.hpp"

namespace porepack::pouring::dem {

using packing::Packing;

class CapsuleDem::State {
public:
    State(const vessels::Container& container, const std::vector<shapes::Shape>& shapes, double density_kg_per_m3, const ContactLaw& law,
          const DemOptions& options);

    /// Bodies are assigned to load slots in blocks; each slot sums its own loads, and the slots are added in their order: so the sums do
    /// not depend on the number of threads.
    static constexpr std::size_t load_slots = 4, block = 16;

    struct Arm {                    ///< a capsule's axis
        shapes::Vec3 start, along;  ///< in the body frame
        double radius;
    };
    struct Node {  ///< an end of one or several capsules, listed once
        shapes::Vec3 place;
        double radius;
    };
    struct Kind {  ///< data common to all grains of a shape
        GrainBody body;
        std::vector<Arm> arms;
        std::vector<Node> nodes;
        double radius = 0.0;    ///< of the bounding sphere about the centre of mass
        double diameter = 0.0;  ///< smallest
        bool isotropic = false;
        std::vector<ContactPiece> pieces;  ///< where a grain has faces
        bool round = false;                ///< some piece is an axis
        bool convex = false;
    };
    struct Derivative {
        shapes::Vec3 v = shapes::Vec3::Zero(), a = shapes::Vec3::Zero(), torque = shapes::Vec3::Zero();
        Eigen::Vector4d turn = Eigen::Vector4d::Zero();
    };
    struct BodyState {
        shapes::Vec3 x = shapes::Vec3::Zero(), v = shapes::Vec3::Zero();  ///< centre of mass and its velocity
        shapes::Vec3 momentum = shapes::Vec3::Zero();                     ///< angular
        shapes::Quaternion q = shapes::Quaternion::Identity();            ///< from the body frame to the world
        shapes::Vec3 force = shapes::Vec3::Zero(), torque = shapes::Vec3::Zero();
        shapes::Vec3 omega = shapes::Vec3::Zero();  ///< for the contacts' velocities
        shapes::Vec3 v_contact = shapes::Vec3::Zero();
        double travelled = 0.0, searched_at = -1e300;  ///< upper bounds of the distance that any of its points has moved
        std::uint32_t kind = 0, first_arm = 0, first_wall = 0;
        std::int32_t quiet = 0;              ///< steps at rest
        std::uint8_t asleep = 0, fresh = 3;  ///< fresh: number of steps without a history
        std::uint8_t held = 0;
        [[nodiscard]] bool moves() const { return asleep == 0 && held == 0; }
        std::int64_t slept_at = -1, woke_at = -3;
        Derivative before, before_that;
    };
    struct VerletPair {  ///< two nearby arms; in the Verlet list of the body with the lower number
        std::uint32_t other;
        std::uint16_t arm, other_arm;
        double out_of_reach;  ///< no contact while the sum of the two bodies' travelled distances is less
        shapes::Vec3 tangential_displacement;
        shapes::Vec3 base_force;         ///< force when one of the two fell asleep
        std::int64_t last_contact = -2;  ///< last step in contact
    };
    struct PiecePair {  ///< a piece of one body and the surface of the other; in the list of the body with the lower number
        std::uint32_t other;
        std::uint16_t piece;
        std::uint16_t own;  ///< 1: the piece belongs to the body with the list
        double out_of_reach;
        shapes::Vec3 tangential_displacement;
        shapes::Vec3 base_force;
        std::int64_t last_contact = -2;
    };
    struct Frame {  ///< of a body's shape in the world
        Eigen::Matrix3d turn;
        shapes::Vec3 origin;
    };
    struct Contact {
        std::size_t pair;                ///< in the body's Verlet list
        shapes::Vec3 shift, normal, at;  ///< periodic shift of the other body; towards it; point of the contact
        double overlap, share;           ///< share: fraction of the stiffness
        double square;                   ///< elastic energy over a quarter of the stiffness
        double twist = 0.0;              ///< torque about the normal over the elastic force
    };
    struct WallContactPoint {
        std::size_t history;  ///< of the body's first WallContact on
        shapes::Vec3 at, outward;
        double overlap, share, square;  ///< as of a contact
        double twist = 0.0;
        std::uint64_t rim = 0;  ///< part of a rim of the mesh, from 1 on; 0: none
    };
    struct WallContact {
        shapes::Vec3 tangential_displacement = shapes::Vec3::Zero();
        std::int64_t last_contact = -2;
    };
    struct RimContact {  ///< with a part of a rim of the wall
        std::uint64_t rim = 0;
        WallContact contact;
    };
    struct NearMesh {  ///< what a body can touch of the wall, until it has travelled so far
        double until = 0.0;
        bool touches = false;
        std::vector<std::uint32_t> sides;
    };
    struct WorldArm {
        shapes::Vec3 start, along;
    };
    struct Load {
        shapes::Vec3 force, torque;
    };
    /// Input of the contact law.
    struct Approach {
        shapes::Vec3 normal;  ///< towards the second body
        double overlap;
        shapes::Vec3 velocity;  ///< of the first body relative to the second, at the contact
        double mass;            ///< effective
        double friction, share;
    };

    void add(std::size_t shape, const shapes::Vec3& position_m, const shapes::Quaternion& orientation, const shapes::Vec3& velocity,
             const shapes::Vec3& angular_velocity);
    void hold(std::size_t body);
    void stop();
    void step(long steps);
    void wake_all();
    void set_sleep(bool sleep);
    void set_gravity(const shapes::Vec3& gravity_m_per_s2) { options_.gravity_m_per_s2 = gravity_m_per_s2; }
    void push(const shapes::Vec3& velocity_m_per_s);
    void set_friction(double friction) { law_.friction = friction; }
    void set_lid(const std::optional<Lid>& lid);
    [[nodiscard]] const std::optional<Lid>& lid() const { return lid_; }
    void resize(const shapes::Vec3& size_m);
    [[nodiscard]] double pressure() const;
    [[nodiscard]] WallLoads wall_loads() const;
    [[nodiscard]] packing::Body pose(std::size_t body) const;
    [[nodiscard]] shapes::Vec3 angular_velocity(std::size_t body) const;
    [[nodiscard]] std::size_t sleeping() const;
    [[nodiscard]] DemEnergy energy() const;
    [[nodiscard]] DemRest rest() const;
    [[nodiscard]] Packing packing() const;
    [[nodiscard]] const vessels::Container& container() const { return container_; }
    [[nodiscard]] std::size_t watched_pairs() const;
    void save(std::ostream& out) const;
    void load(std::istream& in, const std::string& where);

    [[nodiscard]] const std::vector<BodyState>& bodies() const { return bodies_; }
    [[nodiscard]] const std::vector<Kind>& kinds() const { return kinds_; }
    [[nodiscard]] double time() const { return time_; }
    [[nodiscard]] long steps() const { return steps_; }
    [[nodiscard]] std::size_t looked_at() const { return looked_at_; }

private:
    // capsule_dem.cpp: set-up
    /// Planes first, then round ones, then the mesh, then the lid.
    [[nodiscard]] std::size_t wall_count() const { return lid_wall() + 1; }
    [[nodiscard]] std::size_t mesh_wall() const { return vessel_walls_.planes.size() + vessel_walls_.round.size(); }
    [[nodiscard]] std::size_t lid_wall() const { return mesh_wall() + (vessel_walls_.mesh != nullptr ? 1 : 0); }
    [[nodiscard]] geometry::VesselWalls::Plane lid_plane() const { return {-shapes::Vec3::UnitZ(), -lid_->height_m}; }
    /// Places for tangential displacements: of each node, piece and arm at each wall.
    [[nodiscard]] std::size_t wall_histories(const Kind& kind) const {
        return (kind.nodes.size() + kind.pieces.size() + (vessel_walls_.convex() ? 0 : kind.arms.size())) * wall_count();
    }
    [[nodiscard]] static Kind make_kind(const shapes::Shape& shape, double density_kg_per_m3);
    void make_pieces();
    void make_cells();
    void sort_into_cells();
    void make_walls();
    [[nodiscard]] shapes::Vec3 omega_of(const BodyState& body, const shapes::Quaternion& q, const shapes::Vec3& momentum) const;
    [[nodiscard]] shapes::Vec3 image_shift(const shapes::Vec3& between) const;
    void place_arms(std::size_t body);

    // capsule_motion.cpp
    void advance(BodyState& body);
    void finish(BodyState& body);
    void gather(BodyState& body, std::size_t i) const;
    void move_lid(bool first_half);
    void fall_asleep_or_wake();

    // capsule_neighbours.cpp
    [[nodiscard]] long cell_of(const shapes::Vec3& place) const;
    void search();
    void search_one(std::size_t body);
    void move_to_cell(std::size_t body, long cell);
    void add_pairs(std::size_t body, std::size_t other);
    void list_neighbours(std::size_t body);

    // capsule_contacts.cpp
    void forces(double displacement_time);
    void find_contacts(std::size_t body, std::vector<Contact>& contacts) const;
    [[nodiscard]] bool rests_among_sleepers(std::size_t body) const;
    void check_pairs(std::size_t body, std::vector<Contact>& contacts, std::size_t& looked_at);
    template <typename Pair, typename Touches, typename Apart>
    void look_at(std::size_t body, std::vector<Pair>& list, std::size_t& looked_at, const Touches& touches, const Apart& apart);
    [[nodiscard]] bool contact_of(std::size_t body, std::size_t pair, Contact& contact, double& gap) const;
    static void share_stiffness(const std::vector<VerletPair>& pairs, std::vector<Contact>& contacts, double reach);
    using Accept = std::function<void(bool valid)>;  ///< throws UserError where it is not, or at the end of the file
    void load_run(std::istream& in, const Accept& accept);
    void load_body(std::istream& in, std::size_t body, const Accept& accept);
    void grain_forces(std::size_t body, std::vector<Load>& loads, std::size_t& looked_at, std::vector<Contact>& contacts);
    [[nodiscard]] bool is_new(std::int64_t last_contact, const BodyState& body, const BodyState& other) const;
    void watch_sleeper(std::size_t body, std::uint32_t other, shapes::Vec3& base_force, const shapes::Vec3& force);
    template <typename Pair>
    shapes::Vec3 press(std::size_t body, Pair& pair, const Contact& contact, std::vector<Load>& loads);
    void find_wall_contacts(std::size_t body, std::vector<WallContactPoint>& found) const;
    void find_arm_wall_contacts(std::size_t body, std::size_t round, std::vector<WallContactPoint>& found) const;
    void wall_forces(std::size_t body, std::vector<Load>& loads, WallLoads& sums);
    [[nodiscard]] double elastic_force(double overlap, double share) const { return share * 0.5 * law_.normal_stiffness_N_per_m * overlap; }
    [[nodiscard]] shapes::Vec3 contact_force(const Approach& approach, shapes::Vec3& displacement, bool first) const;

    // faced_contacts.cpp: grains with faces
    [[nodiscard]] bool is_faced(std::size_t body, std::size_t other) const;
    [[nodiscard]] bool has_faces(const BodyState& body) const { return shapes_[body.kind].body != nullptr; }
    void add_piece_pairs(std::size_t body, std::size_t other, const shapes::Vec3& shift);
    [[nodiscard]] bool piece_contact_of(std::size_t body, std::size_t pair, Contact& contact, PieceContact& part, double& gap) const;
    void check_piece_pairs(std::size_t body, std::vector<Contact>& contacts, std::size_t& looked_at);
    void find_piece_contacts(std::size_t body, std::vector<Contact>& contacts) const;
    void watch_sleeping_neighbours(std::size_t body, const std::vector<Contact>& contacts, const std::vector<shapes::Vec3>& forces);
    void require_no_crossing();
    void share_potential(std::size_t body, const std::vector<PieceContact>& parts, std::vector<Contact>& contacts) const;
    void find_piece_wall_contacts(std::size_t body, std::vector<WallContactPoint>& found) const;
    [[nodiscard]] bool is_near_mesh(std::size_t body) const;
    [[nodiscard]] WallContact& wall_contact(std::size_t body, const WallContactPoint& touch);

    // capsule_measures.cpp
    template <typename Visit>
    void for_contacts(const Visit& visit) const;
    [[nodiscard]] double wall_energy(std::size_t body, double elastic_J) const;

    vessels::Container container_;
    std::vector<shapes::Shape> shapes_;
    ContactLaw law_;
    DemOptions options_;
    std::vector<Kind> kinds_;
    std::vector<BodyState> bodies_;
    std::vector<WorldArm> arms_;
    std::vector<std::vector<VerletPair>> verlet_lists_;  // by the body of lower number
    bool faced_ = false;                                 // some grain has faces, or the vessel's wall is a mesh
    std::vector<std::vector<PiecePair>> piece_pairs_;    // by the body of lower number; used if so
    std::vector<Frame> frames_;                          // likewise
    std::array<std::vector<shapes::Vec3>, load_slots> piece_forces_;
    std::array<std::array<std::size_t, 3>, load_slots> too_deep_{};  // {found, body, other}
    std::vector<std::vector<std::uint32_t>> neighbours_;             // the other bodies of each list, once
    std::vector<WallContact> walls_;                                 // by body, then by node, piece or arm, and wall
    std::vector<std::vector<RimContact>> rim_contacts_;              // by body; used between walls of a mesh
    mutable std::vector<NearMesh> near_mesh_;                        // likewise
    std::vector<std::vector<Load>> loads_;                           // by load slot
    std::vector<std::vector<std::uint32_t>> cells_;
    std::vector<long> cell_of_body_;
    std::array<long, 3> cell_count_{};
    shapes::Vec3 cell_low_ = shapes::Vec3::Zero();
    double cell_size_ = 1.0, skin_ = 0.0, widest_ = 0.0;  // the last: largest radius of a grain
    geometry::VesselWalls vessel_walls_;                  // the floor, then the vessel's
    bool has_floor_ = false;
    std::optional<Lid> lid_;
    std::array<WallLoads, load_slots> wall_sums_{};             // by load slot
    std::array<double, load_slots> virial_{};                   // likewise
    std::array<std::vector<std::uint32_t>, load_slots> woken_;  // by load slot
    double time_ = 0.0, displacement_time_ = 0.0;
    long steps_ = 0;
    std::size_t looked_at_ = 0, sleepers_ = 0;
    ThreadChoice threads_;
    bool primed_ = false;  // forces of the current state are known
};

// Looks at those pairs of a body's list that may touch by now, and removes those that have separated. `touches` (number, gap) adds a
// contact; `apart` (pair) is told of a pair that does not touch.
template <typename Pair, typename Touches, typename Apart>
void CapsuleDem::State::look_at(std::size_t i, std::vector<Pair>& list, std::size_t& looked_at, const Touches& touches,
                                const Apart& apart) {
    const BodyState& body = bodies_[i];
    const std::size_t before = list.size();
    for (std::size_t n = 0; n < list.size();) {
        Pair& pair = list[n];
        const BodyState& other = bodies_[pair.other];
        if (body.travelled + other.travelled < pair.out_of_reach || (body.asleep != 0 && other.asleep != 0)) {
            ++n;
            continue;
        }
        ++looked_at;
        double gap = 0.0;
        if (!touches(n, gap)) {
            if (gap > 2.0 * skin_) {
                pair = list.back();
                list.pop_back();
                continue;
            }
            pair.out_of_reach = body.travelled + other.travelled + gap;
            apart(pair);
        }
        ++n;
    }
    if (list.size() < before) list_neighbours(i);
}

}  // namespace porepack::pouring::dem
