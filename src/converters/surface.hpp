// Converts grains to one closed triangle surface (CGAL); checks closed surfaces of users.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "converters/config.hpp"
#include "core/interval.hpp"
#include "io/stl.hpp"
#include "pore_space/pore_space.hpp"

namespace porepack::converters {

struct SurfaceCheck {
    bool closed = false;
    bool outward = false;
    bool self_intersecting = false;
    long shells = 0;
    double volume_m3 = 0.0;
    double area_m2 = 0.0;
    shapes::Vec3 low = shapes::Vec3::Zero(), high = shapes::Vec3::Zero();
    double largest_shell_diagonal_m = 0.0;   ///< diagonal of the largest shell's bounding box
    std::string fault;                       ///< first fault found, with its place; empty when there is none
    std::string fix;                         ///< what to do about it, where that is known
    std::vector<shapes::Vec3> fault_places;  ///< where the surface is open or crosses itself
};

/// Closed, oriented outward, without self-intersections: checked on the triangles of the file.
[[nodiscard]] SurfaceCheck check_surface(const geometry::TriangleSurface& surface);
/// Throws UserError that names the fault unless the surface bounds a volume.
void require_sound(const SurfaceCheck& check, const std::string& where);

struct SurfaceOptions {
    /// Maximum distance in metres between the triangles and the exact grains; 0: automatic_deviation(). The number of
    /// triangles grows as 1 / deviation: choose a larger value for images and 3D printing, a smaller one where volume or area of the
    /// surface are compared with exact values.
    double deviation_m = 0.0;
    /// Grains with a gap below this, in metres, become one body; 0: 1e-4 of the smallest thickness of the grains, and 10 and 100 times that
    /// where faults remain. It is also the step by which grains are thinned where the surface crosses itself in single precision.
    double contact_gap_m = 0.0;
    /// Of the surface against the grains, relative. Facets and bridges change the volume. Not checked in periodic containers.
    double max_volume_error = 0.01;
};
/// Those of [geometry].
[[nodiscard]] SurfaceOptions surface_options(const GeometryConfig& geometry);

struct SurfaceResult {
    geometry::TriangleSurface surface;
    SurfaceCheck check;        ///< of this surface, whose coordinates are those of an STL file
    double deviation_m = 0.0;  ///< measured: maximum distance of a corner or a facet's middle from the exact grains
    double contact_gap_m = 0.0;
    long joined_grains = 0;  ///< grains that became one body with others
    long bridges = 0;        ///< contacts nearer than contact_gap_m, joined by a small box that contains the lens of their overlap
    long shrunk_grains = 0;  ///< thinned because the surface crossed itself in single precision: by contact_gap_m in each round of repair;
                             ///< with faces by 1, 3, 7 ... times that
};

/// One closed surface of the union of all grains. Throws NumericalError when CGAL cannot make one, UserError when deviation or contact gap
/// are more than a tenth of the smallest thickness of the grains or change the volume of the grains by more than max_volume_error.
[[nodiscard]] SurfaceResult make_surface(const packing::Packing& packing, const SurfaceOptions& options);

/// One grain in its frame, closed. Throws as make_surface().
[[nodiscard]] geometry::TriangleSurface surface_of_grain(const shapes::Shape& shape, double deviation_m);

struct SurfaceMeasures {
    double volume_m3 = 0.0;
    double area_m2 = 0.0;
    double sphericity = 0.0;
    shapes::Vec3 centre_of_mass_m = shapes::Vec3::Zero();
    Eigen::Matrix3d inertia_per_density_m5 = Eigen::Matrix3d::Zero();  ///< about the centre of mass, for density 1
    double hull_volume_m3 = 0.0, hull_area_m2 = 0.0;
    double bounding_radius_m = 0.0;         ///< about the centre of mass
    double maximum_feret_diameter_m = 0.0;  ///< maximum Feret diameter
};
/// Measures of a closed surface, exact for the polyhedron.
[[nodiscard]] SurfaceMeasures measure_surface(const geometry::TriangleSurface& surface);

/// The part of closed grains between two planes, with closed cut faces.
[[nodiscard]] geometry::TriangleSurface clip_surface(const geometry::TriangleSurface& surface, const packing::Section& section);

/// The boundary of the pore space inside the container, closed; triangles point out of the pores.
struct PoreSurface {
    geometry::TriangleSurface surface;
    std::vector<int> region;  ///< by triangle: 0 inlet (z0), 1 outlet (z1), 2 wall, 3 grains
};
[[nodiscard]] PoreSurface make_pore_surface(const geometry::TriangleSurface& grains, const vessels::Container& container,
                                            const packing::Section& section, double deviation_m);

/// The sides of a vessel as they are drawn, from the floor to `top_m` (a mesh: as high as it is); round ones have 96 facets. Empty for a
/// box.
[[nodiscard]] geometry::TriangleSurface sides_of(const vessels::Container& container, double top_m);

/// A closed triangle surface as a solid; `periodic` repeats it.
class SurfaceSolid : public geometry::Solid {
public:
    SurfaceSolid(geometry::TriangleSurface surface, const vessels::Container& container);
    ~SurfaceSolid() override;
    /// Uses the winding number along the line: overlapping shells are joined.
    void column(double x, double y, std::vector<core::Interval>& parts) const override;
    void near_column(double x, double y, double length, std::vector<core::Interval>& parts) const override;
    /// Exact, unless the container is periodic or the surface reaches through its sides.
    [[nodiscard]] std::optional<double> volume_between(double z0, double z1) const override;
    [[nodiscard]] shapes::Bounds bounds() const override;
    [[nodiscard]] std::unique_ptr<geometry::SolidProbe> probe() const override;
    [[nodiscard]] const geometry::TriangleSurface* surface() const override { return &surface_; }

private:
    class Probe;
    struct Bins;
    const geometry::TriangleSurface surface_;
    std::unique_ptr<Bins> bins_;
};

/// The pore space around a user's closed surface; the section is the whole bed. Throws UserError when the surface is faulty or does not
/// fit the container; `where` names it.
[[nodiscard]] pore_space::PoreSpace pore_space_of(geometry::TriangleSurface surface, const vessels::Container& container,
                                                  const std::string& where);

/// Throws UserError when the surface is probably not in metres: much larger or smaller than the container.
void require_plausible_size(const SurfaceCheck& check, const vessels::Container& container, const std::string& where);

}  // namespace porepack::converters
