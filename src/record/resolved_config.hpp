// The values of a configuration after files and flags, as JSON.
#pragma once

#include "core/json.hpp"
#include "record/config.hpp"

namespace porepack::record {

/// The resolved values, in the order of the list.
[[nodiscard]] core::Json resolved(const Describe& describe);
/// The resolved values of a table's struct.
template <typename Config>
[[nodiscard]] core::Json resolved_config(Config config) {
    return resolved([&](ConfigVisitor& v) { describe(v, config); });
}

}  // namespace porepack::record
