#include "study/case_pipeline.hpp"

#include <utility>
#include <vector>

#include "record/engine_versions.hpp"
#include "stages/stages.hpp"
#include "study/seeds.hpp"
#include "study/uses.hpp"

namespace porepack::study {

Pipeline case_pipeline(const Case& c) {
    std::vector<Stage> studies;
    if (!c.from_surface() && !c.from_image() && c.settings.packings.several() && c.settings.packing.engine != Engine::none)
        studies.push_back(make_seeds_stage(c));
    return {.results = c.results(),
            .stages = case_stages(c, std::move(studies)),
            .versions = record::engine_versions,
            .left_out =
                "stages that a case can disable: foam ([openfoam] enabled), forchheimer ([forchheimer] enabled), causes "
                "([falling_head] causes), seeds ([packings] seeds or until_sure), pack (of an STL file); a case with an image has image, "
                "voxelise, lbm, tortuosity, uncertainty, falling-head, report"};
}

}  // namespace porepack::study
