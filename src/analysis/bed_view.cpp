#include "analysis/bed_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "analysis/streamlines.hpp"
#include "analysis/uses.hpp"
#include "converters/surface.hpp"
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

void add_streamlines(report::BedView& bed, const Path& flow_vti) {
    constexpr std::size_t number = 60;
    constexpr double largest_file_bytes = 1e9;
    if (!std::filesystem::exists(flow_vti) || static_cast<double>(std::filesystem::file_size(flow_vti)) > largest_file_bytes) return;
    const FlowImage flow = io::read_flow_image(flow_vti);
    const auto direction = flow.notes.find("direction");
    const int axis = direction == flow.notes.end() || direction->second == "z" ? 2 : direction->second == "y" ? 1 : 0;
    if (const auto state = flow.notes.find("state"); state != flow.notes.end()) bed.flow = state->second;
    for (Streamline& line : streamlines(flow, axis, number))
        bed.streamlines.push_back({std::move(line.points_m), std::move(line.speeds_m_per_s)});
}

}  // namespace porepack::analysis
