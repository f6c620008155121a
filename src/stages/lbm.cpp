// Permeability by lattice Boltzmann.
#include <filesystem>

#include "analysis/flow.hpp"
#include "core/communicator.hpp"
#include "core/log.hpp"
#include "io/image.hpp"
#include "lbm/checkpoint.hpp"
#include "lbm/layered_flow.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"
#include "stages/work.hpp"

namespace porepack::stages {

results::Lbm run_lbm(const PoreSpace& space, const GeometryConfig& geometry, const LbmConfig& config, const Path& folder,
                     const Path& checkpoint) {
    ComputedFlow flow = compute_flow(space, geometry, config, checkpoint);
    results::Lbm result = written(std::move(flow.outcome), folder);
    if (config.fields == FieldFiles::none) return result;
    io::write_flow_image(folder / "flow.vti", flow.field);
    lbm::end_answers(flow.field, core::ranks());
    return result;
}

Stage make_lbm_stage(const Case& c) {
    Stage stage{.name = "lbm",
                .needs = {solid_stage(c)},
                .configuration = deciding_keys(c, {"container", "section", "lbm"}, {"voxel_size_m", "reservoir_m"}, true),
                .outputs = {"history.csv"},
                .result_version = results::Lbm::version};
    if (c.settings.lbm.direction == Axis::z) stage.outputs.emplace_back("gradient.csv");
    if (c.settings.lbm.fields != FieldFiles::none) stage.outputs.emplace_back("flow.vti");
    stage.run = [c](const Path& folder) {
        const auto run = [&] {
            return run_lbm(case_pore_space(c), c.settings.geometry, c.settings.lbm, folder, c.results() / "lbm.checkpoint");
        };
        try {
            return run();
        } catch (const CheckpointOfAnotherRun& other) {  // of settings that the case no longer has
            log_warning(fmt::format("{} is of other settings and is removed", other.file.string()));
            std::filesystem::remove(other.file);
            return run();
        }
    };
    stage.expect = [c] {
        const PoreSpace space = expected_pore_space(c);
        const double asked = c.settings.geometry.voxel_size_m;
        return expect_flow(space, c.settings.lbm, asked > 0.0 || space.image() ? space.voxel_size_m(asked) : space.grain_size_m / 10.0,
                           expected_porosity(c));
    };
    return stage;
}

}  // namespace porepack::stages
