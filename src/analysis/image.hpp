// The porosity of an image in its container.
#pragma once

#include "inputs/image_input.hpp"
#include "results/image.hpp"

namespace porepack::analysis {

[[nodiscard]] results::Image describe_image(const inputs::ImageInput& input);

}  // namespace porepack::analysis
