// Grains to one closed triangle surface (CGAL), and closed surfaces of users.
#pragma once

#include <memory>

#include "io/stl.hpp"
#include "packing/grains.hpp"

namespace porepack {

struct SurfaceCheck {
    bool closed = false;
    bool outward = false;
    bool self_intersecting = false;
    long shells = 0;
    double volume_m3 = 0.0;
    double area_m2 = 0.0;
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    double largest_shell_span_m = 0.0;  ///< diagonal of the largest shell's bounding box
    std::string fault;                  ///< first fault found, with its place; empty when all is well
    std::vector<Vec3> fault_places;     ///< where the surface is open or crosses itself
};

/// Closed, outward, free of self-intersections: checked on the triangles as they are in the file.
[[nodiscard]] SurfaceCheck check_surface(const TriangleSurface& surface);
/// Throws UserError that names the fault unless the surface bounds a volume.
void require_sound(const SurfaceCheck& check, const std::string& where);

struct SurfaceOptions {
    double deviation_m = 0.0;    ///< 0: 2 % of the smallest capsule diameter
    double contact_gap_m = 0.0;  ///< 0: 1e-4 of it
};

struct SurfaceResult {
    TriangleSurface surface;
    double deviation_m = 0.0;  ///< measured: largest distance of a corner or a facet's middle from the exact capsules
    double contact_gap_m = 0.0;
    long joined_grains = 0;  ///< grains that became one body with others
    long shrunk_grains = 0;  ///< grains thinned by contact_gap_m because the surface crossed itself in single precision
};

/// One closed surface of the union of all grains. Throws NumericalError when CGAL cannot make one.
[[nodiscard]] SurfaceResult make_surface(const Packing& packing, const SurfaceOptions& options);

/// A closed triangle surface as a solid; `periodic` repeats it.
class SurfaceSolid : public Solid {
public:
    SurfaceSolid(const TriangleSurface& surface, const Container& container);
    ~SurfaceSolid() override;
    /// Winding number along the line: overlapping shells are joined.
    void column(double x, double y, std::vector<Interval>& parts) const override;
    [[nodiscard]] Bounds bounds() const override;

private:
    struct Bins;
    std::unique_ptr<Bins> bins_;
};

/// Throws UserError when the surface cannot be in metres: much larger or smaller than the container.
void require_plausible_size(const SurfaceCheck& check, const Container& container, const std::string& where);

}  // namespace porepack
