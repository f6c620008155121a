// The scene that OpenFOAM meshes.
#include <cmath>

#include "openfoam/foam.hpp"

namespace porepack::openfoam {
using namespace packing;
using namespace converters;
namespace {

// The grains that extend into the section; in a periodic box all of them.
Packing grains_near(const PoreSpace& space) {
    Packing near = *space.packing;
    if (!space.container.any_periodic())
        std::erase_if(near.bodies, [&](const Body& body) {
            return body.position_m.z() < space.section.z0 - space.maximum_feret_diameter_m ||
                   body.position_m.z() > space.section.z1 + space.maximum_feret_diameter_m;
        });
    return near;
}

// Close to `size`, such that a periodic box has a whole number of voxels.
double fitting(const PoreSpace& space, double size) {
    return space.container.any_periodic() ? space.section.length() / std::ceil(space.section.length() / size) : size;
}

}  // namespace

double narrow_pores(const PoreSpace& space, double voxel_size_m) {
    return narrow_fraction(space.section_only().voxelise_at(fitting(space, voxel_size_m)), 2);
}

FoamScene foam_scene(const PoreSpace& space, const SurfaceOptions& surface, double coarsest_cell_m) {
    const PoreSpace section = space.section_only();
    FoamScene scene{.surface = space.surface ? *space.surface : make_surface(grains_near(space), surface).surface,
                    .container = space.container,
                    .section = space.section};
    scene.pore_volume_m3 = section.porosity().value * space.container.inner_area_m2() * space.section.length();
    scene.grain_size_m = space.grain_size_m;
    scene.pores = section;
    scene.pore_point = find_pore_point(section.voxelise_at(fitting(space, 0.5 * coarsest_cell_m)), space.container);
    return scene;
}

FoamScene foam_scene_in_water(const PoreSpace& space, const SurfaceOptions& surface, double cell_m, double water_m) {
    FoamScene scene = foam_scene(space, surface, cell_m);
    scene.surface = clip_surface(scene.surface, space.section);
    scene.pore_volume_m3 += 2.0 * water_m * space.container.inner_area_m2();
    scene.section = {space.section.z0 - water_m, space.section.z1 + water_m};
    return scene;
}

}  // namespace porepack::openfoam
