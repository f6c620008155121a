// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {}
namespace converters {
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
}  // namespace converters
}  // namespace porepack
