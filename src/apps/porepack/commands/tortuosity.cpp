// The command tortuosity.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "analysis/tortuosity.hpp"
#include "apps/porepack/run.hpp"
#include "apps/porepack/uses.hpp"
#include "converters/slices.hpp"
#include "core/error.hpp"
#include "core/log.hpp"
#include "core/members_json.hpp"
#include "record/resolved_config.hpp"

namespace porepack::apps {
namespace {

// Only diffusion needs the bed beyond the section.
SectionConfig section_of(const Common& common, TortuosityKind kind) {
    const auto section = config_of<SectionConfig>(common.flags);
    if (kind == TortuosityKind::diffusive) {
        if (section.ends == Ends::paper)
            throw UserError("--ends paper is for flow", {.allowed = "in_situ, planes", .fix = "choose another, or leave it out"});
        return section;
    }
    for (const char* key : {"ends", "buffer_m"})
        if (common.flags.contains(key))
            throw UserError(fmt::format("{} has no effect here", key), {.fix = "remove it: it belongs to the kind diffusive"});
    return {.ends = Ends::planes};
}

void run_kind(const Common& common, TortuosityKind kind) {
    const std::string name(name_of(kind));
    if (is_case(common.input)) {
        log_warning("a case computes all kinds of tortuosity, not " + name + " alone");
        return run_in_case(common, "tortuosity", "tortuosity");
    }
    const auto geometry = config_of<GeometryConfig>(common.flags);
    const auto config = config_of<TortuosityConfig>(common.flags);
    const auto section = section_of(common, kind);
    const bool of_slices = kind == TortuosityKind::geometric_paper && std::filesystem::exists(Path(common.input) / "slices.json");
    if (kind == TortuosityKind::hydraulic || of_slices)
        return run_on_files(common, {.stage = "tortuosity." + name,
                                     .target = target_folder(common),
                                     .configuration = resolved_config(config),
                                     .inputs = {common.input},
                                     .work = [&](const Path& folder) {
                                         return of_slices
                                                    ? json_of(written(compute_geometric_paper(read_slices(common.input), config), folder))
                                                    : json_of(compute_hydraulic_tortuosity(common.input, geometry.section_m));
                                     }});
    run_on_input(common, {.stage = "tortuosity." + name,
                          .geometry = geometry,
                          .section = section,
                          .configuration = {{"tortuosity", resolved_config(config)}, {"section", resolved_config(section)}},
                          .work = [&](const PoreSpace& space,
                                      const Path& folder) { return written(compute_tortuosity(kind, space, geometry, config), folder); },
                          .expect = [&](const PoreSpace& space) -> core::Expectation {
                              if (kind == TortuosityKind::geometric_paper) return {.text = "seconds"};
                              const VoxelPlan plan = space.plan_at(space.voxel_size_m(geometry.voxel_size_m));
                              return expect_tortuosity(kind, static_cast<double>(plan.grid.size()));
                          }});
}

}  // namespace

void add_tortuosity_command(CommandLine& line) {
    const auto kind = std::make_shared<std::string>();
    auto command = line.add("tortuosity", "tortuosity of a named kind", "porepack tortuosity hydraulic flow.vti",
                            [&line, kind] { run_kind(line.common, choice_named<TortuosityKind>(*kind).value()); });
    std::vector<std::string> names;
    for (const auto& choice : choices_of(TortuosityKind::hydraulic)) names.emplace_back(choice.name);
    command.add_option("kind", *kind, "geometric_paper, shortest_path, hydraulic or diffusive (the tortuosity factor eps D0/D_eff)")
        .type_name("name")
        .required()
        .one_of(names);
    line.add_input(
        command,
        "packing.json[.gz], an STL file, a folder of slices, pore.vti; flow.vti or an OpenFOAM case that has run (hydraulic); or a "
        "case");
    line.add_keys(command, "tortuosity");
    line.add_keys(command, "section");
    line.add_keys(command, "geometry", {"slice_spacing_m", "slice_pixel_m", "surface_deviation_m", "contact_gap_m", "reservoir_m"});
}

}  // namespace porepack::apps
