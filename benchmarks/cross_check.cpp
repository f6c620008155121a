// Both flow solvers on the same section of the same packing: k, interval, cost, and mean profiles of the speed.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/benchmarks.hpp"
#include "core/error.hpp"
#include "core/json.hpp"
#include "io/image.hpp"
#include "openfoam/foam_field.hpp"
#include "stages/case.hpp"
#include "study/case_pipeline.hpp"

namespace porepack::benchmarks {
namespace {

constexpr std::size_t bins = 16;

std::string name_of_folder(const Path& folder) {
    return std::filesystem::absolute(folder / ".").lexically_normal().parent_path().filename().string();
}

// Mean speed (solid counts as zero) in equal slabs along z and equal areas along r, over the superficial velocity.
struct Profiles {
    std::array<double, bins> along_z{}, along_r{};
    double flow = 0.0;

    // A cell may be wider than a bin: its volume is spread over a cube.
    void add_cell(const Container& container, const Section& section, const Vec3& centre, const Vec3& velocity, double volume) {
        constexpr int parts = 4;
        const double part = std::cbrt(volume) / parts;
        for (int i = 0; i < parts * parts * parts; ++i) {
            const Vec3 at = Vec3(i % parts, i / parts % parts, i / parts / parts) - Vec3::Constant(0.5 * (parts - 1));
            add(container, section, centre + part * at, velocity, volume / (parts * parts * parts));
        }
    }
    void add(const Container& container, const Section& section, const Vec3& place, const Vec3& velocity, double volume) {
        const Vec3 low = container.low(), high = container.high();
        const double z = (place.z() - section.z0_m) / section.length();
        const double side = std::max(std::abs((place.x() - low.x()) / (high.x() - low.x()) - 0.5),
                                     std::abs((place.y() - low.y()) / (high.y() - low.y()) - 0.5));
        const double r = container.tube_diameter() ? place.head<2>().norm() / (0.5 * *container.tube_diameter()) : 2.0 * side;
        if (z < 0.0 || z >= 1.0) return;
        flow += velocity.z() * volume;
        along_z[static_cast<std::size_t>(z * bins)] += velocity.norm() * volume;
        along_r[std::min(bins - 1, static_cast<std::size_t>(r * r * bins))] += velocity.norm() * volume;
    }
    void normalise() {
        for (std::size_t i = 0; i < bins; ++i) {
            along_z[i] *= bins / flow;
            along_r[i] *= bins / flow;
        }
    }
};

double difference(const std::array<double, bins>& a, const std::array<double, bins>& b) {
    double squares = 0.0, size = 0.0;
    for (std::size_t i = 0; i < bins; ++i) {
        squares += (a[i] - b[i]) * (a[i] - b[i]);
        size += b[i] * b[i];
    }
    return std::sqrt(squares / size);
}

Json solver_json(const Json& result, const Json& manifest) {
    return {{"permeability_m2", result.at("permeability_m2")},
            {"permeability_interval_m2", result.at("permeability_interval_m2")},
            {"wall_time_s", manifest.at("wall_time_s")},
            {"peak_memory_bytes", manifest.at("peak_memory_bytes")}};
}

}  // namespace

Json cross_check_benchmark(const std::vector<Path>& folders, const Path& output) {
    if (folders.empty()) throw UserError("no case is given", {.fix = "porepack benchmark cross-check cases/cross_check"});
    Json rows = Json::array();
    for (const Path& folder : folders) {
        const Case c = read_case(folder);
        if (!c.settings.openfoam.enabled)
            throw UserError("this case disables OpenFOAM", {.where = folder.string(), .fix = "openfoam.enabled = true"});
        const Json lbm = run_pipeline(case_pipeline(c), "lbm"), foam = run_pipeline(case_pipeline(c), "foam");
        const auto manifest = [&](const char* stage) { return read_json(c.results() / stage / "manifest.json"); };
        const Section section{lbm.at("section_m").at(0).get<double>(), lbm.at("section_m").at(1).get<double>()};
        const Container container = make_container(c.settings.container);
        Profiles by_lbm, by_foam;
        const FlowImage image = read_flow_image(c.results() / "lbm" / "flow.vti");
        const double voxel = image.grid.spacing_m[0] * image.grid.spacing_m[1] * image.grid.spacing_m[2];
        for (int k = 0; k < image.grid.cells[2]; ++k)
            for (int j = 0; j < image.grid.cells[1]; ++j)
                for (int i = 0; i < image.grid.cells[0]; ++i) {
                    const float* const u = image.velocity_m_per_s.data() + 3 * image.grid.index(i, j, k);
                    const Vec3 velocity(u[0], u[1], u[2]);
                    if (!velocity.isZero())
                        by_lbm.add_cell(container, section, {image.grid.centre(0, i), image.grid.centre(1, j), image.grid.centre(2, k)},
                                        velocity, voxel);
                }
        for (const FoamCell& cell : read_foam_cells(c.results() / "foam" / "mesh_fine"))
            by_foam.add_cell(container, section, cell.centre_m, cell.velocity, cell.volume_m3);
        by_lbm.normalise();
        by_foam.normalise();
        const double a = lbm.at("permeability_m2").get<double>(), b = foam.at("permeability_m2").get<double>();
        const Json &one = lbm.at("permeability_interval_m2"), &other = foam.at("permeability_interval_m2");
        const bool overlap = one.is_array() && other.is_array() && one.at(0) <= other.at(1) && other.at(0) <= one.at(1);
        rows.push_back(
            {{"case", name_of_folder(folder)},
             {"section_m", lbm.at("section_m")},
             {"lbm", solver_json(lbm, manifest("lbm"))},
             {"openfoam", solver_json(foam, manifest("foam"))},
             {"openfoam_against_lbm", b / a - 1.0},
             {"intervals_overlap", overlap},
             {"openfoam_time_over_lbm", manifest("foam").at("wall_time_s").get<double>() / manifest("lbm").at("wall_time_s").get<double>()},
             {"speed_profile_z_difference", difference(by_foam.along_z, by_lbm.along_z)},
             {"speed_profile_r_difference", difference(by_foam.along_r, by_lbm.along_r)},
             {"speed_profile_z", {{"lbm", by_lbm.along_z}, {"openfoam", by_foam.along_z}}},
             {"speed_profile_r", {{"lbm", by_lbm.along_r}, {"openfoam", by_foam.along_r}}}});
        if (!output.empty()) {
            std::string data = "# bin, LBM, OpenFOAM along z; LBM, OpenFOAM along r\n";
            for (std::size_t i = 0; i < bins; ++i)
                data += fmt::format("{} {:.6g} {:.6g} {:.6g} {:.6g}\n", i, by_lbm.along_z[i], by_foam.along_z[i], by_lbm.along_r[i],
                                    by_foam.along_r[i]);
            write_text(output / ("cross_check_" + name_of_folder(folder) + ".dat"), data);
        }
    }
    return {{"cases", rows}};
}

}  // namespace porepack::benchmarks
