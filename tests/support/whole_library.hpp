// Names of all folders of the library. Only for programs that use all of it: the tests that cross folders, and the benchmarks.
#pragma once

namespace porepack {
namespace devices {}
namespace record {}
namespace io {}
namespace shapes {}
namespace packing {}
namespace vessels {}
namespace pouring {
namespace dem {}
namespace liggghts {}
}  // namespace pouring
namespace pore_space {}
namespace converters {}
namespace lbm {}
namespace openfoam {}
namespace tortuosity {}
namespace permeability {}
namespace uncertainty {}
namespace scans {}
namespace falling_head {}
namespace report {}
namespace pipeline {}
namespace inputs {}
namespace analysis {}
namespace stages {}
namespace study {}
namespace design {}
using namespace record;
using namespace io;
using namespace shapes;
using namespace packing;
using namespace vessels;
using namespace pouring;
using namespace pouring::dem;
using namespace pouring::liggghts;
using namespace pore_space;
using namespace converters;
using namespace lbm;
using namespace openfoam;
using namespace tortuosity;
using namespace permeability;
using namespace uncertainty;
using namespace scans;
using namespace falling_head;
using namespace report;
using namespace pipeline;
using namespace inputs;
using namespace analysis;
using namespace stages;
using namespace study;
using namespace design;
}  // namespace porepack
