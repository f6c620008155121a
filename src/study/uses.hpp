// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {}
namespace lbm {}
namespace permeability {}
namespace uncertainty {}
namespace report {}
namespace pipeline {}
namespace stages {}
namespace study {
using namespace record;
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;
using namespace lbm;
using namespace permeability;
using namespace uncertainty;
using namespace report;
using namespace pipeline;
using namespace stages;
}  // namespace study
}  // namespace porepack
