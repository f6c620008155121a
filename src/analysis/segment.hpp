// A scan segmented into grains: threshold, cavities filled, grains separated, incomplete grains removed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/outcome.hpp"
#include "analysis/stone_library.hpp"
#include "core/files.hpp"
#include "geometry/gray_image.hpp"
#include "imaging/config.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "record/config.hpp"
#include "results/segment.hpp"

namespace porepack::analysis {

struct SegmentConfig {
    double separation = 0.25;
    bool keep_cut_grains = false;
    bool on_floor = false;
    bool keep_cavities = false;
    double smallest_grain = 0.05;
    bool library = false;
};
inline void describe(record::ConfigVisitor& v, SegmentConfig& c) {
    v.number(
        "separation", c.separation, record::between(0.02, 1.0),
        "by how much a maximum of the distance to the surface must stand out to be a grain of its own, over half the grains' thickness; "
        "0.1 to 0.25 for long arms, 0.25 to 0.5 for round grains");
    v.boolean("keep_cut_grains", c.keep_cut_grains, "keep the grains that the first and the last layer of the image cut");
    v.boolean("on_floor", c.on_floor,
              "the first layer lies on the container's floor: grains that reach it are whole, however broad they stand on it");
    v.boolean("keep_cavities", c.keep_cavities, "cavities in the grains stay pores");
    v.number("smallest_grain", c.smallest_grain, record::between(0.0, 1.0), "smaller pieces are removed; volume over the median volume");
    v.boolean("library", c.library,
              "write each whole grain as a closed surface into the folder library/, from which [shape] kind = \"library\" pours new beds");
}

struct Segmented {
    Outcome<results::Segment> outcome;  ///< with grains.csv, the grains' volumes, and a picture of each step
    geometry::GrayImage gray;           ///< solid fractions without the grains that were removed
    geometry::PhaseImage phases;
    std::vector<std::uint32_t> labels;  ///< of all grains; 0: pores
    std::optional<StoneLibrary> library = {};
};
/// Without a threshold, `volume`. `name` names the scan in messages. Throws UserError as read_gray(), and where no grain is left.
[[nodiscard]] Segmented segment_image(const imaging::VolumeSource& source, imaging::ImageConfig image,
                                      const std::optional<vessels::Container>& container, const SegmentConfig& config,
                                      const std::string& name);
/// Of a file or a folder of slices.
[[nodiscard]] Segmented segment_image(const core::Path& file, const imaging::ImageConfig& image,
                                      const std::optional<vessels::Container>& container, const SegmentConfig& config);
/// gray.vti, pore.vti, labels.vti, solid.stl and library/ beside the tables and pictures.
[[nodiscard]] results::Segment written(const Segmented& segmented, const core::Path& folder);

}  // namespace porepack::analysis
