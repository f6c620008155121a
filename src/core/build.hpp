// Version of this porepack build.
#pragma once

namespace porepack::inline core {

[[nodiscard]] const char* program_version();
/// Git hash of the commit that was built; "unknown" outside a checkout.
[[nodiscard]] const char* git_hash();

}  // namespace porepack::inline core
