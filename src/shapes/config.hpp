// Table [shape] of case.toml: one shape, or a mixture of several.
#pragma once

#include "record/config.hpp"
#include "shapes/shape.hpp"

namespace porepack::shapes {

struct ShapeConfig {
    ShapeKind kind = ShapeKind::tetrapod;
    double sphericity = 0.0;
    double volume_m3 = 0.0;
    double diameter_m = 0.0;
    double length_m = 0.0;
    Cavity cavity = Cavity::filled;
    std::string file = {};
    double unit_m = 1.0;
    long arms = 6;
    bool disconnected = false;
    std::vector<Capsule> capsule = {};
    std::vector<ShapeConfig> component = {};
    double number_fraction = 0.0;
};

/// Lists the keys.
void describe(record::ConfigVisitor& v, ShapeConfig& c);

/// The shape with its cavities. Throws UserError when the keys do not determine a shape, or overdetermine it.
[[nodiscard]] Shape make_shape(const ShapeConfig& config);

/// A mixture's shapes with their number fractions (sum 1); a single shape has the number fraction 1.
struct ShapeShare {
    Shape shape;
    double number_fraction = 1.0;
};
[[nodiscard]] std::vector<ShapeShare> make_shapes(const ShapeConfig& config);

}  // namespace porepack::shapes
