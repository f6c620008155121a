// A run's state on disk: a line of JSON, then the populations as they lie in memory.
#pragma once

#include <span>

#include "core/files.hpp"

namespace porepack {

void write_checkpoint(const Path& path, const Json& header, std::span<const std::byte> state);
/// Throws UserError when the file is no checkpoint.
[[nodiscard]] Json read_checkpoint_header(const Path& path);
/// Fills `state`. Throws UserError when the file holds less or more, or numbers that are not finite (of `bytes_a_number`).
void read_checkpoint_state(const Path& path, std::span<std::byte> state, std::size_t bytes_a_number);

}  // namespace porepack
