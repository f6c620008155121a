// Permeability by OpenFOAM.
#include "analysis/foam.hpp"
#include "io/stl.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {

Stage make_foam_stage(const Case& c) {
    Stage stage{.name = "foam",
                .needs = {"stl"},
                .configuration = deciding_keys(c, {"container", "section", "openfoam"}, {}, true),
                .run =
                    [c](const Path& folder) {
                        const geometry::TriangleSurface made = io::read_stl(c.stage_folder("stl") / "solid.stl");
                        return compute_foam_flow(case_pore_space(c), c.settings.geometry, c.settings.openfoam, folder, &made);
                    },
                .expect =
                    [c] {
                        const PoreSpace space = expected_pore_space(c);
                        const FoamConfig& config = c.settings.openfoam;
                        return expect_foam(space, config, config.cell_size_m > 0.0 ? config.cell_size_m : space.grain_size_m / 4.0,
                                           expected_porosity(c));
                    },
                .optional = true,  // a cross-check
                .resumes = true,
                .result_version = results::Foam::version};
    if (!c.from_surface()) stage.needs.insert(stage.needs.begin(), "pack");
    return stage;
}

}  // namespace porepack::stages
