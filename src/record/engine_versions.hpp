// Versions of the engines, for manifests and --version.
#pragma once

#include "core/json_fwd.hpp"

namespace porepack::record {

/// By the name of the engine; empty text for a missing one.
[[nodiscard]] core::Json engine_versions();

}  // namespace porepack::record
