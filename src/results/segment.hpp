// A scan segmented into grains: `porepack image segment`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/interval.hpp"
#include "core/json.hpp"
#include "core/members.hpp"
#include "results/image.hpp"

namespace porepack::results {

/// Numbers of grains by kind.
struct SegmentedGrains {
    long kept = 0, whole = 0, cut = 0, merged = 0, split = 0, speck = 0;
};
template <core::MembersOf<SegmentedGrains> Self, typename Visit>
void visit_members(Self& grains, const Visit& visit) {
    visit("kept", grains.kept);
    visit("whole", grains.whole);
    visit("cut", grains.cut);
    visit("merged", grains.merged);
    visit("split", grains.split);
    visit("speck", grains.speck);
}

/// Closed surfaces of whole grains; left out: not closed, or they cross themselves.
struct SegmentedLibrary {
    long stones = 0, left_out = 0;
};
template <core::MembersOf<SegmentedLibrary> Self, typename Visit>
void visit_members(Self& library, const Visit& visit) {
    visit("stones", library.stones);
    visit("left_out", library.left_out);
}

struct Segment {
    ImageFile file;
    std::string pores;
    core::OptionalKey<scans::GrayNotes> gray = {};
    core::Json container;  ///< as in packing.json
    std::optional<double> porosity{};
    std::optional<core::Interval> section_m{};
    std::int64_t cavity_voxels = 0;
    double half_thickness_m = 0.0, median_grain_volume_m3 = 0.0;
    SegmentedGrains grains = {};
    core::OptionalKey<SegmentedLibrary> library = {};
    std::string meaning =
        "whole: 0.6 to 1.5 median volumes; merged: more; split: less; cut: by the first or last layer, unless it only touches it; the "
        "median is that by volume of the grains that are not cut; section: where no removed grain reaches, a grain's height away from "
        "where "
        "the bed ends inside the image";
};
template <core::MembersOf<Segment> Self, typename Visit>
void visit_members(Self& found, const Visit& visit) {
    visit("", found.file);
    visit("pores", found.pores);
    visit("gray", found.gray);
    visit("container", found.container);
    visit("porosity", found.porosity);
    visit("section_m", found.section_m);
    visit("cavity_voxels", found.cavity_voxels);
    visit("half_thickness_m", found.half_thickness_m);
    visit("median_grain_volume_m3", found.median_grain_volume_m3);
    visit("grains", found.grains);
    visit("library", found.library);
    visit("meaning", found.meaning);
}

}  // namespace porepack::results
