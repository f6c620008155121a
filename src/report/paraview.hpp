// The results of a case for ParaView.
#pragma once

#include "core/files.hpp"

namespace porepack::report {

/// A script for ParaView and pvbatch that opens what lies in `results`, beside the script or there.
void write_paraview_script(const core::Path& file, const core::Path& results);

}  // namespace porepack::report
