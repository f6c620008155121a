// Rendered images of surfaces. Needs a display, or xvfb-run around the program.
#pragma once

#include "core/files.hpp"
#include "io/stl.hpp"

namespace porepack::io {

struct PictureStyle {
    int width = 900;             ///< pixels
    int height = 1100;           ///< pixels
    TriangleSurface walls = {};  ///< of the container, drawn transparent
    bool front = false;          ///< seen along y in parallel projection, for objects side by side
};

/// The image fits the surface's width or its height.
[[nodiscard]] PictureStyle style_for(const TriangleSurface& surface);

/// Renders the surface seen from the side and slightly from above, z up.
void render_surface(const core::Path& png, const TriangleSurface& surface, const PictureStyle& style = {});

}  // namespace porepack::io
