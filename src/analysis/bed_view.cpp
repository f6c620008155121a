#include "analysis/bed_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/streamlines.hpp"
#include "analysis/uses.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "imaging/write_volume.hpp"
#include "io/image.hpp"
#include "packing/structure.hpp"

namespace porepack::analysis {
namespace {

// Up to the highest grain, and a little more.
double shown_height(const Packing& packing) {
    const Container& container = packing.container;
    if (container.any_periodic()) return container.height();
    double top = container.low().z();
    for (const Body& body : packing.bodies) top = std::max(top, bounds_of(placed(packing, body)).high.z());
    return std::clamp(1.05 * (top - container.low().z()), 0.0, container.height());
}

// The bytes of a plane: from low to high, solid cells apart.
template <typename ValueOf>
report::BedView::Slice::Values values_of(const FlowImage& flow, const std::vector<std::size_t>& cells, const char* name, const char* unit,
                                         double share, const ValueOf& value_of) {
    std::vector<double> values;
    for (const std::size_t cell : cells)
        if (flow.phase[cell] == Phase::pore) values.push_back(value_of(cell));
    std::ranges::sort(values);
    const auto at = [&](double part) {
        return values.empty() ? 0.0 : values[static_cast<std::size_t>(part * static_cast<double>(values.size() - 1))];
    };
    report::BedView::Slice::Values found{.name = name, .unit = unit, .range = {at(0.0), at(share)}};
    for (const std::size_t cell : cells) {
        const auto& [low, high] = found.range;
        const double part = high > low ? (value_of(cell) - low) / (high - low) : 0.0;
        found.bytes.push_back(flow.phase[cell] == Phase::pore ? static_cast<std::uint8_t>(std::lround(254.0 * std::clamp(part, 0.0, 1.0)))
                                                              : report::BedView::Slice::Values::solid);
    }
    return found;
}

// Across y, or across x where the flow is along y.
report::BedView::Slice slice_of(const FlowImage& flow, int axis) {
    const std::size_t normal = axis == 1 ? 0 : 1, along = 1 - normal;
    const Grid& grid = flow.grid;
    const int middle = grid.cells[normal] / 2;
    report::BedView::Slice slice{.normal = static_cast<int>(normal),
                                 .at_m = grid.centre(static_cast<int>(normal), middle),
                                 .low_m = {grid.origin_m[along], grid.origin_m[2]},
                                 .size_m = {grid.cells[along] * grid.spacing_m[along], grid.cells[2] * grid.spacing_m[2]},
                                 .width = grid.cells[along],
                                 .height = grid.cells[2]};
    std::vector<std::size_t> cells;
    for (int k = 0; k < slice.height; ++k)
        for (int i = 0; i < slice.width; ++i) cells.push_back(normal == 1 ? grid.index(i, middle, k) : grid.index(middle, i, k));
    slice.values.push_back(values_of(flow, cells, "speed", "m/s", 0.99, [&](std::size_t cell) {
        const float* const u = &flow.velocity_m_per_s[3 * cell];
        return std::hypot(static_cast<double>(u[0]), static_cast<double>(u[1]), static_cast<double>(u[2]));
    }));
    if (!flow.pressure_Pa.empty())
        slice.values.push_back(
            values_of(flow, cells, "pressure", "Pa", 1.0, [&](std::size_t cell) { return static_cast<double>(flow.pressure_Pa[cell]); }));
    return slice;
}

}  // namespace

report::BedView bed_view_of(const Packing& packing, std::optional<Interval> section_m) {
    const double thinnest = finest_diameter(packing), fineness = packing.bodies.size() > 300 ? 0.03 : 0.01;
    const std::vector<long> neighbours = structure_of(packing, 1e-3 * thinnest, thinnest, 1).neighbours;
    const Container& container = packing.container;
    report::BedView bed{.low_m = {container.low().x(), container.low().y(), container.low().z()},
                        .high_m = {container.high().x(), container.high().y(), container.low().z() + shown_height(packing)},
                        .section_m = section_m};
    bed.vessel = converters::sides_of(container, shown_height(packing));
    for (const shapes::Shape& shape : packing.shapes)
        bed.kinds.push_back({shape.id, converters::surface_of_grain(shape, fineness * thinnest)});
    double touching = 0.0;
    for (std::size_t g = 0; g < packing.bodies.size(); ++g) {
        const Body& body = packing.bodies[g];
        const auto& [p, q] = std::tie(body.position_m, body.orientation);
        bed.grains.push_back({body.shape, {p.x(), p.y(), p.z()}, {q.w(), q.x(), q.y(), q.z()}, neighbours[g]});
        touching += static_cast<double>(neighbours[g]);
    }
    bed.text = fmt::format("{} grains in {:.4g} mm of height; each touches {:.2g} others on average.", bed.grains.size(),
                           1e3 * (bed.high_m[2] - bed.low_m[2]), touching / std::max<double>(1.0, static_cast<double>(bed.grains.size())));
    return bed;
}

void add_flow(report::BedView& bed, const Path& flow_vti) {
    constexpr std::size_t number = 60;
    constexpr double largest_file_bytes = 1e9;
    if (!std::filesystem::exists(flow_vti) || static_cast<double>(std::filesystem::file_size(flow_vti)) > largest_file_bytes) return;
    const FlowImage flow = io::read_flow_image(flow_vti);
    const auto direction = flow.notes.find("direction");
    const int axis = direction == flow.notes.end() || direction->second == "z" ? 2 : direction->second == "y" ? 1 : 0;
    if (const auto state = flow.notes.find("state"); state != flow.notes.end()) bed.flow = state->second;
    for (Streamline& line : streamlines(flow, axis, number))
        bed.streamlines.push_back({std::move(line.points_m), std::move(line.speeds_m_per_s)});
    if (!flow.phase.empty()) bed.slice = slice_of(flow, axis);
}

report::BedView scan_view_of(const imaging::VolumeSource& scan, const std::array<double, 3>& low_m) {
    const imaging::VolumeHeader& header = scan.header;
    report::BedView bed{.low_m = low_m};
    for (std::size_t a = 0; a < 3; ++a) bed.high_m[a] = bed.low_m[a] + static_cast<double>(header.voxels[a]) * header.spacing_m[a];
    const auto& n = header.voxels;
    bed.text = fmt::format("A scan of {} x {} x {} voxels of {:.4g} mm.", n[0], n[1], n[2], 1e3 * header.spacing_m[0]);
    add_scan(bed, scan, low_m);
    return bed;
}

void add_scan(report::BedView& bed, const imaging::VolumeSource& scan, const std::array<double, 3>& low_m) {
    constexpr double max_voxels = 6e6, dark = 0.002, bright = 0.998;  // of all values: single ones beyond would take the contrast
    const auto& n = scan.header.voxels;
    const std::int64_t wanted = std::llround(std::ceil(std::cbrt(static_cast<double>(scan.header.count()) / max_voxels))),
                       factor = std::min({wanted, n[0], n[1], n[2]});
    const imaging::VolumeSource source = factor > 1 ? imaging::binned(scan, factor) : scan;
    if (static_cast<double>(source.header.count()) > 4.0 * max_voxels)
        throw UserError(fmt::format("an image of {} x {} x {} voxels is too wide for a page", n[0], n[1], n[2]),
                        {.fix = "a part of it: porepack image crop"});
    std::vector<float> values(static_cast<std::size_t>(source.header.count()));
    source.read(0, values);
    std::vector<float> sorted = values;
    const auto at = [&](double part) {
        const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(sorted.size() - 1));
        std::ranges::nth_element(sorted, place);
        return static_cast<double>(*place);
    };
    report::BedView::Scan seen{.low_m = low_m, .range = {at(dark), at(bright)}};
    if (!(seen.range.high > seen.range.low)) seen.range = {at(0.0), std::max(at(1.0), at(0.0) + 1.0)};
    for (std::size_t a = 0; a < 3; ++a) {
        seen.voxels[a] = static_cast<int>(source.header.voxels[a]);
        seen.size_m[a] = static_cast<double>(source.header.voxels[a]) * source.header.spacing_m[a];
    }
    for (const float value : values) {
        const double part = (static_cast<double>(value) - seen.range.low) / (seen.range.high - seen.range.low);
        seen.bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(part, 0.0, 1.0))));
    }
    bed.scan = std::move(seen);
}

}  // namespace porepack::analysis
