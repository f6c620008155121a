// The exposed surface of a union of capsules, meridian by meridian: the hidden parts are found to rounding accuracy.
// Only for the sources of this folder.
#pragma once

#include <cstdint>
#include <vector>

#include "core/interval.hpp"
#include "shapes/capsule.hpp"

namespace porepack::shapes {

struct SurfacePoint {
    Vec3 x, normal;
    double area_per_parameter;  ///< per unit of the meridian's parameter and of the angle phi
};

/// The three pieces of a meridian: half a cap at either end (parameter: the angle from the pole, 0 to pi/2) and the side
/// line (parameter: the length from a).
enum class Piece : std::uint8_t { cap_a, cap_b, side };

struct ExposedPart {
    Piece piece;
    double low, high;
    /// Where it ends: at a piece of another capsule, or at the meridian's own end. Equal tags on two meridians mean that
    /// the part changes smoothly between them.
    std::uint32_t low_tag, high_tag;
};

class ExposedSurface {
public:
    /// Capsules that lie in another one are left out; where two surfaces coincide, the place belongs to the first one.
    explicit ExposedSurface(const std::vector<Capsule>& capsules);
    [[nodiscard]] const std::vector<Capsule>& capsules() const { return capsules_; }
    /// Replaces `parts` by the exposed parts of the meridian at angle `phi` (radians) of capsule `own`.
    void meridian(std::size_t own, double phi, std::vector<ExposedPart>& parts) const;
    [[nodiscard]] SurfacePoint point(std::size_t own, double phi, Piece piece, double parameter) const;

private:
    struct Frame {
        Vec3 axis, e1, e2;
        double length;
    };
    struct Arc;
    void hide_arc(std::size_t own, std::size_t other, const Arc& arc, std::vector<core::Interval>& hidden) const;
    void hide_side(std::size_t own, std::size_t other, double phi, std::vector<core::Interval>& hidden) const;
    void add_parts(std::size_t own, double phi, Piece piece, double end, std::vector<core::Interval>& hidden,
                   std::vector<ExposedPart>& parts) const;
    [[nodiscard]] bool covers(std::size_t other, std::size_t own, const SurfacePoint& at) const;
    [[nodiscard]] std::uint32_t tag_at(std::size_t own, const Vec3& x) const;

    std::vector<Capsule> capsules_;
    std::vector<Frame> frames_;
    std::vector<std::vector<std::size_t>> near_;  // by capsule: the others that can hide part of it
};

}  // namespace porepack::shapes
