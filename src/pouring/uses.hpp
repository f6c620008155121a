// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {
using namespace record;
using namespace shapes;
using namespace packing;
using namespace vessels;
}  // namespace pouring
}  // namespace porepack
