// A scan or a segmented image, as read: results/image/result.json.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/json.hpp"
#include "core/members.hpp"
#include "scans/gray_notes.hpp"

namespace porepack::results {

/// How the file was understood.
struct ImageFile {
    std::string format;
    std::array<std::int64_t, 3> voxels{};
    std::array<double, 3> voxel_size_m{};
    std::string voxel_size_from, orientation;
};
template <core::MembersOf<ImageFile> Self, typename Visit>
void visit_members(Self& image, const Visit& visit) {
    visit("format", image.format);
    visit("voxels", image.voxels);
    visit("voxel_size_m", image.voxel_size_m);
    visit("voxel_size_from", image.voxel_size_from);
    visit("orientation", image.orientation);
}

struct Image {
    static constexpr const char* stage = "image";
    /// Raised when these numbers can change, or a key is added: older results are out of date then.
    static constexpr long version = 1;
    ImageFile file;
    std::string pores;                              ///< what of the image they are: "values below 100"
    core::OptionalKey<scans::GrayNotes> gray = {};  ///< with walls from gray values
    core::Json container;                           ///< as in packing.json
    double porosity_bed = 0.0;
    std::string meaning;
};
template <core::MembersOf<Image> Self, typename Visit>
void visit_members(Self& image, const Visit& visit) {
    visit("", image.file);
    visit("pores", image.pores);
    visit("gray", image.gray);
    visit("container", image.container);
    visit("porosity_bed", image.porosity_bed);
    visit("meaning", image.meaning);
}

}  // namespace porepack::results
