// The chain of a case.
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

namespace {

// What an image, which has no grains, can be used for.
std::vector<Stage> image_stages(const Case& c) {
    std::vector<Stage> stages;
    for (const auto& make : {make_image_stage, make_voxelise_stage, make_lbm_stage, make_tortuosity_stage}) stages.push_back(make(c));
    std::vector<std::string> computed, needs;
    for (const Stage& stage : stages) computed.push_back(stage.name);
    stages.push_back(make_uncertainty_stage(c, computed));
    stages.push_back(make_falling_head_stage(c));
    for (const Stage& stage : stages) needs.push_back(stage.name);
    stages.push_back(make_report_stage(c, needs, needs));
    return stages;
}

}  // namespace

std::vector<Stage> case_stages(const Case& c, std::vector<Stage> studies) {
    const Settings& s = c.settings;
    if (c.from_image()) return image_stages(c);
    if (c.from_surface() && s.shape.file.empty())
        throw UserError("kind = \"surface\" needs a file", {.where = "[shape]", .fix = "file = \"grains.stl\""});
    std::vector<Stage> stages = {make_shape_stage(c)};
    if (!c.from_surface()) stages.push_back(make_pack_stage(c));
    for (const auto& make : {make_stl_stage, make_voxelise_stage, make_slices_stage, make_lbm_stage}) stages.push_back(make(c));
    const bool with_foam = s.openfoam.enabled && s.geometry.closing_radius_m == 0.0;  // the surface has no menisci
    if (with_foam) stages.push_back(make_foam_stage(c));
    stages.push_back(make_tortuosity_stage(c));
    for (Stage& study : studies) stages.push_back(std::move(study));
    std::vector<std::string> computed;
    for (const Stage& stage : stages) computed.push_back(stage.name);
    stages.push_back(make_uncertainty_stage(c, computed));
    if (s.forchheimer.enabled) stages.push_back(make_forchheimer_stage(c));
    stages.push_back(make_falling_head_stage(c));
    if (s.falling_head.causes) stages.push_back(make_causes_stage(c));
    stages.push_back(make_descriptors_stage(c));

    // The surface of a packing is made only for stages that render or mesh it.
    const bool surface_wanted = c.from_surface() || with_foam || s.report.pictures || s.stl.pores || s.stl.clip;
    std::vector<std::string> needs, shown;
    for (Stage& stage : stages) {
        stage.seed = s.packing.seed;
        shown.push_back(stage.name);
        if (stage.name != "stl" || surface_wanted) needs.push_back(stage.name);
    }
    stages.push_back(make_report_stage(c, needs, shown));
    stages.back().seed = s.packing.seed;
    return stages;
}

}  // namespace porepack::stages
