// Grains of known shape found in a scan: a packing of exact poses.
#pragma once

#include <optional>

#include "core/config.hpp"
#include "core/files.hpp"
#include "imaging/config.hpp"
#include "packing/packing.hpp"
#include "results/fit.hpp"

namespace porepack::stages {

/// Finds the grains and writes packing.json, grains.csv and fit.png into `folder`. Without a threshold, `volume`. The shapes' poses are in
/// the container's frame, with the image's first layer on the floor. Throws UserError as read_gray(), and where no grain is found.
[[nodiscard]] results::Fit fit_image(const core::Path& file, imaging::ImageConfig image, const std::optional<packing::Container>& container,
                                     const std::vector<shapes::Shape>& shapes, const core::Path& folder);

}  // namespace porepack::stages
