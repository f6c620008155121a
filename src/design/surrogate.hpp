// Porosity and permeability of a bed that has not been poured, from beds that have: what `porepack design` chooses its proposals by.
#pragma once

#include <string>
#include <vector>

#include "design/gaussian_process.hpp"
#include "design/scatter.hpp"
#include "packing/packing.hpp"
#include "shapes/shape.hpp"
#include "study/study.hpp"

namespace porepack::design {

/// The measures of a grain that do not depend on its size; d_v: diameter of the sphere of its volume.
struct GrainForm {
    double sphericity = 0.0;
    double convexity = 0.0;
    double thickness = 0.0;  ///< smallest capsule diameter / d_v
    double feret = 0.0;      ///< maximum Feret diameter / d_v
};

/// A bed that has been poured and solved; values are means over its packings.
struct KnownBed {
    std::string name;
    GrainForm form;
    double wall = 0.0;  ///< d_v / diameter of the container
    long packings = 1;
    double porosity = 0.0;
    double permeability = 0.0;            ///< k / d_v^2
    double porosity_deviation = 0.0;      ///< standard deviation between its packings; 0 for one packing
    double permeability_deviation = 0.0;  ///< the same of k, relative
};

/// d_v / D, with D the container's diameter, or 4 area / perimeter of the sides of a box that are walls; 0 where no side is a wall.
[[nodiscard]] double wall_ratio(double equal_volume_diameter_m, const vessels::Container& container);

/// Those of the study's table, of any version. Throws UserError when none has all columns that are needed.
[[nodiscard]] std::vector<KnownBed> known_beds(const study::Study& study);

/// Scatter of k (relative) and of the porosity between packings.
[[nodiscard]] ScatterOfBeds permeability_scatter(const std::vector<KnownBed>& beds);
[[nodiscard]] ScatterOfBeds porosity_scatter(const std::vector<KnownBed>& beds);

/// Of the mean of some packings of a bed. The standard deviations contain the scatter of such means.
struct Prediction {
    Estimate porosity;
    Estimate log_permeability;  ///< ln(k / d_v^2)
    bool extrapolated = false;  ///< a measure of the grain, or the wall ratio, lies outside the beds that are known
};

/// Two Gaussian processes over (sphericity, convexity, thickness, feret, wall): of the porosity, and of the logarithm of the Kozeny
/// constant eps^3 / (k S^2), with S the grains' surface per volume of the bed. The Kozeny constant changes little from shape to shape,
/// so that k follows from the porosity and the exact surface.
class Surrogate {
public:
    /// Beds of spheres in tubes are looser by 0.2 to 0.4 per d_v/D (Dixon 1988, Can. J. Chem. Eng. 66, 705, at d_v/D of 0.2 and 0.4).
    /// Where no bed of such a d_v/D is known, this part of the porosity is uncertain.
    static constexpr double porosity_per_wall = 0.3;
    /// Of ln k, for a small change of the porosity.
    [[nodiscard]] static double log_permeability_per_porosity(double porosity) { return 3.0 / porosity + 2.0 / (1.0 - porosity); }

    /// Needs two beds or more.
    explicit Surrogate(const std::vector<KnownBed>& beds);
    [[nodiscard]] Prediction at(const GrainForm& form, double wall) const;
    /// Of bed i from all others.
    [[nodiscard]] Prediction leave_one_out(std::size_t i) const;

private:
    [[nodiscard]] Prediction combined(const Estimate& porosity, const Estimate& log_kozeny, double sphericity) const;

    std::vector<KnownBed> beds_;
    Eigen::VectorXd low_, high_;  // of the coordinates of the known beds
    GaussianProcess porosity_, log_kozeny_;
};

}  // namespace porepack::design
