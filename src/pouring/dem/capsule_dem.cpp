// Set-up (grain shapes, cells, walls) and the public interface.
#include "pouring/dem/capsule_dem.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {

CapsuleDem::State::State(const Container& container, const std::vector<Shape>& shapes, double density_kg_per_m3, const ContactLaw& law,
                         const DemOptions& options)
    : container_(container), shapes_(shapes), law_(law), options_(options), loads_(load_slots) {
    double finest = 1e300;
    for (const Shape& shape : shapes) {
        kinds_.push_back(make_kind(shape, density_kg_per_m3));
        widest_ = std::max(widest_, kinds_.back().radius);
        finest = std::min(finest, kinds_.back().diameter);
        faced_ = faced_ || shape.body != nullptr;
    }
    make_walls();
    faced_ = faced_ || vessel_walls_.mesh != nullptr;
    if (faced_) make_pieces();
    skin_ = options.skin_m > 0.0 ? options.skin_m : 0.25 * finest;
    make_cells();
}

void CapsuleDem::State::make_pieces() {
    std::vector<std::vector<ContactPiece>> pieces = pieces_of(shapes_);
    for (std::size_t k = 0; k < kinds_.size(); ++k) {
        Kind& kind = kinds_[k];
        kind.convex = is_convex(shapes_[k]);
        kind.pieces = std::move(pieces[k]);
        kind.round = std::any_of(kind.pieces.begin(), kind.pieces.end(),
                                 [](const ContactPiece& piece) { return piece.kind == ContactPiece::Kind::axis; });
        if (kind.pieces.size() > 65535)
            throw UserError(fmt::format("shape `{}` has {} corners and edges", shapes_[k].id, kind.pieces.size()),
                            {.allowed = "65535; fewer where the smallest grain is not much smaller than the largest"});
    }
}

CapsuleDem::State::Kind CapsuleDem::State::make_kind(const Shape& shape, double density_kg_per_m3) {
    Kind kind{.body = grain_body(shape, density_kg_per_m3), .arms = {}, .nodes = {}};
    kind.diameter = smallest_diameter(shape);
    const Vec3& inertia = kind.body.inertia_kg_m2;
    // With three equal moments the angular velocity is parallel to the angular momentum, whatever the rotation. Differences by rounding are
    // removed.
    kind.isotropic = inertia.maxCoeff() - inertia.minCoeff() < 1e-6 * inertia.maxCoeff();
    if (kind.isotropic) kind.body.inertia_kg_m2.setConstant(inertia.mean());
    for (const Capsule& capsule : shape.capsules) {
        const Vec3 a = kind.body.turn.conjugate() * (capsule.a - kind.body.centre_m),
                   b = kind.body.turn.conjugate() * (capsule.b - kind.body.centre_m);
        kind.arms.push_back({.start = a, .along = b - a, .radius = capsule.radius});
        kind.radius = std::max(kind.radius, std::max(a.norm(), b.norm()) + capsule.radius);
    }
    if (shape.body != nullptr) kind.radius = shape.body->reach_from(kind.body.centre_m);
    // An end that lies on another arm's axis does not change the outline.
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
    return kind;
}

void CapsuleDem::State::make_cells() {
    // Grains whose gap is below twice the skin have centres at most this far apart: they lie in the same cell or in neighbouring ones.
    cell_size_ = 2.0 * widest_ + 2.0 * skin_;
    const Vec3 low = container_.low(), high = container_.high();
    cell_low_ = low;
    for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        // A pair keeps one periodic shift, so two images of a grain must not be near another grain at the same time.
        const double extent = high[axis] - low[axis];
        if (container_.periodic()[a] && extent < 4.0 * widest_ + 2.0 * skin_)
            throw UserError(
                fmt::format("the periodic box is {:g} m wide along axis {}, too narrow for grains of radius {:g} m", extent, axis, widest_),
                {.allowed = fmt::format("{:g} m or more, so that no two grains have two contacts", 4.0 * widest_ + 2.0 * skin_)});
        cell_count_[a] = std::clamp(static_cast<long>(extent / cell_size_), 1L, 400L);
    }
    cells_.assign(static_cast<std::size_t>(cell_count_[0] * cell_count_[1] * cell_count_[2]), {});
}

