#include "converters/pore_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace porepack::converters {
using namespace core;
using namespace shapes;
using namespace packing;
namespace {

// The image covers the container's cross-section, within two voxels.
void require_same_width(const Grid& grid, const Container& container, const std::string& where) {
    const Vec3 inner = container.high() - container.low();
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        const double width = grid.cells[a] * grid.spacing_m[a];
        if (std::abs(width - inner[axis]) > 2.01 * grid.spacing_m[a])
            throw UserError(fmt::format("the image is {:g} m wide along axis {}, the container {:g} m", width, axis, inner[axis]),
                            {.where = where, .fix = "give the container that the image shows (--container, metres)"});
    }
}

PhaseImage cropped(const PhaseImage& image, const Section& section) {
    const double h = image.grid.spacing_m[2];
    const auto layer_at = [&](double z) { return static_cast<int>(std::lround((z - image.grid.origin_m[2]) / h)); };
    const int low = std::clamp(layer_at(section.z0), 0, image.grid.cells[2] - 1),
              high = std::clamp(layer_at(section.z1), low + 1, image.grid.cells[2]);
    PhaseImage part{.grid = image.grid, .phase = {}, .notes = image.notes};
    part.grid.cells[2] = high - low;
    part.grid.origin_m[2] += low * h;
    const std::size_t layer = image.grid.index(0, 0, 1);
    part.phase.assign(image.phase.begin() + static_cast<std::ptrdiff_t>(layer * static_cast<std::size_t>(low)),
                      image.phase.begin() + static_cast<std::ptrdiff_t>(layer * static_cast<std::size_t>(high)));
    return part;
}

}  // namespace

double PoreSpace::known_grain_diameter_m() const {
    return solid && (grains || !surface) ? grain_size_m : std::numeric_limits<double>::infinity();
}

double PoreSpace::voxel_size_m(double asked_m) const {
    if (asked_m > 0.0) return asked_m;
    if (image) return image->grid.spacing_m[0];
    if (grains) return grain_size_m / 10.0;
    throw UserError("the voxel size is missing: an STL file does not contain the grain diameter",
                    {.fix = "--voxel-size (metres), or voxel_size_m in [geometry]"});
}

VoxelPlan PoreSpace::plan_at(double voxel_size_m) const {
    if (image)
        return {.grid = image->grid, .voxel_size_m = image->grid.spacing_m[2], .memory_bytes = static_cast<double>(image->grid.size())};
    return plan_voxels(container, section, voxel_size_m, reservoir_m, grain_size_m);
}

PhaseImage PoreSpace::voxelise_at(double voxel_size_m) const {
    return image ? *image : voxelise(*solid, container, section, plan_at(voxel_size_m));
}

std::optional<FlowWalls> PoreSpace::walls() const {
    if (!solid) return std::nullopt;
    return FlowWalls{*solid, container, section};
}

PoreSpace PoreSpace::section_only() const {
    PoreSpace part = *this;
    part.reservoir_m = 0.0;
    if (image) part.image = std::make_shared<const PhaseImage>(cropped(*image, section));
    return part;
}

PoreSpace PoreSpace::with_section(const Section& other) const {
    PoreSpace part = *this;
    part.section = other;
    return part;
}

Porosity PoreSpace::porosity(long lines) const {
    if (solid) return packing::porosity(*solid, container, section, lines);
    const PoreSpace part = section_only();
    double pores = 0.0, inside = 0.0;
    for (const std::uint8_t phase : part.image->phase) {
        pores += phase == Phase::pore ? 1.0 : 0.0;
        inside += phase != Phase::outside ? 1.0 : 0.0;
    }
    return {.value = inside > 0.0 ? pores / inside : 0.0, .uncertainty = std::numeric_limits<double>::quiet_NaN()};
}

std::array<bool, 3> PoreSpace::periodic_sides() const {
    return packing::periodic_sides(container, section);
}

PoreSpace pore_space_of(Packing packing) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain");
    PoreSpace space{.container = packing.container, .section = {}};
    space.grain_size_m = finest_diameter(packing);
    for (const auto& shape : packing.shapes)
        space.maximum_feret_diameter_m = std::max(space.maximum_feret_diameter_m, maximum_feret_diameter(shape));
    space.grains = std::make_shared<const Grains>(packing);
    space.solid = space.grains;
    space.packing = std::make_shared<const Packing>(std::move(packing));
    space.bed_top_m = space.grains->bounds().high.z();
    space.section = whole_bed(space.container, space.bed_top_m);
    return space;
}

PoreSpace pore_space_of(PhaseImage image, const Container& container, const Section& section, const std::string& where) {
    require_same_width(image.grid, container, where);
    const double h = image.grid.spacing_m[2], z0 = image.grid.origin_m[2], z1 = z0 + image.grid.cells[2] * h;
    if (section.z0 < z0 - 0.5 * h || section.z1 > z1 + 0.5 * h || section.length() < h)
        throw UserError(fmt::format("the section from {:g} to {:g} m is not in the image", section.z0, section.z1),
                        {.where = where, .allowed = fmt::format("{:g} <= z0 < z1 <= {:g} m", z0, z1)});
    PoreSpace space{.container = container, .section = section};
    space.image = std::make_shared<const PhaseImage>(std::move(image));
    space.bed_top_m = z1;
    return space;
}

PoreSpace pore_space_of(std::shared_ptr<const Solid> solid, const Container& container, const Section& section, double grain_size_m) {
    PoreSpace space{.container = container, .section = section};
    space.bed_top_m = solid->bounds().high.z();
    space.solid = std::move(solid);
    space.grain_size_m = grain_size_m;
    return space;
}

}  // namespace porepack::converters
