// How much k and the porosity of a section would scatter between places or beds, from the variation along the section.
#pragma once

#include <optional>
#include <span>

#include "core/interval.hpp"

namespace porepack::uncertainty {

struct SectionScatter {
    double relative = 0.0;         ///< standard deviation of k between sections of this length
    core::Interval interval = {};  ///< of 95 %; wide, because a section of a few diameters holds little information
    double section_m = 0.0;        ///< length
    double diameters = 0.0;        ///< the same in grain diameters
};

/// `gradient`: pressure gradient of layers of equal thickness over that of the section, which is their resistance over the mean one; in a
/// flow through the section, the resistances of layers add up. Its variogram g(l), half the mean square of the difference of two layers at
/// the distance l, does not depend on the unknown mean of the bed. Resistances further apart than one grain diameter `diameter_m` are
/// taken as independent, so that the mean of g between 1 and 2.5 diameters is the variance s^2 of a layer, and s^2 - g(l) the covariance
/// at shorter distances. The variance of the mean over the section follows by summation (the integral range of Kanit, Forest, Galliet,
/// Mounoury & Jeulin 2003, Int. J. Solids Struct. 40, in one dimension). None for sections shorter than 3.5 diameters or diameters of
/// fewer than four layers.
///
/// What all layers of one packing have in common is not seen. The variances from 30 beds of 5 diameters scattered like those of chi squared
/// with one degree of freedom per 2.5 diameters, which gives the interval.
[[nodiscard]] std::optional<SectionScatter> section_scatter(std::span<const double> gradient, double section_m, double diameter_m);

struct PorosityScatter {
    double deviation = 0.0;        ///< standard deviation of the porosity between sections of this length
    core::Interval interval = {};  ///< of 95 % for one section
};
/// The same from the porosities of layers, which also add up; distances from 1 to 2 diameters give the variance of a layer, and 2.5
/// diameters are enough. In a single short section the sum over short distances is often near 0 or negative by chance. The deviation is
/// therefore limited to 0.35 to 0.7 times that of independent layers of one diameter, where it lies between poured beds and between random
/// spheres without overlap; the interval is 0.2 to 1.25 times that value.
[[nodiscard]] std::optional<PorosityScatter> porosity_scatter(std::span<const double> layer_porosity, double section_m, double diameter_m);

}  // namespace porepack::uncertainty
