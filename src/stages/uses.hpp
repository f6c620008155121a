// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {}
namespace pore_space {}
namespace converters {}
namespace lbm {}
namespace openfoam {}
namespace tortuosity {}
namespace permeability {}
namespace falling_head {}
namespace report {}
namespace inputs {}
namespace analysis {}
namespace pipeline {}
namespace stages {
using namespace record;
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;
using namespace pore_space;
using namespace converters;
using namespace lbm;
using namespace openfoam;
using namespace tortuosity;
using namespace permeability;
using namespace falling_head;
using namespace report;
using namespace inputs;
using namespace analysis;
using namespace pipeline;
}  // namespace stages
}  // namespace porepack
