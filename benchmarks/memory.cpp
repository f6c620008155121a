// Memory of lattice Boltzmann runs: predicted and used.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "benchmarks/lbm_speed.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "core/machine.hpp"
#include "lbm/permeability.hpp"
#include "pore_space/pore_space.hpp"
#include "stages/stages.hpp"
#include "stages/work.hpp"
#include "support/whole_library.hpp"

namespace porepack::benchmarks {
namespace {

// Overlapping spheres of 40 nodes diameter in a cylinder as high as it is wide, as `porepack lbm` runs it; not until it is exact.
Json run_of(double porosity, double nodes, const LbmConfig& config, const Path& folder) {
    const double cells = std::cbrt(nodes / porosity * 4.0 / std::numbers::pi);
    const PoreSpace space = pore_space_of(overlapping_spheres("cylinder:1,1", porosity, 20.0 / cells)).with_section({0.0, 1.0});
    std::filesystem::create_directories(folder);
    reset_peak_memory();
    const double before = peak_memory_bytes();
    const results::Lbm result = stages::run_lbm(space, {.voxel_size_m = 1.0 / cells}, config, folder, {});
    const LbmGridResult& fine = result.fine;
    const double fluid = static_cast<double>(fine.nodes), peak = result.peak_memory_bytes, expected = result.expected_memory_bytes,
                 all = static_cast<double>(fine.cells[0]) * fine.cells[1] * fine.cells[2], flow = fine.bytes_per_node;
    return {{"porosity", porosity},
            {"precision", name_of(config.precision)},
            {"flow_vti", config.fields == FieldFiles::vti},
            {"fluid_nodes", fluid},
            {"cells", all},
            {"wall_links_per_node", static_cast<double>(fine.wall_links) / fluid},
            {"populations_addresses_and_walls_bytes_per_node", flow},
            {"before_bytes", before},
            {"peak_memory_bytes", peak},
            {"expected_memory_bytes", expected},
            {"expected_over_peak", expected / peak},
            {"peak_bytes_per_node", (peak - before) / fluid},
            {"rest_bytes_per_solid_cell", (peak - before - flow * fluid) / (all - fluid)},
            {"set_up_seconds_per_1e7_nodes", fine.set_up_seconds * 1e7 / fluid},
            {"steps", fine.run.steps},
            {"seconds_per_step", fine.run.seconds / static_cast<double>(fine.run.steps)},
            {"iteration_error", fine.run.iteration_error}};
}

double number_of_nodes(const std::string& text) {
    char* end = nullptr;
    const double nodes = std::strtod(text.c_str(), &end);
    if (*end != '\0' || !(nodes >= 1e5 && nodes <= 4e9)) throw UserError("not a number of fluid nodes: " + text, {.allowed = "1e5 to 4e9"});
    return nodes;
}

}  // namespace

Json memory_benchmark(bool quick, const std::vector<std::string>& nodes, const Path& folder) {
    const Path runs = (folder.empty() ? Path("memory_study") : folder) / "runs";
    LbmConfig config{.iteration_tolerance = 0.05, .grids = 2};
    Json rows = Json::array();
    if (!nodes.empty()) {
        config.precision = Precision::single_precision;
        config.fields = FieldFiles::none;
        config.iteration_tolerance = 0.01;
        rows.push_back(run_of(0.7, number_of_nodes(nodes.front()), config, runs));
    } else {
        for (const double porosity : {0.2, 0.4, 0.7})
            for (const auto& [precision, name] : choices_of(Precision{})) {
                config.precision = precision;
                rows.push_back(run_of(porosity, quick ? 2e6 : 1e7, config, runs));
            }
    }
    return {{"memory", rows}};
}

}  // namespace porepack::benchmarks
