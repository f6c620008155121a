// JSON documents, whose keys keep their order.
#pragma once

#include <nlohmann/json.hpp>

#include "core/json_fwd.hpp"
