#include "pore_space/image_solid.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

// The voxel that holds a coordinate; outside the image less than 0, or the number of voxels or more.
int voxel_at(const Grid& grid, std::size_t axis, double coordinate) {
    return static_cast<int>(std::floor((coordinate - grid.origin_m[axis]) / grid.spacing_m[axis]));
}

bool is_inside(const Grid& grid, const std::array<int, 3>& at) {
    for (std::size_t a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= grid.cells[a]) return false;
    return true;
}

}  // namespace

class ImageSolid::Probe : public SolidProbe {
public:
    explicit Probe(const ImageSolid& solid) : solid_(solid) {}
    void move_to(const Vec3&, double) override {}
    [[nodiscard]] std::optional<double> first_hit(const Vec3& from, const Vec3& step) const override {
        const Vec3 end = from + step;
        const Grid& grid = solid_.image_.grid;
        const std::array<int, 3> at = {voxel_at(grid, 0, end.x()), voxel_at(grid, 1, end.y()), voxel_at(grid, 2, end.z())};
        if (!is_inside(grid, at) || !solid_.is_grain(at[0], at[1], at[2])) return std::nullopt;
        return 0.5;
    }

private:
    const ImageSolid& solid_;
};

std::unique_ptr<SolidProbe> ImageSolid::probe() const {
    return std::make_unique<Probe>(*this);
}

void ImageSolid::column(double x, double y, std::vector<Interval>& parts) const {
    parts.clear();
    const Grid& grid = image_.grid;
    const int i = voxel_at(grid, 0, x), j = voxel_at(grid, 1, y);
    if (!is_inside(grid, {i, j, 0})) return;
    for (int k = 0; k < grid.cells[2]; ++k) {
        if (!layers_.has(k) || !is_grain(i, j, k)) continue;
        const double low = grid.origin_m[2] + k * grid.spacing_m[2];
        while (k + 1 < grid.cells[2] && layers_.has(k + 1) && is_grain(i, j, k + 1)) ++k;
        parts.push_back({low, grid.origin_m[2] + (k + 1) * grid.spacing_m[2]});
    }
}

PhaseImage ImageSolid::own_phases(const Grid& layers) const {
    const long low = std::lround((layers.origin_m[2] - image_.grid.origin_m[2]) / layers.spacing_m[2]);
    const auto cells = static_cast<std::ptrdiff_t>(layers.index(0, 0, 1));
    PhaseImage part{.grid = layers, .phase = {}, .notes = image_.notes};
    part.phase.reserve(layers.size());
    for (int k = 0; k < layers.cells[2]; ++k) {
        const int layer = static_cast<int>(low) + layers.layer(k);
        if (!layers_.has(layer)) throw std::logic_error("phases of layers that this part of an image does not keep");
        const auto first = image_.phase.begin() + layers_.place(layer) * cells;
        part.phase.insert(part.phase.end(), first, first + cells);
    }
    return part;
}

std::shared_ptr<const Solid> ImageSolid::between(const std::vector<Interval>& heights_m, bool periodic) const {
    const KnownLayers layers(image_.grid, heights_m, periodic);
    PhaseImage kept{.grid = image_.grid, .phase = layers.values(image_.grid, layers_, image_.phase), .notes = image_.notes};
    return std::shared_ptr<const ImageSolid>(new ImageSolid(std::move(kept), layers));
}

void ImageSolid::near_column(double, double, double, std::vector<Interval>& parts) const {
    parts.clear();
}

Bounds ImageSolid::bounds() const {
    const Vec3 low(image_.grid.origin_m.data());
    const Vec3 size =
        Vec3(image_.grid.spacing_m.data()).cwiseProduct(Vec3(image_.grid.cells[0], image_.grid.cells[1], image_.grid.cells[2]));
    return {low, low + size};
}

}  // namespace porepack::pore_space
