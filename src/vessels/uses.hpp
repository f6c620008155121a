// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace core {}
namespace geometry {}
namespace vessels {
using namespace core;
using namespace geometry;
}  // namespace vessels
}  // namespace porepack
