// A closed surface of a user, as a grain of few faces with rounded edges (CGAL).
#pragma once

#include <memory>
#include <string>

#include "io/stl.hpp"
#include "shapes/rounded_body.hpp"

namespace porepack::converters {

struct MeshGrainOptions {
    long faces = 80;           ///< wanted number of triangles
    double deviation_m = 0.0;  ///< instead: as few as keep every point of the surface within this distance; 0: `faces` decides
    double rounding_m = 0.0;   ///< radius of the rounded edges; 0: 2 % of the diameter of the sphere of the same volume
};

struct MeshGrain {
    std::shared_ptr<const shapes::RoundedBody> body = nullptr;  ///< its centre of mass lies at the origin
    geometry::TriangleSurface surface = {};                     ///< the one that was given, with its centre of mass at the origin
    long faces_before = 0, faces = 0;
    double volume_m3 = 0.0;  ///< of the surface, and of the body to its surface_error()
    double scale = 1.0;      ///< of the body, which gives it that volume
    double area_before_m2 = 0.0;
    double largest_deviation_m = 0.0, rms_deviation_m = 0.0;  ///< between the two surfaces, in both directions
};

/// The surface is simplified by collapsing edges (Lindstrom and Turk); then the corners are moved until the body with rounded edges fits
/// the surface best by least squares. Holes through the grain stay. Throws UserError, with `where`, where the surface is open, inverted,
/// crosses itself, has several parts, or where so few faces and so much rounding leave nothing like it.
[[nodiscard]] MeshGrain grain_from_mesh(const geometry::TriangleSurface& surface, const MeshGrainOptions& options,
                                        const std::string& where);

/// Throws UserError where a hole through the surface closes in the body: where its walls come nearer than twice the rounding.
void require_same_holes(const MeshGrain& grain, const std::string& where);

}  // namespace porepack::converters
