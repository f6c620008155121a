// Poses fitted to simulated X-ray scans of the settled beds, against the exact poses.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/fit_image.hpp"
#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "imaging/write_volume.hpp"
#include "scans/scanner.hpp"
#include "scans/shape_points.hpp"

namespace porepack::benchmarks {
using shapes::Vec3;
namespace {

struct Scene {
    std::string name;
    Packing packing;
    Section part;
    ScannerConfig scanner;
    double memory_bytes = 0.0;  ///< of the fit; 0: no limit
};

struct Errors {
    long whole = 0, found = 0, wrong = 0, cut = 0;
    double centre_rms = 0.0, end_rms = 0.0, end_largest = 0.0, stated_end_rms = 0.0, stated_centre_rms = 0.0,
           cut_end_rms = 0.0;  ///< in voxels
};

// By the ends of the capsules, in any order that the shape's symmetry allows.
Errors errors_of(const Scene& scene, const Packing& fitted, const std::vector<std::array<double, 2>>& stated_m) {
    Errors errors;
    const double h = scene.scanner.voxel_size_m;
    std::vector<std::vector<shapes::Capsule>> found;
    for (const Body& body : fitted.bodies) found.push_back(world_capsules(fitted, body));
    std::vector<bool> used(found.size(), false);
    double centres = 0.0, ends = 0.0, stated = 0.0, stated_centres = 0.0, cut_ends = 0.0;
    for (Body body : scene.packing.bodies) {
        body.position_m.z() -= scene.part.z0_m;
        const auto exact = world_capsules(scene.packing, body);
        shapes::Bounds bounds;
        for (const auto& capsule : exact) add(bounds, capsule);
        if (bounds.high.z() < 0.0 || bounds.low.z() > scene.part.length()) continue;
        const bool whole = bounds.low.z() >= 0.0 && bounds.high.z() <= scene.part.length();
        errors.whole += whole ? 1 : 0;
        std::size_t best = found.size();
        double least = 0.5 * exact[0].radius;
        for (std::size_t f = 0; f < found.size(); ++f)
            if (found[f].size() == exact.size())
                if (const double difference = scans::largest_difference_m(exact, found[f]); difference < least) {
                    least = difference;
                    best = f;
                }
        if (best == found.size()) continue;
        used[best] = true;
        if (!whole) {
            ++errors.cut;
            cut_ends += least * least;
            continue;
        }
        ++errors.found;
        centres += (fitted.bodies[best].position_m - body.position_m).squaredNorm();
        ends += least * least;
        stated_centres += stated_m[best][0] * stated_m[best][0];
        stated += stated_m[best][1] * stated_m[best][1];
        errors.end_largest = std::max(errors.end_largest, least / h);
    }
    for (const bool one : used) errors.wrong += one ? 0 : 1;
    const double n = std::max(1.0, static_cast<double>(errors.found));
    errors.centre_rms = std::sqrt(centres / n) / h;
    errors.end_rms = std::sqrt(ends / n) / h;
    errors.stated_centre_rms = std::sqrt(stated_centres / n) / h;
    errors.stated_end_rms = std::sqrt(stated / n) / h;
    errors.cut_end_rms = std::sqrt(cut_ends / std::max(1.0, static_cast<double>(errors.cut))) / h;
    return errors;
}

// Of position and end.
std::vector<std::array<double, 2>> stated_errors(const Path& file) {
    std::vector<std::array<double, 2>> errors;
    std::ifstream lines(file);
    std::string line, cell;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
        std::istringstream cells(line);
        for (int column = 0; column <= 10; ++column) std::getline(cells, cell, ',');
        const double centre = std::stod(cell);
        std::getline(cells, cell, ',');
        errors.push_back({centre, std::stod(cell)});
    }
    return errors;
}

Scene settled(const std::string& name, double voxels_per_diameter, Section part) {
    Scene scene{
        .name = name, .packing = read_packing(data_file("cases/paper_packing/settled/" + name + ".json.gz")), .part = part, .scanner = {}};
    scene.scanner.voxel_size_m = finest_diameter(scene.packing) / voxels_per_diameter;
    return scene;
}

}  // namespace

Json fit_benchmark(bool quick, const Path& given) {
    const Path folder = given.empty() ? Path("fit_scans") : given;
    make_folder(folder);
    Json rows = Json::array();
    std::vector<Scene> scenes = {settled("tetrapod_053", 8.0, {0.08, quick ? 0.12 : 0.16})};
    scenes.push_back(settled("tetrapod_053", 12.0, {0.08, quick ? 0.12 : 0.16}));
    scenes.push_back(settled("tetrahedron_074", 12.0, {0.08, quick ? 0.11 : 0.14}));
    scenes.push_back(settled("tetrapod_053", 16.0, {0.08, 0.12}));
    scenes.push_back(scenes.back());
    scenes.back().memory_bytes = 1e8;  // the same scan, slab by slab
    for (const Scene& scene : scenes) {
        const Path scan = folder / fmt::format("{}_{:.3g}.nrrd", scene.name, scene.scanner.voxel_size_m);
        Stopwatch watch;
        if (!std::filesystem::exists(scan)) {
            const SimulatedScan image = scan_packing(scene.packing, scene.part, scene.scanner);
            imaging::write_volume(scan, imaging::source_of(image.grid, image.values));
        }
        const double scan_s = watch.seconds();
        const Path target = folder / scan.stem();
        make_folder(target);
        watch = {};
        reset_peak_memory();
        const results::Fit found = written(
            fit_image(scan, {.find_container = true, .fit_memory_bytes = scene.memory_bytes}, std::nullopt, scene.packing.shapes), target);
        const double seconds = watch.seconds();
        const Packing fitted = read_packing(target / "packing.json");
        const Errors errors = errors_of(scene, fitted, stated_errors(target / "grains.csv"));
        const Section inner = found.section_m ? Section{found.section_m->low, found.section_m->high} : Section{0.0, scene.part.length()};
        const Json row = {
            {"packing", scene.name},
            {"voxels_per_diameter", finest_diameter(scene.packing) / scene.scanner.voxel_size_m},
            {"memory_bytes", scene.memory_bytes},
            {"peak_memory_bytes", peak_memory_bytes()},
            {"whole_grains", errors.whole},
            {"found", errors.found},
            {"wrong", errors.wrong},
            {"cut_found", errors.cut},
            {"centre_rms_voxels", errors.centre_rms},
            {"end_rms_voxels", errors.end_rms},
            {"end_largest_voxels", errors.end_largest},
            {"stated_centre_rms_voxels", errors.stated_centre_rms},
            {"stated_end_rms_voxels", errors.stated_end_rms},
            {"cut_end_rms_voxels", errors.cut_end_rms},
            {"section_m", json_of(found.section_m)},
            {"porosity", porosity(Grains(fitted), fitted.container, inner).value},
            {"porosity_exact",
             porosity(Grains(scene.packing), scene.packing.container, {scene.part.z0_m + inner.z0_m, scene.part.z0_m + inner.z1_m}).value},
            {"diameter_error_m", *fitted.container.tube_diameter() - *scene.packing.container.tube_diameter()},
            {"sizes", json_of(found.sizes)},
            {"residual", found.residual},
            {"doubts", json_of(found.doubts)},
            {"scan_s", scan_s},
            {"fit_s", seconds}};
        log_info("{}", row.dump());
        rows.push_back(row);
    }
    return {{"rows", rows}};
}

}  // namespace porepack::benchmarks
