// The part of a bed that is evaluated, between two horizontal planes.
#pragma once

#include <array>
#include <vector>

#include "core/interval.hpp"
#include "packing/packing.hpp"

namespace porepack::packing {

/// The part of the bed that is evaluated, between two horizontal planes.
struct Section {
    double z0_m = 0.0;
    double z1_m = 0.0;
    [[nodiscard]] double length() const { return z1_m - z0_m; }
    [[nodiscard]] core::Interval interval() const { return {z0_m, z1_m}; }
};

/// The part of a packing between two planes, with cut ends and its floor at z = 0; grains that reach into it are kept whole.
[[nodiscard]] Packing cut_out(const Packing& packing, const Section& part);

struct SectionChoice {
    std::vector<double> section_m;  ///< z0, z1; empty: chosen from the bed
    double trim_m = 0.0;            ///< 0: the smaller of 30 mm and one grain's maximum Feret diameter
    bool bed_known = true;          ///< else `bed` is an estimate, and a section need not lie in it
};
/// The default is `bed` (lowest to highest point of the grains) without the trim at both ends; a container that is periodic along z is
/// used as a whole. Throws UserError with the bed's height when nothing is left.
[[nodiscard]] Section choose_section(const vessels::Container& container, const SectionChoice& choice, const Section& bed,
                                     double maximum_feret_diameter_m);

/// The bed, inside the container; the whole container if it is periodic along z.
[[nodiscard]] Section whole_bed(const vessels::Container& container, const Section& bed);
/// Periodic sides of the section; along z only when it is the whole box.
[[nodiscard]] std::array<bool, 3> periodic_sides(const vessels::Container& container, const Section& section);

}  // namespace porepack::packing
