// Dimensionless numbers of the case's bed.
#include "analysis/descriptors.hpp"

#include <filesystem>
#include <optional>

#include "io/image.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace {

results::Descriptors run_descriptors(const Case& c, const Path& folder) {
    const PoreSpace space = case_pore_space(c);
    const Path file = c.stage_folder("lbm") / "flow.vti";
    std::optional<geometry::FlowImage> flow;
    if (space.container.tube_diameter() && space.equivalent_diameter_m > 0.0 && std::filesystem::exists(file))
        flow = io::read_flow_image(file);
    std::optional<results::Forchheimer> forchheimer;
    if (c.settings.forchheimer.enabled) forchheimer = c.result<results::Forchheimer>();
    return written(describe_bed(space, c.result<results::Lbm>(), flow ? &*flow : nullptr, forchheimer), folder);
}

}  // namespace

Stage make_descriptors_stage(const Case& c) {
    Stage stage{.name = "descriptors",
                .needs = {solid_stage(c), "lbm"},
                .configuration = deciding_keys(c, {"container"}, {}, true),
                .outputs = {"*.csv"},
                .run = [c](const Path& folder) { return run_descriptors(c, folder); },
                .result_version = results::Descriptors::version};
    if (c.settings.forchheimer.enabled) stage.needs.emplace_back("forchheimer");
    return stage;
}

}  // namespace porepack::stages
