// Files with their final name are complete: text and bytes are written to a temporary name, then renamed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "core/json_fwd.hpp"

namespace porepack::inline core {

using Path = std::filesystem::path;

/// Throws UserError when `path` is missing, no regular file (a folder, a pipe, a device), or larger than `max_bytes`.
void require_file(const Path& path, double max_bytes = 1e12);
/// The content of such a file. Throws MachineError, with the file's name, when memory does not suffice.
[[nodiscard]] std::string read_text(const Path& path, double max_bytes = 1e12);
/// `source`: of the text, for messages. Throws UserError with the position of the error, and for an object with the same key twice.
[[nodiscard]] Json parse_json(std::string_view text, const std::string& source);
[[nodiscard]] Json read_json(const Path& path);

void write_text(const Path& path, std::string_view text);
void write_json(const Path& path, const Json& json);
/// Calls `write` with a temporary name beside `path`, then renames it. A failed write leaves nothing behind.
/// The temporary name keeps the extension of `path`, because some writers choose the format from it.
void write_whole(const Path& path, const std::function<void(const Path&)>& write);

/// Creates the folder and its parents; throws UserError when permission is missing.
void make_folder(const Path& path);
/// Throws UserError unless a file can be written in the folder.
void require_writable(const Path& folder);

/// The last `lines` lines of a text file; empty when there is none.
[[nodiscard]] std::string tail(const Path& path, int lines);

}  // namespace porepack::inline core
