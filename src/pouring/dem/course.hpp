// How far the places of a contact piece are from another body's surface.
#pragma once

#include <array>
#include <cstddef>

#include "pouring/dem/piece_contact.hpp"
#include "pouring/dem/piece_rows.hpp"

namespace porepack::pouring::dem {

/// A place of a piece (0 to 1) and its distance from the surface.
struct Place {
    double s, distance;
};

/// A piece from one end to the other. Its turns are places between which the distance from the surface only rises or only falls (but for
/// a slope of 1e-5).
class Course {
public:
    /// Fifteen steps from place to place; along a step, there is one nearest place at most (pieces_of).
    Course(const ContactPiece& piece, const Surface& surface);
    [[nodiscard]] double bound() const { return bound_; }  ///< no place of the piece is nearer; closer after find_turns
    void find_turns();
    [[nodiscard]] std::size_t parts() const { return turn_count_ - 1; }
    [[nodiscard]] std::size_t turn(std::size_t n) const { return turns_[n]; }
    [[nodiscard]] const Place& operator[](std::size_t place) const { return places_[place]; }
    [[nodiscard]] const Place& nearest() const { return places_[nearest_]; }

private:
    static constexpr std::size_t samples = shapes::PointRow::most;
    static bool nearer(const Place& one, const Place& other) { return one.distance < other.distance; }
    void add(const Place& place) {
        if (count_ == 0 || place.distance < places_[nearest_].distance) nearest_ = count_;
        places_[count_++] = place;
    }

    const ContactPiece& piece_;
    const Surface& surface_;
    PlaceRow row_;
    shapes::DistanceRow found_;
    double bound_;
    std::array<Place, 2 * samples> places_;
    std::array<std::size_t, 2 * samples> turns_;  // numbers of places; the first and the last one are among them
    std::size_t count_ = 0, turn_count_ = 0, nearest_ = 0;
};

}  // namespace porepack::pouring::dem
