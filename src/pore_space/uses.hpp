// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {
using namespace shapes;
using namespace packing;
using namespace vessels;
}  // namespace pore_space
}  // namespace porepack
