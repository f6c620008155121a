// Names of the folders below this one. Only for the sources of this folder.
#pragma once

namespace porepack {
namespace report {}
namespace evidence {
using namespace report;
}  // namespace evidence
}  // namespace porepack
