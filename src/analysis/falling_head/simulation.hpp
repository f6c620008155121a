// A falling-head test, simulated; and the correlations beside it.
#pragma once

#include <optional>

#include "analysis/outcome.hpp"
#include "falling_head/config.hpp"
#include "results/falling_head.hpp"
#include "results/shape.hpp"

namespace porepack::analysis {

/// Times by Eq. 18 and by the full equation; `with_curve`: the table falling_head.csv. Throws UserError where a time is not finite.
[[nodiscard]] Outcome<results::FallingHead> simulate_falling_head(double permeability_m2, double inertial_permeability_m,
                                                                  const falling_head::FallingHeadConfig& config, bool with_curve);

/// m of a sample: tortuosity factor / porosity, or porosity^-1.5 without one (Bruggeman).
[[nodiscard]] double estimated_inertia_coefficient(double porosity, std::optional<double> tortuosity_factor);

struct GrainForm {
    double sphericity, equal_volume_diameter_m, volume_m3;
};
/// None of a surface of several bodies.
[[nodiscard]] std::optional<GrainForm> grain_form(const results::Shape& shape);
[[nodiscard]] results::Correlations correlations_of(const std::optional<GrainForm>& grain, double porosity);

}  // namespace porepack::analysis
