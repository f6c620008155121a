// The values of a configuration after files and flags, as JSON.
#pragma once

#include "core/config.hpp"
#include "core/json.hpp"

namespace porepack::core {

/// The resolved values, in the order of the list.
[[nodiscard]] Json resolved(const Describe& describe);
/// The resolved values of a table's struct.
template <typename Config>
[[nodiscard]] Json resolved_config(Config config) {
    return resolved([&](ConfigVisitor& v) { describe(v, config); });
}

}  // namespace porepack::core
