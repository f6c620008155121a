// Files of any kind, read as a pore space.
#pragma once

#include <optional>
#include <string>

#include "converters/config.hpp"
#include "core/files.hpp"
#include "imaging/volume.hpp"
#include "pore_space/config.hpp"
#include "pore_space/pore_space.hpp"
#include "record/config.hpp"

namespace porepack::inputs {

struct InputOptions {
    std::optional<vessels::Container> container = {};  ///< of a surface, or of an image that does not name its own
    double unit_m = 1.0;                               ///< length of a surface's unit in metres
    converters::GeometryConfig geometry = {};          ///< section, trim and reservoir
    pore_space::SectionConfig section = {};            ///< ends and buffers of a flow
    imaging::ImageConfig image = {};                   ///< how an image is read
    bool whole_bed = false;                            ///< the section is the whole bed, independent of `geometry`
};

/// packing.json[.gz], an .stl (which needs a container), an image of any format (docs/images.md), or a folder of slices. Throws UserError
/// on anything else, and where the file, the container and the section do not fit together.
[[nodiscard]] pore_space::PoreSpace load_pore_space(const core::Path& input, const InputOptions& options = {});
/// Of a packing, an image, or a surface in metres (which needs a container), that is no file; `name` names it in messages.
[[nodiscard]] pore_space::PoreSpace load_pore_space(packing::Packing packing, const std::string& name, const InputOptions& options);
[[nodiscard]] pore_space::PoreSpace load_pore_space(geometry::TriangleSurface surface, const std::string& name,
                                                    const InputOptions& options);
[[nodiscard]] pore_space::PoreSpace load_pore_space(const imaging::VolumeSource& image, const std::string& name,
                                                    const InputOptions& options);

[[nodiscard]] bool is_packing(const core::Path& input);
[[nodiscard]] bool is_surface(const core::Path& input);
/// An image of any format, or a folder of slices.
[[nodiscard]] bool is_image(const core::Path& input);
/// A folder with case.toml, or a .toml file.
[[nodiscard]] bool is_case(const core::Path& input);

/// The section from the field data of an image. Throws UserError.
[[nodiscard]] packing::Section section_of_note(const std::string& note, const core::Path& file);

}  // namespace porepack::inputs
