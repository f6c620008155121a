// Tortuosities of the case's section.
#include <algorithm>
#include <utility>

#include "analysis/tortuosity.hpp"
#include "core/log.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace {

results::Tortuosity run_case_tortuosity(const Case& c, const Path& folder) {
    const TortuosityConfig& config = c.settings.tortuosity;
    const GeometryConfig& geometry = c.settings.geometry;
    const PoreSpace space = case_pore_space(c);
    results::Tortuosity result;
    if (space.container.vessel().outlines(space.container.size().norm()).empty()) {
        log_info("the paper's tortuosity is left out: it needs a container whose cross-section is the same at all heights");
    } else if (c.from_image()) {
        result.geometric_paper_pixels = written(compute_geometric_paper(space, config), folder);
    } else {
        if (space.packing() != nullptr) result.geometric_paper_exact = written(compute_geometric_paper(space, config), folder);
        result.geometric_paper_pixels = written(compute_geometric_paper(read_slices(c.stage_folder("slices")), config), folder);
    }
    if (config.shortest_path) result.shortest_path = written(compute_shortest_path(space, geometry, config.direction), folder);
    if (config.diffusive) result.diffusive = compute_diffusive_tortuosity(space, geometry, config.direction);
    if (c.settings.lbm.fields == lbm::FieldFiles::none) {
        const auto lbm = c.result<results::Lbm>();
        result.hydraulic = {.direction = lbm.direction, .tortuosity = lbm.hydraulic_tortuosity};
    } else {
        result.hydraulic = compute_hydraulic_tortuosity(c.stage_folder("lbm") / "flow.vti", {});
    }
    return result;
}

Expectation expect_case(const Case& c) {
    const PoreSpace space = expected_pore_space(c);
    const double asked = c.settings.geometry.voxel_size_m, h = asked > 0.0 ? asked : space.grain_size_m / 10.0;
    const Vec3 inner = space.container.high() - space.container.low();
    const double per_length = inner.x() * inner.y() / (h * h * h), cells = per_length * space.section.length();
    Expectation expected = expect_tortuosity(TortuosityKind::geometric_paper, cells);
    for (const auto& [wanted, kind] : {std::pair(c.settings.tortuosity.shortest_path, TortuosityKind::shortest_path),
                                       std::pair(c.settings.tortuosity.diffusive, TortuosityKind::diffusive)}) {
        if (!wanted) continue;
        const Expectation one = expect_tortuosity(kind, kind == TortuosityKind::diffusive ? per_length * space.computed().length() : cells);
        expected.memory_bytes = std::max(expected.memory_bytes, one.memory_bytes);
        expected.wall_time_s += one.wall_time_s;
        expected.text = one.text;
    }
    return expected;
}

}  // namespace

Stage make_tortuosity_stage(const Case& c) {
    Stage stage{.name = "tortuosity",
                .needs = {"slices", "lbm"},
                .configuration = deciding_keys(c, {"container", "section", "tortuosity"}, {"voxel_size_m"}, true),
                .outputs = {"*.vtp"},
                .run = [c](const Path& folder) { return run_case_tortuosity(c, folder); },
                .expect = [c] { return expect_case(c); },
                .result_version = results::Tortuosity::version};
    if (c.from_image()) stage.needs = {"image", "lbm"};
    if (!c.from_surface() && !c.from_image()) stage.needs.insert(stage.needs.begin(), "pack");
    return stage;
}

}  // namespace porepack::stages
