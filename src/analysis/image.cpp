#include "analysis/image.hpp"

#include <cstdint>
#include <string>

#include "analysis/uses.hpp"
#include "core/json.hpp"
#include "pore_space/gray_solid.hpp"

namespace porepack::analysis {

results::Image describe_image(const ImageInput& input) {
    const std::string place = "the image is put with its middle on the container's axis, its first layer on the floor";
    results::Image result{.file = input.file, .pores = input.pores, .gray = input.gray_notes, .container = to_json(input.container)};
    if (input.gray) {
        const double height = input.gray->image()->grid.cells[2] * input.gray->image()->grid.spacing_m[2];
        result.porosity_bed = porosity(*input.gray, input.container, {0.0, height}).value;
        result.meaning = "porosity of the level set in the container; " + place;
        return result;
    }
    double pores = 0.0, inside = 0.0;
    for (const std::uint8_t phase : input.image.phase) {
        pores += phase == Phase::pore ? 1.0 : 0.0;
        inside += phase != Phase::outside ? 1.0 : 0.0;
    }
    result.porosity_bed = pores / inside;
    result.meaning = "porosity of all voxels in the container; " + place;
    return result;
}

}  // namespace porepack::analysis
