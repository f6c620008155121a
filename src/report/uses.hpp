// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace io {}
namespace uncertainty {}
namespace report {
using namespace io;
using namespace uncertainty;
}  // namespace report
}  // namespace porepack
