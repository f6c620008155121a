// A bed of grains that a reader turns in a browser: part of a page, with three.js (Debian's libjs-three) inside.
#pragma once

#include <array>
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
        io::TriangleSurface surface;  ///< closed, in the grain's frame
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
    std::string text;  ///< what is seen, for those who do not see it
    std::vector<Kind> kinds;
    std::vector<Grain> grains;
    io::TriangleSurface vessel = {};  ///< its sides; empty for a box
    std::array<double, 3> low_m{}, high_m{};
    std::optional<core::Interval> section_m = {};
    std::vector<Line> streamlines = {};
    std::string flow = {};  ///< whose streamlines they are: "water at a superficial velocity of ..."
};

/// Throws EngineError where libjs-three is not installed.
void require_three();
/// HTML for the body of a page, with style and scripts; at most one per page. Throws as require_three().
[[nodiscard]] std::string bed_view_html(const BedView& bed);
/// A page of its own.
void write_bed_page(const core::Path& html, const std::string& title, const BedView& bed);

}  // namespace porepack::report
