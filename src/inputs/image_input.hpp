// A scan or a segmented image, put into its container.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "core/files.hpp"
#include "imaging/config.hpp"
#include "imaging/volume.hpp"
#include "packing/packing.hpp"
#include "pore_space/gray_solid.hpp"
#include "results/image.hpp"
#include "vessels/config.hpp"

namespace porepack::inputs {

/// How a container is given on the command line, for messages.
inline std::string container_flag() {
    return "--container " + vessels::container_forms() + " (metres)";
}

/// An image as load_pore_space() takes it: in the container's frame, with what lies outside left out.
struct ImageInput {
    geometry::PhaseImage image;                              ///< its notes name the container; empty with gray walls
    std::shared_ptr<const pore_space::GraySolid> gray = {};  ///< with gray walls
    vessels::Container container = {};
    results::ImageFile file = {};
    bool own = false;                                 ///< written by PorePack
    std::string pores = {};                           ///< what of the image they are
    std::optional<scans::GrayNotes> gray_notes = {};  ///< with gray walls
};
[[nodiscard]] ImageInput read_image(const core::Path& file, const imaging::ImageConfig& config,
                                    const std::optional<vessels::Container>& container);
/// The same of an image that is open; `file` names it in messages.
[[nodiscard]] ImageInput read_image(const imaging::VolumeSource& source, const imaging::ImageConfig& config,
                                    const std::optional<vessels::Container>& container, const core::Path& file);

/// The box that an image fills.
[[nodiscard]] vessels::Container box_of(const imaging::VolumeHeader& image);
/// Walls at the gray values' threshold. Throws UserError where they are asked for without one.
[[nodiscard]] bool has_gray_walls(const imaging::ImageConfig& config);

}  // namespace porepack::inputs
