// How the gray values of a scan were read.
#pragma once

#include "core/members.hpp"

namespace porepack::scans {

/// What was done to the gray values, and what they tell; kept with the image as its note `gray`.
struct GrayNotes {
    double pore_level = 0.0, solid_level = 1.0;  ///< gray values
    double noise = 0.0;                          ///< standard deviation over contrast, before smoothing
    double smoothing_voxels = 0.0;
    double blur_voxels = 0.0;     ///< of the smoothed image; standard deviation of its point spread function
    double threshold = 0.0;       ///< gray value
    double level = 0.5;           ///< the threshold as a solid fraction
    double fraction_error = 0.0;  ///< standard error of the solid fraction, from the gray levels' errors
    double slope = 0.0;           ///< change of the solid fraction with the level
    bool levels_given = false;    ///< by the user, with a judged standard error of 0.002 of the contrast each
    bool keeps_volume = true;     ///< the level keeps the gray volume
    bool tube_removed = false;    ///< the wall of the container was visible and was subtracted
};
template <core::MembersOf<GrayNotes> Self, typename Visit>
void visit_members(Self& notes, const Visit& visit) {
    visit("pore_level", notes.pore_level);
    visit("solid_level", notes.solid_level);
    visit("noise", notes.noise);
    visit("smoothing_voxels", notes.smoothing_voxels);
    visit("blur_voxels", notes.blur_voxels);
    visit("threshold", notes.threshold);
    visit("level", notes.level);
    visit("solid_fraction_error", notes.fraction_error);
    visit("solid_fraction_per_level", notes.slope);
    visit("levels_given", notes.levels_given);
    visit("keeps_volume", notes.keeps_volume);
    visit("tube_removed", notes.tube_removed);
}

}  // namespace porepack::scans
