// Grains of known shape found in a scan: a packing of exact poses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/outcome.hpp"
#include "core/expectation.hpp"
#include "core/files.hpp"
#include "imaging/config.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "results/fit.hpp"

namespace porepack::analysis {

struct Fitted {
    Outcome<results::Fit> outcome;  ///< with grains.csv and fit.png
    packing::Packing packing;       ///< in the container's frame, with the image's first layer on the floor
};
/// Without a threshold, `volume`. `name` names the scan in messages. Throws UserError as read_gray(), and where no grain is found.
[[nodiscard]] Fitted fit_image(const imaging::VolumeSource& source, imaging::ImageConfig image,
                               const std::optional<vessels::Container>& container, const std::vector<shapes::Shape>& shapes,
                               const std::string& name);
/// Of a file or a folder of slices.
[[nodiscard]] Fitted fit_image(const core::Path& file, const imaging::ImageConfig& image,
                               const std::optional<vessels::Container>& container, const std::vector<shapes::Shape>& shapes);
/// packing.json beside the table and the picture.
[[nodiscard]] results::Fit written(const Fitted& fitted, const core::Path& folder);
[[nodiscard]] core::Expectation expect_fit(double voxels);

}  // namespace porepack::analysis
