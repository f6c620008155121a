// Table [shape] of case.toml: one shape, or a mixture of several.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "record/config.hpp"
#include "shapes/shape.hpp"

namespace porepack::shapes {

/// What is the same for every stone of a library: its part in the number of grains, or in their volume.
enum class LibraryBy { number, volume };
constexpr std::array<core::Choice<LibraryBy>, 2> choices_of(LibraryBy) {
    return {{{LibraryBy::number, "number"}, {LibraryBy::volume, "volume"}}};
}

struct ShapeConfig {
    ShapeKind kind = ShapeKind::tetrapod;
    double sphericity = 0.0;
    double volume_m3 = 0.0;
    double diameter_m = 0.0;
    double length_m = 0.0;
    Cavity cavity = Cavity::filled;
    std::string file = {};
    double unit_m = 0.0;  ///< 0: metres
    long arms = 6;
    bool disconnected = false;
    std::vector<Capsule> capsule = {};
    // Of grains with faces; 0 and empty lists: not given.
    double height_m = 0.0, inner_diameter_m = 0.0, lobe_diameter_m = 0.0, side_m = 0.0, rounding_m = 0.0;
    std::vector<double> size_m = {};
    long sides = 0, lobes = 0;
    // Of a mesh, or a library of meshes.
    std::string folder = {};
    LibraryBy library_by = LibraryBy::number;
    long faces = 0;
    double deviation_m = 0.0;
    std::shared_ptr<const RoundedBody> from_file = nullptr;  ///< not a key: what the file holds, as soon as it is read
    std::vector<ShapeConfig> component = {};
    double number_fraction = 0.0;
};

/// Of kind "surface".
[[nodiscard]] inline double surface_unit_m(const ShapeConfig& config) {
    return config.unit_m > 0.0 ? config.unit_m : 1.0;
}

/// Lists the keys.
void describe(record::ConfigVisitor& v, ShapeConfig& c);

/// The sizes of one number each, by their keys.
struct SizeKey {
    const char* name;
    double ShapeConfig::*size;
};
inline constexpr std::array<SizeKey, 7> size_keys = {{{"diameter_m", &ShapeConfig::diameter_m},
                                                      {"length_m", &ShapeConfig::length_m},
                                                      {"height_m", &ShapeConfig::height_m},
                                                      {"inner_diameter_m", &ShapeConfig::inner_diameter_m},
                                                      {"lobe_diameter_m", &ShapeConfig::lobe_diameter_m},
                                                      {"side_m", &ShapeConfig::side_m},
                                                      {"rounding_m", &ShapeConfig::rounding_m}}};

/// The shape with its cavities. Throws UserError when the keys do not determine a shape, or overdetermine it, or a mesh has not been read.
[[nodiscard]] Shape make_shape(const ShapeConfig& config);

/// Of a grain with faces, if its rounding is not given: the radius over the diameter of the sphere of the same volume.
inline constexpr double default_rounding = 0.02;

/// cylinder, ring, box, cube, lobed or prism.
[[nodiscard]] bool has_faces(ShapeKind kind);
/// A grain with faces. `body` has the volume of the grain with sharp edges and the given sizes.
struct FacedGrain {
    std::shared_ptr<const RoundedBody> body;
    double scale = 1.0;  ///< of the given sizes, which keeps that volume
    double sharp_area_m2 = 0.0, sharp_sphericity = 0.0;
};
/// Throws UserError when the keys do not determine it, or overdetermine it. By sphericity and volume: the higher one of two.
[[nodiscard]] FacedGrain make_faced(const ShapeConfig& config);
/// Throws UserError for a key of sizes: the shape is in a file. `allowed`: the keys that it has.
void refuse_sizes(const ShapeConfig& config, const std::string& allowed);
/// Throws UserError for a key that a mesh does not have, or if the unit of its file is missing.
void require_mesh_keys(const ShapeConfig& config);
/// Throws UserError for a key that a library does not have, or if its folder or the unit of its files is missing.
void require_library_keys(const ShapeConfig& config);
/// Throws UserError for a key that only grains with faces have.
void refuse_keys_of_faces(const ShapeConfig& config);

/// A mixture's shapes with their number fractions (sum 1); a single shape has the number fraction 1.
struct ShapeShare {
    Shape shape;
    double number_fraction = 1.0;
};
[[nodiscard]] std::vector<ShapeShare> make_shapes(const ShapeConfig& config);

}  // namespace porepack::shapes
