// A bed of grains that a reader turns in a browser: part of a page, with three.js (Debian's libjs-three) inside.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "core/interval.hpp"
#include "io/stl.hpp"

namespace porepack::report {

/// What is shown. Lengths in metres, z up.
struct BedView {
    struct Kind {
        std::string name;
        geometry::TriangleSurface surface;  ///< closed, in the grain's frame
    };
    struct Grain {
        std::size_t kind = 0;
        std::array<double, 3> position_m{};
        std::array<double, 4> orientation = {1.0, 0.0, 0.0, 0.0};  ///< quaternion w, x, y, z from the grain's frame
        long neighbours = 0;                                       ///< grains that it touches
    };
    struct Line {
        std::vector<std::array<double, 3>> points_m;
        std::vector<double> speeds_m_per_s;
    };
    /// Values on the cells of a plane, row by row from below.
    struct Slice {
        int normal = 1;  ///< axis; rows lie along the first other axis, one above the other along the second one
        double at_m = 0.0;
        std::array<double, 2> low_m{}, size_m{};  ///< along these
        int width = 0, height = 0;
        struct Values {
            std::string name, unit;  ///< "speed", "m/s"
            core::Interval range;    ///< of the bytes 0 to 254
            std::vector<std::uint8_t> bytes = {};
            static constexpr std::uint8_t solid = 255;
        };
        std::vector<Values> values = {};
    };
    /// Gray values of an image, x fastest, of which a slice follows the cut.
    struct Scan {
        std::array<int, 3> voxels{};
        std::array<double, 3> low_m{}, size_m{};
        core::Interval range = {};        ///< of the bytes 0 to 255
        std::vector<std::uint8_t> bytes;  ///< values beyond the range are cut there
    };
    std::string text;  ///< what is seen, for those who do not see it
    std::vector<Kind> kinds;
    std::vector<Grain> grains;
    geometry::TriangleSurface vessel = {};  ///< its sides; empty for a box
    std::array<double, 3> low_m{}, high_m{};
    std::optional<core::Interval> section_m = {};
    std::vector<Line> streamlines = {};
    std::string flow = {};  ///< whose streamlines and slice they are: "water at a superficial velocity of ..."
    std::optional<Slice> slice = {};
    std::optional<Scan> scan = {};
};

/// Throws EngineError where libjs-three is not installed.
void require_three();
/// HTML for the body of a page, with style and scripts; at most one per page. Throws as require_three().
[[nodiscard]] std::string bed_view_html(const BedView& bed);
/// A page of its own.
void write_bed_page(const core::Path& html, const std::string& title, const BedView& bed);

}  // namespace porepack::report
