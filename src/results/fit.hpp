// Grains found in a scan: `porepack image fit`, and the key `fit` of results/pack/result.json.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/interval.hpp"
#include "core/json.hpp"
#include "core/members.hpp"
#include "results/image.hpp"
#include "scans/estimate.hpp"

namespace porepack::results {

struct FittedGrains {
    std::size_t found = 0;
    long cut = 0;             ///< by an end of the image
    std::size_t dropped = 0;  ///< found, but they fit far worse than the others
};
template <core::MembersOf<FittedGrains> Self, typename Visit>
void visit_members(Self& grains, const Visit& visit) {
    visit("found", grains.found);
    visit("cut", grains.cut);
    visit("dropped", grains.dropped);
}

/// Sizes of all grains of one shape.
struct FittedSizes {
    scans::Estimate radius_change_m{0.0}, length_factor{1.0};
};
template <core::MembersOf<FittedSizes> Self, typename Visit>
void visit_members(Self& sizes, const Visit& visit) {
    visit("radius_change_m", sizes.radius_change_m);
    visit("length_factor", sizes.length_factor);
}

struct Fit {
    ImageFile file;
    core::OptionalKey<scans::GrayNotes> gray = {};
    core::Json container;                                          ///< as in packing.json
    core::OptionalKey<std::array<double, 3>> image_origin_m = {};  ///< lowest corner of the image's first voxel, in the packing's frame
    FittedGrains grains = {};
    core::ByName<FittedSizes> sizes;  ///< by shape
    double solid_change = 0.0;        ///< of the solid's volume by fitted sizes, relative
    scans::Estimate blur_m{0.0}, pores{0.0}, solid{1.0};
    double residual = 0.0, residual_median = 0.0;
    double noise = 0.0;
    std::optional<double> position_uncertainty_m{}, end_uncertainty_m{};  ///< medians of whole grains; none without one
    double unexplained_solid = 0.0, unexplained_solid_at_ends = 0.0, grain_without_solid = 0.0;
    std::optional<core::Interval> section_m{};  ///< between the planes that no piece at an end reaches
    std::optional<double> porosity{};           ///< of that section
    double largest_overlap_m = 0.0;
    long contacts = 0;
    std::vector<std::string> doubts;
    double search_s = 0.0, poses_s = 0.0;
    std::string meaning =
        "residual: root mean square of gray value against fitted value, over contrast, near the surfaces; position and end: median "
        "standard uncertainties of whole grains; unexplained: voxels of solid that no grain explains, over all voxels of solid; at ends: "
        "in pieces that reach the first or the last layer, of grains of which too little is shown; section: between the planes that none "
        "of these pieces reaches";
};
template <core::MembersOf<Fit> Self, typename Visit>
void visit_members(Self& fit, const Visit& visit) {
    visit("", fit.file);
    visit("gray", fit.gray);
    visit("container", fit.container);
    visit("image_origin_m", fit.image_origin_m);
    visit("grains", fit.grains);
    visit("sizes", fit.sizes);
    visit("solid_change", fit.solid_change);
    visit("blur_m", fit.blur_m);
    visit("pores", fit.pores);
    visit("solid", fit.solid);
    visit("residual", fit.residual);
    visit("residual_median", fit.residual_median);
    visit("noise", fit.noise);
    visit("position_uncertainty_m", fit.position_uncertainty_m);
    visit("end_uncertainty_m", fit.end_uncertainty_m);
    visit("unexplained_solid", fit.unexplained_solid);
    visit("unexplained_solid_at_ends", fit.unexplained_solid_at_ends);
    visit("grain_without_solid", fit.grain_without_solid);
    visit("section_m", fit.section_m);
    visit("porosity", fit.porosity);
    visit("largest_overlap_m", fit.largest_overlap_m);
    visit("contacts", fit.contacts);
    visit("doubts", fit.doubts);
    visit("search_s", fit.search_s);
    visit("poses_s", fit.poses_s);
    visit("meaning", fit.meaning);
}

}  // namespace porepack::results