void CapsuleDem::State::sort_into_cells() {
    cell_of_body_.assign(bodies_.size(), -1);
    for (std::size_t i = 0; i < bodies_.size(); ++i) move_to_cell(i, cell_of(bodies_[i].x));
}

void CapsuleDem::State::make_walls() {
    const std::optional<VesselWalls> walls = container_.vessel().walls();
    if (!walls) throw UserError("grains cannot be poured into this vessel: its walls are not known", {.where = text_of(container_)});
    vessel_walls_ = *walls;
    has_floor_ = !container_.periodic()[2] && !container_.cut_ends();
    if (has_floor_) vessel_walls_.planes.insert(vessel_walls_.planes.begin(), {Vec3::UnitZ(), container_.low().z()});
}

void CapsuleDem::State::add(std::size_t shape, const Vec3& position_m, const Quaternion& orientation, const Vec3& velocity,
                            const Vec3& angular_velocity) {
    const Kind& kind = kinds_[shape];
    BodyState body;
    body.kind = static_cast<std::uint32_t>(shape);
    body.q = (orientation * kind.body.turn).normalized();
    body.x = position_m + orientation * kind.body.centre_m;
    body.v = body.v_contact = velocity;
    body.omega = angular_velocity;
    // The inertia is constant in the body's frame alone: into this frame, times inertia, and back.
    body.momentum = body.q * (kind.body.inertia_kg_m2.cwiseProduct(body.q.conjugate() * angular_velocity));
    body.force = Vec3::Zero();
    body.first_arm = static_cast<std::uint32_t>(arms_.size());
    body.first_wall = static_cast<std::uint32_t>(walls_.size());
    arms_.resize(arms_.size() + kind.arms.size());
    walls_.resize(walls_.size() + wall_histories(kind));
    bodies_.push_back(body);
    verlet_lists_.emplace_back();
    neighbours_.emplace_back();
    if (faced_) {
        piece_pairs_.emplace_back();
        frames_.emplace_back();
        rim_contacts_.emplace_back();
        near_mesh_.emplace_back();
    }
    cell_of_body_.push_back(-1);
    place_arms(bodies_.size() - 1);
    primed_ = false;
}

Vec3 CapsuleDem::State::omega_of(const BodyState& body, const Quaternion& q, const Vec3& momentum) const {
    const Kind& kind = kinds_[body.kind];
    if (kind.isotropic) return momentum / kind.body.inertia_kg_m2.x();
    return q * (q.conjugate() * momentum).cwiseQuotient(kind.body.inertia_kg_m2);
}

Vec3 CapsuleDem::State::angular_velocity(std::size_t body) const {
    return omega_of(bodies_[body], bodies_[body].q, bodies_[body].momentum);
}

Body CapsuleDem::State::pose(std::size_t body) const {
    const BodyState& state = bodies_[body];
    const GrainBody& grain = kinds_[state.kind].body;
    Body pose{.shape = state.kind};
    pose.orientation = (state.q * grain.turn.conjugate()).normalized();
    pose.position_m = state.x - pose.orientation * grain.centre_m;
    for (int axis = 0; axis < 3; ++axis)
        if (container_.periodic()[static_cast<std::size_t>(axis)])
            pose.position_m[axis] -= container_.size()[axis] * std::floor(pose.position_m[axis] / container_.size()[axis]);
    return pose;
}

Packing CapsuleDem::State::packing() const {
    Packing packing{.container = container_, .shapes = shapes_, .bodies = {}};
    for (std::size_t i = 0; i < bodies_.size(); ++i) packing.bodies.push_back(pose(i));
    return packing;
}

Vec3 CapsuleDem::State::image_shift(const Vec3& between) const {
    Vec3 shift = Vec3::Zero();
    for (int axis = 0; axis < 3; ++axis)
        if (container_.periodic()[static_cast<std::size_t>(axis)])
            shift[axis] = -container_.size()[axis] * std::round(between[axis] / container_.size()[axis]);
    return shift;
}

void CapsuleDem::State::place_arms(std::size_t index) {
    const BodyState& body = bodies_[index];
    const Eigen::Matrix3d turn = body.q.toRotationMatrix();
    const Kind& kind = kinds_[body.kind];
    for (std::size_t a = 0; a < kind.arms.size(); ++a)
        arms_[body.first_arm + a] = {body.x + turn * kind.arms[a].start, turn * kind.arms[a].along};
    if (!faced_) return;
    Frame& frame = frames_[index];
    frame.turn = turn * kind.body.turn.conjugate().toRotationMatrix();
    frame.origin = body.x - frame.turn * kind.body.centre_m;
}

