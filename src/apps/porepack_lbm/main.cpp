// porepack_lbm: the permeability of a packing.json, and nothing else. It is part of the minimal build (Eigen, fmt and JSON alone), for
// machines where nothing can be installed, as those with graphics cards often are; `porepack lbm` has all inputs and outputs.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <new>
#include <string>
#include <vector>

#include "apps/porepack_lbm/flag_reader.hpp"
#include "core/files.hpp"
#include "core/interrupt.hpp"
#include "core/json.hpp"
#include "core/passive_waiting.hpp"
#include "devices/device.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/config.hpp"

namespace porepack::apps {
namespace {

// Keys of [lbm] that porepack lbm has, and this program does not.
const std::vector<std::string> without = {"fields", "superficial_velocity_m_per_s", "tensor", "subsections"};

struct OwnOptions {
    double voxel_size_m = 0.0;
    std::vector<double> section_m;
    std::string checkpoint;
};

void describe(record::ConfigVisitor& v, OwnOptions& c) {
    v.number("voxel_size_m", c.voxel_size_m, record::length_range_or_auto(),
             "size of the voxels of the finest grid; auto: a tenth of the grain diameter");
    v.numbers("section_m", c.section_m, {2, 2}, record::between(-1e6, 1e6),
              "lower and upper plane of the section; auto: the bed without one grain at each end");
    v.text("checkpoint", c.checkpoint, "file that the run updates, and from which it resumes if it is there; default: beside the result");
}

// For all tables that this program reads.
template <typename Visit>
void visit_tables(OwnOptions& own, pore_space::SectionConfig& section, lbm::LbmConfig& config, const Visit& visit) {
    visit([&](record::ConfigVisitor& v) { describe(v, own); });
    visit([&](record::ConfigVisitor& v) { describe(v, section); });
    visit([&](record::ConfigVisitor& v) { describe(v, config); });
}

std::string help() {
    std::string text =
        "porepack_lbm packing.json RESULT.json [--voxel-size 2e-4] [--device gpu] [--precision single] ...\n\n"
        "Permeability of a packing by lattice Boltzmann, with its interval. Devices of this machine: porepack_lbm devices\n\n";
    OwnOptions own;
    pore_space::SectionConfig section;
    lbm::LbmConfig config;
    visit_tables(own, section, config, [&](const record::Describe& keys) {
        for (const record::KeyRow& row : record::key_rows(keys))
            if (std::find(without.begin(), without.end(), row.key) == without.end())
                text += fmt::format("  {} <{}>{}\n      {}\n", record::flag_of(row.key), row.type,
                                    row.unit.empty() ? "" : fmt::format(" [{}]", row.unit), row.meaning);
    });
    return text;
}

void list_devices() {
    fmt::print("cpu: this processor\n");
    for (const devices::DeviceInfo& info : devices::find_devices())
        fmt::print("{}: {}, {:.3g} GB, copies {:.3g} GB/s\n", info.id, info.name, 1e-9 * info.memory_bytes,
                   1e-9 * devices::copy_bandwidth(*devices::open_device(info.id)));
}

pore_space::PoreSpace pores_of(const Path& packing, const OwnOptions& own, const pore_space::SectionConfig& section) {
    pore_space::PoreSpace bed = pore_space::pore_space_of(packing::read_packing(packing));
    const packing::Section chosen =
        packing::choose_section(bed.container, {.section_m = own.section_m}, bed.section, bed.maximum_feret_diameter_m);
    return bed.with_section(chosen).with_ends(section.ends, section.buffer_m);
}

Json json_of(const lbm::LbmResult& result, const pore_space::PoreSpace& pores, const lbm::LbmConfig& config) {
    Json grids = Json::array();
    for (const lbm::LbmGridResult& grid : result.grids)
        grids.push_back({{"voxel_size_m", grid.voxel_size_m},
                         {"nodes", grid.nodes},
                         {"permeability_m2", grid.permeability_m2},
                         {"iteration_error", grid.run.iteration_error},
                         {"steps", grid.run.steps},
                         {"seconds", grid.run.seconds},
                         {"set_up_seconds", grid.set_up_seconds},
                         {"updates_per_second", grid.run.updates_per_second},
                         {"bytes_per_node", grid.bytes_per_node}});
    const auto interval = result.interval_m2();
    return {{"permeability_m2", result.permeability_m2},
            {"permeability_interval_m2", interval ? Json{interval->low, interval->high} : Json()},
            {"porosity", pores.porosity().value},
            {"section_m", {pores.section.z0_m, pores.section.z1_m}},
            {"ends", std::string(name_of(pores.ends))},
            {"precision", std::string(name_of(config.precision))},
            {"device", result.device},
            {"grids", grids}};
}

int run(const std::vector<std::string>& words) {
    if (words.empty() || words[0] == "--help" || words[0] == "-h") {
        fmt::print("{}", help());
        return 0;
    }
    if (words == std::vector<std::string>{"devices"}) {
        list_devices();
        return 0;
    }
    if (words.size() < 2 || words[1].starts_with("--"))
        throw UserError("the file of the result is missing", {.fix = "porepack_lbm packing.json RESULT.json"});
    FlagReader flags({words.begin() + 2, words.end()}, without);
    OwnOptions own;
    pore_space::SectionConfig section{.ends = pore_space::Ends::planes};  // as porepack lbm on a file
    lbm::LbmConfig config;
    config.fields = lbm::FieldFiles::none;
    visit_tables(own, section, config, [&](const record::Describe& keys) { keys(flags); });
    flags.require_all_read();
    const Path result_file = words[1];
    const pore_space::PoreSpace pores = pores_of(words[0], own, section);
    const Path checkpoint = own.checkpoint.empty() ? Path(words[1] + ".checkpoint") : Path(own.checkpoint);
    const lbm::LbmResult result = lbm::lbm_permeability(pores, pores.voxel_size_m(own.voxel_size_m), config, {.checkpoint = checkpoint});
    const Json json = json_of(result, pores, config);
    write_json(result_file, json);
    fmt::print("{}\n", json.dump(2));
    return 0;
}

}  // namespace
}  // namespace porepack::apps

int main(int argc, char** argv) {
    using porepack::core::ExitCode;
    porepack::core::wait_passively(argv);
    porepack::core::install_signal_handlers();
    const auto report = [](const char* what, ExitCode code) {
        std::fprintf(stderr, "error: %s\n", what);
        return static_cast<int>(code);
    };
    try {
        return porepack::apps::run({argv + 1, argv + argc});
    } catch (const porepack::core::Error& error) {
        return report(error.what(), error.code());
    } catch (const std::bad_alloc&) {
        return report("out of memory\n  fix:     use a larger voxel size or a shorter section", ExitCode::machine);
    } catch (const std::exception& fault) {
        return report(fault.what(), ExitCode::machine);
    }
}
