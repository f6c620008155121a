// Random packings on which the interval of k is calibrated and judged.
#pragma once

#include <string>

#include "pore_space/pore_space.hpp"

namespace porepack::benchmarks {

inline constexpr int random_beds = 100;

/// Spheres, tetrapods and rods of capsule diameter 4 mm, in cylinders, boxes, and boxes that are periodic in x, y and z, 8 to 9 diameters
/// wide; poured (grains in contact), placed without overlap, or overlapping (Boolean models); porosity 0.3 to 0.8.
struct RandomBed {
    std::string name;
    packing::Packing packing;
    double section_diameters;  ///< length of the section about the middle of the bed; 0: the whole periodic box
};
/// Bed `index` of random_beds. A pour works in `folder`.
/// `wide_diameters`: another width, with a section of twice the length.
[[nodiscard]] RandomBed random_bed(int index, const core::Path& folder, double wide_diameters = 0.0);

/// Volume of its solid in the section over the cube of the capsule diameter.
[[nodiscard]] double grains_of_random_bed(int index, double porosity);

/// Its pore space, on one of two positions of the grid: the grains of a cylinder are turned, those of a periodic box moved, and in a box
/// with walls the grids are 5 % finer.
[[nodiscard]] pore_space::PoreSpace pore_space_of(const RandomBed& bed, int position);

}  // namespace porepack::benchmarks
