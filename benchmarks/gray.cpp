// Gray walls: error and interval of k on simulated scans of arrays of known answer.
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "analysis/gray_parts.hpp"
#include "benchmarks/benchmarks.hpp"
#include "benchmarks/gray_run.hpp"
#include "core/log.hpp"
#include "core/median.hpp"
#include "core/members_json.hpp"
#include "pore_space/pore_space.hpp"
#include "scans/gray_input.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Row {
    std::string flow;
    bool to_judge = false;
    double voxels = 0.0, blur = 0.0, error = 0.0, half_width = 0.0, porosity_error = 0.0, half_way_error = 0.0;
    Json parts, notes;
    bool held = false;
};

Row measure(const KnownFlow& flow, double voxels, double blur, double noise, unsigned seed) {
    const auto [scan, input, space, config, result] = gray_run(flow, voxels, {blur, noise, seed});
    Row row{.flow = flow.name, .voxels = voxels, .blur = blur};
    row.error = result.permeability_m2 / flow.permeability_m2 - 1.0;
    if (const auto interval = result.interval_m2()) {
        row.half_width = 0.5 * (interval->high - interval->low) / result.permeability_m2;
        row.held = interval->low <= flow.permeability_m2 && flow.permeability_m2 <= interval->high;
    }
    row.porosity_error = space.porosity().value - flow.space().porosity().value;
    if (const auto& parts = result.half_width)
        row.parts = {{"grid", parts->grid_m2},
                     {"iteration", parts->iteration_m2},
                     {"mass_balance", parts->mass_balance_m2},
                     {"precision", parts->precision_m2},
                     {"stretch", parts->stretch_m2},
                     {"threshold", parts->threshold_m2},
                     {"blur", parts->blur_m2}};
    for (auto& part : row.parts) part = part.get<double>() / result.permeability_m2;
    row.notes = json_of(input.notes);
    PhaseImage phases{.grid = scan.grid};
    for (const std::uint16_t value : scan.packed) phases.phase.push_back(GrayImage::unpack(value) > 0.5 ? Phase::grain : Phase::pore);
    const PoreSpace voxels_only = pore_space_of(std::move(phases), flow.container, {0.0, flow.container.height()}, flow.name);
    row.half_way_error = lbm_permeability(voxels_only, scan.grid.spacing_m[0], config).permeability_m2 / flow.permeability_m2 - 1.0;
    return row;
}

}  // namespace

GrayRun gray_run(const KnownFlow& flow, double voxels, const ScanSettings& settings) {
    GrayImage scan = simulated_scan(*flow.solid, flow.container, flow.diameter_m / voxels, settings);
    GrayInput input = read_gray(scans::scan_of(scan, 0.0, 1.0), {.threshold = imaging::ThresholdRule::volume, .gray_levels = {0.0, 1.0}},
                                flow.container, flow.name);
    const PoreSpace space = pore_space_of(input.solid, flow.container, {0.0, flow.container.height()}, flow.name);
    const LbmConfig config{.direction = flow.direction, .fields = FieldFiles::none};
    LbmResult result = lbm_permeability(space, space.voxel_size_m(0.0), config);
    add_gray_parts(result, space, config);
    return {std::move(scan), std::move(input), space, config, std::move(result)};
}

Json gray_benchmark(bool quick) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> place(0.0, 1.0);
    const auto anywhere = [&] { return shapes::Vec3(place(random), place(random), place(random)); };
    std::vector<Row> rows;
    Json json;
    // The constants of the interval were fitted to the first set; the second one judges them.
    const std::vector<double> voxels_of[] = {{10.0, 20.0, 40.0}, {14.0, 28.0}}, blurs_of[] = {{0.5, 1.0, 1.5}, {0.75, 1.25}};
    for (const std::size_t set : {0U, 1U})
        for (const double voxels : quick ? std::vector<double>{20.0} : voxels_of[set])
            for (const double blur : blurs_of[set]) {
                std::vector<KnownFlow> flows;
                if (set == 1)
                    for (const CylinderDrag& row : cylinder_drags())
                        if (row.solid_fraction < 0.6)  // the gaps of the densest are narrower than a voxel
                            flows.push_back(cylinder_array(row.solid_fraction, row.across, 0.25, anywhere(), Axis::x));
                for (const SphereDrag& row : sphere_drags()) {
                    if (set == 0 ? row.solid_fraction < 0.34 || row.solid_fraction == 0.4
                                 : row.solid_fraction < 0.1 || row.solid_fraction == 0.5)
                        continue;
                    if (row.simple_cubic > 0.0)
                        flows.push_back(sphere_array(row.solid_fraction, row.simple_cubic, simple_cubic(), anywhere()));
                    if (row.body_centred > 0.0)
                        flows.push_back(sphere_array(row.solid_fraction, row.body_centred, body_centred(), anywhere()));
                }
                for (const KnownFlow& flow : flows) {
                    rows.push_back(measure(flow, voxels, blur, 0.03, static_cast<unsigned>(rows.size() + 1)));
                    rows.back().to_judge = set == 1;
                    const Row& row = rows.back();
                    log_info("{}, {:g} voxels per diameter, blur {:g}: k {:+.2f} % +- {:.2f} %, half-way {:+.2f} %, porosity {:+.4f}",
                             row.flow, row.voxels, row.blur, 100.0 * row.error, 100.0 * row.half_width, 100.0 * row.half_way_error,
                             row.porosity_error);
                }
            }
    struct Set {
        std::vector<double> errors, widths;
        int held = 0;
    };
    Set sets[2];
    json["rows"] = Json::array();
    for (const Row& row : rows) {
        Set& set = sets[row.to_judge ? 1 : 0];
        set.held += row.held ? 1 : 0;
        set.errors.push_back(std::abs(row.error));
        set.widths.push_back(row.half_width);
        json["rows"].push_back({{"flow", row.flow},
                                {"to_judge", row.to_judge},
                                {"voxels_per_diameter", row.voxels},
                                {"blur_voxels", row.blur},
                                {"error", row.error},
                                {"half_width", row.half_width},
                                {"held", row.held},
                                {"porosity_error", row.porosity_error},
                                {"half_way_error", row.half_way_error},
                                {"parts", row.parts},
                                {"notes", row.notes}});
    }
    for (const std::size_t set : {0U, 1U})
        json[set == 0 ? "fitted" : "judged"] = {{"runs", sets[set].errors.size()},
                                                {"held", sets[set].held},
                                                {"median_error", median(sets[set].errors)},
                                                {"median_half_width", median(sets[set].widths)}};
    return json;
}

}  // namespace porepack::benchmarks
