// The name of JSON documents, for headers that only pass them on; core/json.hpp is for those that look inside.
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace porepack::inline core {
using Json = nlohmann::ordered_json;
}  // namespace porepack::inline core
