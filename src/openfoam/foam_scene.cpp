// The scene that OpenFOAM meshes.
#include <cmath>

#include "core/error.hpp"
#include "openfoam/foam.hpp"
#include "openfoam/uses.hpp"

namespace porepack::openfoam {
namespace {

// The grains that extend into the computed part; in a periodic box all of them.
Packing grains_near(const PoreSpace& space) {
    Packing near = *space.packing();
    if (!space.container.any_periodic())
        std::erase_if(near.bodies, [&](const Body& body) {
            return body.position_m.z() < space.computed().z0_m - space.maximum_feret_diameter_m ||
                   body.position_m.z() > space.computed().z1_m + space.maximum_feret_diameter_m;
        });
    return near;
}

}  // namespace

double narrow_pores(const PoreSpace& space, double voxel_size_m) {
    return narrow_fraction(space.section_only().voxelise_at(voxel_size_m), 2);
}

FoamScene foam_scene(const PoreSpace& space, const SurfaceOptions& surface, double coarsest_cell_m, const TriangleSurface* made) {
    if (made == nullptr) made = space.surface();
    const auto walls = space.container.vessel().walls();
    if (!space.container.vessel().fills_bounds() && !(walls && walls->planes.empty()))
        throw UserError("the cases of OpenFOAM have round walls and boxes, not other vessels",
                        {.where = text_of(space.container), .fix = "leave OpenFOAM out ([openfoam] enabled = false)"});
    const PoreSpace meshed = space.with_section(space.computed()).section_only();
    FoamScene scene{.surface = made != nullptr ? *made : make_surface(grains_near(space), surface).surface,
                    .container = space.container,
                    .section = meshed.section};
    if (space.ends == Ends::in_situ && !space.container.periodic()[2]) scene.evaluated = space.section;
    scene.pore_volume_m3 =
        meshed.porosity().value * space.container.vessel().mean_area(meshed.section.interval()) * meshed.section.length();
    scene.grain_size_m = space.grain_size_m;
    scene.pores = meshed;
    scene.pore_point = find_pore_point(meshed.voxelise_at(0.5 * coarsest_cell_m), space.container);
    return scene;
}

FoamScene foam_scene_in_water(const PoreSpace& space, const SurfaceOptions& surface, double cell_m, double water_m) {
    FoamScene scene = foam_scene(space, surface, cell_m);
    scene.surface = clip_surface(scene.surface, space.computed());
    scene.pore_volume_m3 += 2.0 * water_m * space.container.vessel().mean_area(space.computed().interval());
    scene.section = {space.computed().z0_m - water_m, space.computed().z1_m + water_m};
    return scene;
}

}  // namespace porepack::openfoam
