// Files that commands write: whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace firn {

/// Writes beside `path` and renames, so that a reader never sees half a file. @throws std::runtime_error with path
/// and reason.
void write_whole(const std::filesystem::path& path, std::string_view text);

/// Writes a generated document to `output` ("-" = stdout) and says so on stderr; with `json`, {"written": …} or the
/// document as a JSON string goes to stdout.
void write_generated(const std::string& output, const std::string& text, bool json);

}  // namespace firn
