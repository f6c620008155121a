// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace imaging {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {}
namespace scans {
using namespace imaging;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
}  // namespace scans
}  // namespace porepack
