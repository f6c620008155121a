// Segmentation of simulated scans of the settled beds: grains found, intersection over union, porosity.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/segment.hpp"
#include "benchmarks/benchmarks.hpp"
#include "core/data_file.hpp"
#include "core/log.hpp"
#include "core/machine.hpp"
#include "core/members_json.hpp"
#include "imaging/write_volume.hpp"
#include "scans/gray_levels.hpp"
#include "support/simulated_scan.hpp"

namespace porepack::benchmarks {
using namespace test;
namespace {

struct Scene {
    const char* packing;
    double voxel_m;
    Section part;
    double separation;
};

struct Scores {
    int whole = 0, above_95 = 0, above_80 = 0;
    double median = 0.0;
};

// Of the grains that lie in the part as a whole: the label that shares most voxels with a grain.
Scores scores_of(const Grains& grains, std::size_t bodies, const Grid& grid, const std::vector<float>& label, double bottom_m) {
    std::vector<std::map<int, double>> shared(bodies);
    std::map<int, double> size;
    std::vector<double> own(bodies, 0.0);
    std::vector<bool> whole(bodies, false);
    for (const float value : label) size[static_cast<int>(value)] += 1.0;
    for (const Grains::Image& image : grains.images()) {
        const double top = bottom_m + grid.cells[2] * grid.spacing_m[2];
        whole[image.body] = image.bounds.low.z() > bottom_m && image.bounds.high.z() < top;
        if (!whole[image.body]) continue;
        std::array<int, 3> low{}, high{};
        for (const int axis : {0, 1, 2}) {
            const auto a = static_cast<std::size_t>(axis);
            const double origin = grid.origin_m[a] + (axis == 2 ? bottom_m : 0.0);
            low[a] = std::max(0, static_cast<int>((image.bounds.low[axis] - origin) / grid.spacing_m[a]));
            high[a] = std::min(grid.cells[a] - 1, static_cast<int>((image.bounds.high[axis] - origin) / grid.spacing_m[a]));
        }
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i) {
                    const shapes::Vec3 centre(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k) + bottom_m);
                    const bool inside = std::any_of(image.capsules.begin(), image.capsules.end(), [&](const shapes::Capsule& capsule) {
                        return shapes::signed_distance(capsule, centre) < 0.0;
                    });
                    if (!inside) continue;
                    own[image.body] += 1.0;
                    shared[image.body][static_cast<int>(label[grid.index(i, j, k)])] += 1.0;
                }
    }
    Scores scores;
    for (std::size_t body = 0; body < bodies; ++body) {
        if (!whole[body]) continue;
        double best = 0.0;
        for (const auto& [value, count] : shared[body])
            if (value != 0) best = std::max(best, count / (own[body] + size[value] - count));
        ++scores.whole;
        scores.above_95 += best > 0.95 ? 1 : 0;
        scores.above_80 += best > 0.8 ? 1 : 0;
    }
    return scores;
}

}  // namespace

Json segment_benchmark(bool quick, const Path& given) {
    const Path folder = given.empty() ? Path("segment_scans") : given;
    make_folder(folder);
    Json rows = Json::array();
    const double height = quick ? 0.02 : 0.04;
    for (const Scene& scene :
         {Scene{"tetrapod_053", 2.5e-4, {0.1, 0.1 + height}, 0.25}, Scene{"tetrahedron_074", 2.5e-4, {0.1, 0.1 + height}, 0.25}}) {
        const Packing packing = read_packing(data_file(std::string("cases/paper_packing/settled/") + scene.packing + ".json.gz"));
        const Grains grains(packing);
        const Path scan = folder / (std::string(scene.packing) + ".nrrd"), target = folder / scene.packing;
        {
            const GrayImage image = simulated_scan(grains, packing.container, scene.voxel_m,
                                                   {.blur_voxels = 0.7, .noise = 0.05, .seed = 4, .tube = true, .part = scene.part});
            write_volume(scan, scans::scan_of(image, 60.0, 180.0));
        }
        make_folder(target);
        Stopwatch watch;
        const results::Segment found =
            written(segment_image(scan, {.find_container = true}, std::nullopt, {.separation = scene.separation}), target);
        const double seconds = watch.seconds();
        const imaging::VolumeSource labels = imaging::open_volume(target / "labels.vti", {.unit_m = 1.0, .field = "label"});
        std::vector<float> label(static_cast<std::size_t>(labels.header.count()));
        labels.read(0, label);
        Grid grid;
        for (std::size_t a = 0; a < 3; ++a) {
            grid.cells[a] = static_cast<int>(labels.header.voxels[a]);
            grid.origin_m[a] = labels.header.origin_m[a];
            grid.spacing_m[a] = labels.header.spacing_m[a];
        }
        const Scores scores = scores_of(grains, packing.bodies.size(), grid, label, scene.part.z0_m);
        Json row = {{"packing", scene.packing},
                    {"voxel_size_m", grid.spacing_m[0]},
                    {"voxels", grid.cells},
                    {"whole_grains", scores.whole},
                    {"intersection_over_union_above_0.95", scores.above_95},
                    {"intersection_over_union_above_0.8", scores.above_80},
                    {"container", json_of(found.container)},
                    {"grains", json_of(found.grains)},
                    {"porosity", json_of(found.porosity)},
                    {"section_m", json_of(found.section_m)},
                    {"seconds", seconds}};
        if (found.section_m) {
            const Section section{scene.part.z0_m + found.section_m->low, scene.part.z0_m + found.section_m->high};
            row["porosity_exact"] = porosity(grains, packing.container, section).value;
        }
        log_info("{}", row.dump());
        rows.push_back(row);
    }
    return {{"rows", rows}};
}

}  // namespace porepack::benchmarks
