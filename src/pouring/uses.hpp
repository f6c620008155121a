// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace core {}
namespace record {}
namespace shapes {}
namespace packing {}
namespace pouring {
using namespace core;
using namespace record;
using namespace shapes;
using namespace packing;
}  // namespace pouring
}  // namespace porepack
