// Table [section] of case.toml.
#pragma once

#include <array>

#include "core/choice.hpp"
#include "record/config.hpp"

namespace porepack::pore_space {

/// Where the pressure is constant, and which part of the flow gives the permeability.
enum class Ends {
    in_situ,  ///< on planes one buffer beyond the section; k from the flow inside the section
    planes,   ///< on the planes of the section, which cut grains
    paper     ///< inlet and outlet of the paper, behind reservoirs
};
constexpr std::array<core::Choice<Ends>, 4> choices_of(Ends) {
    return {{{Ends::in_situ, "in_situ"}, {Ends::planes, "planes"}, {Ends::paper, "paper"}, {Ends::planes, "pressure"}}};
}

/// Meaning, unit, range and default of each key: see describe(). 0 means "chosen automatically".
struct SectionConfig {
    Ends ends = Ends::in_situ;
    double buffer_m = 0.0;
};

inline void describe(record::ConfigVisitor& v, SectionConfig& c) {
    v.moved_here("lbm", "ends");
    v.choice(
        "ends", c.ends,
        "in_situ: the flow is computed in the section and a buffer beyond each of its planes, and k is that of the section inside this "
        "flow; planes (or pressure): constant pressure on the planes of the section, which cut grains, so k is too high; paper: as in "
        "the paper, Poiseuille profile of the tube at the first plane (needs a reservoir), constant pressure and zero gradient of the "
        "normal velocity at the second plane (lattice Boltzmann only)");
    v.number("buffer_m", c.buffer_m, record::length_range_or_auto(),
             "in_situ: length of the bed beyond each plane of the section in which the flow is computed too; auto: 1.5 diameters of the "
             "sphere with the mean volume of a grain, at most half the width of the container. It ends where "
             "the bed ends");
}

}  // namespace porepack::pore_space
