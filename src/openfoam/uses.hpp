// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {}
namespace converters {}
namespace openfoam {
using namespace record;
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
using namespace converters;
}  // namespace openfoam
}  // namespace porepack
