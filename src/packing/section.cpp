#include "packing/section.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"

namespace porepack::packing {
using namespace shapes;
using namespace vessels;

Section choose_section(const Container& container, const SectionChoice& choice, const Section& bed, double maximum_feret_diameter_m) {
    if (choice.section_m.size() == 2) {
        const Section section{choice.section_m[0], choice.section_m[1]};
        if (container.periodic()[2] && (section.z0_m > 1e-9 * container.height() || section.z1_m < container.height() * (1.0 - 1e-9)))
            throw UserError("a cell that is periodic along z is taken as a whole: it has no section",
                            {.allowed = fmt::format("0,{:g} or nothing", container.height()), .fix = "leave the section out"});
        if (section.length() <= 0.0 || section.z0_m < 0.0 || section.z1_m > container.height() * (1.0 + 1e-9))
            throw UserError(fmt::format("the section from {:g} to {:g} m is not possible", section.z0_m, section.z1_m),
                            {.allowed = fmt::format("0 <= z0 < z1 <= {:g} m (the container's height); the bed is {:g} m high",
                                                    container.height(), bed.z1_m)});
        const double rounding = 1e-6 * container.height();
        if (choice.bed_known && !container.periodic()[2] && (section.z0_m < bed.z0_m - rounding || section.z1_m > bed.z1_m + rounding))
            throw UserError(
                fmt::format("the section from {:g} to {:g} m is not in the bed: free space would count as pores", section.z0_m,
                            section.z1_m),
                {.allowed = fmt::format("{:.6g} <= z0 < z1 <= {:.6g} m (lowest and highest point of the grains)", bed.z0_m, bed.z1_m)});
        return section;
    }
    if (container.periodic()[2]) return {0.0, container.size().z()};
    const double trim = choice.trim_m > 0.0 ? choice.trim_m : std::min(0.03, maximum_feret_diameter_m);
    const double top = std::min(bed.z1_m, container.height());
    if (top - bed.z0_m - 2.0 * trim <= 0.0)
        throw UserError(fmt::format("nothing is left of the bed: it {} {:.4g} m high, and {:.4g} m are trimmed at both ends",
                                    choice.bed_known ? "is" : "will be about", bed.length(), trim),
                        {.allowed = "in [geometry]: section_m (--section z0,z1), trim_m (--trim)",
                         .fix = "use a smaller trim_m, a section_m, or more grains"});
    return {bed.z0_m + trim, top - trim};
}

Packing cut_out(const Packing& packing, const Section& part) {
    Packing cut{.container = packing.container, .shapes = packing.shapes, .bodies = {}, .overlap_allowed = packing.overlap_allowed};
    const Vec3& size = packing.container.size();
    cut.container = packing.container.resized({size.x(), size.y(), part.length()}).with_cut_ends();
    for (Body body : packing.bodies) {
        body.position_m.z() -= part.z0_m;
        const Bounds bounds = bounds_of(placed(packing, body));
        if (bounds.high.z() > 0.0 && bounds.low.z() < part.length()) cut.bodies.push_back(body);
    }
    return cut;
}

Section whole_bed(const Container& container, const Section& bed) {
    return container.periodic()[2] ? Section{0.0, container.height()} : Section{bed.z0_m, std::min(bed.z1_m, container.height())};
}

std::array<bool, 3> periodic_sides(const Container& container, const Section& section) {
    return {container.periodic()[0], container.periodic()[1], container.periodic()[2] && section.length() > 0.999 * container.height()};
}

}  // namespace porepack::packing
