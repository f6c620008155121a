// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace io {}
namespace imaging {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {}
namespace pouring::dem {}
namespace pore_space {}
namespace converters {}
namespace lbm {}
namespace openfoam {}
namespace tortuosity {}
namespace pores {}
namespace scans {}
namespace permeability {}
namespace uncertainty {}
namespace falling_head {}
namespace inputs {}
namespace analysis {
using namespace record;
using namespace io;
using namespace imaging;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;
using namespace pouring::dem;
using namespace pore_space;
using namespace converters;
using namespace lbm;
using namespace openfoam;
using namespace tortuosity;
using namespace pores;
using namespace scans;
using namespace permeability;
using namespace uncertainty;
using namespace falling_head;
using namespace inputs;
}  // namespace analysis
}  // namespace porepack
