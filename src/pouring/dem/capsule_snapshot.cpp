// Snapshots: write and read the whole state.
#include <istream>
#include <ostream>

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
    const auto refuse = [&] {
        throw UserError("this snapshot is cut short or of another run", {.where = where, .fix = "remove it to start from the beginning"});
    };
    std::uint64_t mark = 0;
    std::size_t layout = 0, kinds = 0, count = 0;
    double step = 0.0;
    get(in, mark);
    get(in, layout);
    get(in, step);
    get(in, kinds);
    get(in, count);
    if (!in || mark != state_mark || layout != sizeof(BodyState) + sizeof(VerletPair) + sizeof(PiecePair) + sizeof(RimContact) ||
        step != options_.time_step_s || kinds != kinds_.size() || count > 100000000)
        refuse();
    get(in, time_);
    get(in, steps_);
    get(in, primed_);
    Vec3 size = container_.size();
    bool has_lid = false;
    Lid lid;
    get(in, size);
    get(in, has_lid);
    get(in, lid);
    if (!in || !size.allFinite() || !(size.minCoeff() > 0.0)) refuse();
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
    cell_of_body_.assign(count, -1);
    std::size_t arms = 0, walls = 0;
    for (std::size_t i = 0; i < count; ++i) {
        get(in, bodies_[i]);
        std::size_t pairs = 0;
        get(in, pairs);
        if (!in || bodies_[i].kind >= kinds_.size() || pairs > 1000000) refuse();
        verlet_lists_[i].resize(pairs);
        for (VerletPair& pair : verlet_lists_[i]) get(in, pair);
        if (faced_) {
            get(in, pairs);
            if (!in || pairs > 1000000) refuse();
            piece_pairs_[i].resize(pairs);
            for (PiecePair& pair : piece_pairs_[i]) {
                get(in, pair);
                if (!in || pair.other >= count) refuse();
            }
            get(in, pairs);
            if (!in || pairs > 1000000) refuse();
            rim_contacts_[i].resize(pairs);
            for (RimContact& rim : rim_contacts_[i]) get(in, rim);
        }
        arms += kinds_[bodies_[i].kind].arms.size();
        walls += wall_histories(kinds_[bodies_[i].kind]);
    }
    walls_.assign(walls, {});
    for (WallContact& contact : walls_) get(in, contact);
    for (std::size_t c = 0; c < cells_.size(); ++c) {
        std::size_t members = 0;
        get(in, members);
        if (!in || members > count) refuse();
        cells_[c].resize(members);
        for (std::uint32_t& body : cells_[c]) {
            get(in, body);
            if (body >= count) refuse();
            cell_of_body_[body] = static_cast<long>(c);
        }
    }
    mark = 0;
    get(in, mark);
    if (!in || mark != state_mark) refuse();
    neighbours_.assign(count, {});
    for (std::size_t i = 0; i < count; ++i) list_neighbours(i);
    arms_.assign(arms, {});
    for (std::size_t i = 0; i < count; ++i) {
        for (const PiecePair& pair : faced_ ? piece_pairs_[i] : std::vector<PiecePair>())
            if (pair.piece >= kinds_[bodies_[pair.own != 0 ? i : pair.other].kind].pieces.size()) refuse();
        place_arms(i);
    }
}

}  // namespace porepack::pouring::dem
