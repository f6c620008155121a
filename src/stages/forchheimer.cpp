// Flows with inertia.
#include "analysis/flow.hpp"
#include "analysis/inertia.hpp"
#include "lbm/permeability.hpp"
#include "pipeline/run_ranks.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

Stage make_forchheimer_stage(const Case& c) {
    return {.name = "forchheimer",
            .needs = {solid_stage(c)},
            .configuration = deciding_keys(c, {"container", "section", "forchheimer"}, {}, true),
            .outputs = {"forchheimer.csv"},
            .run =
                [c](const Path& folder) {
                    if (c.settings.parallel.ranks > 1)
                        run_ranks(c.settings.parallel.ranks, rank_arguments("forchheimer", c, folder), folder);
                    return written(compute_inertial_flows(case_pore_space(c), c.settings.geometry, c.settings.forchheimer, folder), folder);
                },
            .expect = [c]() -> Expectation {
                if (!has_packing(c) && !c.from_surface()) return {.text = "as soon as there is a packing"};
                const PoreSpace space = expected_pore_space(c);
                const ForchheimerConfig& config = c.settings.forchheimer;
                return on_ranks(expect_inertia(space, config), c.settings.parallel.ranks, space, space.voxel_size_m(config.voxel_size_m),
                                {.device = config.device});
            },
            .resumes = true,
            .result_version = results::Forchheimer::version,
            .processes = c.settings.parallel.ranks};
}

void run_forchheimer_rank(const Case& c, const Path& folder) {
    solve_lattice_grids(case_pore_space(c), c.settings.forchheimer, folder);
}

}  // namespace porepack::stages
