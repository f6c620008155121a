// Snapshots: write and read the whole state.
#include <cstdint>
#include <istream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "pouring/dem/capsule_state.hpp"
#include "pouring/uses.hpp"

namespace porepack::pouring::dem {
namespace {

constexpr std::uint64_t state_mark = 0x32307374'61746570ULL;

template <typename Value>
void put(std::ostream& out, const Value& value) {
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename Value>
void get(std::istream& in, Value& value) {
    in.read(reinterpret_cast<char*>(&value), sizeof value);
}

template <typename Value, typename Accept>
void get_list(std::istream& in, std::vector<Value>& list, std::size_t most, const Accept& accept) {
    std::size_t size = 0;
    get(in, size);
    accept(size <= most);
    list.resize(size);
    for (Value& value : list) get(in, value);
}

}  // namespace

void CapsuleDem::State::save(std::ostream& out) const {
    put(out, state_mark);
    put(out, sizeof(BodyState) + sizeof(VerletPair) + sizeof(PiecePair) + sizeof(RimContact));
    put(out, options_.time_step_s);
    put(out, kinds_.size());
    put(out, bodies_.size());
    put(out, time_);
    put(out, steps_);
    put(out, primed_);
    put(out, container_.size());
    put(out, lid_.has_value());
    put(out, lid_.value_or(Lid{}));
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        put(out, bodies_[i]);
        put(out, verlet_lists_[i].size());
        for (const VerletPair& pair : verlet_lists_[i]) put(out, pair);
        if (!faced_) continue;
        put(out, piece_pairs_[i].size());
        for (const PiecePair& pair : piece_pairs_[i]) put(out, pair);
        put(out, rim_contacts_[i].size());
        for (const RimContact& rim : rim_contacts_[i]) put(out, rim);
    }
    for (const WallContact& contact : walls_) put(out, contact);
    for (const auto& cell : cells_) {  // their order determines the order of the pairs
        put(out, cell.size());
        for (const std::uint32_t body : cell) put(out, body);
    }
    put(out, state_mark);
}

void CapsuleDem::State::load(std::istream& in, const std::string& where) {
    const auto accept = [&](bool valid) {
        if (!in || !valid)
            throw UserError("this snapshot is cut short or of another run",
                            {.where = where, .fix = "remove it to start from the beginning"});
    };
    load_run(in, accept);
    for (std::size_t i = 0; i < bodies_.size(); ++i) load_body(in, i, accept);
    std::size_t arms = 0, walls = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Kind& kind = kinds_[bodies_[i].kind];
        accept(bodies_[i].first_arm == arms && bodies_[i].first_wall == walls);
        arms += kind.arms.size();
        walls += wall_histories(kind);
        for (const VerletPair& pair : verlet_lists_[i])
            accept(pair.arm < kind.arms.size() && pair.other_arm < kinds_[bodies_[pair.other].kind].arms.size());
        for (const PiecePair& pair : faced_ ? piece_pairs_[i] : std::vector<PiecePair>())
            accept(pair.piece < kinds_[bodies_[pair.own != 0 ? i : pair.other].kind].pieces.size());
    }
    walls_.assign(walls, {});
    for (WallContact& contact : walls_) get(in, contact);
    cell_of_body_.assign(bodies_.size(), -1);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        get_list(in, cells_[c], bodies_.size(), accept);
        for (const std::uint32_t body : cells_[c]) {
            accept(body < bodies_.size());
            cell_of_body_[body] = static_cast<long>(c);
        }
    }
    std::uint64_t mark = 0;
    get(in, mark);
    accept(mark == state_mark);
    neighbours_.assign(bodies_.size(), {});
    for (std::size_t i = 0; i < bodies_.size(); ++i) list_neighbours(i);
    arms_.assign(arms, {});
    for (std::size_t i = 0; i < bodies_.size(); ++i) place_arms(i);
}

// What is one of the whole run: time, container, lid, and the number of bodies.
void CapsuleDem::State::load_run(std::istream& in, const Accept& accept) {
    std::uint64_t mark = 0;
    std::size_t layout = 0, kinds = 0, count = 0;
    double step = 0.0;
    get(in, mark);
    get(in, layout);
    get(in, step);
    get(in, kinds);
    get(in, count);
    accept(mark == state_mark && layout == sizeof(BodyState) + sizeof(VerletPair) + sizeof(PiecePair) + sizeof(RimContact) &&
           step == options_.time_step_s && kinds == kinds_.size() && count <= 100000000);
    get(in, time_);
    get(in, steps_);
    get(in, primed_);
    Vec3 size = container_.size();
    bool has_lid = false;
    Lid lid;
    get(in, size);
    get(in, has_lid);
    get(in, lid);
    const Vec3 change = size.cwiseQuotient(container_.size());  // a step of the protocol may compress it
    accept(size.allFinite() && change.minCoeff() > 1e-3 && change.maxCoeff() < 1e3);
    if (size != container_.size()) {
        container_ = container_.resized(size);
        make_cells();
    }
    lid_ = has_lid ? std::optional(lid) : std::nullopt;
    bodies_.assign(count, {});
    verlet_lists_.assign(count, {});
    if (faced_) {
        piece_pairs_.assign(count, {});
        frames_.resize(count);
        rim_contacts_.assign(count, {});
        near_mesh_.assign(count, {});
    }
}

void CapsuleDem::State::load_body(std::istream& in, std::size_t i, const Accept& accept) {
    constexpr std::size_t most = 1000000;  // pairs of one body
    get(in, bodies_[i]);
    accept(bodies_[i].kind < kinds_.size());
    get_list(in, verlet_lists_[i], most, accept);
    for (const VerletPair& pair : verlet_lists_[i]) accept(pair.other < bodies_.size());
    if (!faced_) return;
    get_list(in, piece_pairs_[i], most, accept);
    for (const PiecePair& pair : piece_pairs_[i]) accept(pair.other < bodies_.size());
    get_list(in, rim_contacts_[i], most, accept);
}

}  // namespace porepack::pouring::dem
