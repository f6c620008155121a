// Which porepack this is.
#pragma once

namespace porepack::core {

[[nodiscard]] const char* program_version();
/// Of the commit that was built; "unknown" outside a checkout.
[[nodiscard]] const char* git_hash();

}  // namespace porepack::core
