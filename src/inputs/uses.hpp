// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {}
namespace converters {}
namespace scans {}
namespace inputs {
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
using namespace converters;
using namespace scans;
}  // namespace inputs
}  // namespace porepack
