// Permeability by lattice Boltzmann.
#include <algorithm>
#include <utility>

#include "analysis/flow.hpp"
#include "core/log.hpp"
#include "pore_space/closing.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

Stage make_lbm_stage(const Case& c) {
    const long ranks = c.settings.parallel.ranks;
    Stage stage{.name = "lbm",
                .needs = {solid_stage(c)},
                .configuration = deciding_keys(c, {"container", "section", "lbm"}, {"voxel_size_m", "reservoir_m"}, true),
                .outputs = {"history.csv"},
                .result_version = results::Lbm::version,
                .processes = ranks};
    if (c.settings.lbm.direction == Axis::z) stage.outputs.emplace_back("gradient.csv");
    if (c.settings.lbm.fields != FieldFiles::none) stage.outputs.emplace_back("flow.vti");
    stage.run = [c](const Path& folder) { return run_lbm(c, folder); };
    stage.expect = [c, ranks] {
        const PoreSpace space = expected_pore_space(c);
        const double asked = c.settings.geometry.voxel_size_m,
                     voxel = asked > 0.0 || space.own_grid() ? space.voxel_size_m(asked) : space.grain_size_m / 10.0;
        Expectation flow = on_ranks(expect_flow(space, c.settings.lbm, voxel, expected_porosity(c)), ranks, space, voxel, c.settings.lbm);
        if (const double radius = c.settings.geometry.closing_radius_m; radius > 0.0) {  // each rank makes all menisci
            const double menisci = closing_memory_bytes(space, radius);
            flow.memory_bytes = std::max(flow.memory_bytes, static_cast<double>(std::max(1L, ranks)) * menisci);
            if (ranks > 1) flow.text += fmt::format("; the menisci take {} in each", human_bytes(menisci));
        }
        return flow;
    };
    return stage;
}

}  // namespace porepack::stages
