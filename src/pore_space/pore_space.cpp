#include "pore_space/pore_space.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/log.hpp"
#include "pore_space/find_cuts.hpp"
#include "pore_space/gray_solid.hpp"
#include "pore_space/image_solid.hpp"
#include "pore_space/uses.hpp"

namespace porepack::pore_space {
namespace {

// The image covers the container's cross-section, within two voxels.
void require_same_width(const Grid& grid, const Container& container, const std::string& where, bool shows_wall) {
    const Vec3 inner = container.high() - container.low();
    for (const int axis : {0, 1}) {
        const auto a = static_cast<std::size_t>(axis);
        const double width = grid.cells[a] * grid.spacing_m[a];
        const double allowed = container.periodic()[a] ? 0.01 : 2.01;  // voxels; a periodic image of another size is another medium
        if (shows_wall && container.tube_diameter() && width > inner[axis]) continue;
        if (std::abs(width - inner[axis]) > allowed * grid.spacing_m[a])
            throw UserError(fmt::format("the image is {:g} m wide along axis {}, the container {:g} m", width, axis, inner[axis]),
                            {.where = where, .fix = "give the container that the image shows (--container, metres)"});
    }
}

// The layers of cells between the planes of the section.
Grid cropped_grid(Grid grid, const Section& section) {
    const double h = grid.spacing_m[2];
    const auto layer_at = [&](double z) { return static_cast<int>(std::lround((z - grid.origin_m[2]) / h)); };
    const int low = std::clamp(layer_at(section.z0_m), 0, grid.cells[2] - 1),
              high = std::clamp(layer_at(section.z1_m), low + 1, grid.cells[2]);
    grid.cells[2] = high - low;
    grid.origin_m[2] += low * h;
    return grid;
}

}  // namespace

const Grains* PoreSpace::grains() const {
    return dynamic_cast<const Grains*>(solid.get());
}

const Packing* PoreSpace::packing() const {
    const Grains* const found = grains();
    return found ? &found->packing() : nullptr;
}

const GraySolid* PoreSpace::gray() const {
    return dynamic_cast<const GraySolid*>(solid.get());
}

double PoreSpace::known_grain_diameter_m() const {
    return has_exact_walls() && !surface() ? grain_size_m : std::numeric_limits<double>::infinity();
}

double PoreSpace::voxel_size_m(double asked_m) const {
    if (const Grid* const grid = own_grid()) {
        const double own = grid->spacing_m[0];
        if (asked_m > 0.0 && std::abs(asked_m / own - 1.0) > 1e-6)
            throw UserError(
                fmt::format("a segmented image is its own grid of {:g} m: a voxel size of {:g} m has no effect", own, asked_m),
                {.where = source, .fix = "remove --voxel-size (voxel_size_m in [geometry]); porepack image bin makes larger voxels"});
        return own;
    }
    if (asked_m > 0.0) return asked_m;
    if (image_voxel_size_m > 0.0) return image_voxel_size_m;
    if (grains() || closing_radius_m > 0.0) return grain_size_m / 10.0;
    throw UserError("the voxel size is missing: an STL file does not contain the grain diameter",
                    {.fix = "--voxel-size (metres), or voxel_size_m in [geometry]"});
}

VoxelPlan PoreSpace::plan_at(double voxel_size_m) const {
    if (!own_grid()) return plan_voxels(container, section, voxel_size_m, {buffers_m, reservoir_m}, grain_size_m, round_sides);
    const Grid grid = cropped_grid(*own_grid(), computed());
    return {.grid = grid, .voxel_size_m = grid.spacing_m[2], .memory_bytes = static_cast<double>(grid.size())};
}

PhaseImage PoreSpace::phases_on(const Grid& grid) const {
    return own_grid() ? solid->own_phases(grid) : voxelise(*solid, container, section, grid, kept_solid());
}

PhaseImage PoreSpace::voxelise_at(double voxel_size_m) const {
    return phases_on(plan_at(voxel_size_m).grid);
}

PoreSpace PoreSpace::stretched(const Stretch& stretch) const {
    PoreSpace space = *this;
    const double up = stretch[2];
    space.container = container.resized(container.size().cwiseProduct(Vec3(stretch.data())));
    space.section = {up * section.z0_m, up * section.z1_m};
    space.bed_bottom_m *= up;
    space.bed_top_m *= up;
    space.solid = std::make_shared<const StretchedSolid>(solid, stretch);
    return space;
}

CubicVoxels cubic_voxels(const PoreSpace& space, double voxel_size_m, const std::function<Grid(const Grid&)>& part) {
    const Grid whole = space.plan_at(voxel_size_m).grid;
    CubicVoxels voxels{.image = space.phases_on(part ? part(whole) : whole), .space = space};
    if (space.own_grid()) return voxels;
    voxels.stretch = stretch_to_cubes(voxels.image.grid);
    if (!voxels.stretch) return voxels;
    const auto& [x, y, z] = *voxels.stretch;
    log_info("the box is stretched by {:+.2f} % along x, {:+.2f} % along y and {:+.2f} % along z: whole numbers of cubic voxels",
             100.0 * (x - 1.0), 100.0 * (y - 1.0), 100.0 * (z - 1.0));
    stretch_grid(voxels.image.grid, *voxels.stretch);
    voxels.space = space.stretched(*voxels.stretch);
    return voxels;
}

// Without reservoirs the grid ends where the flow ends, and nothing is cut: beyond the grid lies its mirror image.
Section PoreSpace::kept_solid() const {
    return reservoir_m > 0.0 ? computed() : Section{bed_bottom_m - container.height(), bed_top_m + container.height()};
}

std::optional<FlowWalls> PoreSpace::walls() const {
    if (!has_exact_walls()) return std::nullopt;
    return FlowWalls{*solid, container, kept_solid()};
}

LinkCuts PoreSpace::link_cuts(const PhaseImage& phases, const Drive& drive) const {
    const std::optional<FlowWalls> exact = walls();
    return exact ? find_cuts(phases, *exact, drive) : find_cuts(phases, drive);
}

bool PoreSpace::computes_whole_bed() const {
    const double rounding = 1e-9 * container.height();
    return ends == Ends::in_situ && !own_grid() && image_voxel_size_m == 0.0 && !container.periodic()[2] &&
           std::abs(computed().z0_m - bed_bottom_m) < rounding && std::abs(computed().z1_m - bed_top_m) < rounding;
}

PoreSpace PoreSpace::section_only() const {
    PoreSpace part = with_ends(Ends::planes);
    part.reservoir_m = 0.0;
    if (own_grid()) part.solid = std::make_shared<const ImageSolid>(solid->own_phases(cropped_grid(*own_grid(), section)));
    return part;
}

PoreSpace PoreSpace::between(const std::vector<Interval>& heights_m) const {
    PoreSpace part = *this;
    if (std::shared_ptr<const Solid> smaller = solid->between(heights_m, container.periodic()[2])) {
        part.solid = std::move(smaller);
        part.kept_m = heights_m;
    }
    return part;
}

bool PoreSpace::is_known(const Section& part) const {
    return kept_m.empty() ||
           std::any_of(kept_m.begin(), kept_m.end(), [&](const Interval& kept) { return kept.low <= part.z0_m && part.z1_m <= kept.high; });
}

PoreSpace PoreSpace::with_section(const Section& other) const {
    PoreSpace part = with_ends(Ends::planes);
    part.section = other;
    return part;
}

PoreSpace PoreSpace::with_ends(Ends wanted, double buffer_m) const {
    PoreSpace part = *this;
    part.ends = wanted;
    part.buffers_m = {0.0, 0.0};
    if (wanted != Ends::in_situ || container.periodic()[2]) return part;
    const double longest = buffer_m > 0.0 ? buffer_m : default_buffer_m();
    part.buffers_m = {std::clamp(section.z0_m - bed_bottom_m, 0.0, longest), std::clamp(bed_top_m - section.z1_m, 0.0, longest)};
    const double voxel = own_grid() ? own_grid()->spacing_m[2] : image_voxel_size_m;
    if (std::min(part.buffers_m[0], part.buffers_m[1]) < voxel) return with_ends(Ends::planes);  // 0: no image
    return part;
}

double PoreSpace::default_buffer_m() const {
    const Vec3 inner = container.high() - container.low();
    const double half_width = 0.5 * std::min(inner.x(), inner.y());
    return equivalent_diameter_m > 0.0 ? std::min(1.5 * equivalent_diameter_m, half_width) : half_width;
}

// A voxel whose centre is in a thinner grain lies completely in the grain: if the other voxels do not connect, nothing does.
bool PoreSpace::certainly_blocked(double voxel_size_m, const Drive& drive) const {
    const VoxelPlan plan = plan_at(voxel_size_m);
    const double h = std::ranges::max(plan.grid.spacing_m);
    PoreSpace space = with_section(computed());
    space.solid = solid ? solid->thinned(0.5 * std::numbers::sqrt3 * h) : nullptr;
    if (!space.solid) return false;
    PhaseImage blocked = space.voxelise_at(plan.voxel_size_m);
    // Voxels that reach into the vessel count too, although their centres lie outside.
    const Grid& grid = blocked.grid;
    std::vector<Interval> parts;
    for (int j = 0; j < grid.cells[1]; ++j)
        for (int i = 0; i < grid.cells[0]; ++i) {
            space.solid->column(grid.centre(0, i), grid.centre(1, j), parts);
            for (int k = 0; k < grid.cells[2]; ++k) {
                std::uint8_t& phase = blocked.phase[grid.index(i, j, k)];
                const Vec3 centre(grid.centre(0, i), grid.centre(1, j), grid.centre(2, k));
                if (phase != Phase::outside || container.wall_distance(centre) < -0.5 * std::numbers::sqrt3 * h) continue;
                phase = geometry::contains(parts, centre.z()) ? Phase::grain : Phase::pore;
            }
        }
    try {
        (void)find_percolating_cells(blocked, drive);
    } catch (const DoesNotPercolate&) {
        return true;
    }
    return false;
}

Porosity PoreSpace::porosity(long lines) const {
    if (!own_grid()) {
        Porosity found = packing::porosity(*solid, container, section, lines);
        found.uncertainty = std::hypot(found.uncertainty, image_porosity_error);
        return found;
    }
    double pores = 0.0, inside = 0.0;
    for (const std::uint8_t phase : solid->own_phases(cropped_grid(*own_grid(), section)).phase) {
        pores += phase == Phase::pore ? 1.0 : 0.0;
        inside += phase != Phase::outside ? 1.0 : 0.0;
    }
    return {.value = inside > 0.0 ? pores / inside : 0.0, .uncertainty = std::numeric_limits<double>::quiet_NaN()};
}

std::array<bool, 3> PoreSpace::periodic_sides() const {
    return packing::periodic_sides(container, section);
}

PoreSpace pore_space_of(Packing packing) {
    if (packing.bodies.empty()) throw UserError("the packing has no grain", {.fix = "packing.json needs bodies: porepack pack"});
    PoreSpace space{.container = packing.container, .section = {}};
    space.grain_size_m = finest_diameter(packing);
    for (const auto& shape : packing.shapes)
        space.maximum_feret_diameter_m = std::max(space.maximum_feret_diameter_m, maximum_feret_diameter(shape));
    space.equivalent_diameter_m = grain_means(packing).equivalent_diameter_m;
    space.solid = std::make_shared<const Grains>(std::move(packing));
    space.bed_bottom_m = std::max(0.0, space.solid->bounds().low.z());
    space.bed_top_m = space.solid->bounds().high.z();
    space.section = whole_bed(space.container, {space.bed_bottom_m, space.bed_top_m});
    return space;
}

PoreSpace pore_space_of(PhaseImage image, const Container& container, const Section& section, const std::string& where) {
    require_fit(image.grid, container, section, where, image.notes.contains("shows_wall"));
    PoreSpace space{.container = container, .section = section};
    space.bed_bottom_m = image.grid.origin_m[2];
    space.bed_top_m = image.grid.origin_m[2] + image.grid.cells[2] * image.grid.spacing_m[2];
    space.solid = std::make_shared<const ImageSolid>(std::move(image));
    return space;
}

void require_fit(const Grid& grid, const Container& container, const Section& section, const std::string& where, bool shows_wall) {
    require_same_width(grid, container, where, shows_wall);
    const double h = grid.spacing_m[2], z0 = grid.origin_m[2], z1 = z0 + grid.cells[2] * h;
    if (section.length() >= 0.0 && section.length() < h)
        throw UserError(fmt::format("the section from {:g} to {:g} m is thinner than a voxel", section.z0_m, section.z1_m),
                        {.where = where, .allowed = fmt::format("{:g} m or more", h)});
    if (section.z0_m < z0 - 0.5 * h || section.z1_m > z1 + 0.5 * h || section.length() < 0.0)
        throw UserError(fmt::format("the section from {:g} to {:g} m is not in the image", section.z0_m, section.z1_m),
                        {.where = where, .allowed = fmt::format("{:g} <= z0 < z1 <= {:g} m", z0, z1)});
    if (z0 < -1.01 * h || z1 > container.height() + 1.01 * h)
        throw UserError(fmt::format("the image reaches from {:g} to {:g} m, the container from 0 to {:g} m", z0, z1, container.height()),
                        {.where = where, .fix = "give the container that the image shows (--container, metres)"});
    if (container.periodic()[2] && (section.z0_m > z0 + 0.5 * h || section.z1_m < z1 - 0.5 * h))
        throw UserError("a section of an image that is periodic along z is not periodic",
                        {.where = where, .fix = "leave out --section, or give a container that is not periodic along z"});
}

PoreSpace pore_space_of(std::shared_ptr<const Solid> solid, const Container& container, const Section& section, double grain_size_m) {
    PoreSpace space{.container = container, .section = section};
    space.bed_bottom_m = std::max(0.0, solid->bounds().low.z());
    space.bed_top_m = solid->bounds().high.z();
    space.solid = std::move(solid);
    space.grain_size_m = grain_size_m;
    return space;
}

}  // namespace porepack::pore_space
