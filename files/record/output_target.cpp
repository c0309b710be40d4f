#include "files/record/output_target.h"

#include <cerrno>

#include "files/record/file.h"
#include "files/record/open_file.h"

namespace firn::record {

std::filesystem::path output_target(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (is_file_of_run(file)) {
    if (fs::is_symlink(fs::symlink_status(file, error)))
      throw FileError(file, 0, "is a link in a run folder and cannot be replaced", ELOOP);
    if (fs::exists(status) && !fs::is_regular_file(status))
      throw FileError(file, 0, "is no regular file and cannot be replaced", EINVAL);
    return file;
  }
  if (!fs::exists(status)) return file;
  if (fs::is_directory(status)) throw FileError(file, 0, "cannot be replaced", EISDIR);
  if (!fs::is_regular_file(status))
    throw FileError(file, 0, "is no regular file and cannot be replaced", EINVAL);
  const fs::path target = fs::canonical(file, error);
  return error ? file : target;
}

}  // namespace firn::record
