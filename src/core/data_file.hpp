// Files installed with porepack: LIGGGHTS templates, OpenFOAM cases, templates of reports and plots.
#pragma once

#include "core/files.hpp"

namespace porepack::inline core {

/// Full path of `name`, for instance "openfoam_cases" or "templates/report.html". Looked for in POREPACK_HOME, in the folder that the host
/// program set, in ../share/porepack beside the program, where porepack was installed, and in the source tree that was built. Throws
/// UserError when none of them contains it.
[[nodiscard]] Path data_file(const Path& name);

/// For a host program that ships the files itself, or runs outside the prefix that porepack was installed to (porepack_DATA_FOLDER of
/// find_package(porepack)).
void set_data_folder(const Path& folder);

}  // namespace porepack::inline core
