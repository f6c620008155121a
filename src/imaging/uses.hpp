// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace core {}
namespace geometry {}
namespace imaging {
using namespace core;
using namespace geometry;
}  // namespace imaging
}  // namespace porepack
