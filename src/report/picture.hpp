// Pictures of surfaces, rendered by VTK in a program of its own.
#pragma once

#include <string>
#include <vector>

#include "core/files.hpp"

namespace porepack::report {

/// Renders an STL file by the program `porepack picture` beside this program or on PATH. False, with log.picture next to the image, when it
/// could not.
bool draw_picture(const core::Path& stl, const core::Path& png, const std::vector<std::string>& more = {});

}  // namespace porepack::report
