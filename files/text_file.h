// write_file_atomically and read_file write and read whole text files.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace firn {

/// A file that cannot be finished: no space, a disk that is gone. The text names path, byte and the system's
/// reason.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Writes a file whole or not at all: temporary file, fsync, rename. Follows symbolic links; a folder, a
/// device or a pipe is never replaced. In a run folder no link is followed (files/record/open_file.h).
/// @throws UsageError: an unwritable place; WriteError
void write_file_atomically(const std::filesystem::path& path, std::string_view content);
/// Reads 64 MiB of a file in a run folder at most, and no link there.
/// @throws UsageError naming path and the system's reason: a missing file, a folder
std::string read_file(const std::filesystem::path& path);

}  // namespace firn