std::size_t CapsuleDem::State::sleeping() const {
    return static_cast<std::size_t>(std::count_if(bodies_.begin(), bodies_.end(), [](const BodyState& body) { return body.asleep != 0; }));
}

std::size_t CapsuleDem::State::watched_pairs() const {
    std::size_t count = 0;
    for (const auto& list : verlet_lists_) count += list.size();
    for (const auto& list : piece_pairs_) count += list.size();
    return count;
}

CapsuleDem::CapsuleDem(const Container& container, const std::vector<Shape>& shapes, double density_kg_per_m3, const ContactLaw& law,
                       const DemOptions& options)
    : state_(std::make_unique<State>(container, shapes, density_kg_per_m3, law, options)) {}
CapsuleDem::~CapsuleDem() = default;
CapsuleDem::CapsuleDem(CapsuleDem&&) noexcept = default;
CapsuleDem& CapsuleDem::operator=(CapsuleDem&&) noexcept = default;

void CapsuleDem::add(std::size_t shape, const Vec3& position_m, const Quaternion& orientation, const Vec3& velocity,
                     const Vec3& angular_velocity) {
    state_->add(shape, position_m, orientation, velocity, angular_velocity);
}
void CapsuleDem::hold(std::size_t body) {
    state_->hold(body);
}
void CapsuleDem::stop() {
    state_->stop();
}
void CapsuleDem::step(long steps) {
    state_->step(steps);
}
void CapsuleDem::wake_all() {
    state_->wake_all();
}
void CapsuleDem::set_sleep(bool sleep) {
    state_->set_sleep(sleep);
}
void CapsuleDem::set_gravity(const Vec3& gravity_m_per_s2) {
    state_->set_gravity(gravity_m_per_s2);
}
void CapsuleDem::push(const Vec3& velocity_m_per_s) {
    state_->push(velocity_m_per_s);
}
void CapsuleDem::set_friction(double friction) {
    state_->set_friction(friction);
}
void CapsuleDem::set_lid(const std::optional<Lid>& lid) {
    state_->set_lid(lid);
}
const std::optional<Lid>& CapsuleDem::lid() const {
    return state_->lid();
}
void CapsuleDem::resize(const Vec3& size_m) {
    state_->resize(size_m);
}
double CapsuleDem::pressure_Pa() const {
    return state_->pressure();
}
WallLoads CapsuleDem::wall_loads() const {
    return state_->wall_loads();
}
std::size_t CapsuleDem::size() const {
    return state_->bodies().size();
}
double CapsuleDem::time_s() const {
    return state_->time();
}
long CapsuleDem::steps() const {
    return state_->steps();
}
Body CapsuleDem::pose(std::size_t body) const {
    return state_->pose(body);
}
const Vec3& CapsuleDem::centre_of_mass(std::size_t body) const {
    return state_->bodies()[body].x;
}
const Vec3& CapsuleDem::velocity(std::size_t body) const {
    return state_->bodies()[body].v;
}
Vec3 CapsuleDem::angular_velocity(std::size_t body) const {
    return state_->angular_velocity(body);
}
const Vec3& CapsuleDem::angular_momentum(std::size_t body) const {
    return state_->bodies()[body].momentum;
}
const GrainBody& CapsuleDem::grain(std::size_t shape) const {
    return state_->kinds()[shape].body;
}
std::size_t CapsuleDem::sleeping() const {
    return state_->sleeping();
}
DemEnergy CapsuleDem::energy() const {
    return state_->energy();
}
DemRest CapsuleDem::rest() const {
    return state_->rest();
}
Packing CapsuleDem::packing() const {
    return state_->packing();
}
const Container& CapsuleDem::container() const {
    return state_->container();
}
std::size_t CapsuleDem::watched_pairs() const {
    return state_->watched_pairs();
}
std::size_t CapsuleDem::looked_at() const {
    return state_->looked_at();
}
void CapsuleDem::save(std::ostream& out) const {
    state_->save(out);
}
void CapsuleDem::load(std::istream& in, const std::string& where) {
    state_->load(in, where);
}

}  // namespace porepack::pouring::dem
