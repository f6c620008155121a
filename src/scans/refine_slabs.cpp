#include "scans/refine_slabs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/log.hpp"
#include "scans/uses.hpp"

namespace porepack::scans {
namespace {

constexpr double bytes_per_voxel = 2.0;

double farthest_reach_m(const std::vector<ShapePoints>& shapes) {
    double reach = 0.0;
    for (const ShapePoints& shape : shapes) reach = std::max(reach, shape.reach_m);
    return reach;
}

// Layers that a grain reaches beyond its middle, with its band.
int margin_layers(const Grid& grid, const std::vector<ShapePoints>& shapes, double blur_m) {
    return static_cast<int>(std::ceil((1.02 * farthest_reach_m(shapes) + 3.0 * blur_m) / grid.spacing_m[2])) + 2;
}

double layer_bytes(const Grid& grid) {
    return bytes_per_voxel * static_cast<double>(grid.cells[0]) * grid.cells[1];
}

// Means of estimates, weighted by the number of grains that each is from.
class Mean {
public:
    void add(const Estimate& estimate, double grains) {
        sum_ += grains * estimate.value;
        squares_ += grains * grains * estimate.uncertainty * estimate.uncertainty;
        grains_ += grains;
    }
    [[nodiscard]] Estimate value_or(const Estimate& other) const {
        return grains_ > 0.0 ? Estimate{sum_ / grains_, std::sqrt(squares_) / grains_} : other;
    }

private:
    double sum_ = 0.0, squares_ = 0.0, grains_ = 0.0;
};

struct CommonMean {
    Mean pores, solid, blur;
    struct OfShape {
        Mean radius_change, length_factor;
    };
    std::vector<OfShape> shapes;

    void add(const Common& common, const std::vector<double>& grains_of_shape) {
        double all = 0.0;
        for (std::size_t s = 0; s < shapes.size(); ++s) {
            shapes[s].radius_change.add(common.shapes[s].radius_change_m, grains_of_shape[s]);
            shapes[s].length_factor.add(common.shapes[s].length_factor, grains_of_shape[s]);
            all += grains_of_shape[s];
        }
        pores.add(common.pores, all);
        solid.add(common.solid, all);
        blur.add(common.blur_m, all);
    }
    [[nodiscard]] Common result(Common common) const {
        common.pores = pores.value_or(common.pores);
        common.solid = solid.value_or(common.solid);
        common.blur_m = blur.value_or(common.blur_m);
        for (std::size_t s = 0; s < shapes.size(); ++s) {
            common.shapes[s].radius_change_m = shapes[s].radius_change.value_or(common.shapes[s].radius_change_m);
            common.shapes[s].length_factor = shapes[s].length_factor.value_or(common.shapes[s].length_factor);
        }
        return common;
    }
};

}  // namespace

double smallest_slab_bytes(const Grid& grid, const std::vector<ShapePoints>& shapes, double blur_m) {
    return layer_bytes(grid) * std::min(grid.cells[2], 3 * margin_layers(grid, shapes, blur_m));
}

Refined refine_slabs(const ReadLayers& read, const Grid& grid, const vessels::Container& container, const std::vector<ShapePoints>& shapes,
                     const Refined& start, double slab_bytes) {
    const double blur = start.common.blur_m.value, h = grid.spacing_m[2];
    const int margin = margin_layers(grid, shapes, blur);
    const int maximum = static_cast<int>(std::min(slab_bytes / layer_bytes(grid), 1.0 * grid.cells[2])) - 2 * margin;
    const int slabs = (grid.cells[2] + std::max(maximum, margin) - 1) / std::max(maximum, margin);
    const int core = (grid.cells[2] + slabs - 1) / slabs;
    Refined found = start;
    CommonMean mean{.pores = {}, .solid = {}, .blur = {}, .shapes = std::vector<CommonMean::OfShape>(shapes.size())};
    const double neighbourhood = 2.2 * farthest_reach_m(shapes) + 12.0 * blur;
    for (int slab = 0; slab < slabs; ++slab) {
        // Grains beyond the first or the last layer, which the ends cut, belong to the first or the last slab.
        const auto slab_of = [&](const FittedGrain& grain) {
            return std::clamp(static_cast<int>(std::floor((grain.pose.position_m.z() - grid.origin_m[2]) / (h * core))), 0, slabs - 1);
        };
        const double from = grid.origin_m[2] + h * core * slab, to = from + h * core;
        std::vector<std::size_t> members;
        std::vector<double> of_shape(shapes.size(), 0.0);
        for (std::size_t g = 0; g < found.grains.size(); ++g)
            if (slab_of(start.grains[g]) == slab) {
                members.push_back(g);
                of_shape[found.grains[g].shape] += 1.0;
            }
        const std::size_t moving = members.size();
        if (moving == 0) continue;
        for (std::size_t g = 0; g < found.grains.size(); ++g)
            if (const double z = found.grains[g].pose.position_m.z();
                slab_of(start.grains[g]) != slab && z > from - neighbourhood && z < to + neighbourhood)
                members.push_back(g);
        std::vector<FittedGrain> grains;
        for (const std::size_t g : members) grains.push_back(found.grains[g]);
        const int first = std::max(0, slab * core - margin), end = std::min(grid.cells[2], (slab + 1) * core + margin);
        log_info("slab {} of {}: layers {} to {}, {} grains", slab + 1, slabs, first, end - 1, moving);
        const Refined part = refine(read(first, end - first), container, shapes, std::move(grains), start.common, moving);
        for (std::size_t m = 0; m < moving; ++m) found.grains[members[m]] = part.grains[m];
        mean.add(part.common, of_shape);
    }
    found.common = mean.result(start.common);
    double squares = 0.0;
    for (const FittedGrain& grain : found.grains) squares += grain.residual * grain.residual;
    found.residual = std::sqrt(squares / std::max(1.0, static_cast<double>(found.grains.size())));
    return found;
}

}  // namespace porepack::scans
