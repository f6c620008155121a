#include "stages/report_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/bed_view.hpp"
#include "converters/surface.hpp"
#include "core/error.hpp"
#include "core/interrupt.hpp"
#include "core/log.hpp"
#include "io/stl.hpp"
#include "report/picture.hpp"
#include "stages/case_space.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace fs = std::filesystem;

bool draw_packing(const Case& c, const results::CaseResults& results, const Path& folder) {
    const Container container = case_container(c);
    const auto bed = results::bed_of(results);
    // The empty part above the bed is not shown.
    const double shown = std::min(container.height(), 1.15 * (bed ? bed->bed_height_m : container.height()));
    const geometry::TriangleSurface walls = converters::sides_of(container, shown);
    std::vector<std::string> more;
    const Path file = folder / "walls.stl";
    if (!walls.triangles.empty()) {
        io::write_stl(file, walls);
        more = {"--walls", fs::absolute(file).string()};
    }
    const bool drawn = draw_picture(c.stage_folder("stl") / "solid.stl", folder / "packing.png", more);
    fs::remove(file);
    return drawn;
}

std::optional<report::BedView> bed_to_turn(const Case& c, const results::CaseResults& results) {
    try {
        report::require_three();
        report::BedView bed = bed_view_of(packing::read_packing(c.stage_folder("pack") / "packing.json"),
                                          results.voxelise ? std::optional(results.voxelise->section_m) : std::nullopt);
        if (results.lbm) add_flow(bed, c.stage_folder("lbm") / "flow.vti");
        return bed;
    } catch (const Error& fault) {
        if (interrupted()) throw;
        log_warning(fmt::format("the bed in the report cannot be turned: {}", fault.what()));
        return std::nullopt;
    }
}

}  // namespace porepack::stages
