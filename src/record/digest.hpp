// SHA-256 digests in the format of sha256sum.
#pragma once

#include <string>
#include <string_view>

#include "core/files.hpp"

namespace porepack::record {

[[nodiscard]] std::string sha256(std::string_view bytes);
/// Throws UserError when the file cannot be read.
[[nodiscard]] std::string sha256_of_file(const core::Path& path);

}  // namespace porepack::record
