// The shapes among which `porepack design` chooses.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "design/surrogate.hpp"

namespace porepack::design {

/// A grain of the volume of a sphere with diameter 1.
struct Candidate {
    std::string family;         ///< "tetrapod", or the file of a user's shape
    shapes::ShapeConfig shape;  ///< sizes in units of d_v
    GrainForm form;
    std::vector<double> parameters;  ///< length (or height) / diameter of a preset; values of the free parameters of a user's shape
};

/// A parameter of a user's shape. Of a union of capsules: "radius_m" of all capsules, "capsule.2.radius_m" (numbers from 1), or
/// "capsule.2.length_m", which moves the capsule's end b along its axis. Of a grain with faces: the key of a size, such as
/// "inner_diameter_m" of a ring.
struct FreeParameter {
    std::string name;
    double low = 0.0, high = 0.0;
};
/// "capsule.2.radius_m=0.001,0.002". Throws UserError for any other form.
[[nodiscard]] FreeParameter parse_free_parameter(const std::string& text);

/// Grains of a preset for length / diameter from 0.02 to 12 (height / diameter of a cylinder) whose sphericity is within `sphericity`; a
/// sphere and a cube are one grain each.
[[nodiscard]] std::vector<Candidate> preset_candidates(shapes::ShapeKind kind, const core::Interval& sphericity, long arms = 6);

/// A user's shape with all combinations of the free parameters: about 100 grains, those left out that are no valid shape. Throws UserError
/// when a parameter does not exist or no grain is left.
[[nodiscard]] std::vector<Candidate> own_candidates(const std::string& family, const shapes::ShapeConfig& shape,
                                                    const std::vector<FreeParameter>& free);

/// The same grain with the equal-volume diameter `size_m`.
[[nodiscard]] shapes::ShapeConfig scaled(const shapes::ShapeConfig& shape, double size_m);

}  // namespace porepack::design
