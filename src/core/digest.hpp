// SHA-256 digests in the format of sha256sum.
#pragma once

#include <string>
#include <string_view>

#include "core/files.hpp"

namespace porepack::core {

[[nodiscard]] std::string sha256(std::string_view bytes);
/// Throws UserError when the file cannot be read.
[[nodiscard]] std::string sha256_of_file(const Path& path);

}  // namespace porepack::core
