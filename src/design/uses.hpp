// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {}
namespace report {}
namespace pipeline {}
namespace stages {}
namespace study {}
namespace design {
using namespace record;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;
using namespace report;
using namespace pipeline;
using namespace stages;
using namespace study;
}  // namespace design
}  // namespace porepack
