// Grains in the case's container: poured or given.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "analysis/porosity.hpp"
#include "analysis/pour.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "inputs/mesh_grains.hpp"
#include "inputs/mesh_vessel.hpp"
#include "record/digest.hpp"
#include "stages/case_space.hpp"
#include "stages/stages.hpp"
#include "stages/uses.hpp"

namespace porepack::stages {
namespace {

Poured given(const Case& c) {
    const PackingConfig& config = c.settings.packing;
    if (config.file.empty()) throw UserError("engine = \"none\" needs a packing", {.where = "[packing]", .fix = "file = \"packing.json\""});
    Poured given{.result = {.engine = std::string(name_of(config.engine)), .seed = config.seed},
                 .packing = read_packing(c.resolve(config.file)),
                 .protocol = {}};
    require_same_bed(case_shapes(c), inputs::make_container(c.settings.container, c.folder), given.packing, config.file);
    return given;
}

results::Pack run_pack(const Case& c, const Path& folder) {
    const PackingConfig& config = c.settings.packing;
    auto [result, packing, protocol] =
        config.engine == Engine::none
            ? given(c)
            : pour(case_shapes(c), inputs::make_container(c.settings.container, c.folder), config, c.settings.protocol, folder);
    add_grains(result, packing);
    if (packing.overlap_allowed) result.overlap_allowed = true;
    write_packing(folder / "packing.json", packing);
    if (protocol) protocol->write(folder / "protocol.csv");
    result.bed = bed_porosity(pore_space_of(read_packing(folder / "packing.json")));
    return result;
}

Expectation expect_pack(const Case& c) {
    if (c.settings.packing.engine == Engine::none) return {.text = "seconds"};
    Expectation expected =
        expect_pour(case_shapes(c), inputs::make_container(c.settings.container, c.folder), c.settings.packing, c.settings.protocol);
    if (!c.settings.geometry.section_m.empty())
        if (const PoreSpace bed = expected_pore_space(c); bed.section.z1_m > bed.bed_top_m)
            expected.text += fmt::format("; the section ends at {:g} m, above the expected top of the bed (about {:.2g} m)",
                                         bed.section.z1_m, bed.bed_top_m);
    return expected;
}

}  // namespace

Stage make_pack_stage(const Case& c) {
    if (c.from_fit()) return make_fit_stage(c);
    const PackingConfig& config = c.settings.packing;
    Json configuration = c.settings.resolved_tables({"shape", "container", "packing"});
    if (!c.settings.protocol.none()) configuration["protocol"] = c.settings.resolved_tables({"protocol"})["protocol"];
    configuration["packing"].erase("friction_uncertainty");  // it decides other packings, not this one
    std::vector<std::string> outputs = {"packing.json"};
    if (!c.settings.protocol.none()) outputs.emplace_back("protocol.csv");
    Stage stage{.name = "pack",
                .configuration = configuration,
                .outputs = outputs,
                .run = [c](const Path& folder) { return run_pack(c, folder); },
                .expect = [c] { return expect_pack(c); },
                .resumes = config.engine != Engine::none,
                .result_version = results::Pack::version,
                .processes = config.processes};
    stage.files = inputs::mesh_files(c.settings.shape, c.folder);
    for (const Path& file : inputs::vessel_files(c.settings.container, c.folder)) stage.files.push_back(file);
    if (config.engine == Engine::none && !config.file.empty()) stage.files.push_back(c.resolve(config.file));
    for (const Path& file : stage.files) (void)record::sha256_of_file(file);  // a missing file is named before anything runs
    return stage;
}

}  // namespace porepack::stages
