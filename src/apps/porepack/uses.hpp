// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace record {}
namespace io {}
namespace imaging {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pore_space {}
namespace converters {}
namespace lbm {}
namespace openfoam {}
namespace tortuosity {}
namespace scans {}
namespace permeability {}
namespace falling_head {}
namespace inputs {}
namespace analysis {}
namespace pipeline {}
namespace stages {}
namespace study {}
namespace design {}
namespace apps {
using namespace record;
using namespace io;
using namespace imaging;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pore_space;
using namespace converters;
using namespace lbm;
using namespace openfoam;
using namespace tortuosity;
using namespace scans;
using namespace permeability;
using namespace falling_head;
using namespace inputs;
using namespace analysis;
using namespace pipeline;
using namespace stages;
using namespace study;
using namespace design;
}  // namespace apps
}  // namespace porepack
